//! Local rational fit of several FRFs that share poles:  g_c(x) = Σ_k r_ck/(x − p_k) + Σ_d a_cd T_d(x),  x = (f − f₀)/h
//! in [−1, 1].
//!
//! A mode is one pole p = (f_d + jζf) in the upper half plane of the frequency axis; its mirror image, the other modes
//! and the electronics are smooth in the window and go into the Chebyshev polynomial. Maximum likelihood for circular
//! complex noise of known shape: residues and polynomial are solved exactly for given poles (variable projection:
//! Golub and Pereyra, Inverse Problems 19, 2003), the poles, frequency and damping at once, move by Levenberg–Marquardt
//! in complex parameters, in which the model is holomorphic. The inverse of the projected curvature is their
//! covariance, H⁻¹ E[ggᴴ] H⁻¹ with the gradient g where the noise of one channel is in the next as well.
//! Symbols: r residues, a coefficients, T_d Chebyshev polynomials, σ standard deviation of a complex entry.

use crate::linalg::{Mat, c64, solve_complex};

/// Samples of one FRF in the window.
#[derive(Clone, Debug)]
pub(super) struct LocalChannel {
    /// Values, one a line.
    pub(super) value: Vec<c64>,
    /// Standard deviation of the complex value.
    pub(super) sigma: Vec<f64>,
    /// Correlation with the next channel, one a line; empty: none.
    pub(super) with_next: Vec<c64>,
}

#[derive(Clone, Debug)]
pub(super) struct LocalData {
    /// Normalised frequency of every line.
    pub(super) x: Vec<f64>,
    /// FRFs.
    pub(super) channels: Vec<LocalChannel>,
}

#[derive(Clone, Debug)]
pub(super) struct LocalFit {
    /// Free poles, normalised.
    pub(super) poles: Vec<c64>,
    /// Standard deviation of the real and of the imaginary part of every free pole for noise of the given size.
    pub(super) pole_sd: Vec<f64>,
    /// Residual over noise, squared, per degree of freedom (complex ones).
    pub(super) chi_squared: f64,
    /// All poles, the free ones first.
    all: Vec<c64>,
    degree: usize,
    /// Per channel: residues of free poles, of fixed poles, polynomial.
    coefficients: Vec<Vec<c64>>,
    /// Per channel a square root F of the covariance F Fᴴ of its coefficients for given poles.
    root_covariance: Vec<Mat<c64>>,
}

/// A root of a fitted channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChannelRoot {
    /// Normalised, complex.
    pub(super) x: c64,
    /// Standard deviation of its real part, normalised.
    pub(super) sd: f64,
    /// Slope of the channel at the root over the standard deviation of that slope: noise has roots too, but no slope.
    pub(super) slope_over_sd: f64,
}

/// Most steps of a fit: ten are usual from a stable pole.
pub(super) const STEPS: usize = 30;
/// Largest move of a pole in one step, half windows.
const STEP_LIMIT: f64 = 0.3;
/// Size of a step, relative to the damping of the pole or in half windows, at which a pole stands still: far below any
/// standard deviation.
const STILL: f64 = 1e-9;
/// Relative fall of the misfit below which steps are rounding.
const NO_FALL: f64 = 1e-10;
/// Lines on either side of one that tells of a pole that show the noise there: some more than a residue and a pole
/// follow.
const BESIDE: usize = 4;
/// Levenberg–Marquardt damping: first, least, and where a step is given up.
const DAMPING: [f64; 3] = [1e-3, 1e-9, 1e8];

/// Everything that is solved for given poles.
struct Projection {
    coefficients: Vec<Vec<c64>>,
    root_covariance: Vec<Mat<c64>>,
    misfit: f64,
    /// JᴴJ and Jᴴ(residual) of the free poles, with what the coefficients can follow projected out.
    curvature: Mat<c64>,
    gradient: Mat<c64>,
    /// J of every channel.
    slopes: Vec<Mat<c64>>,
}

