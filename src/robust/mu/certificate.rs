//! Proof that μ stays below a level at every frequency, by scalings that are frozen over intervals.
//!
//! For one scaling (D, G) and a level β the frequencies where λ_max(M̃ᴴM̃ + j(G̃M̃ − M̃ᴴG̃ᴴ)) = β² are axis eigenvalues
//! of
//!   H = [A − B R⁻¹Sᴴ, −B R⁻¹Bᴴ; −Q + S R⁻¹Sᴴ, −Aᴴ + S R⁻¹Bᴴ]
//! with Q = CᴴC, S = Cᴴ(D − jG̃ᴴ), R = DᴴD − jDᴴG̃ᴴ + jG̃D − β²I of the scaled system. Between two of them the bound of
//! the scaling stays on one side of β. The sweep goes from 0 to ∞: the scaling of a frequency a little ahead proves an
//! interval up to its next crossing, the next scaling starts there.
//!
//! Rounding moves axis eigenvalues off the axis: every eigenvalue near the axis counts as a possible crossing, and
//! every interval between two of them is tested at its middle. A false candidate costs time only.

use super::level_form::LevelForm;
use super::system::{MuPoint, MuSystem};
use crate::linalg::dense::complex;
use crate::linalg::hermitian::inverse_complex;
use crate::linalg::{Mat, NumericError, c64, eigenvalues, eigenvalues_complex};
use crate::lti::norm::hamiltonian;
use crate::lti::scale::balancing;
use crate::robust::structure::{MuError, Scaling};

/// Frozen scalings at most; a flat μ over seven decades needs a few hundred.
const MAX_SCALINGS: usize = 1500;
/// Distance from the axis, relative to the modulus, below which an eigenvalue counts as a possible crossing.
const NEAR_AXIS: f64 = 1e-3;

/// A crossing of the real line so close ahead of where the sweep stands is what stops it.
const NEAR: f64 = 1e-3;
/// Share of the level up to which a bound is as good as a lower one, where a smaller G reaches further.
const ENOUGH: f64 = 0.9;

/// Covers all frequencies with scalings whose bound is below (1 + slack) times the largest value met; that value grows
/// when the sweep meets a larger one. Crossings are eigenvalues of `form`. Returns the point of that value and the
/// number of scalings.
pub(super) fn certify(
    system: &MuSystem,
    attained: MuPoint,
    points: &[MuPoint],
    slack: f64,
    form: &LevelForm,
) -> Result<(MuPoint, usize), MuError> {
    let mut best = attained;
    if best.upper <= 0.0 {
        return Ok((best, 0));
    }
    let sweep = CertificateSweep { system, points, form };
    let (mut covered, mut ahead, mut scalings) = (0.0f64, 0.05f64, 0);
    while covered < f64::INFINITY {
        let level = best.upper * (1.0 + slack);
        scalings += 1;
        if scalings > MAX_SCALINGS {
            return Err(MuError::NotCovered { covered_to_rad_s: covered, steps: scalings });
        }
        let trial = sweep.trial(covered, ahead)?;
        if trial.upper > best.upper {
            best = trial;
            continue;
        }
        let reach = sweep.reach(&sweep.moderate(&trial, level), covered, level)?;
        if let Some(end) = reach.filter(|e| *e > covered * (1.0 + 1e-9)) {
            if covered > 0.0 && end.is_finite() {
                ahead = (2.0 * ahead).min(0.6 * (end / covered).ln()).max(1e-6);
            }
            covered = end;
            continue;
        }
        if ahead > 1e-5 && covered > 0.0 {
            ahead *= 0.3;
            continue;
        }
        // The scaling of the very frequency where the sweep stands.
        let here = system.point(covered)?;
        if here.upper > best.upper {
            best = here;
            continue;
        }
        let mut end = sweep.reach(&here.scaling, covered, level)?.unwrap_or(covered);
        // A scaling of extreme spread (at DC, where a loop may fall apart) loses digits: those of the next points serve
        // too.
        for point in sweep.points.iter().filter(|p| p.omega_rad_s > covered).take(12) {
            if end <= covered * (1.0 + 1e-9) {
                end = sweep.reach(&point.scaling, covered, level)?.unwrap_or(covered);
            }
        }
        // Where a real parameter makes the loop real the bound of any other frequency jumps.
        for crossing in system.crossings.iter().filter(|c| c.omega_rad_s >= covered * (1.0 - 1e-6)) {
            if end <= covered * (1.0 + 1e-9) && crossing.omega_rad_s <= covered * (1.0 + NEAR) {
                end = sweep.reach(&system.scaling_across(crossing)?.scaling, covered, level)?.unwrap_or(covered);
            }
        }
        if end <= covered * (1.0 + 1e-9) {
            return Err(MuError::NotCovered { covered_to_rad_s: covered, steps: scalings });
        }
        covered = end;
    }
    Ok((best, scalings))
}

struct CertificateSweep<'a> {
    system: &'a MuSystem,
    points: &'a [MuPoint],
    form: &'a LevelForm,
}

