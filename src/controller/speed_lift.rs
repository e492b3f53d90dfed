//! Gain of the lifted sampled loop from a speed perturbation back to itself (small-gain bound).
//!
//! The undelayed plant is affine in the speed, ẋ = (A₀ + Ω A₁) x + B u, C and B do not depend on it: A₁ holds the
//! gyroscopic matrix and the circulatory part of rotating damping. Write A₁ = L R with L Lᵀ = (A₁A₁ᵀ)^{1/2}, RᵀR =
//! (A₁ᵀA₁)^{1/2}. The loop at Ω + δ is the loop at Ω with w = δ z, z = R x, where w enters by L w at every instant, not
//! only at the samples. Lifted over one period, z = M w with signals in L²[0, T]:
//!   M = O (zI − A_c)⁻¹ C + V,   C w = ∫₀ᵀ e^{A(T−s)} L w(s) ds,   (O ξ)(s) = R x(s) from the states and held commands
//!   ξ,
//!   (V w)(s) = R ∫₀ˢ e^{A(s−t)} L w(t) dt.
//! C Cᵀ and OᵀO are gramians over a finite time, so the first part has the norm of a finite sampled system; V is
//! bounded by its Hilbert–Schmidt norm. By the small-gain theorem the loop is stable for every |δ| ≤ 1/(‖O(zI −
//! A_c)⁻¹C‖∞ + ‖V‖), both norms from above. No bilinear or first-order approximation of the hold enters. Numbers are
//! doubles, not intervals.

use super::ControllerError;
use crate::linalg::equal_planes::{EqualPlanes, above_rounding};
use crate::linalg::{Mat, NumericError, svd, symmetric_eigen};
use crate::lti::connect::{lower_lft, stack_cols, stack_rows};
use crate::lti::delay::{hold, sample_with_delay};
use crate::lti::norm::stays_below;
use crate::lti::{Continuous, Discrete, StateSpace, TimeBase};
use crate::spindle::Plant;
use crate::spindle::plant::AXES;

/// The plant as an affine function of the speed, with its sampling.
#[derive(Clone, Debug)]
pub(crate) struct AffinePlant {
    /// Plant without delay at rest; the first [`AXES`] inputs are commands, the first [`AXES`] outputs signals.
    pub at_rest: StateSpace<Continuous>,
    /// dA/dΩ.
    pub slope: Mat<f64>,
    /// L Lᵀ.
    force: Mat<f64>,
    /// RᵀR.
    read: Mat<f64>,
    /// The same as a plant, which knows the planes of its states.
    plant: Plant,
    /// Delay beyond the hold, s.
    pub delay_s: f64,
    /// Sample period, s.
    pub period_s: f64,
}

/// What the loop at one speed proves about its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Neighbourhood {
    /// Growth rate of the loop at this speed, 1/s.
    pub growth_rate_per_s: f64,
    /// Whether the loop is stable at every speed within the distance asked for.
    pub proven: bool,
    /// A distance worth asking for next, rad/s: from the largest gain met; zero for an unstable loop.
    pub advised_rad_s: f64,
    /// Frequency of that gain, rad/s.
    pub omega_rad_s: f64,
}

/// Largest deviation from an affine function of the speed that counts as rounding, relative to the largest entry.
const AFFINE: f64 = 1e-11;
/// Eigenvalues of a gramian below this share of the largest are rounding.
const GRAMIAN_ROUNDING: f64 = 1e-15;
/// Pieces of a period in the bound of the part within a sample.
const PIECES: usize = 8;