/// Fits the window; `None` when there are too few lines, the equations are singular or a free pole runs away.
pub(super) fn fit(data: &LocalData, start: &[c64], fixed: &[c64], degree: usize) -> Option<LocalFit> {
    fit_in_steps(data, start, fixed, degree, STEPS)
}

/// Such a fit that ends after `most_steps` at the latest.
pub(super) fn fit_in_steps(
    data: &LocalData,
    start: &[c64],
    fixed: &[c64],
    degree: usize,
    most_steps: usize,
) -> Option<LocalFit> {
    let (lines, channels) = (data.x.len(), data.channels.len());
    let per_channel = start.len() + fixed.len() + degree + 1;
    if lines * channels <= channels * per_channel + start.len() || lines <= per_channel {
        return None;
    }
    let mut poles = start.to_vec();
    let mut now = Projection::of(data, &poles, fixed, degree)?;
    let [mut damping, least, given_up] = DAMPING;
    for _ in 0..if start.is_empty() { 0 } else { most_steps } {
        let steps = now.steps(damping)?;
        let next: Vec<c64> = poles.iter().zip(&steps).map(|(p, d)| p + d).collect();
        let inside = next.iter().all(|p| p.re.abs() < 1.6 && p.im.abs() < 2.0);
        match inside.then(|| Projection::of(data, &next, fixed, degree)).flatten() {
            Some(better) if better.misfit <= now.misfit => {
                let moved = steps.iter().zip(&next).map(|(d, p)| d.norm() / p.im.abs().max(STILL));
                let still = moved.fold(0.0, f64::max) < STILL || now.misfit - better.misfit <= NO_FALL * now.misfit;
                (poles, now, damping) = (next, better, (damping / 10.0).max(least));
                if still {
                    break;
                }
            }
            _ => damping *= 10.0,
        }
        if damping > given_up {
            break;
        }
    }
    now.finish(data, poles, fixed, degree)
}

impl Projection {
    fn of(data: &LocalData, free: &[c64], fixed: &[c64], degree: usize) -> Option<Self> {
        let all: Vec<c64> = free.iter().chain(fixed).copied().collect();
        let rows: Vec<Vec<c64>> = data.x.iter().map(|x| basis(&all, degree, c64::new(*x, 0.0))).collect();
        let (lines, n) = (rows.len(), all.len() + degree + 1);
        let identity = Mat::from_fn(n, n, |i, j| c64::new(if i == j { 1.0 } else { 0.0 }, 0.0));
        let mut sum = Self {
            coefficients: vec![],
            root_covariance: vec![],
            misfit: 0.0,
            curvature: Mat::zeros(free.len(), free.len()),
            gradient: Mat::zeros(free.len(), 1),
            slopes: vec![],
        };
        for channel in &data.channels {
            let w: Vec<f64> = channel.sigma.iter().map(|s| s.recip()).collect();
            // Columns of unit length: residues and polynomial differ by orders of magnitude.
            let length = |k: usize| rows.iter().zip(&w).map(|(r, w)| (r[k] * w).norm_sqr()).sum::<f64>().sqrt();
            let lengths: Vec<f64> = (0..n).map(length).collect();
            let qr = Mat::from_fn(lines, n, |l, k| rows[l][k] * (w[l] / lengths[k])).qr();
            let q = qr.compute_thin_Q();
            let inverse = solve_complex(&qr.thin_R().to_owned(), &identity);
            let root = Mat::from_fn(n, n, |i, j| inverse[(i, j)] / lengths[i]);
            let y = Mat::from_fn(lines, 1, |l, _| channel.value[l] * w[l]);
            let projected = q.adjoint() * &y;
            let residual = &y - &q * &projected;
            let solved = &root * &projected;
            let coefficients: Vec<c64> = (0..n).map(|k| solved[(k, 0)]).collect();
            if !coefficients.iter().all(|c| c.is_finite()) {
                return None;
            }
            let slope = |l: usize, k: usize| {
                let gap = c64::new(data.x[l], 0.0) - free[k];
                coefficients[k] * w[l] / (gap * gap)
            };
            let j = Mat::from_fn(lines, free.len(), slope);
            let j = &j - &q * (q.adjoint() * &j);
            sum.curvature += j.adjoint() * &j;
            sum.gradient += j.adjoint() * &residual;
            sum.misfit += residual.squared_norm_l2();
            sum.coefficients.push(coefficients);
            sum.root_covariance.push(root);
            sum.slopes.push(j);
        }
        sum.misfit.is_finite().then_some(sum)
    }

