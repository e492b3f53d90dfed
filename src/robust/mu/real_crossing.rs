//! Real parameters over frequency. A real Δ makes the loop singular only at frequencies where an eigenvalue of ΔM(jω)
//! is real: with one parameter these are single points, beside which μ is zero, and a grid of frequencies misses them.
//! They are found by the sign of the imaginary part on a grid that is dense round the poles, and are points of the
//! search for the peak. From there and from the peak eigenvalues are followed for a lower bound.

use super::MuBounds;
use super::lower::{SingularDelta, list_unrestored, singular};
use super::system::{MuPoint, MuSystem};
use super::vertex_crossing::RealCrossing;
use crate::linalg::{Mat, c64, eigenvalues_complex};
use crate::robust::structure::{MuError, Scaling, Structure};

/// Share of the upper bound from which a lower bound is left as it is.
const CLOSE: f64 = 0.99;
/// The search goes this far from the peak, relative to its frequency: other peaks have grid points of their own.
const REACH: f64 = 0.5;
/// Smallest relative step: the width of a peak of damping 1e-9.
const FIRST_STEP: f64 = 1e-9;
/// Ratio of two steps: a branch turns by a few degrees between them on the flank of a resonance.
const STEP_RATIO: f64 = 1.25;
/// Bisections down to neighbouring numbers.
const HALVINGS: usize = 80;

/// Parameters up to which all their signs are met together.
const MOST_TOGETHER: usize = 5;
/// Distances from a lightly damped pole in its widths: decades, and points in each. A residue of size one moves a
/// crossing by a width; smaller ones lie between the poles, where the grid of the system is.
const WIDTH_DECADES: [i32; 2] = [-2, 4];
const PER_DECADE: i32 = 8;

impl MuSystem {
    /// Crossings of the vertices of the real parameters, one by one and all together.
    pub(super) fn find_real_crossings(&self) -> Vec<RealCrossing> {
        let grid = self.dense_grid();
        let responses: Vec<Mat<c64>> = grid.iter().map(|w| self.response(*w)).collect();
        let mut found = vec![];
        for delta in vertices(&self.structure) {
            let values: Vec<Vec<c64>> = responses.iter().map(|m| eigenvalues_of(&delta, m)).collect();
            for k in 1..grid.len() {
                for before in &values[k - 1] {
                    let Some(after) = nearest(&values[k], *before) else {
                        continue;
                    };
                    let is_crossing = before.im * after.im < 0.0 && before.re * after.re > 0.0;
                    if is_crossing {
                        let (omega_rad_s, value) = self.bisect(&delta, [(grid[k - 1], *before), (grid[k], after)]);
                        found.push(RealCrossing { omega_rad_s, delta: delta.clone(), value });
                    }
                }
            }
        }
        found
    }

    /// The scaling without G at a crossing: beside it the scalings of neighbours, whose G is large, bound nothing.
    pub(super) fn scaling_across(&self, crossing: &RealCrossing) -> Result<MuPoint, MuError> {
        let mut point = self.point(crossing.omega_rad_s)?;
        point.scaling =
            Scaling { skew: Mat::zeros(point.scaling.skew.nrows(), point.scaling.skew.ncols()), ..point.scaling };
        Ok(point)
    }

    fn dense_grid(&self) -> Vec<f64> {
        let mut list = self.grid();
        for pole in self.poles.iter().filter(|p| p.im > 0.0) {
            let width = pole.re.abs();
            let [first, last] = WIDTH_DECADES.map(|decade| decade * PER_DECADE);
            for k in first..=last {
                let distance = width * 10f64.powf(f64::from(k) / f64::from(PER_DECADE));
                // Beyond the frequency itself the grid of the system is dense enough.
                if distance < 0.5 * pole.im {
                    list.extend([pole.im - distance, pole.im + distance]);
                }
            }
        }
        list.retain(|w| w.is_finite() && *w > 0.0);
        list.sort_by(f64::total_cmp);
        list.dedup();
        list
    }

    /// Where an eigenvalue whose imaginary part has another sign at each end is real.
    fn bisect(&self, delta: &Mat<c64>, [mut lo, mut hi]: [(f64, c64); 2]) -> (f64, c64) {
        let smaller = |lo: (f64, c64), hi: (f64, c64)| if lo.1.im.abs() < hi.1.im.abs() { lo } else { hi };
        for _ in 0..HALVINGS {
            let mid = 0.5 * (lo.0 + hi.0);
            let near = smaller(lo, hi).1;
            let Some(value) = nearest(&eigenvalues_of(delta, &self.response(mid)), near) else {
                break;
            };
            if mid == lo.0 || mid == hi.0 {
                break;
            }
            let end = if value.im * lo.1.im > 0.0 { &mut lo } else { &mut hi };
            *end = (mid, value);
        }
        smaller(lo, hi)
    }