impl AffinePlant {
    /// From the plant at rest, and the undelayed plants at rest, at half and at full `speed_rad_s`.
    pub(crate) fn new(
        plant: &Plant,
        [rest, half, full]: [StateSpace<Continuous>; 3],
        speed_rad_s: f64,
        delay_s: f64,
        period_s: f64,
    ) -> Result<Self, ControllerError> {
        let n = rest.order();
        let slope = Mat::from_fn(n, n, |i, j| (full.a[(i, j)] - rest.a[(i, j)]) / speed_rad_s);
        let middle = Mat::from_fn(n, n, |i, j| half.a[(i, j)] - rest.a[(i, j)] - 0.5 * speed_rad_s * slope[(i, j)]);
        let change = [&half, &full]
            .iter()
            .flat_map(|p| [&p.b - &rest.b, &p.c - &rest.c, &p.d - &rest.d])
            .zip([&rest.b, &rest.c, &rest.d].iter().cycle())
            .map(|(change, whole)| change.norm_max() / whole.norm_max().max(f64::MIN_POSITIVE))
            .fold(middle.norm_max() / rest.a.norm_max(), f64::max);
        if change > AFFINE {
            return Err(ControllerError::Numeric {
                step: "speed proof",
                source: NumericError::Dimension {
                    what: "plant over speed",
                    expected: "an affine function of the speed".into(),
                    found: format!("a deviation of {change:.1e} at half the top speed"),
                },
            });
        }
        // |A₁ᵀ| = L Lᵀ and |A₁| = RᵀR.
        let f = svd(&slope).map_err(super::in_step("speed proof"))?;
        let modulus = |v: &Mat<f64>| Mat::from_fn(n, n, |i, j| (0..n).map(|k| v[(i, k)] * f.s[k] * v[(j, k)]).sum());
        Ok(Self {
            force: modulus(&f.u),
            read: modulus(&f.v),
            at_rest: rest,
            plant: plant.clone(),
            slope,
            delay_s,
            period_s,
        })
    }

    /// Whether the sampled loop with u = K y is stable at every speed within `distance_rad_s` of `speed_rad_s`.
    pub(crate) fn neighbourhood(
        &self,
        controller: &StateSpace<Discrete>,
        speed_rad_s: f64,
        distance_rad_s: f64,
    ) -> Result<Neighbourhood, ControllerError> {
        self.examine(controller, speed_rad_s, distance_rad_s).map_err(super::in_step("speed proof"))
    }

    fn examine(
        &self,
        controller: &StateSpace<Discrete>,
        speed_rad_s: f64,
        distance_rad_s: f64,
    ) -> Result<Neighbourhood, NumericError> {
        let n = self.at_rest.order();
        let a = Mat::from_fn(n, n, |i, j| self.at_rest.a[(i, j)] + speed_rad_s * self.slope[(i, j)]);
        let (inside, reached) = self.within_a_sample(&a)?;
        let lifted = self.lift_speed(&a, &reached)?;
        let closed = lower_lft(&lifted, controller)?;
        let planes = self.plant.planes_of_loop(lifted.order(), controller)?;
        let allowed = 1.0 / distance_rad_s - inside;
        let poles = EqualPlanes::eigenvalues_on(planes.as_ref(), &closed.a)?;
        let growth_rate_per_s = closed.time.largest_growth_rate(&poles);
        let unproven = |advised_rad_s: f64, omega_rad_s: f64| Neighbourhood {
            growth_rate_per_s,
            proven: false,
            advised_rad_s,
            omega_rad_s,
        };
        if growth_rate_per_s >= 0.0 {
            return Ok(unproven(0.0, f64::NAN));
        }
        if allowed <= 0.0 {
            return Ok(unproven(0.5 / inside, f64::NAN));
        }
        let (proven, omega_rad_s, gain) = stays_below(&closed, allowed, planes.as_ref())?;
        Ok(Neighbourhood { proven, ..unproven(1.0 / (gain.max(allowed) + inside), omega_rad_s) })
    }

