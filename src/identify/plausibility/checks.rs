//! Physical checks of a sweep, each with the sentence a control engineer would say about it.
//!
//! At low frequency G is −ki/ks in kind: the rotor on its magnets moves against the current, by an amount that the
//! bearing constants give. Above the corner √(Σks/m) and below the first bending mode it follows −ki/(mω²): the mass
//! line. Delay and amplifiers only lag. At rest the axes do not see each other, and x and y of a plane agree. All
//! figures are medians over lines, so that resonances which are not where the model has them do not count.

use super::Check;
use super::search::{Agreement, HALF_A_DECADE};
use super::spectrum::{LogValue, Spectrum, median, wrap_angle};
use crate::identify::frf::{AXES, AXIS_NAMES};
use crate::identify::{IdentifyError, MeasuredFrf};
use crate::linalg::c64;
use crate::lti::HeldResponse;
use crate::spindle::Machine;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Fewest lines of a band.
const FEWEST: usize = 3;
/// Lines at the lower end that serve where no line lies below the first bending mode.
const LOWEST: usize = 5;
/// Condition number of U above which noise of one experiment is amplified a hundred times in the others.
const CONDITION: f64 = 100.0;
/// Median relative standard deviation of the compared entries above which a record shows its noise.
const SCATTER: f64 = 0.5;
/// Lag of the electronics, rad, that shows its sign well: clear of the shaft's own damping and of a quarter turn.
const LAG: (f64, f64) = (0.35, 1.22);

/// What the checks look at.
pub(crate) struct MeasuredRecord<'a> {
    pub frf: &'a MeasuredFrf,
    /// Lines of the sweep that are compared.
    pub lines: &'a [usize],
    pub data: &'a Spectrum,
    pub nominal: &'a Spectrum,
    pub machine: &'a Machine,
    /// Its first bending mode, Hz.
    pub first_flexible_hz: Option<f64>,
    /// The controller that the record names.
    pub controller: Option<&'a dyn HeldResponse>,
}

/// All checks that the record allows.
pub(crate) fn checks(measured: &MeasuredRecord, agreement: Agreement) -> Result<Vec<Check>, IdentifyError> {
    let low = measured.low_band();
    let mut list = vec![];
    list.extend(measured.static_gain(&low));
    list.extend(measured.low_frequency_phase(&low));
    list.extend(measured.phase_lag());
    list.extend(measured.symmetry());
    list.extend(measured.crossed_planes());
    list.extend(measured.cross_axis());
    list.extend(measured.mass_line()?);
    list.push(Check {
        name: "agreement",
        value: agreement.worst,
        expected: "below 1.15 (half a decade)".into(),
        ok: agreement.worst <= HALF_A_DECADE,
        decides: true,
        words: format!(
            "in one channel half of the lines are further than {:.2} from the nominal machine, in nepers and radians",
            agreement.worst
        ),
    });
    list.extend(measured.condition());
    list.extend(measured.scatter());
    list.extend(measured.controller());
    Ok(list)
}

fn factor_check(name: &'static str, ratio: f64, words: String) -> Check {
    Check {
        name,
        value: ratio.exp(),
        expected: "0.32 to 3.2".into(),
        ok: ratio.abs() <= HALF_A_DECADE,
        decides: true,
        words,
    }
}

