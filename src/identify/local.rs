//! Local rational fit of several FRFs that share poles:  g_c(x) = Σ_k r_ck/(x − p_k) + Σ_d a_cd T_d(x),  x = (f − f₀)/h
//! in [−1, 1].
//!
//! A lightly damped mode is one pole p = (f_d + jζf) in the upper half plane of the frequency axis; its mirror image,
//! the other modes and the electronics are smooth in the window and go into the Chebyshev polynomial. Weighted least
//! squares over complex parameters, in which the model is holomorphic: the coefficients are solved exactly for given
//! poles, the poles move by Gauss–Newton. Covariances are those of circular complex noise, scaled up when the residual
//! exceeds the noise.
//! Symbols: r residues, a coefficients, T_d Chebyshev polynomials, σ standard deviation of a complex entry.

use crate::linalg::{Mat, c64, solve_complex};

/// Samples of one FRF in the window.
#[derive(Clone, Debug)]
pub(crate) struct LocalChannel {
    /// Values, one a line.
    pub value: Vec<c64>,
    /// Standard deviation of the complex value.
    pub sigma: Vec<f64>,
}

/// Data in one window.
#[derive(Clone, Debug)]
pub(crate) struct LocalData {
    /// Normalised frequency of every line.
    pub x: Vec<f64>,
    /// FRFs.
    pub channels: Vec<LocalChannel>,
}

/// A fitted window.
#[derive(Clone, Debug)]
pub(crate) struct LocalFit {
    /// Free poles, normalised.
    pub poles: Vec<c64>,
    /// Standard deviation of the real and of the imaginary part of every free pole.
    pub pole_sd: Vec<f64>,
    /// Poles held fixed, normalised.
    pub fixed: Vec<c64>,
    /// Residual over noise, squared, per degree of freedom (complex ones).
    pub chi_squared: f64,
    degree: usize,
    /// Per channel: residues of free poles, of fixed poles, polynomial.
    coefficients: Vec<Vec<c64>>,
    /// Covariance of all parameters: coefficients channel by channel, then the free poles.
    covariance: Mat<c64>,
}

/// A root of a fitted channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChannelRoot {
    /// Normalised, complex.
    pub x: c64,
    /// Standard deviation of its real part, normalised.
    pub sd: f64,
    /// Slope of the channel at the root over the standard deviation of that slope: noise has roots too, but no slope.
    pub slope_over_sd: f64,
}

/// Largest move of a pole in one step, half windows.
const STEP_LIMIT: f64 = 0.3;
/// Relative size of a step at which a pole stands still: far below any standard deviation.
const STILL: f64 = 1e-9;

/// Fits the window; `None` when there are too few lines, the equations are singular or a free pole runs away.
pub(crate) fn fit(data: &LocalData, start: &[c64], fixed: &[c64], degree: usize) -> Option<LocalFit> {
    let (lines, channels) = (data.x.len(), data.channels.len());
    let per_channel = start.len() + fixed.len() + degree + 1;
    let unknowns = channels * per_channel + start.len();
    if lines * channels <= unknowns || lines <= per_channel {
        return None;
    }
    let mut poles = start.to_vec();
    // Twenty steps: four are usual from a neighbouring line.
    for _ in 0..20 {
        let coefficients = linear(data, &poles, fixed, degree)?;
        if start.is_empty() {
            return finish(data, poles, fixed, degree, coefficients);
        }
        let (normal, right) = normal_equations(data, &poles, fixed, degree, &coefficients);
        let step = solve_complex(&normal, &right);
        let base = channels * per_channel;
        let mut largest = 0.0f64;
        for (k, pole) in poles.iter_mut().enumerate() {
            let mut d = step[(base + k, 0)];
            if !d.is_finite() {
                return None;
            }
            if d.norm() > STEP_LIMIT {
                d *= STEP_LIMIT / d.norm();
            }
            *pole += d;
            largest = largest.max(d.norm());
            if pole.re.abs() > 1.5 || pole.im.abs() > 2.0 {
                return None;
            }
        }
        if largest < STILL {
            break;
        }
    }
    let coefficients = linear(data, &poles, fixed, degree)?;
    finish(data, poles, fixed, degree, coefficients)
}

impl LocalFit {
    fn basis(&self, x: c64) -> Vec<c64> {
        let all: Vec<c64> = self.poles.iter().chain(&self.fixed).copied().collect();
        basis(&all, self.degree, x)
    }

    /// Value of a channel at a point of the complex plane.
    pub(crate) fn value(&self, channel: usize, x: c64) -> c64 {
        dot(&self.coefficients[channel], &self.basis(x))
    }

    /// Residue of a channel at a free pole.
    pub(crate) fn residue(&self, channel: usize, pole: usize) -> c64 {
        self.coefficients[channel][pole]
    }

    /// Standard deviation of the complex residue of a channel at a free pole.
    pub(crate) fn residue_sd(&self, channel: usize, pole: usize) -> f64 {
        let k = channel * self.coefficients[channel].len() + pole;
        self.covariance[(k, k)].re.max(0.0).sqrt()
    }

