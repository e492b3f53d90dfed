//! The most probable parameters of a set of effects: min χ²(θ, η) + Σ(η/sd)² by Levenberg–Marquardt, the model floor lowered
//! in steps. Small parameters have analytic derivatives, effects are differenced.

use super::DiagnoseError;
use super::evidence::{Evidence, Use, whiten};
use super::hypothesis::Hypothesis;
use super::model::{Assembled, Model, SIDE, Square, ZERO};
use super::nuisance::DAMPED_MODES;
use crate::linalg::{Mat, c64, solve, symmetric_eigen};
use crate::spindle::Effect;

/// Model floor of final fits: what a fine mesh, modal damping and re-levitation leave, relative.
pub const FINAL_FLOOR: f64 = 5e-4;

/// Parameters of a hypothesis, fitted or not.
#[derive(Clone, Debug)]
pub struct Point {
    /// Small parameters.
    pub p: Vec<f64>,
    /// Fit coordinates of each effect.
    pub theta: Vec<Vec<f64>>,
}

/// A fitted hypothesis.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Where.
    pub at: Point,
    /// χ² of the data and of the priors.
    pub chi2: f64,
    /// χ² of the data alone.
    pub data_chi2: f64,
    /// Number of real residuals.
    pub residuals: usize,
    /// JᵀJ with priors at the end, small parameters first, then the effects'.
    pub information: Mat<f64>,
}

/// Effects at a point, linearised.
pub struct Linear {
    residual: Vec<f64>,
    jacobian: Mat<f64>,
    normal: Mat<f64>,
}

impl Linear {
    /// Residuals, their derivatives (of the prediction) and JᵀJ with priors.
    pub fn parts(&self) -> (&[f64], &Mat<f64>, &Mat<f64>) {
        (&self.residual, &self.jacobian, &self.normal)
    }

    /// Number of real residuals.
    pub fn residuals(&self) -> usize {
        self.residual.len()
    }
}

/// A step of the schedule: model floor and iterations.
pub type Stage = (f64, usize);

/// Something that can be fitted.
pub struct Problem<'a> {
    /// The reduced machine.
    pub model: &'a Model,
    /// The data.
    pub evidence: &'a Evidence,
    /// Which of them.
    pub usage: Use,
    /// The effects.
    pub effects: &'a [Hypothesis],
}

/// Relative decrease of χ² below which an iteration ends a stage; χ² differences below 0.01 mean nothing.
const SETTLED: f64 = 1e-5;