impl CertificateSweep<'_> {
    /// The scaling to try next: of a point already met when one lies well ahead of where the sweep stands, else a new
    /// one.
    fn trial(&self, covered: f64, ahead: f64) -> Result<MuPoint, MuError> {
        if covered == 0.0 {
            return self.system.point(0.0);
        }
        let target = covered * ahead.exp();
        let met = self.points.iter().find(|p| {
            p.omega_rad_s >= covered * (1.0 + 0.7 * (target / covered - 1.0))
                && p.omega_rad_s <= covered * (1.0 + 1.3 * (target / covered - 1.0))
        });
        match met {
            Some(point) => Ok(point.clone()),
            None => self.system.point(target),
        }
    }

    /// The scaling of a point with the smallest G, in steps of a decade, that keeps its bound well below the level: the
    /// bound changes less over frequency.
    fn moderate(&self, point: &MuPoint, level: f64) -> Scaling {
        let mut scaling = point.scaling.clone();
        if scaling.skew.norm_max() == 0.0 {
            return scaling;
        }
        let response = self.system.response(point.omega_rad_s);
        for _ in 0..8 {
            let smaller = Scaling {
                skew: Mat::from_fn(scaling.skew.nrows(), scaling.skew.ncols(), |i, j| scaling.skew[(i, j)] * 0.1),
                ..scaling.clone()
            };
            if smaller.bound_at(&response) < ENOUGH * level {
                scaling = smaller;
            } else {
                break;
            }
        }
        scaling
    }

    /// End of the interval from `from` on in which the scaling keeps the bound below the level; `None` when it is not
    /// below at `from`.
    fn reach(&self, scaling: &Scaling, from: f64, level: f64) -> Result<Option<f64>, MuError> {
        // The norm is never below the bound: just under the level it is enough.
        let enough = level * (1.0 - f64::EPSILON);
        let below = |omega: f64| scaling.bound_from(&self.system.response(omega), enough) < level;
        if !below(from) {
            return Ok(None);
        }
        let crossings = crossings(self.form, scaling, level)?;
        let mut end = from;
        for crossing in crossings.into_iter().filter(|w| *w > from) {
            let middle = 0.5 * (end + crossing);
            if !below(middle) {
                return Ok(Some(end));
            }
            end = crossing;
            if !below(crossing) && scaling.skew.norm_max() > 0.0 {
                // With G the bound is steep, and the eigenvalue less exact than the place where the bound fails.
                return Ok(Some(last_below(&below, middle, crossing)));
            }
            if !below(crossing) {
                // The crossing itself is at the level: stop short of it by more than its error.
                let short = crossing - 1e-6 * (crossing - from);
                return Ok(Some(short.max(from)));
            }
        }
        if below(2.0 * end + 1e-300) && below(f64::INFINITY) {
            return Ok(Some(f64::INFINITY));
        }
        Ok(Some(end))
    }
}

/// The last frequency, to rounding, at which the bound is below, between one where it is and one where it is not.
fn last_below(below: &impl Fn(f64) -> bool, mut lo: f64, mut hi: f64) -> f64 {
    loop {
        let middle = 0.5 * (lo + hi);
        if middle <= lo || middle >= hi {
            return lo;
        }
        *(if below(middle) { &mut lo } else { &mut hi }) = middle;
    }
}

/// Frequencies (ascending, rad/s) where the bound of a scaling may meet a level.
fn crossings(form: &LevelForm, scaling: &Scaling, level: f64) -> Result<Vec<f64>, NumericError> {
    let scaled = form.system.scale_states(&balancing(&form.system));
    let level = form.level(scaling, level);
    let is_real = |m: &Mat<c64>| (0..m.ncols()).all(|j| (0..m.nrows()).all(|i| m[(i, j)].im == 0.0));
    let plain = scaling.skew.norm_max() == 0.0 && is_real(&scaling.left) && is_real(&scaling.right);
    let values = if plain {
        let real = |m: &Mat<c64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)].re);
        let right = real(&inverse_complex(&scaling.right));
        let own = scaled.scale_inputs(&right).scale_outputs(&real(&scaling.left));
        eigenvalues(&hamiltonian(&own, level)?)?
    } else {
        eigenvalues_complex(&popov(&scaled, scaling, level)?)?
    };
    let largest = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    // Rounding of the smallest eigenvalues is set by the largest.
    let mut list: Vec<f64> = values
        .iter()
        .filter(|v| v.re.abs() <= NEAR_AXIS * v.norm() + 1e-12 * largest && v.im > 0.0)
        .map(|v| v.im)
        .collect();
    list.sort_by(f64::total_cmp);
    list.dedup();
    Ok(list)
}

/// The matrix H of the module for a complex scaling with G.
fn popov(
    system: &crate::lti::StateSpace<crate::lti::Continuous>,
    scaling: &Scaling,
    level: f64,
) -> Result<Mat<c64>, NumericError> {
    let inverse = inverse_complex(&scaling.right);
    let (a, n) = (complex(&system.a), system.order());
    let b = complex(&system.b) * &inverse;
    let c = &scaling.left * complex(&system.c);
    let d = &scaling.left * complex(&system.d) * &inverse;
    let g = Mat::from_fn(d.nrows(), d.ncols(), |i, j| c64::new(0.0, -1.0) * scaling.skew[(j, i)].conj());
    let cross = d.adjoint() * &g;
    let product = d.adjoint() * &d;
    let r = Mat::from_fn(d.ncols(), d.ncols(), |i, j| {
        let own = if i == j { level * level } else { 0.0 };
        product[(i, j)] + cross[(i, j)] + cross[(j, i)].conj() - own
    });
    let s = c.adjoint() * (&d + &g);
    let r = inverse_complex(&r);
    if !r.is_all_finite() {
        return Err(NumericError::Singular { what: "feedthrough of the level test", rcond: 0.0 });
    }
    let top = &a - &b * &r * s.adjoint();
    let right = &b * &r * b.adjoint();
    let left = &s * &r * s.adjoint() - c.adjoint() * &c;
    Ok(Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => top[(i, j)],
        (true, false) => -right[(i, j - n)],
        (false, true) => left[(i - n, j)],
        (false, false) => -top[(j - n, i - n)].conj(),
    }))
}