    fn steps(&self, damping: f64) -> Option<Vec<c64>> {
        let n = self.curvature.nrows();
        let more = |i: usize, j: usize| if i == j { 1.0 + damping } else { 1.0 };
        let matrix = Mat::from_fn(n, n, |i, j| self.curvature[(i, j)] * more(i, j));
        let step = solve_complex(&matrix, &self.gradient);
        let limited = |d: c64| if d.norm() > STEP_LIMIT { d * (STEP_LIMIT / d.norm()) } else { d };
        step.is_all_finite().then(|| (0..n).map(|k| limited(step[(k, 0)])).collect())
    }

    /// E[ggᴴ] of the gradient g = Σ Jᴴe for noise e of the given size and correlation: the curvature, where every
    /// channel has a noise of its own.
    fn gradient_covariance(&self, data: &LocalData) -> Mat<c64> {
        let mut sum = self.curvature.clone();
        for (channel, pair) in data.channels.iter().zip(self.slopes.windows(2)) {
            let correlation = &channel.with_next;
            if correlation.len() != data.x.len() {
                continue;
            }
            let (own, next) = (&pair[0], &pair[1]);
            let turned = Mat::from_fn(next.nrows(), next.ncols(), |l, k| correlation[l] * next[(l, k)]);
            let cross = own.adjoint() * &turned;
            sum += &cross + cross.adjoint();
        }
        sum
    }

    fn finish(self, data: &LocalData, poles: Vec<c64>, fixed: &[c64], degree: usize) -> Option<LocalFit> {
        let n = poles.len();
        let identity = Mat::from_fn(n, n, |i, j| c64::new(if i == j { 1.0 } else { 0.0 }, 0.0));
        let inverse = solve_complex(&self.curvature, &identity);
        let covariance = &inverse * self.gradient_covariance(data) * &inverse;
        let pole_sd: Vec<f64> = (0..n).map(|k| (0.5 * covariance[(k, k)].re).sqrt()).collect();
        let all: Vec<c64> = poles.iter().chain(fixed).copied().collect();
        let used = data.channels.len() * (all.len() + degree + 1) + n;
        // Lines without weight tell nothing.
        let told: usize = data.channels.iter().map(|c| c.sigma.iter().filter(|s| s.is_finite()).count()).sum();
        let chi_squared = self.misfit / told.saturating_sub(used).max(1) as f64;
        pole_sd.iter().all(|s| s.is_finite()).then_some(LocalFit {
            poles,
            pole_sd,
            chi_squared,
            all,
            degree,
            coefficients: self.coefficients,
            root_covariance: self.root_covariance,
        })
    }
}

impl LocalFit {
    fn basis(&self, x: c64) -> Vec<c64> {
        basis(&self.all, self.degree, x)
    }

    /// Value of a channel at a point of the complex plane.
    fn value(&self, channel: usize, x: c64) -> c64 {
        dot(&self.coefficients[channel], &self.basis(x))
    }

    /// Residue of a channel at a pole, the free ones first.
    pub(super) fn residue(&self, channel: usize, pole: usize) -> c64 {
        self.coefficients[channel][pole]
    }

    /// Standard deviation of that residue for given poles and noise of the given size.
    pub(super) fn residue_sd(&self, channel: usize, pole: usize) -> f64 {
        let root = &self.root_covariance[channel];
        (0..root.ncols()).map(|k| root[(pole, k)].norm_sqr()).sum::<f64>().sqrt()
    }

    /// Σ |r|²/σ² over the channels: by how much the misfit rises without the pole, all other poles held.
    pub(super) fn gain(&self, pole: usize) -> f64 {
        let each = (0..self.coefficients.len()).map(|c| self.residue(c, pole).norm() / self.residue_sd(c, pole));
        each.map(|seen| seen * seen).sum()
    }