impl MeasuredRecord<'_> {
    /// Positions among the compared lines of those well below the first bending mode, or the lowest ones.
    fn low_band(&self) -> Vec<usize> {
        let limit = self.first_flexible_hz.unwrap_or(f64::INFINITY) / 3.0;
        let below = self.data.frequency_hz.partition_point(|f| *f <= limit);
        (0..below.max(LOWEST).min(self.data.frequency_hz.len())).collect()
    }

    pub(super) fn measured_log(&self, line: usize, output: usize, input: usize) -> LogValue {
        self.data.entries[line][output + AXES * input]
    }

    pub(super) fn model(&self, line: usize, output: usize, input: usize) -> LogValue {
        self.nominal.entries[line][output + AXES * input]
    }

    fn lines_words(&self, band: &[usize]) -> String {
        let at = |k: Option<&usize>| k.and_then(|k| self.data.frequency_hz.get(*k)).copied();
        match (at(band.first()), at(band.last())) {
            (Some(a), Some(b)) => format!("from {a:.4} to {b:.4} Hz"),
            _ => "at no line".into(),
        }
    }

    /// Of one number per channel the one furthest from zero, with the channel.
    fn furthest(numbers: impl Iterator<Item = (usize, Option<f64>)>) -> Option<(usize, f64)> {
        let known = numbers.filter_map(|(k, v)| v.map(|v| (k, v)));
        known.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    }

    fn static_gain(&self, band: &[usize]) -> Option<Check> {
        let ratio = |k: usize| {
            let each = |l: &usize| self.measured_log(*l, k, k).magnitude - self.model(*l, k, k).magnitude;
            (k, median(band.iter().map(each)))
        };
        let (k, ratio) = Self::furthest((0..AXES).map(ratio))?;
        let level = median(band.iter().map(|l| self.measured_log(*l, k, k).magnitude))?.exp();
        Some(factor_check(
            "static_gain",
            ratio,
            format!(
                "{}: 1 A moves the signal by {level:.3e} m {}, {:.3e} times what ki, ks and mass of the nominal \
                 machine give",
                AXIS_NAMES[k],
                self.lines_words(band),
                ratio.exp()
            ),
        ))
    }

    fn low_frequency_phase(&self, band: &[usize]) -> Option<Check> {
        let off = |k: usize| {
            let each = |l: &usize| wrap_angle(self.measured_log(*l, k, k).phase - self.model(*l, k, k).phase).abs();
            (k, median(band.iter().map(each)))
        };
        let (k, phase) = Self::furthest((0..AXES).map(off))?;
        Some(Check {
            name: "low_frequency_phase",
            value: phase.to_degrees(),
            expected: "below 90 degrees".into(),
            ok: phase <= FRAC_PI_2,
            decides: true,
            words: format!(
                "{}: the phase {} differs from that of the nominal machine by {:.0} degrees",
                AXIS_NAMES[k],
                self.lines_words(band),
                phase.to_degrees()
            ),
        })
    }

    /// The phase of a coaxial response against the shaft's real one: a lag, because of delay and amplifiers.
    fn phase_lag(&self) -> Option<Check> {
        let against_real = |phase: f64| phase - PI * (phase / PI).round();
        let mut phases = vec![];
        for l in 0..self.data.frequency_hz.len() {
            for k in 0..AXES {
                let lag = -against_real(self.model(l, k, k).phase);
                if (LAG.0..LAG.1).contains(&lag) {
                    phases.push(against_real(self.measured_log(l, k, k).phase));
                }
            }
        }
        if phases.len() < FEWEST * AXES {
            return None;
        }
        let phase = median(phases)?;
        Some(Check {
            name: "phase_lag",
            value: phase.to_degrees(),
            expected: "below 0 degrees".into(),
            ok: phase <= 0.0,
            decides: true,
            words: format!(
                "where delay and amplifiers lag, the measured phase is {:.0} degrees from the real axis; a lead \
                 is not causal",
                phase.to_degrees()
            ),
        })
    }

    fn symmetry(&self) -> Option<Check> {
        let ratio = |plane: usize| {
            let (x, y) = (2 * plane, 2 * plane + 1);
            let each = |l: usize| self.measured_log(l, x, x).magnitude - self.measured_log(l, y, y).magnitude;
            (plane, median((0..self.data.entries.len()).map(each)))
        };
        let (plane, ratio) = Self::furthest((0..2).map(ratio))?;
        Some(factor_check(
            "x_y_symmetry",
            ratio,
            format!(
                "{} and {} see the same rotor; their responses stand at {:.3e} to 1",
                AXIS_NAMES[2 * plane],
                AXIS_NAMES[2 * plane + 1],
                ratio.exp()
            ),
        ))
    }

    /// Reciprocity as far as it holds: with sensors beside the actuators the model says the ratio of the crossed
    /// responses.
    fn crossed_planes(&self) -> Option<Check> {
        let ratio = |axis: usize| {
            let (f, r) = (axis, axis + 2);
            let crossed = |at: &dyn Fn(usize, usize) -> LogValue| at(f, r).magnitude - at(r, f).magnitude;
            let each = |l: usize| crossed(&|i, j| self.measured_log(l, i, j)) - crossed(&|i, j| self.model(l, i, j));
            (axis, median((0..self.data.entries.len()).map(each)))
        };
        let (axis, ratio) = Self::furthest((0..2).map(ratio))?;
        Some(factor_check(
            "reciprocity",
            ratio,
            format!(
                "the responses front over rear and rear over front in {} stand at {:.3e} times the ratio of the \
                 nominal machine",
                ["x", "y"][axis],
                ratio.exp()
            ),
        ))
    }

    /// Responses from x to y against those within an axis, at rest.
    fn cross_axis(&self) -> Option<Check> {
        if self.frf.speed_rpm != 0.0 {
            return None;
        }
        let ratio = |plane: usize| {
            let (x, y) = (2 * plane, 2 * plane + 1);
            let each = |l: usize| {
                let at = |i, j| self.measured_log(l, i, j).magnitude;
                0.5 * (at(x, y) + at(y, x) - at(x, x) - at(y, y))
            };
            (plane, median((0..self.data.entries.len()).map(each)))
        };
        let largest = (0..2).map(ratio).filter_map(|(p, r)| r.map(|r| (p, r)));
        let (plane, ratio) = largest.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Check {
            name: "cross_axis",
            value: ratio.exp(),
            expected: "below 1".into(),
            ok: ratio <= 0.0,
            decides: true,
            words: format!(
                "{} plane at rest: responses between x and y are {:.3e} times those within an axis",
                ["front", "rear"][plane],
                ratio.exp()
            ),
        })
    }

    fn mass_line(&self) -> Result<Option<Check>, IdentifyError> {
        let mass = self.machine.rotor()?.mass_properties().mass_kg;
        let spindle = &self.machine.spindle;
        let corner = ((spindle.front.ks_n_per_m + spindle.rear.ks_n_per_m) / mass).sqrt() / TAU;
        let (from, to) = (2.0 * corner, self.first_flexible_hz.unwrap_or(f64::INFINITY) / 2.0);
        let hz = &self.data.frequency_hz;
        let band: Vec<usize> = (0..hz.len()).filter(|l| hz[*l] >= from && hz[*l] <= to).collect();
        if band.len() < FEWEST {
            return Ok(None);
        }
        let each = |(l, k): (usize, usize)| self.measured_log(l, k, k).magnitude - self.model(l, k, k).magnitude;
        let pairs = band.iter().flat_map(|l| (0..AXES).map(|k| (*l, k)));
        Ok(median(pairs.map(each)).map(|ratio| Check {
            name: "rigid_body_mass",
            value: mass * (-ratio).exp(),
            expected: format!("{:.3} to {:.3}", mass * 0.32, mass * 3.2),
            ok: ratio.abs() <= HALF_A_DECADE,
            decides: true,
            words: format!(
                "the mass line {} shows a rotor of {:.3e} kg; the nominal one has {mass:.3} kg",
                self.lines_words(&band),
                mass * (-ratio).exp()
            ),
        }))
    }

    fn condition(&self) -> Option<Check> {
        let condition = median(self.lines.iter().map(|l| self.frf.condition[*l]))?;
        Some(Check {
            name: "condition_of_currents",
            value: condition,
            expected: format!("below {CONDITION}"),
            ok: condition <= CONDITION,
            decides: false,
            words: format!(
                "the condition number of U is {condition:.1e} at half of the lines: the four injections hardly \
                 differ, or one current has another scale"
            ),
        })
    }

    /// Scatter over repeats, which stands for the coherence of the sweep.
    fn scatter(&self) -> Option<Check> {
        if self.frf.repeats < 2 {
            return None;
        }
        let entries = |line: &Vec<LogValue>| {
            (0..AXES).map(|k| line[k + AXES * k]).map(|g| g.deviation - g.magnitude).collect::<Vec<_>>()
        };
        let scatter = median(self.data.entries.iter().flat_map(entries))?.exp();
        Some(Check {
            name: "scatter_over_repeats",
            value: scatter,
            expected: format!("below {SCATTER}"),
            ok: scatter <= SCATTER,
            decides: false,
            words: format!(
                "the repeats scatter by {scatter:.2} of the response at half of the lines: more excitation or \
                 more repeats needed"
            ),
        })
    }

    /// u against K y in the plane that has no injection. It holds for injection at the currents and says nothing
    /// otherwise.
    fn controller(&self) -> Option<Check> {
        let controller = self.controller?;
        let mut distances = vec![];
        for (l, f) in self.lines.iter().zip(&self.data.frequency_hz) {
            let k = controller.held_at(TAU * f);
            if k.nrows() != AXES || k.ncols() != AXES {
                return None;
            }
            for e in 0..AXES {
                let other = (e + 2) % AXES;
                let predicted = (0..AXES).map(|j| k[(other, j)] * self.frf.signal[(*l, j, e)]).sum::<c64>();
                let found = LogValue::of(self.frf.current[(*l, other, e)], 0.0);
                distances.extend(found.distance(&LogValue::of(predicted, 0.0)));
            }
        }
        let distance = median(distances)?;
        Some(Check {
            name: "controller",
            value: distance,
            expected: "below 1.15 (half a decade)".into(),
            ok: distance <= HALF_A_DECADE,
            decides: false,
            words: format!(
                "the currents of axes without injection differ by {distance:.2} (nepers and radians) from the \
                 named controller acting on the signals: another controller, another unit or sign, or an injection \
                 elsewhere than at the currents"
            ),
        })
    }
}