    /// The sampled plant with lifted w as first inputs and lifted z as first outputs, commands and signals last;
    /// `reached` is C Cᵀ.
    fn lift_speed(&self, a: &Mat<f64>, reached: &Mat<f64>) -> Result<StateSpace<Discrete>, NumericError> {
        let read = &self.read;
        let n = a.nrows();
        let axes: Vec<usize> = (0..AXES).collect();
        let turning = StateSpace { a: a.clone(), ..self.at_rest.select(&axes, &axes) };
        let sampled = sample_with_delay(&turning, AXES, self.delay_s, self.period_s)?;
        let commands = turning.b.clone();
        // Commands that act before and after the change within a period, as rows over (states, inputs) of `sampled`.
        let steps = (sampled.order() - n) / AXES;
        let ratio = self.delay_s / self.period_s;
        let whole = (ratio + 1e-9).floor() as usize;
        let split = steps > whole;
        let late_s = if split { self.delay_s - whole as f64 * self.period_s } else { 0.0 };
        let columns = sampled.order() + AXES;
        let command = |age: usize| {
            let first = match age {
                0 => sampled.order(),
                _ => n + (age - 1) * AXES,
            };
            Mat::from_fn(AXES, columns, |i, j| f64::from(u8::from(j == first + i)))
        };
        let states = Mat::from_fn(n, columns, |i, j| f64::from(u8::from(i == j)));
        let generator = Mat::from_fn(n + AXES, n + AXES, |i, j| match (i < n, j < n) {
            (true, true) => a[(i, j)],
            (true, false) => commands[(i, j - n)],
            _ => 0.0,
        });
        let weight = Mat::from_fn(n + AXES, n + AXES, |i, j| if i < n && j < n { read[(i, j)] } else { 0.0 });
        let energy = |from: &Mat<f64>, seconds: f64| -> Result<Mat<f64>, NumericError> {
            let (inner, _) = finite_gramian(&generator, &weight, seconds)?;
            Ok(from.transpose() * inner * from)
        };
        let mut seen = Mat::<f64>::zeros(columns, columns);
        let mut start = states;
        if split {
            let before = stack_rows(&start, &command(whole + 1));
            seen += &energy(&before, late_s)?;
            let (moved, driven) = hold(a, &commands, late_s)?;
            start = stack_cols(&moved, &driven) * &before;
        }
        seen += &energy(&stack_rows(&start, &command(whole)), self.period_s - late_s)?;
        // Commands of x and y alternate.
        let commanded = EqualPlanes::of(&[false, true, false, true]);
        let planes = self.plant.planes_of_states(sampled.order())?.zip(commanded);
        let planes = planes.map(|(states, commanded)| states.followed_by(&commanded));
        let (rows, drive) = (root(&seen, planes.as_ref())?, root(reached, self.plant.planes_of_states(n)?.as_ref())?);
        let (nz, nw) = (rows.nrows(), drive.nrows());
        let m = sampled.order();
        let b = Mat::from_fn(m, nw + AXES, |i, j| {
            if j >= nw {
                sampled.b[(i, j - nw)]
            } else if i < n {
                drive[(j, i)]
            } else {
                0.0
            }
        });
        let c = stack_rows(&rows.subcols(0, m).to_owned(), &sampled.c);
        let d = Mat::from_fn(nz + AXES, nw + AXES, |i, j| match (i < nz, j < nw) {
            (_, true) => 0.0,
            (true, false) => rows[(i, m + j - nw)],
            (false, false) => sampled.d[(i - nz, j - nw)],
        });
        StateSpace::new(sampled.a, b, c, d, sampled.time)
    }

    /// Bound of ‖V‖: Hilbert–Schmidt, ‖V‖² ≤ ∫₀ᵀ tr(R W(s) Rᵀ) ds with the gramian W(s) of (A, L), a sum from above
    /// since the integrand rises; and W(T) = C Cᵀ.
    fn within_a_sample(&self, a: &Mat<f64>) -> Result<(f64, Mat<f64>), NumericError> {
        let (force, read) = (&self.force, &self.read);
        let n = a.nrows();
        let step = self.period_s / PIECES as f64;
        let transposed = a.transpose().to_owned();
        let (first, turned) = finite_gramian(&transposed, force, step)?;
        let moved = turned.transpose();
        let mut gramian = Mat::<f64>::zeros(n, n);
        let mut sum = 0.0;
        for _ in 0..PIECES {
            gramian = moved * &gramian * &turned + &first;
            // tr(RᵀR W), both symmetric.
            let trace = |k: usize| (0..n).map(|i| read[(i, k)] * gramian[(i, k)]).sum::<f64>();
            sum += step * (0..n).map(trace).sum::<f64>();
        }
        let reached = Mat::from_fn(n, n, |i, j| 0.5 * (gramian[(i, j)] + gramian[(j, i)]));
        Ok((sum.max(0.0).sqrt(), reached))
    }
}