    /// Raises the lower bound of `bounds`, which belong to `omega`, where real parameters leave it below the upper one.
    /// The frequency of the lower bound, rad/s.
    pub(super) fn raise_lower(&self, bounds: &mut MuBounds, omega: f64) -> Result<f64, MuError> {
        let mut place = omega;
        if !self.structure.has_real() {
            return Ok(place);
        }
        let mut take = |found: SingularDelta, at: f64, bounds: &mut MuBounds| {
            if found.value > bounds.lower {
                (bounds.lower, bounds.delta, place) = (found.value, found.delta, at);
            }
        };
        // The response is real at both ends of the axis.
        for end in [0.0, f64::INFINITY] {
            if bounds.lower < CLOSE * bounds.upper {
                let own = self.bounds(end)?;
                take(SingularDelta { value: own.lower, delta: own.delta, singularity: f64::NAN }, end, bounds);
            }
        }
        for crossing in &self.crossings {
            let sign = c64::new(crossing.value.re.signum(), 0.0);
            let m = self.response(crossing.omega_rad_s);
            let delta = Mat::from_fn(m.ncols(), m.nrows(), |i, j| crossing.delta[(i, j)] * sign);
            if let Some(found) = singular(&m, &self.structure, &delta, crossing.value * sign) {
                take(found, crossing.omega_rad_s, bounds);
            }
        }
        if !(omega > 0.0 && omega.is_finite()) {
            return Ok(place);
        }
        for (delta, lambda) in list_unrestored(&self.response(omega), &self.structure, &bounds.scaling) {
            if bounds.lower >= CLOSE * bounds.upper {
                break;
            }
            for side in [-1.0, 1.0] {
                let Some((at, found)) = self.crossing(&delta, (omega, lambda), side) else {
                    continue;
                };
                take(found, at, bounds);
                // Other blocks have room to gain where the loop can be singular at all.
                if bounds.lower < CLOSE * bounds.upper && self.structure.spans.len() > 1 {
                    let own = self.bounds(at)?;
                    take(SingularDelta { value: own.lower, delta: own.delta, singularity: f64::NAN }, at, bounds);
                }
            }
        }
        Ok(place)
    }

    /// The first frequency on one side at which the eigenvalue of ΔM(jω) that starts as `from` is real and positive,
    /// and the perturbation there.
    fn crossing(&self, delta: &Mat<c64>, from: (f64, c64), side: f64) -> Option<(f64, SingularDelta)> {
        let (start, mut near) = from;
        let follow = |omega: f64, near: c64| nearest(&eigenvalues_of(delta, &self.response(omega)), near);
        let (mut omega, mut step) = (start, FIRST_STEP);
        let (lo, hi) = loop {
            let next = start * (1.0 + side * step);
            let value = follow(next, near)?;
            if value.im * near.im <= 0.0 && value.re > 0.0 {
                break ((omega, near), (next, value));
            }
            (omega, near) = (next, value);
            step *= STEP_RATIO;
            if step > REACH {
                return None;
            }
        };
        let (at, lambda) = self.bisect(delta, [lo, hi]);
        let found = singular(&self.response(at), &self.structure, delta, lambda)?;
        Some((at, found))
    }
}

/// Δ with ±1 for the real parameters: each alone, and all of them with every sign but a common one.
fn vertices(structure: &Structure) -> Vec<Mat<c64>> {
    let real: Vec<_> = structure.spans.iter().filter(|span| span.is_real()).collect();
    let with = |signs: &dyn Fn(usize) -> f64| {
        let mut delta = Mat::zeros(structure.inputs(), structure.outputs());
        for (k, span) in real.iter().enumerate() {
            for (i, j) in span.w.clone().zip(span.z.clone()) {
                delta[(i, j)] = c64::new(signs(k), 0.0);
            }
        }
        delta
    };
    let mut list: Vec<Mat<c64>> = (0..real.len()).map(|own| with(&|k| f64::from(u8::from(k == own)))).collect();
    if (2..=MOST_TOGETHER).contains(&real.len()) {
        let signs = 0..1usize << (real.len() - 1);
        list.extend(signs.map(|signs| with(&|k| if (signs >> k) & 1 == 0 { 1.0 } else { -1.0 })));
    }
    list
}

/// Eigenvalues of ΔM apart from zeros; none when they fail.
fn eigenvalues_of(delta: &Mat<c64>, m: &Mat<c64>) -> Vec<c64> {
    let mut list = eigenvalues_complex(&(delta * m)).unwrap_or_default();
    list.retain(|v| v.norm() > 0.0);
    list
}

fn nearest(list: &[c64], to: c64) -> Option<c64> {
    list.iter().copied().min_by(|x, y| (x - to).norm().total_cmp(&(y - to).norm()))
}
