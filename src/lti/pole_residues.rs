//! The response of a sampled system from one input to one output as a sum over its poles,
//! f(θ) = d + Σ_k r_k/(e^{jθ} − p_k), and its largest modulus with a certificate.
//!
//! Between two angles a distance w apart f stays within M w²/8 of the straight line between its values there, with
//! M ≥ |f″|, and on that line |f| is largest at an end. With δ_k the distance of the arc from p_k,
//! |f″| ≤ Σ |r_k| (δ_k⁻² + 2δ_k⁻³). Arcs whose bound is above the largest value met are halved.

use super::line_maximum::LineMaximum;
use super::norm::HinfNorm;
use crate::linalg::c64;
use crate::linalg::lanes::WIDTH;
use std::f64::consts::{PI, TAU};

/// A response with real coefficients: that at −θ is the conjugate of that at θ.
#[derive(Clone, Debug)]
pub(crate) struct PoleResidues {
    terms: Vec<FourTerms>,
    poles: Vec<c64>,
    direct: c64,
}

/// Four poles with their residues; what fills up the last ones has none.
#[derive(Clone, Copy, Debug)]
struct FourTerms {
    pole: [[f64; WIDTH]; 2],
    residue: [[f64; WIDTH]; 2],
    size: [f64; WIDTH],
    /// 1 − |p|, the least distance from the unit circle.
    gap: [f64; WIDTH],
}

/// Lines on each side of a pole at first: one, three and nine times its distance from the unit circle away.
const BESIDE: [f64; 7] = [-9.0, -3.0, -1.0, 0.0, 1.0, 3.0, 9.0];
/// Arcs at most; residues that cancel to many digits would need more.
const MOST_ARCS: usize = 40_000;
/// Width of the search for the largest value, of the arc that it is in.
const PLACE: f64 = 1e-4;

impl PoleResidues {
    /// From poles inside the unit circle and their residues.
    pub(crate) fn new(terms: &[(c64, c64)], direct: c64) -> Self {
        let zero = c64::new(0.0, 0.0);
        let four = |some: &[(c64, c64)]| {
            let at = |l: usize| some.get(l).copied().unwrap_or((zero, zero));
            let each = |of: &dyn Fn((c64, c64)) -> f64| std::array::from_fn(|l| of(at(l)));
            FourTerms {
                pole: [each(&|(p, _)| p.re), each(&|(p, _)| p.im)],
                residue: [each(&|(_, r)| r.re), each(&|(_, r)| r.im)],
                size: each(&|(_, r)| r.norm()),
                gap: each(&|(p, _)| 1.0 - p.norm()),
            }
        };
        Self { terms: terms.chunks(WIDTH).map(four).collect(), poles: terms.iter().map(|(p, _)| *p).collect(), direct }
    }