impl Problem<'_> {
    fn named(&self, theta: &[Vec<f64>]) -> Vec<Effect> {
        self.effects
            .iter()
            .zip(theta)
            .map(|(h, t)| h.effect(t))
            .collect()
    }

    fn assembled(
        &self,
        at: &Point,
        speeds: &[f64],
        derivatives: bool,
    ) -> Result<Vec<Assembled>, DiagnoseError> {
        let effects = self.named(&at.theta);
        let model = self.model;
        speeds
            .iter()
            .map(|speed| model.assemble(&at.p, &effects, *speed, derivatives))
            .collect()
    }

    fn speeds(&self) -> Vec<f64> {
        let sweeps = self.evidence.sweeps.iter().map(|s| s.speed_rad_s);
        let taps = self.evidence.taps.iter().map(|t| t.speed_rad_s);
        let all = sweeps.chain(taps.filter(|_| self.usage.taps));
        let mut speeds: Vec<f64> = all.collect();
        speeds.sort_by(f64::total_cmp);
        speeds.dedup();
        speeds
    }

    /// Whitened residuals (real and imaginary parts, times √2) at a point.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the model cannot be assembled.
    pub fn residual(&self, at: &Point, floor: f64) -> Result<Vec<f64>, DiagnoseError> {
        let speeds = self.speeds();
        let models = self.assembled(at, &speeds, false)?;
        let mut r = Vec::new();
        self.walk(&speeds, floor, |record, speed, omega, line, weight| {
            let f = models[speed].line(omega, None).response;
            self.one(record, line, &f, &at.p, weight, &mut r);
        });
        Ok(r)
    }

    /// Residual of one line appended to `r`.
    fn one(
        &self,
        record: Record,
        line: usize,
        f: &Square,
        p: &[f64],
        weight: &Weight,
        r: &mut Vec<f64>,
    ) {
        match (record, weight) {
            (Record::Sweep(s), Weight::Rows(rows)) => {
                let g = &self.evidence.sweeps[s].response[line];
                for i in 0..4 {
                    let gain = 1.0 + p[self.model.layout.axis(s, i)];
                    let mut d: [c64; 4] =
                        std::array::from_fn(|j| g[4 * i + j] - f[SIDE * i + j] * gain);
                    whiten(&rows[i], &mut d);
                    push(r, &d);
                }
            }
            (Record::Tap(t), Weight::One(sd)) => {
                let tap = &self.evidence.taps[t];
                let (h, ..) = tap.close(line, f);
                push(r, &[(tap.compliance[line] - h) / *sd]);
            }
            _ => {}
        }
    }

    fn walk(
        &self,
        speeds: &[f64],
        floor: f64,
        mut visit: impl FnMut(Record, usize, f64, usize, &Weight),
    ) {
        let index = |speed: f64| speeds.iter().position(|s| *s == speed).unwrap_or_default();
        for (s, sweep) in self.evidence.sweeps.iter().enumerate() {
            for line in (0..sweep.omega_rad_s.len()).step_by(self.usage.stride) {
                let rows = sweep.whitening(line, floor, self.usage.off_diagonal);
                let omega = sweep.omega_rad_s[line];
                visit(
                    Record::Sweep(s),
                    index(sweep.speed_rad_s),
                    omega,
                    line,
                    &Weight::Rows(Box::new(rows)),
                );
            }
        }
        if !self.usage.taps {
            return;
        }
        for (t, tap) in self.evidence.taps.iter().enumerate() {
            for line in (0..tap.omega_rad_s.len()).step_by(self.usage.stride) {
                let weight = Weight::One(tap.sd(line, floor));
                visit(
                    Record::Tap(t),
                    index(tap.speed_rad_s),
                    tap.omega_rad_s[line],
                    line,
                    &weight,
                );
            }
        }
    }

    /// Residuals and Jacobian of the model (∂prediction, whitened) at a point.
    fn linearised(&self, at: &Point, floor: f64) -> Result<(Vec<f64>, Mat<f64>), DiagnoseError> {
        let speeds = self.speeds();
        let layout = &self.model.layout;
        let models = self.assembled(at, &speeds, true)?;
        let mut moved = vec![];
        for (e, hypothesis) in self.effects.iter().enumerate() {
            for i in 0..at.theta[e].len() {
                let mut there = at.clone();
                let step = hypothesis.step(i);
                there.theta[e][i] += step;
                hypothesis.clamp(&mut there.theta[e]);
                let mut taken = there.theta[e][i] - at.theta[e][i];
                if taken.abs() < 0.5 * step {
                    there.theta[e][i] = at.theta[e][i] - step;
                    taken = -step;
                }
                moved.push((self.assembled(&there, &speeds, false)?, taken));
            }
        }
        let (small, columns) = (layout.len(), layout.len() + moved.len());
        let mut r = Vec::new();
        let mut rows: Vec<f64> = Vec::new();
        self.walk(&speeds, floor, |record, speed, omega, line, weight| {
            let here = models[speed].line(omega, Some(layout));
            let f = &here.response;
            self.one(record, line, f, &at.p, weight, &mut r);
            let derivative = |column: &mut dyn FnMut(&[c64])| match (record, weight) {
                (Record::Sweep(s), Weight::Rows(l)) => {
                    for c in 0..columns {
                        let df =
                            self.derivative(c, f, &here.derivatives, &moved, speed, omega, &at.p);
                        let mut all = [ZERO; 16];
                        for i in 0..4 {
                            let gain = 1.0 + at.p[layout.axis(s, i)];
                            let mut d: [c64; 4] = std::array::from_fn(|j| match &df {
                                Some(df) => df[SIDE * i + j] * gain,
                                None if c == layout.axis(s, i) => f[SIDE * i + j],
                                None => ZERO,
                            });
                            whiten(&l[i], &mut d);
                            all[4 * i..4 * i + 4].copy_from_slice(&d);
                        }
                        column(&all);
                    }
                }
                (Record::Tap(t), Weight::One(sd)) => {
                    let (_, left, right) = self.evidence.taps[t].close(line, f);
                    for c in 0..columns {
                        let df =
                            self.derivative(c, f, &here.derivatives, &moved, speed, omega, &at.p);
                        let mut sum = ZERO;
                        if let Some(df) = &df {
                            for i in 0..SIDE {
                                for j in 0..SIDE {
                                    sum += left[i] * df[SIDE * i + j] * right[j];
                                }
                            }
                        }
                        column(&[sum / *sd]);
                    }
                }
                _ => {}
            };
            // Column by column for this line; the block is stored columns × real rows.
            derivative(&mut |values| push(&mut rows, values));
        });
        debug_assert_eq!(rows.len(), r.len() * columns);
        // Blocks of a line: columns × (2 × complex rows). Unfold into rows × columns.
        let mut jacobian = Mat::zeros(r.len(), columns);
        let (mut from, mut row) = (0, 0);
        self.walk(&speeds, 1.0, |record, _, _, _, _| {
            let height = if matches!(record, Record::Sweep(_)) {
                32
            } else {
                2
            };
            for c in 0..columns {
                for i in 0..height {
                    jacobian[(row + i, c)] = rows[from + c * height + i];
                }
            }
            from += columns * height;
            row += height;
        });
        let _ = small;
        Ok((r, jacobian))
    }

    /// ∂F to column `c`; `None` for axis gains, which act on rows of one sweep only.
    #[allow(clippy::too_many_arguments)]
    fn derivative(
        &self,
        c: usize,
        f: &Square,
        analytic: &[Square],
        moved: &[(Vec<Assembled>, f64)],
        speed: usize,
        omega: f64,
        p: &[f64],
    ) -> Option<Square> {
        let layout = &self.model.layout;
        let groups = layout.groups;
        if c < groups {
            return analytic.get(c).copied();
        }
        for b in 0..2 {
            if c == layout.ki(b) {
                return Some(std::array::from_fn(|n| {
                    if n % SIDE / 2 == b {
                        f[n] / (1.0 + p[c])
                    } else {
                        ZERO
                    }
                }));
            }
            if c == layout.gain(b) {
                return Some(std::array::from_fn(|n| {
                    if n / SIDE / 2 == b {
                        f[n] / (1.0 + p[c])
                    } else {
                        ZERO
                    }
                }));
            }
            if c == layout.ks(b) {
                return analytic
                    .get(groups + b)
                    .map(|d| d.map(|x| x / (1.0 + p[c])));
            }
        }
        let first = layout.damping(0);
        if (first..first + DAMPED_MODES).contains(&c) {
            return analytic.get(groups + 2 + c - first).copied();
        }
        let (models, step) = moved.get(c.checked_sub(layout.len())?)?;
        let there = models[speed].line(omega, None).response;
        Some(std::array::from_fn(|n| (there[n] - f[n]) / *step))
    }

    /// Residuals and derivatives of these effects at a point, for [`Self::predicted`].
    ///
    /// # Errors
    /// As [`Self::residual`].
    pub fn linear(&self, at: &Point, floor: f64) -> Result<Linear, DiagnoseError> {
        let (r, jacobian) = self.linearised(at, floor)?;
        let mut normal = jacobian.transpose() * &jacobian;
        for (k, sd) in self.model.layout.sd.iter().enumerate() {
            normal[(k, k)] += sd.powi(-2);
        }
        Ok(Linear {
            residual: r,
            jacobian,
            normal,
        })
    }

    /// χ² that one joint Gauss step from `from` promises, the last effect of the problem being new; and the point it leads to.
    ///
    /// # Errors
    /// As [`Self::residual`].
    pub fn predicted(
        &self,
        base: &Linear,
        from: &Point,
        floor: f64,
    ) -> Result<(Point, f64), DiagnoseError> {
        let (Some(hypothesis), Some(theta)) = (self.effects.last(), from.theta.last()) else {
            return Ok((from.clone(), f64::INFINITY));
        };
        let last = from.theta.len() - 1;
        let here = self.residual(from, floor)?;
        let (n, d) = (base.jacobian.ncols(), theta.len());
        let mut columns = Mat::zeros(here.len(), d);
        for i in 0..d {
            let mut there = from.clone();
            there.theta[last][i] += hypothesis.step(i);
            hypothesis.clamp(&mut there.theta[last]);
            let taken = there.theta[last][i] - theta[i];
            let moved = self.residual(&there, floor)?;
            for (k, (a, b)) in moved.iter().zip(&here).enumerate() {
                columns[(k, i)] = if taken != 0.0 { (b - a) / taken } else { 0.0 };
            }
        }
        let r = Mat::from_fn(here.len(), 1, |i, _| here[i]);
        let cross = base.jacobian.transpose() * &columns;
        let own = columns.transpose() * &columns;
        let mut slope = Mat::zeros(n + d, 1);
        let (small, new) = (base.jacobian.transpose() * &r, columns.transpose() * &r);
        for k in 0..n {
            let weight = self.model.layout.sd.get(k).map_or(0.0, |sd| sd.powi(-2));
            slope[(k, 0)] = small[(k, 0)] - weight * from.p.get(k).copied().unwrap_or_default();
        }
        for k in 0..d {
            slope[(n + k, 0)] = new[(k, 0)];
        }
        let normal = Mat::from_fn(n + d, n + d, |i, j| match (i < n, j < n) {
            (true, true) => base.normal[(i, j)],
            (true, false) => cross[(i, j - n)],
            (false, true) => cross[(j, i - n)],
            // A coordinate without influence at this start (the place of no mass) stays where it is.
            (false, false) => {
                own[(i - n, j - n)]
                    + if i == j {
                        1e-6 * own[(i - n, i - n)] + 1e-9
                    } else {
                        0.0
                    }
            }
        });
        let step = solve(&normal, &slope)?;
        let gain: f64 = (0..n + d).map(|k| step[(k, 0)] * slope[(k, 0)]).sum();
        // The whole step where it is short, the same direction where it is long: the prediction is linear. The small parameters
        // go along, as they have taken up what the new effect explains.
        let share = (0..d).fold(1.0f64, |share, i| {
            let limit = 2.0 + theta[i].abs();
            share.min(limit / step[(n + i, 0)].abs().max(f64::MIN_POSITIVE))
        });
        let mut there = from.clone();
        for (k, p) in there.p.iter_mut().enumerate() {
            *p = (*p + share * step[(k, 0)]).clamp(-0.5, 3.0);
        }
        let mut c = there.p.len();
        for (h, theta) in self.effects.iter().zip(&mut there.theta) {
            for t in theta.iter_mut() {
                *t += share * step[(c, 0)];
                c += 1;
            }
            h.clamp(theta);
        }
        let data: f64 = here.iter().map(|r| r * r).sum();
        let chi2 = data + self.prior(&from.p) - gain;
        // The longer a step, the less a linear prediction is worth; a negative χ² is none.
        Ok((there, chi2.max(0.0)))
    }

    fn prior(&self, p: &[f64]) -> f64 {
        p.iter()
            .zip(&self.model.layout.sd)
            .map(|(p, sd)| (p / sd).powi(2))
            .sum()
    }

    /// χ² with priors at a point.
    ///
    /// # Errors
    /// As [`Self::residual`].
    pub fn chi2(&self, at: &Point, floor: f64) -> Result<f64, DiagnoseError> {
        let r = self.residual(at, floor)?;
        Ok(r.iter().map(|r| r * r).sum::<f64>() + self.prior(&at.p))
    }

    /// Fits from a start through stages.
    ///
    /// # Errors
    /// [`DiagnoseError`] when a model cannot be assembled.
    pub fn fit(&self, start: &Point, stages: &[Stage]) -> Result<Fit, DiagnoseError> {
        let layout = &self.model.layout;
        let small = layout.len();
        let mut at = start.clone();
        let mut end = None;
        for (floor, iterations) in stages {
            // Next to none: a small parameter and an effect of the same kind are told apart by the prior alone, whose
            // curvature is 10⁴ times below that of the data, and a larger damping would stop on the way.
            let mut damping = 1e-10;
            let (mut r, mut j) = self.linearised(&at, *floor)?;
            for iteration in 0..=*iterations {
                let data: f64 = r.iter().map(|r| r * r).sum();
                let here = data + self.prior(&at.p);
                let n = j.ncols();
                let mut normal = j.transpose() * &j;
                let residual = Mat::from_fn(r.len(), 1, |i, _| r[i]);
                let mut slope = j.transpose() * residual;
                for k in 0..small {
                    let weight = layout.sd[k].powi(-2);
                    normal[(k, k)] += weight;
                    slope[(k, 0)] -= weight * at.p[k];
                }
                end = Some(Fit {
                    at: at.clone(),
                    chi2: here,
                    data_chi2: data,
                    residuals: r.len(),
                    information: normal.clone(),
                });
                if iteration == *iterations {
                    break;
                }
                let mut accepted = None;
                // Twelve tries span twelve decades of damping; beyond, the point is a minimum to rounding.
                for _ in 0..12 {
                    let damped = Mat::from_fn(n, n, |a, b| {
                        let own = normal[(a, b)];
                        if a == b {
                            own * (1.0 + damping) + 1e-12
                        } else {
                            own
                        }
                    });
                    let Ok(step) = solve(&damped, &slope) else {
                        damping = (damping * 10.0f64).max(1e-7);
                        continue;
                    };
                    let mut there = at.clone();
                    for k in 0..small {
                        // A factor stays a factor: no step beyond half.
                        there.p[k] = (there.p[k] + step[(k, 0)]).clamp(-0.5, 3.0);
                    }
                    let mut c = small;
                    for (hypothesis, theta) in self.effects.iter().zip(&mut there.theta) {
                        for t in theta.iter_mut() {
                            *t += step[(c, 0)];
                            c += 1;
                        }
                        hypothesis.clamp(theta);
                    }
                    let value = self.chi2(&there, *floor).unwrap_or(f64::INFINITY);
                    if value < here {
                        damping = (damping * 0.01).max(1e-10);
                        accepted = Some((there, here - value));
                        break;
                    }
                    damping = (damping * 10.0).max(1e-7);
                }
                let Some((there, gain)) = accepted else { break };
                at = there;
                (r, j) = self.linearised(&at, *floor)?;
                if gain < SETTLED * here || gain < 0.01 {
                    let data: f64 = r.iter().map(|r| r * r).sum();
                    if let Some(end) = &mut end {
                        end.at = at.clone();
                        end.data_chi2 = data;
                        end.chi2 = data + self.prior(&at.p);
                    }
                    break;
                }
            }
        }
        match end {
            Some(fit) => Ok(fit),
            None => {
                let r = self.residual(&at, FINAL_FLOOR)?;
                let data: f64 = r.iter().map(|r| r * r).sum();
                Ok(Fit {
                    chi2: data + self.prior(&at.p),
                    data_chi2: data,
                    residuals: r.len(),
                    information: Mat::identity(small, small),
                    at,
                })
            }
        }
    }
}

