//! What no controller comes below, from single frequencies.
//!
//! At jω even a control that is not causal leaves, with the constant scales D of the uncertainty channels,
//!   max(σ_max(Π D P11 D⁻¹), σ_max(D P11 D⁻¹ Π')),
//! Π the projection on what D P12 does not reach, Π' that on what P21 D⁻¹ does not read (Parrott 1978). A frequency
//! where this exceeds a level shows that the level is out of reach, at a small part of the cost of the Riccati
//! equations, which take longest where they have no solution.

use crate::augment::GeneralizedPlant;
use crate::linalg::largest_singular::largest_singular_value;
use crate::linalg::planar::{Planar, add_scaled, add_scaled_conj};
use crate::linalg::{Mat, NumericError, c64};
use crate::lti::FrequencyResponder;
use crate::lti::norm::seeds;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Responses of a plant without scales at frequencies where peaks may be.
pub(super) struct FrequencyFloor {
    responses: Vec<Mat<c64>>,
    /// Errors and disturbances.
    rows: usize,
    columns: usize,
    /// The response that was above a level last: it is asked first. No answer depends on it.
    last: AtomicUsize,
}

impl FrequencyFloor {
    /// Responses of `plant` round its poles and between.
    pub(super) fn new(plant: &GeneralizedPlant) -> Result<Self, NumericError> {
        let system = &plant.system;
        let responder = FrequencyResponder::new(system);
        let responses = seeds(&system.poles()?)
            .into_iter()
            .map(|omega| responder.at_or_infinity(omega))
            .filter(Mat::is_all_finite)
            .collect();
        Ok(Self {
            responses,
            rows: system.outputs() - plant.measurements,
            columns: system.inputs() - plant.controls,
            last: AtomicUsize::new(0),
        })
    }

    /// True when a frequency shows that no controller reaches `level`, with the outputs of the plant multiplied by
    /// `left` and its inputs by `right`.
    pub(super) fn is_above(&self, level: f64, left: &[f64], right: &[f64]) -> bool {
        let first = self.last.load(Ordering::Relaxed);
        let order = (first..self.responses.len()).chain(0..first);
        for k in order {
            if self.exceeds(&self.responses[k], level, left, right) {
                self.last.store(k, Ordering::Relaxed);
                return true;
            }
        }
        false
    }

    fn exceeds(&self, response: &Mat<c64>, level: f64, left: &[f64], right: &[f64]) -> bool {
        let (p, m) = (self.rows, self.columns);
        let entry = |i: usize, j: usize| {
            let value = response[(i, j)] * (left[i] * right[j]);
            (value.re, value.im)
        };
        let whole = Planar::from_fn(p, m, entry);
        if whole.sum_of_squares() <= level * level {
            return false;
        }
        let reached = Planar::from_fn(p, response.ncols() - m, |i, j| entry(i, m + j));
        let turned = Planar::from_fn(m, p, |j, i| entry(i, j));
        let read = Planar::from_fn(m, response.nrows() - p, |j, i| entry(p + i, j));
        [(whole, reached), (turned, read)].into_iter().any(|(of, control)| {
            let rest = without_range(of, control);
            rest.sum_of_squares() > level * level && largest_singular_value(&rest) > level
        })
    }
}

/// What is left of the columns of a matrix beside those of another, by orthogonal projection.
fn without_range(mut of: Planar, mut range: Planar) -> Planar {
    let rows = of.rows();
    for k in 0..range.cols() {
        // Twice: once leaves what rounding of nearly parallel columns puts back.
        for _ in 0..2 {
            for l in 0..k {
                let unit = column(&range, l);
                subtract_along(&mut range, k, &unit);
            }
        }
        let size = column(&range, k).sum_of_squares().sqrt();
        if size == 0.0 {
            continue;
        }
        let own = range.part_mut(0, rows, k);
        for v in own.0.iter_mut().chain(own.1) {
            *v /= size;
        }
        let unit = column(&range, k);
        for j in 0..of.cols() {
            subtract_along(&mut of, j, &unit);
        }
    }
    of
}

fn column(of: &Planar, k: usize) -> Planar {
    Planar::from_fn(of.rows(), 1, |i, _| of.at(i, k))
}

/// Takes the part along a column of unit length off column `j`.
fn subtract_along(of: &mut Planar, j: usize, unit: &Planar) {
    let rows = of.rows();
    let mut along = Planar::zeros(1, 1);
    for i in 0..rows {
        // uᴴ x.
        let (value, own) = (of.at(i, j), unit.part(i, i + 1, 0));
        add_scaled_conj(along.part_mut(0, 1, 0), value, own);
    }
    let (re, im) = along.at(0, 0);
    add_scaled(of.part_mut(0, rows, j), (-re, -im), unit.part(0, rows, 0));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lti::{Continuous, StateSpace};

    /// z₁ = w₁/(s + 1) + u, z₂ = 2 w₂ + w₁, y = w₁ + w₂/2: the control reaches z₁ only, and reads one combination of w.
    fn plant() -> GeneralizedPlant {
        let row = |list: &[f64]| Mat::from_fn(1, list.len(), |_, j| list[j]);
        let d = [[0.0, 0.0, 1.0], [1.0, 2.0, 0.0], [1.0, 0.5, 0.0]];
        GeneralizedPlant {
            system: StateSpace {
                a: row(&[-1.0]),
                b: row(&[1.0, 0.0, 0.0]),
                c: Mat::from_fn(3, 1, |i, _| if i == 0 { 1.0 } else { 0.0 }),
                d: Mat::from_fn(3, 3, |i, j| d[i][j]),
                time: Continuous,
            },
            controls: 1,
            measurements: 1,
            blocks: vec![],
        }
    }

    #[test]
    fn the_floor_is_what_the_control_neither_reaches_nor_reads() {
        let floor = FrequencyFloor::new(&plant()).expect("the plant has a pole");
        let above = |level: f64, left: f64| floor.is_above(level, &[1.0, left, 1.0], &[1.0; 3]);
        // z₂ alone has the norm √5; with w along (−1/2, 1) unread: |(−1/2)/(jω + 1)|² + (3/2)² over 5/4, at most 2.
        let level = 5f64.sqrt();
        assert!(above(0.999 * level, 1.0) && !above(1.001 * level, 1.0));
        assert!(above(2.99 * level, 3.0) && !above(3.01 * level, 3.0));
        // Beside the row that nothing reaches the direction that nothing reads counts: at ω = 0, 1/√5 without z₂.
        let least = (0.25f64 / 1.25).sqrt();
        assert!(above(0.99 * least, 0.0) && !above(1.01 * least, 0.0));
    }
}