    /// f(θ), and a bound of |f″| within `half` of θ.
    fn at(&self, theta: f64, half: f64) -> (c64, f64) {
        let (y, x) = theta.sin_cos();
        let (mut re, mut im, mut bend) = ([0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
        for four in &self.terms {
            for l in 0..WIDTH {
                let (a, b) = (x - four.pole[0][l], y - four.pole[1][l]);
                let square = a * a + b * b;
                let (r, i) = (four.residue[0][l], four.residue[1][l]);
                re[l] += (r * a + i * b) / square;
                im[l] += (i * a - r * b) / square;
                let distance = (square.sqrt() - half).max(four.gap[l]);
                let inverse = 1.0 / distance;
                bend[l] += four.size[l] * inverse * inverse * (1.0 + 2.0 * inverse);
            }
        }
        let sum = |four: [f64; WIDTH]| (four[0] + four[1]) + (four[2] + four[3]);
        (self.direct + c64::new(sum(re), sum(im)), sum(bend))
    }

    /// f(θ).
    pub(crate) fn value(&self, theta: f64) -> c64 {
        self.at(theta, 0.0).0
    }

    /// Angles from 0 to π to begin with.
    fn first_angles(&self) -> Vec<f64> {
        let near = self.poles.iter().filter(|p| p.im >= 0.0).flat_map(|p| {
            let (angle, gap) = (p.arg(), 1.0 - p.norm());
            BESIDE.map(|away| angle + away * gap)
        });
        let mut angles: Vec<f64> = near.filter(|angle| (0.0..=PI).contains(angle)).collect();
        angles.extend([0.0, PI]);
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        angles
    }

    /// Largest modulus on the unit circle, of a system sampled every `period_s`, to a relative tolerance; none when
    /// that takes too many arcs, or where a pole is not inside the circle.
    pub(crate) fn largest(&self, period_s: f64, rel_tol: f64) -> Option<HinfNorm> {
        if !self.poles.iter().all(|p| p.norm() < 1.0) {
            return None;
        }
        let size = |theta: f64| self.value(theta).norm();
        let angles = self.first_angles();
        let sizes: Vec<f64> = angles.iter().map(|theta| size(*theta)).collect();
        let k = (0..sizes.len()).reduce(|a, b| if sizes[b] > sizes[a] { b } else { a })?;
        let point = |k: usize| (angles[k], sizes[k]);
        let mut best = point(k);
        if k > 0 && k + 1 < angles.len() {
            let beside = [point(k - 1), best, point(k + 1)];
            let mut search = LineMaximum::new(beside, PLACE * (beside[2].0 - beside[0].0));
            while let Some(theta) = search.next() {
                search.add(theta, size(theta));
            }
            best = search.best();
        }
        let mut upper = best.1;
        let mut arcs: Vec<[(f64, f64); 2]> = (1..angles.len()).map(|k| [point(k - 1), point(k)]).collect();
        let mut left = MOST_ARCS;
        while let Some([low, high]) = arcs.pop() {
            left = left.checked_sub(1)?;
            let width = high.0 - low.0;
            let middle = 0.5 * (low.0 + high.0);
            let (value, bend) = self.at(middle, 0.5 * width);
            let value = value.norm();
            if value > best.1 {
                best = (middle, value);
            }
            // Of both halves.
            let most = low.1.max(high.1).max(value) + bend * width * width / 32.0;
            if most <= best.1 * (1.0 + rel_tol) {
                upper = upper.max(most);
            } else if width > f64::EPSILON * TAU {
                let middle = (middle, value);
                arcs.extend([[low, middle], [middle, high]]);
            } else {
                return None;
            }
        }
        Some(HinfNorm { norm: best.1, peak_omega_rad_s: best.0 / period_s, upper: upper.max(best.1) })
    }
}

#[cfg(test)]
mod tests {
    use super::super::norm::hinf_norm_discrete;
    use super::super::{Discrete, Response, StateSpace};
    use super::*;
    use crate::linalg::Mat;

    /// Pairs of poles of these moduli and angles, their residues turned by numbers of pairs.
    fn pairs(moduli: &[f64]) -> Vec<(c64, c64)> {
        let pair = |(k, modulus): (usize, &f64)| {
            let p = c64::from_polar(*modulus, 0.15 + 0.6 * k as f64);
            let r = c64::from_polar((1.0 - modulus) * (1.0 + k as f64), (5 * k + 1) as f64);
            [(p, r), (p.conj(), r.conj())]
        };
        moduli.iter().enumerate().flat_map(pair).collect()
    }

    /// The same system in real coordinates.
    fn system(terms: &[(c64, c64)], direct: f64, period_s: f64) -> StateSpace<Discrete> {
        let n = terms.len();
        let first = |k: usize| terms[k - k % 2];
        let a = Mat::from_fn(n, n, |i, j| match (i / 2 == j / 2, i % 2, j % 2) {
            (false, ..) => 0.0,
            (_, 0, 1) => first(i).0.im,
            (_, 1, 0) => -first(i).0.im,
            _ => first(i).0.re,
        });
        // 2 Re(r/(z − p)) from an input on the first coordinate of a pair.
        let b = Mat::from_fn(n, 1, |i, _| f64::from(i % 2 == 0));
        let c = Mat::from_fn(1, n, |_, j| match j % 2 {
            0 => 2.0 * first(j).1.re,
            _ => 2.0 * first(j).1.im,
        });
        let d = Mat::from_fn(1, 1, |_, _| direct);
        StateSpace::new(a, b, c, d, Discrete { period_s }).expect("shapes fit")
    }

    #[test]
    fn the_largest_modulus_is_the_norm_by_level_sets() {
        for moduli in [vec![0.5], vec![0.9, 0.99, 0.3], vec![0.999, 0.9995, 0.9, 0.2, 0.97], vec![0.999_99, 0.8]] {
            let (terms, period_s) = (pairs(&moduli), 1e-4);
            let response = PoleResidues::new(&terms, c64::from(0.4));
            let system = system(&terms, 0.4, period_s);
            for theta in [0.01, 0.9, 2.5] {
                let exact = system.at(theta / period_s)[(0, 0)];
                assert!((response.value(theta) - exact).norm() < 1e-12 * (1.0 + exact.norm()));
            }
            let exact = hinf_norm_discrete(&system, 1e-10).expect("stable");
            for tolerance in [1e-2, 1e-4, 1e-7] {
                let found = response.largest(period_s, tolerance).expect("few arcs");
                assert!(found.norm <= exact.upper * (1.0 + 1e-12) && found.upper >= exact.norm);
                assert!(found.upper <= found.norm * (1.0 + tolerance));
            }
        }
    }

    #[test]
    fn a_pole_outside_the_circle_has_no_largest_modulus() {
        let response = PoleResidues::new(&pairs(&[1.0001]), c64::from(0.0));
        assert!(response.largest(1e-4, 1e-4).is_none());
    }

    #[test]
    fn a_bend_is_bounded_over_its_arc() {
        let response = PoleResidues::new(&pairs(&[0.9, 0.97]), c64::from(1.0));
        let step = 1e-4;
        for centre in [0.1, 0.14, 0.7, 0.76, 1.4] {
            let bound = response.at(centre, 0.02).1;
            for k in -19..20 {
                let theta = centre + 1e-3 * f64::from(k);
                let f = |away: f64| response.value(theta + away);
                let bend = (f(step) - 2.0 * f(0.0) + f(-step)) / (step * step);
                assert!(bend.norm() < bound * (1.0 + 1e-5));
            }
        }
    }
}