/// ∫₀ᵗ e^{Fᵀs} Q e^{Fs} ds for symmetric Q ≥ 0, and e^{Ft}: over a short time h by their series,
///   X(h) = Σ_k h^{k+1} Λᵏ(Q)/(k+1)!,   Λ(Q) = FᵀQ + QF,   e^{Fh} = Σ_k (Fh)ᵏ/k!,
/// then doubled, since X(2h) = X(h) + e^{Fᵀh} X(h) e^{Fh}: no growing exponential enters however stiff F is.
fn finite_gramian(f: &Mat<f64>, q: &Mat<f64>, seconds: f64) -> Result<(Mat<f64>, Mat<f64>), NumericError> {
    let n = f.nrows();
    let norm = f.norm_l2() * seconds;
    if !norm.is_finite() {
        return Err(NumericError::NotFinite { what: "generator of a gramian" });
    }
    let doublings = (norm / SHORT).log2().ceil().clamp(0.0, 60.0) as i32;
    let h = seconds / 2f64.powi(doublings);
    let step = Mat::from_fn(n, n, |i, j| f[(i, j)] * h);
    let mut power = Mat::<f64>::identity(n, n);
    let mut moved = power.clone();
    let mut term = Mat::from_fn(n, n, |i, j| q[(i, j)] * h);
    let mut x = term.clone();
    for k in 1..=TERMS {
        power = &step * &power * f64::from(k).recip();
        moved += &power;
        // (QF)ᵀ = FᵀQ for a symmetric Q.
        let half = &term * &step;
        term = (&half + half.transpose()) * f64::from(k + 1).recip();
        x += &term;
    }
    for _ in 0..doublings {
        x = &x + moved.transpose() * &x * &moved;
        moved = &moved * &moved;
    }
    let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (x[(i, j)] + x[(j, i)]));
    Ok((symmetric, moved))
}

/// ‖F‖h of the series and terms after their first: what is left of the gramian, 0.5¹⁴/15!, of its first term, and of
/// the exponential is below rounding.
const SHORT: f64 = 0.25;
const TERMS: i32 = 13;

/// Rows S with SᵀS = W for W ≥ 0, without those at rounding level.
fn root(w: &Mat<f64>, planes: Option<&EqualPlanes>) -> Result<Mat<f64>, NumericError> {
    if let Some(planes) = planes
        && let Some(rows) = planes.root(w, GRAMIAN_ROUNDING)?
    {
        return Ok(rows);
    }
    let (values, vectors) = symmetric_eigen(w)?;
    let kept = above_rounding(&values, GRAMIAN_ROUNDING);
    Ok(Mat::from_fn(kept.len(), w.nrows(), |i, j| values[kept[i]].sqrt() * vectors[(j, kept[i])]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::exponential;

    /// Van Loan (1978): exp [−Fᵀ Q; 0 F]t holds e^{Ft}, and the gramian as e^{Fᵀt} times its upper right part.
    #[test]
    fn series_of_a_gramian_agrees_with_the_exponential_of_van_loan() {
        let n = 6;
        // Stiff: poles from 1 to 1e4 rad/s, coupled, over half a time constant of the fastest and over many.
        let f =
            Mat::from_fn(
                n,
                n,
                |i, j| if i == j { -10f64.powi(i as i32 - 1) } else { 3.0 * ((2 * i + 3 * j) as f64).sin() },
            );
        let r = Mat::from_fn(n, n, |i, j| ((i * j) as f64 + 0.3 * i as f64).cos());
        let q = r.transpose() * &r;
        for seconds in [5e-5, 1e-3] {
            let block = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
                (true, true) => -f[(j, i)] * seconds,
                (true, false) => q[(i, j - n)] * seconds,
                (false, true) => 0.0,
                (false, false) => f[(i - n, j - n)] * seconds,
            });
            let e = exponential(&block).expect("entries are finite");
            let moved = e.submatrix(n, n, n, n).to_owned();
            let gramian = moved.transpose() * e.submatrix(0, n, n, n);
            let (own, turned) = finite_gramian(&f, &q, seconds).expect("entries are finite");
            // The growing half of the exponential, e^{10} over the longer time, costs Van Loan's form four digits.
            let close = |a: &Mat<f64>, b: &Mat<f64>| (a - b).norm_max() <= 1e-11 * b.norm_max();
            assert!(close(&turned, &moved), "exponential over {seconds} s");
            assert!(close(&own, &gramian), "gramian over {seconds} s");
        }
    }
}
