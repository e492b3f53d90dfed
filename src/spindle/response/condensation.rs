//! Modes of a shaft of which the fast coordinates follow the slow ones: a small eigenproblem in place of a large one.
//!
//! Coordinates have unit mass and are ordered by frequency; a are the slow flexible ones, b the fast ones. Under a
//! motion of the slow ones the fast ones take x_b = −Ψ x_a, Ψ = K_bb⁻¹K_ba (static condensation: R. J. Guyan, AIAA J. 3
//! (1965) 380), and (K_aa − K_ab Ψ) v = λ (1 + ΨᵀΨ) v. Their own inertia moves them further by −λ K_bb⁻¹Ψ v; with that,
//! a frequency is off by |Ψ|² (λ/λ_b)² relative, λ_b the square of a fast frequency. Of K_bb = L Lᵀ the columns of L⁻ᵀ
//! are the fast modes, made orthogonal by stiffness to the slow ones: all modes together have the flexibility of the
//! shaft.

use super::shaft_modes::{Modes, frequency};
use crate::linalg::dense::dot;
use crate::linalg::symmetric::DefiniteFactor;
use crate::linalg::{Mat, NumericError, definite_eigen};
use crate::rotor::modes::RIGID;

/// Coordinates from this many ends of a sweep on are fast. On six spindles with three tools each, damped by 0.5 %,
/// every response up to the end of the sweep, antiresonances included, was then off by at most 7e-5 of itself with
/// moduli off by 3 % each, 1.3e-4 with 10 % and 8e-4 with 30 %; the floor of a final fit is 5e-4.
const FAST: f64 = 14.0;

/// Which coordinates of a shaft follow the others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Condensation {
    /// Number of slow coordinates, with the rigid ones; the others are fast.
    slow: usize,
    /// Least frequency of a fast coordinate, rad/s: half of that on the shaft as it is.
    least_rad_s: f64,
}

impl Condensation {
    /// Of coordinates with frequencies `own_rad_s`, ascending, for sweeps that end at `end_rad_s`.
    pub(super) fn new(own_rad_s: &[f64], end_rad_s: f64) -> Self {
        let limit = FAST * end_rad_s;
        Self { slow: own_rad_s.partition_point(|w| *w < limit).max(RIGID + 1), least_rad_s: 0.5 * limit }
    }

