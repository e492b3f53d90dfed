//! Plausibility of a hammer test: measured compliance against that of the nominal machine under the controller of the
//! record.

use super::hypotheses::of_hammer;
use super::search::{Comparison, HALF_A_DECADE};
use super::spectrum::{LogValue, Spectrum, median, wrap_angle};
use super::sweep::spread;
use super::{Check, Plausibility};
use crate::identify::hammer::closed_loop_compliance;
use crate::identify::{HammerFrf, IdentifyError};
use crate::lti::HeldResponse;
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Lines that are compared.
const LINES: usize = 100;
/// Lines at the lower end whose median is the static compliance.
const LOWEST: usize = 5;

/// Plausibility of a hammer test that was read from `record`; `axis` 0 is x, 1 is y.
///
/// # Errors
/// [`IdentifyError::Machine`] when the machine has no plant.
pub fn hammer_plausibility(
    record: &str,
    hammer: &HammerFrf,
    axis: usize,
    machine: &Machine,
    controller: &dyn HeldResponse,
) -> Result<Plausibility, IdentifyError> {
    let plant = Plant::new(machine, hammer.speed_rpm * TAU / 60.0, ModelDetail::Full)?;
    let lines = spread(&hammer.frequency_hz, LINES);
    let noise = hammer.sigmas(0.0);
    let entry = |l: &usize| vec![LogValue::of(hammer.compliance[*l], noise[*l])];
    let data = Spectrum {
        frequency_hz: lines.iter().map(|l| hammer.frequency_hz[*l]).collect(),
        entries: lines.iter().map(entry).collect(),
    };
    let model = |hz: &[f64]| {
        let line = |f: &f64| {
            let h = closed_loop_compliance(&plant, controller, TAU * f, axis);
            vec![LogValue::of(h, 0.0)]
        };
        Spectrum { frequency_hz: hz.to_vec(), entries: hz.iter().map(line).collect() }
    };
    let comparison = Comparison { data: &data, outputs: 1, compared: &[0], model: &model };
    let faults = comparison.faults(&of_hammer());
    Ok(Plausibility {
        record: record.to_owned(),
        checks: checks(&data, &model(&data.frequency_hz), comparison.agreement().worst),
        faults,
    })
}

fn checks(data: &Spectrum, nominal: &Spectrum, distance: f64) -> Vec<Check> {
    let pairs: Vec<(&LogValue, &LogValue)> =
        (data.entries.iter().flatten()).zip(nominal.entries.iter().flatten()).take(LOWEST).collect();
    let mut list = vec![];
    if let Some(ratio) = median(pairs.iter().map(|(d, m)| d.magnitude - m.magnitude)) {
        let level = median(pairs.iter().map(|(d, _)| d.magnitude)).unwrap_or_default();
        list.push(Check {
            name: "static_compliance",
            value: ratio.exp(),
            expected: "0.32 to 3.2".into(),
            ok: ratio.abs() <= HALF_A_DECADE,
            decides: true,
            words: format!(
                "the compliance at the lowest lines is {:.3e} m/N, {:.3e} times that of the nominal machine under \
                 the controller of the record",
                level.exp(),
                ratio.exp()
            ),
        });
    }
    if let Some(phase) = median(pairs.iter().map(|(d, m)| wrap_angle(d.phase - m.phase).abs())) {
        list.push(Check {
            name: "low_frequency_phase",
            value: phase.to_degrees(),
            expected: "below 90 degrees".into(),
            ok: phase <= FRAC_PI_2,
            decides: true,
            words: format!(
                "the phase at the lowest lines differs from that of the nominal machine by {:.0} degrees",
                phase.to_degrees()
            ),
        });
    }
    list.push(Check {
        name: "agreement",
        value: distance,
        expected: "below 1.15 (half a decade)".into(),
        ok: distance <= HALF_A_DECADE,
        decides: true,
        words: format!(
            "half of the lines are further than {distance:.2} from the nominal machine, in nepers and radians"
        ),
    });
    list
}
