//! A PID tuned without regard to the design: a start of the polish, and the rival whose stiffness the polish exceeds at
//! low frequency and at that of the top speed (figure 9 of the paper).

use super::PipelineError;
use super::comparison::{LOW_HZ, Prediction, predict};
use super::delivery::plane_of_law;
use crate::augment::weights::StiffnessFloor;
use crate::lti::{Discrete, StateSpace};
use crate::pid::parameters::PidParameters;
use crate::pid::settings::TuneSettings;
use crate::pid::tune::tune;
use crate::spindle::Machine;

/// Half of the band round the frequency of the top speed, as a share of it: what the speed of a spindle varies by under
/// load, and wide enough that no sharp peak of stiffness meets the floor at one line.
const HALF_BAND: f64 = 0.03;

pub(super) struct StartingPid {
    pub parameters: PidParameters,
    /// One plane, m to A.
    pub plane: StateSpace<Discrete>,
    /// Stiffness at rest and at top speed; none where its loop is unstable at one of them.
    pub stiffness: Option<ToolStiffness>,
}

/// Stiffness of the tool in the places where controllers are compared, at rest and at top speed, N/m.
#[derive(Clone, Copy, Debug)]
pub(super) struct ToolStiffness {
    pub minimum_n_per_m: [f64; 2],
    at_low_frequency_n_per_m: [f64; 2],
    at_top_speed_frequency_n_per_m: [f64; 2],
}

impl ToolStiffness {
    /// Of the loop at rest and at top speed; none of an unstable loop.
    pub(super) fn of([rest, fast]: &[Prediction; 2]) -> Option<Self> {
        let both = |figure: fn(&Prediction) -> f64| [figure(rest), figure(fast)];
        (rest.is_stable() && fast.is_stable()).then(|| Self {
            minimum_n_per_m: both(|p| p.minimum.0),
            at_low_frequency_n_per_m: both(|p| p.at_10_hz_n_per_m),
            at_top_speed_frequency_n_per_m: both(|p| p.at_max_speed_n_per_m),
        })
    }

    /// Smallest ratio of these figures to those of `other`.
    pub(super) fn least_ratio_to(&self, other: &Self) -> f64 {
        let figures = |own: &Self| {
            [own.minimum_n_per_m, own.at_low_frequency_n_per_m, own.at_top_speed_frequency_n_per_m]
                .into_iter()
                .flatten()
        };
        let ratios = figures(self).zip(figures(other)).map(|(own, other)| own / other);
        ratios.fold(f64::INFINITY, f64::min)
    }

    /// Floors at a multiple of these figures, at low frequency and round that of the top speed.
    pub(super) fn floors(&self, machine: &Machine, multiple: f64) -> [StiffnessFloor; 2] {
        let largest = |[rest, fast]: [f64; 2]| multiple * rest.max(fast);
        let top_hz = machine.spindle.max_rpm / 60.0;
        [
            StiffnessFloor { from_hz: LOW_HZ, to_hz: LOW_HZ, at_least_n_per_m: largest(self.at_low_frequency_n_per_m) },
            StiffnessFloor {
                from_hz: (1.0 - HALF_BAND) * top_hz,
                to_hz: (1.0 + HALF_BAND) * top_hz,
                at_least_n_per_m: largest(self.at_top_speed_frequency_n_per_m),
            },
        ]
    }
}

/// Tunes a PID, and says how stiff it is.
pub(super) fn tune_starting_pid(machine: &Machine) -> Result<StartingPid, PipelineError> {
    let found = tune(machine, &TuneSettings::start(), &mut |_, _| {})?;
    let at = |rpm: f64| predict(machine, &found.controller, rpm);
    let (rest, fast) = rayon::join(|| at(0.0), || at(machine.spindle.max_rpm));
    Ok(StartingPid {
        parameters: found.parameters,
        plane: plane_of_law(machine, &found.controller)?,
        stiffness: ToolStiffness::of(&[rest?, fast?]),
    })
}
