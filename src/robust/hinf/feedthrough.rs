//! Direct terms that are almost nothing: D12 (D21) has full rank, but a control (measurement) that costs (disturbs) a
//! millionth of what it does elsewhere leaves no digits for X and Y, whose entries grow with the inverse square.
//! Measure: the smallest singular value of D12 with every column divided by the largest gain of P12 in that column,
//! over frequency; for D21 the rows of P21.

use crate::augment::GeneralizedPlant;
use crate::linalg::{Mat, c64, svd};
use crate::lti::norm::seeds;
use crate::lti::responder::FrequencyResponder;
use crate::lti::{Continuous, StateSpace};
use crate::robust::error::SynthesisError;

/// Share of the largest gain below which a failure is put down to the direct term: X then spans eight decades, half the
/// digits of a double, before the plant's own spread.
const WEAK: f64 = 1e-4;

/// The failure with the weak direct term behind it, if there is one and the failure does not name a cause of its own.
pub(super) fn blame_feedthrough(plant: &GeneralizedPlant, error: SynthesisError) -> SynthesisError {
    use SynthesisError as E;
    let unexplained =
        matches!(&error, E::Regulator { .. } | E::NoLevel { .. } | E::Refuted { .. } | E::Numeric(_) | E::Norm(_))
            || matches!(&error, E::Infeasible { condition: crate::robust::error::Condition::Unsolved, .. });
    if !unexplained {
        return error;
    }
    match weakest(plant) {
        Some(found) => E::WeakFeedthrough {
            which: found.which,
            rows: found.rows,
            cols: found.cols,
            smallest: found.smallest,
            relative: found.relative,
            source: Box::new(error),
        },
        None => error,
    }
}

struct Weak {
    which: &'static str,
    rows: usize,
    cols: usize,
    smallest: f64,
    relative: f64,
}

fn weakest(plant: &GeneralizedPlant) -> Option<Weak> {
    let (control, transposed) = parts(plant);
    let of = |part: &StateSpace<Continuous>, which| -> Option<Weak> {
        let found = direct_share(part, 0.0)?;
        Some(Weak {
            which,
            rows: part.outputs(),
            cols: part.inputs(),
            smallest: found.smallest,
            relative: found.relative,
        })
    };
    let d12 = of(&control, "D12");
    let d21 = of(&transposed, "D21").map(|w| Weak { rows: w.cols, cols: w.rows, ..w });
    [d12, d21].into_iter().flatten().filter(|w| w.relative < WEAK).min_by(|a, b| a.relative.total_cmp(&b.relative))
}

/// P12, and P21 transposed.
pub(super) fn parts(plant: &GeneralizedPlant) -> (StateSpace<Continuous>, StateSpace<Continuous>) {
    let (nw, nz) = (plant.disturbances(), plant.errors());
    let range = |from: usize, count: usize| (from..from + count).collect::<Vec<_>>();
    let control = plant.system.select(&range(0, nz), &range(nw, plant.controls));
    let sensing = plant.system.select(&range(nz, plant.measurements), &range(0, nw));
    let transposed = StateSpace {
        a: sensing.a.transpose().to_owned(),
        b: sensing.c.transpose().to_owned(),
        c: sensing.b.transpose().to_owned(),
        d: sensing.d.transpose().to_owned(),
        time: Continuous,
    };
    (control, transposed)
}

/// A direct term beside the gains of its system.
pub(super) struct DirectShare {
    /// Largest gain of each input over frequency.
    pub gains: Vec<f64>,
    /// Smallest singular value of D; 0 where D has fewer rows than columns.
    pub smallest: f64,
    /// The same with every column divided by its gain.
    pub relative: f64,
}

/// Smallest singular value of D, plain and with its columns divided by the gains of the system at s = ω(`damping` + j).
pub(super) fn direct_share(system: &StateSpace<Continuous>, damping: f64) -> Option<DirectShare> {
    let poles = system.poles().ok()?;
    let responder = FrequencyResponder::new(system);
    let mut gains: Vec<f64> = (0..system.inputs()).map(|j| system.d.col(j).norm_l2()).collect();
    for omega in seeds(&poles) {
        let response = if omega.is_infinite() || damping == 0.0 {
            responder.at_or_infinity(omega)
        } else {
            responder.transfer(c64::new(damping * omega, omega))
        };
        for (j, gain) in gains.iter_mut().enumerate() {
            let here = response.col(j).norm_l2();
            if here.is_finite() {
                *gain = gain.max(here);
            }
        }
    }
    let smallest = smallest_singular_value(&system.d)?;
    let relative = smallest_share(&system.d, &gains)?;
    Some(DirectShare { gains, smallest, relative })
}

/// Smallest singular value of D with its columns divided by their gains; 0 where D has fewer rows than columns.
pub(super) fn smallest_share(d: &Mat<f64>, gains: &[f64]) -> Option<f64> {
    let share = Mat::from_fn(d.nrows(), d.ncols(), |i, j| d[(i, j)] / gains[j].max(f64::MIN_POSITIVE));
    smallest_singular_value(&share)
}

fn smallest_singular_value(d: &Mat<f64>) -> Option<f64> {
    if d.nrows() < d.ncols() { Some(0.0) } else { svd(d).ok().and_then(|f| f.s.last().copied()) }
}