    /// χ² per degree of freedom with lines weighted as they count, or that of all lines where it is larger: the noise
    /// may be as large as the record says on some lines and far smaller on the others.
    pub(super) fn chi_squared_of(&self, data: &LocalData, weight: impl Fn(usize) -> f64) -> f64 {
        let of_line = |l: usize| {
            let at = c64::new(data.x[l], 0.0);
            let each = data.channels.iter().enumerate();
            each.map(|(c, own)| ((own.value[l] - self.value(c, at)) / own.sigma[l]).norm_sqr()).sum::<f64>()
        };
        let misfit: Vec<f64> = (0..data.x.len()).map(of_line).collect();
        let own: Vec<f64> = (0..data.x.len()).map(weight).collect();
        // The pole follows the noise of the lines that tell most of it; those beside them show how large it is.
        let around = |l: usize| &own[l.saturating_sub(BESIDE)..(l + BESIDE + 1).min(own.len())];
        let weights = (0..own.len()).map(|l| around(l).iter().fold(0.0, |most: f64, w| most.max(*w)));
        let weights: Vec<f64> = weights.collect();
        let mean = misfit.iter().sum::<f64>() / misfit.len() as f64;
        let weighted = misfit.iter().zip(&weights).map(|(m, w)| m * w).sum::<f64>() / weights.iter().sum::<f64>();
        let share = weighted / mean;
        if share.is_finite() { self.chi_squared * share.max(1.0) } else { self.chi_squared }
    }

    /// Root of a channel next to `start`, of a fit without free poles; `None` when Newton leaves the window.
    pub(super) fn root(&self, channel: usize, start: c64) -> Option<ChannelRoot> {
        let step = 1e-6;
        let slope = |x: c64| {
            let h = c64::new(step, 0.0);
            (self.value(channel, x + h) - self.value(channel, x - h)) / (2.0 * step)
        };
        let mut x = start;
        for _ in 0..40 {
            let mut d = self.value(channel, x) / slope(x);
            if !d.is_finite() {
                return None;
            }
            if d.norm() > STEP_LIMIT {
                d *= STEP_LIMIT / d.norm();
            }
            x -= d;
            if x.re.abs() > 1.2 || x.im.abs() > 1.5 {
                return None;
            }
            if d.norm() < STILL {
                let h = c64::new(step, 0.0);
                let (after, before) = (self.basis(x + h), self.basis(x - h));
                let bend: Vec<c64> = after.iter().zip(&before).map(|(a, b)| (a - b) / (2.0 * step)).collect();
                let sd = (0.5 * self.variance(channel, &self.basis(x))).sqrt() / slope(x).norm();
                let slope_over_sd = slope(x).norm() / self.variance(channel, &bend).sqrt();
                return sd.is_finite().then_some(ChannelRoot { x, sd, slope_over_sd });
            }
        }
        None
    }

    /// Variance of Σ g·coefficients. A residual above the noise means a model error of that size.
    fn variance(&self, channel: usize, g: &[c64]) -> f64 {
        let root = &self.root_covariance[channel];
        let of_column = |k: usize| g.iter().enumerate().map(|(i, g)| g * root[(i, k)]).sum::<c64>().norm_sqr();
        (0..root.ncols()).map(of_column).sum::<f64>() * self.chi_squared.max(1.0)
    }
}

fn basis(poles: &[c64], degree: usize, x: c64) -> Vec<c64> {
    let one = c64::new(1.0, 0.0);
    let mut b: Vec<c64> = poles.iter().map(|p| one / (x - *p)).collect();
    let (mut t0, mut t1) = (one, x);
    for _ in 0..=degree {
        b.push(t0);
        (t0, t1) = (t1, 2.0 * x * t1 - t0);
    }
    b
}

fn dot(a: &[c64], b: &[c64]) -> c64 {
    a.iter().zip(b).fold(c64::new(0.0, 0.0), |sum, (a, b)| sum + a * b)
}