impl Fit {
    /// Covariance of the effects' fit coordinates; infinite variances where the data say nothing.
    ///
    /// # Errors
    /// [`DiagnoseError::Numeric`] when the eigenvalue iteration fails.
    pub fn covariance(&self) -> Result<Mat<f64>, DiagnoseError> {
        let n = self.information.nrows();
        let scale: Vec<f64> = (0..n)
            .map(|i| {
                self.information[(i, i)]
                    .max(f64::MIN_POSITIVE)
                    .sqrt()
                    .recip()
            })
            .collect();
        let unit = Mat::from_fn(n, n, |i, j| self.information[(i, j)] * scale[i] * scale[j]);
        let (values, vectors) = symmetric_eigen(&unit)?;
        Ok(Mat::from_fn(n, n, |i, j| {
            let sum: f64 = (0..n)
                // A direction below rounding is undetermined, its variance large but finite.
                .map(|k| vectors[(i, k)] * vectors[(j, k)] / values[k].max(1e-13))
                .sum();
            sum * scale[i] * scale[j]
        }))
    }
}

#[derive(Clone, Copy)]
enum Record {
    Sweep(usize),
    Tap(usize),
}

enum Weight {
    Rows(Box<[[c64; 16]; 4]>),
    One(f64),
}

fn push(all: &mut Vec<f64>, values: &[c64]) {
    for v in values {
        all.push(std::f64::consts::SQRT_2 * v.re);
        all.push(std::f64::consts::SQRT_2 * v.im);
    }
}