    /// Root of a channel next to `start`; `None` when Newton leaves the window.
    pub(crate) fn root(&self, channel: usize, start: c64) -> Option<ChannelRoot> {
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
                let basis = self.basis(x);
                let count = basis.len();
                let total = self.covariance.nrows();
                let base = total - self.poles.len();
                let mut gradient = vec![c64::new(0.0, 0.0); total];
                for (k, b) in basis.iter().enumerate() {
                    gradient[channel * count + k] = *b;
                }
                for (k, p) in self.poles.iter().enumerate() {
                    let gap = x - *p;
                    gradient[base + k] = self.coefficients[channel][k] / (gap * gap);
                }
                let variance = |g: &[c64]| {
                    let mut sum = c64::new(0.0, 0.0);
                    for (i, a) in g.iter().enumerate() {
                        for (j, b) in g.iter().enumerate() {
                            sum += a * self.covariance[(i, j)] * b.conj();
                        }
                    }
                    sum.re.max(0.0)
                };
                let h = c64::new(step, 0.0);
                let (after, before) = (self.basis(x + h), self.basis(x - h));
                let mut bend = vec![c64::new(0.0, 0.0); total];
                for k in 0..count {
                    bend[channel * count + k] = (after[k] - before[k]) / (2.0 * step);
                }
                let sd = (0.5 * variance(&gradient)).sqrt() / slope(x).norm();
                let slope_over_sd = slope(x).norm() / variance(&bend).sqrt();
                return sd.is_finite().then_some(ChannelRoot { x, sd, slope_over_sd });
            }
        }
        None
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

/// Coefficients of every channel for given poles.
fn linear(data: &LocalData, poles: &[c64], fixed: &[c64], degree: usize) -> Option<Vec<Vec<c64>>> {
    let all: Vec<c64> = poles.iter().chain(fixed).copied().collect();
    let rows: Vec<Vec<c64>> = data.x.iter().map(|x| basis(&all, degree, c64::new(*x, 0.0))).collect();
    let n = all.len() + degree + 1;
    data.channels
        .iter()
        .map(|channel| {
            let mut a = Mat::<c64>::zeros(n, n);
            let mut b = Mat::<c64>::zeros(n, 1);
            for ((row, value), sigma) in rows.iter().zip(&channel.value).zip(&channel.sigma) {
                let w = sigma.powi(-2);
                for i in 0..n {
                    b[(i, 0)] += row[i].conj() * value * w;
                    for j in 0..n {
                        a[(i, j)] += row[i].conj() * row[j] * w;
                    }
                }
            }
            let c = solve_complex(&a, &b);
            let c: Vec<c64> = (0..n).map(|i| c[(i, 0)]).collect();
            c.iter().all(|v| v.is_finite()).then_some(c)
        })
        .collect()
}

/// JᴴWJ and JᴴW(residual) over all parameters.
fn normal_equations(
    data: &LocalData,
    poles: &[c64],
    fixed: &[c64],
    degree: usize,
    coefficients: &[Vec<c64>],
) -> (Mat<c64>, Mat<c64>) {
    let all: Vec<c64> = poles.iter().chain(fixed).copied().collect();
    let n = all.len() + degree + 1;
    let base = data.channels.len() * n;
    let total = base + poles.len();
    let mut a = Mat::<c64>::zeros(total, total);
    let mut b = Mat::<c64>::zeros(total, 1);
    for (line, x) in data.x.iter().enumerate() {
        let x = c64::new(*x, 0.0);
        let row = basis(&all, degree, x);
        for (c, channel) in data.channels.iter().enumerate() {
            let w = channel.sigma[line].powi(-2);
            let residual = channel.value[line] - dot(&coefficients[c], &row);
            let mut entries: Vec<(usize, c64)> = row.iter().enumerate().map(|(k, v)| (c * n + k, *v)).collect();
            for (k, p) in poles.iter().enumerate() {
                let gap = x - *p;
                entries.push((base + k, coefficients[c][k] / (gap * gap)));
            }
            for (i, u) in &entries {
                b[(*i, 0)] += u.conj() * residual * w;
                for (j, v) in &entries {
                    a[(*i, *j)] += u.conj() * v * w;
                }
            }
        }
    }
    (a, b)
}

fn finish(
    data: &LocalData,
    poles: Vec<c64>,
    fixed: &[c64],
    degree: usize,
    coefficients: Vec<Vec<c64>>,
) -> Option<LocalFit> {
    let (normal, _) = normal_equations(data, &poles, fixed, degree, &coefficients);
    let total = normal.nrows();
    // Scale to unit diagonal before inverting: residues and polynomial differ by orders of magnitude.
    let d: Vec<f64> = (0..total).map(|i| normal[(i, i)].re.max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = Mat::from_fn(total, total, |i, j| normal[(i, j)] / (d[i] * d[j]));
    let identity = Mat::from_fn(total, total, |i, j| c64::new(if i == j { 1.0 } else { 0.0 }, 0.0));
    let inverse = solve_complex(&scaled, &identity);
    let all: Vec<c64> = poles.iter().chain(fixed).copied().collect();
    let mut sum = 0.0;
    for (line, x) in data.x.iter().enumerate() {
        let row = basis(&all, degree, c64::new(*x, 0.0));
        for (c, channel) in data.channels.iter().enumerate() {
            let r = channel.value[line] - dot(&coefficients[c], &row);
            sum += r.norm_sqr() / channel.sigma[line].powi(2);
        }
    }
    let freedom = data.x.len() * data.channels.len() - total;
    let chi_squared = sum / freedom.max(1) as f64;
    // A residual above the noise means a model error of that size: the standard deviations grow with it.
    let scale = chi_squared.max(1.0);
    let covariance = Mat::from_fn(total, total, |i, j| inverse[(i, j)] * scale / (d[i] * d[j]));
    let base = total - poles.len();
    let pole_sd: Vec<f64> =
        (0..poles.len()).map(|k| (0.5 * covariance[(base + k, base + k)].re.max(0.0)).sqrt()).collect();
    if !pole_sd.iter().all(|s| s.is_finite()) || !chi_squared.is_finite() {
        return None;
    }
    Some(LocalFit { poles, pole_sd, fixed: fixed.to_vec(), chi_squared, degree, coefficients, covariance })
}