    /// The modes of a stiffness on a unit mass matrix; none where a fast coordinate is not fast any more, or where
    /// there is none.
    pub(super) fn modes(&self, stiffness: &Mat<f64>) -> Result<Option<Modes>, NumericError> {
        let (n, slow) = (stiffness.nrows(), self.slow);
        if slow >= n {
            return Ok(None);
        }
        let (a, b) = (slow - RIGID, n - slow);
        let block = |(i, j): (usize, usize), (rows, columns): (usize, usize)| {
            stiffness.submatrix(i, j, rows, columns).to_owned()
        };
        let Some(factor) = DefiniteFactor::new(&block((slow, slow), (b, b))) else {
            return Ok(None);
        };
        let fast = factor.solve_upper(Mat::identity(b, b));
        if (0..b).any(|k| fast[(k, k)] * self.least_rad_s >= 1.0) {
            return Ok(None);
        }
        let half = factor.solve_lower(block((slow, RIGID), (b, a)));
        let still = block((RIGID, RIGID), (a, a)) - half.transpose() * &half;
        let follow = factor.solve_upper(half);
        let mass = Mat::<f64>::identity(a, a) + follow.transpose() * &follow;
        let own = definite_eigen(&still, &mass)?;
        let first = &follow * &own.vectors;
        let mut omega = vec![0.0; RIGID];
        let mut shapes = Mat::identity(n, n);
        for (k, value) in own.values.iter().enumerate() {
            omega.push(frequency(*value));
            let shape = &mut shapes.col_as_slice_mut(RIGID + k)[RIGID..];
            let (slow, fast) = shape.split_at_mut(a);
            slow.copy_from_slice(own.vectors.col_as_slice(k));
            for (x, y) in fast.iter_mut().zip(first.col_as_slice(k)) {
                *x = -y;
            }
        }
        // The correction holds for modes far below the fast ones; it fades out towards these.
        let limit = self.least_rad_s.powi(2);
        let lowest = own.values.partition_point(|value| *value < limit);
        let first = first.subcols(0, lowest).to_owned();
        let further = factor.solve_upper(factor.solve_lower(first.clone()));
        let mut shares = first.transpose() * &fast;
        for (k, value) in own.values[..lowest].iter().enumerate() {
            let by = value * (1.0 - (value / limit).powi(2));
            let (y, z) = (first.col_as_slice(k), further.col_as_slice(k));
            let energy = value + by * by * dot(y, z);
            let mass = 1.0 + 2.0 * by * dot(y, z) + by * by * dot(z, z);
            omega[RIGID + k] = frequency(energy / mass);
            let unit = mass.sqrt().recip();
            let shape = &mut shapes.col_as_slice_mut(RIGID + k)[RIGID..];
            for (x, z) in shape[a..].iter_mut().zip(z) {
                *x -= by * z;
            }
            shape.iter_mut().for_each(|x| *x *= unit);
            let weight = unit * by * mass / energy;
            (0..b).for_each(|j| shares[(k, j)] *= weight);
        }
        let lowest_modes = shapes.submatrix(RIGID, RIGID, n - RIGID, lowest);
        let along = lowest_modes * shares;
        for k in 0..b {
            let own = stiffness[(slow + k, slow + k)].sqrt();
            omega.push(own);
            let column = &mut shapes.col_as_slice_mut(slow + k)[RIGID..];
            for (x, along) in column.iter_mut().zip(along.col_as_slice(k)) {
                *x = own * along;
            }
            for (x, f) in column[a..].iter_mut().zip(fast.col_as_slice(k)) {
                *x += own * f;
            }
        }
        Ok(Some(Modes { omega, shapes }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{c64, symmetric_eigen};
    use crate::spindle::response::shaft_modes::modes;

    /// Stiffness of the springs of a chain whose springs are equal, N/m.
    const EQUAL: f64 = 1e6;
    /// End of a sweep over the chain of 60 masses, rad/s: beyond its first flexible mode, and about half of its
    /// coordinates are fast.
    const END: f64 = 90.0;

    /// Stiffness of a free chain of unit masses whose springs have these factors, in the modes of the chain with equal
    /// springs, behind as many rigid coordinates as a shaft has.
    fn chain(springs: &[f64]) -> Mat<f64> {
        let n = springs.len() + 1;
        let stiffness = |springs: &[f64]| {
            let mut k = Mat::<f64>::zeros(n, n);
            for (i, factor) in springs.iter().enumerate() {
                let spring = EQUAL * factor;
                k[(i, i)] += spring;
                k[(i + 1, i + 1)] += spring;
                k[(i, i + 1)] -= spring;
                k[(i + 1, i)] -= spring;
            }
            k
        };
        let (_, turn) = symmetric_eigen(&stiffness(&vec![1.0; n - 1])).expect("modes");
        let turned = turn.transpose() * stiffness(springs) * &turn;
        Mat::from_fn(n + 1, n + 1, |i, j| if i < RIGID || j < RIGID { 0.0 } else { turned[(i - 1, j - 1)] })
    }

    /// Receptance between all pairs of some rows over the flexible coordinates, with a damping ratio of 0.5 %.
    fn receptances(modes: &Modes, rows: &[Vec<f64>], w: f64) -> Vec<c64> {
        let n = modes.omega.len();
        let seen = |row: &Vec<f64>, k: usize| -> f64 { (RIGID..n).map(|i| row[i] * modes.shapes[(i, k)]).sum() };
        let between = |a: &Vec<f64>, b: &Vec<f64>| -> c64 {
            let term = |k: usize| {
                let own = modes.omega[k];
                seen(a, k) * seen(b, k) / c64::new(own * own - w * w, 0.01 * own * w)
            };
            (RIGID..n).map(term).sum()
        };
        let pairs = rows.iter().flat_map(|a| rows.iter().map(move |b| (a, b)));
        pairs.map(|(a, b)| between(a, b)).collect()
    }

    /// Largest distance of the receptances of condensed modes from those of all, relative to the largest at a line,
    /// over 60 lines from rest to `end`.
    fn off(condensation: &Condensation, stiffness: &Mat<f64>, end: f64) -> Option<f64> {
        let own = condensation.modes(stiffness).expect("modes")?;
        let all = modes(stiffness, &[]).expect("modes");
        let n = stiffness.nrows();
        let row = |seed: usize| (0..n).map(|i| ((i * seed) as f64).cos()).collect();
        let rows: Vec<Vec<f64>> = [1, 2, 3].into_iter().map(row).collect();
        let line = |k: usize| {
            let w = end * k as f64 / 59.0;
            let (want, got) = (receptances(&all, &rows, w), receptances(&own, &rows, w));
            let apart = want.iter().zip(&got).map(|(a, b)| (a - b).norm());
            let size = want.iter().map(|a| a.norm()).fold(0.0, f64::max);
            apart.fold(0.0, f64::max) / size
        };
        Some((0..60).map(line).fold(0.0, f64::max))
    }

    fn of_chain(n: usize) -> Condensation {
        let nominal = chain(&vec![1.0; n - 1]);
        let own: Vec<f64> = (0..=n).map(|k| nominal[(k, k)].max(0.0).sqrt()).collect();
        Condensation::new(&own, END)
    }

    fn springs(n: usize, by: f64) -> Vec<f64> {
        let sign = |i: usize| 1.0 - 2.0 * ((i * i / 3) % 2) as f64;
        (0..n - 1).map(|i| (by * sign(i)).exp()).collect()
    }

    #[test]
    fn a_shaft_as_it_is_has_its_own_modes() {
        let condensation = of_chain(60);
        assert!((20..50).contains(&condensation.slow), "{condensation:?}");
        let error = off(&condensation, &chain(&springs(60, 0.0)), END);
        // Rounding of the largest square of a frequency, at a resonance.
        assert!(error.expect("fast") < 1e-10, "{error:?}");
    }

    #[test]
    fn fast_coordinates_follow_moduli_that_are_off() {
        let condensation = of_chain(60);
        for (by, most) in [(0.03, 1e-5), (0.1, 1e-4), (0.3, 1e-3)] {
            let error = off(&condensation, &chain(&springs(60, by)), END);
            assert!(error.expect("fast") < most, "{by}: {error:?}");
        }
    }

    #[test]
    fn together_the_modes_have_the_flexibility_of_the_shaft() {
        let condensation = of_chain(60);
        let error = off(&condensation, &chain(&springs(60, 0.3)), 0.0);
        assert!(error.expect("fast") < 1e-4, "{error:?}");
    }

    #[test]
    fn what_is_not_fast_any_more_is_not_condensed() {
        let condensation = of_chain(60);
        let soft = vec![0.01; 59];
        assert_eq!(off(&condensation, &chain(&soft), END), None);
        let all = Condensation { slow: 61, ..condensation };
        assert_eq!(off(&all, &chain(&soft), END), None);
    }
}
