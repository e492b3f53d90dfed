//! The shape of a law that was recovered line by line: constant, −ω² m, jω c, half order, pure delay, first-order lag,
//! resonance.
//!
//! Each shape is a weighted least squares fit, weights 1/σ². The simplest shape that carries nearly all of the law is
//! taken, else the best by n ln χ² + k ln n, n the number of independent lines (neighbours share what the nuisance
//! parameters left). Rational laws by iterated linear least squares (Sanathanan–Koerner): N(s)/(1 + d₁s + d₂s²). A
//! relative change has a constant gain beside its shape, because only priors tell it from force constants and sensor
//! gains.

use super::place::LawUnit;
use crate::linalg::{Mat, c64, solve};
use crate::spindle::correction::RecoveredLaw;
use crate::spindle::response::ZERO;
use std::f64::consts::TAU;

/// Lines that carry one independent piece of information.
const CORRELATED: f64 = 8.0;
/// Share of the law that a shape must carry to be named.
const CARRIED: f64 = 0.6;
/// Share at which a simpler shape is enough: a law that nuisance parameters have bent by a fifth still carries it.
const ENOUGH: f64 = 0.96;
/// Delays that are tried, s; between them the best is refined.
const DELAYS_S: (f64, f64, usize) = (1e-6, 1e-3, 40);

/// A kind of law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LawShape {
    /// Nothing beyond the noise.
    Nothing,
    /// k.
    Constant(f64),
    /// −ω² m.
    Mass(f64),
    /// jω c.
    Damper(f64),
    /// k − ω² m + jω c.
    SpringMassDamper(f64, f64, f64),
    /// a √(jω).
    HalfOrder(f64),
    /// e^(−jωτ) − 1.
    Delay(f64),
    /// jω b/(1 + jω/ω_c), a lag for b < 0: b in s, corner in Hz.
    Lag(f64, f64),
    /// N(s)/(1 + 2ζ s/ω₀ + s²/ω₀²): Hz, ζ, largest size.
    Resonance(f64, f64, f64),
    /// None of these.
    Other,
}

/// A law with its shape.
#[derive(Clone, Debug)]
pub struct Law {
    /// Which law of the place, empty where there is one only.
    pub name: String,
    /// What its numbers are.
    pub unit: LawUnit,
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Values.
    pub values: Vec<c64>,
    /// Standard deviations.
    pub sd: Vec<f64>,
    /// The best shape.
    pub shape: LawShape,
    /// The shape at the lines.
    pub fitted: Vec<c64>,
    /// Share of the weighted square of the law that the shape carries.
    pub carried: f64,
}

impl Law {
    /// Finds the shape of a law.
    pub fn new(name: &str, unit: LawUnit, frequency_hz: Vec<f64>, values: Vec<c64>, sd: Vec<f64>) -> Self {
        let (shape, fitted, carried) = shape(&frequency_hz, &values, &sd, unit);
        Self { name: name.to_owned(), unit, frequency_hz, values, sd, shape, fitted, carried }
    }

    /// As a correction takes it.
    pub(crate) fn to_recovered(&self) -> RecoveredLaw {
        let lines = self.frequency_hz.iter().zip(&self.values).zip(&self.sd);
        let lines = lines.map(|((hz, value), sd)| (TAU * hz, *value, *sd)).collect();
        RecoveredLaw { name: self.name.clone(), lines }
    }

    /// Median of |law|.
    pub fn size(&self) -> f64 {
        let mut sizes: Vec<f64> = self.values.iter().map(|v| v.norm()).collect();
        sizes.retain(|v| v.is_finite());
        sizes.sort_by(f64::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or_default()
    }

    /// The shape in words, with its numbers.
    pub fn words(&self) -> String {
        let u = self.unit.text();
        let relative = self.unit == LawUnit::Relative;
        match self.shape {
            LawShape::Nothing => "nothing beyond the noise".into(),
            LawShape::Constant(k) if relative => format!("a constant gain of {:+.2} %", 100.0 * k),
            LawShape::Constant(k) if self.unit == LawUnit::Arm => {
                format!("a constant arm of {:+.2} mm", 1e3 * k)
            }
            LawShape::Constant(k) if self.unit == LawUnit::Flexibility && k != 0.0 => {
                format!("a constant flexibility, a stiffness of {:.3e} N/m", k.recip())
            }
            LawShape::Constant(k) if self.unit == LawUnit::TurningFlexibility && k != 0.0 => {
                format!("a constant flexibility, a stiffness of {:.3e} N m/rad", k.recip())
            }
            LawShape::Constant(k) => format!("a constant stiffness of {k:.3e} {u}"),
            LawShape::Mass(m) if self.unit == LawUnit::Stiffness => {
                format!("a mass of {:.1} g (−ω² m)", 1e3 * m)
            }
            LawShape::Mass(m) => format!("a law −ω² · {m:.3e}"),
            LawShape::Damper(c) if relative => {
                format!("a delay or fast lag of {:.1} µs (jω)", -1e6 * c)
            }
            LawShape::Damper(c) => format!("a damper of {c:.3e} {u} s (jω c)"),
            LawShape::SpringMassDamper(k, m, c) => {
                format!("spring, mass and damper: {k:.2e} {u}, {:.1} g, {c:.1e} {u} s", 1e3 * m)
            }
            LawShape::HalfOrder(a) => format!("half order, {a:.2e} √(jω) (eddy currents)"),
            LawShape::Delay(t) => format!("a pure delay of {:.1} µs", 1e6 * t),
            LawShape::Lag(b, hz) => format!(
                "a first-order {} of {:.1} µs with its corner at {hz:.0} Hz",
                if b < 0.0 { "lag" } else { "lead" },
                1e6 * b.abs()
            ),
            LawShape::Resonance(hz, zeta, top) => {
                format!("a resonance at {hz:.0} Hz, damping ratio {zeta:.3}, up to {top:.2e} {u}")
            }
            LawShape::Other => "no simple law".into(),
        }
    }

    /// Name of the shape in files.
    pub(crate) fn name_of_shape(&self) -> &'static str {
        match self.shape {
            LawShape::Nothing => "nothing",
            LawShape::Constant(_) => "constant",
            LawShape::Mass(_) => "mass",
            LawShape::Damper(_) => "damper",
            LawShape::SpringMassDamper(..) => "spring_mass_damper",
            LawShape::HalfOrder(_) => "half_order",
            LawShape::Delay(_) => "delay",
            LawShape::Lag(..) => "first_order_lag",
            LawShape::Resonance(..) => "resonance",
            LawShape::Other => "other",
        }
    }
}

/// Values, weights and lines of a fit.
struct LawData<'a> {
    omega: Vec<f64>,
    values: &'a [c64],
    weight: Vec<f64>,
}

type Tried = (LawShape, Vec<c64>, usize);

fn shape(frequency_hz: &[f64], values: &[c64], sd: &[f64], unit: LawUnit) -> (LawShape, Vec<c64>, f64) {
    // A line on which the law cannot be seen weighs nothing; one that is seen far too well does not decide alone.
    let mut typical: Vec<f64> = sd.iter().copied().filter(|s| *s > 0.0).collect();
    typical.sort_by(f64::total_cmp);
    let model_error = 0.1 * typical.get(typical.len() / 4).copied().unwrap_or(1.0);
    let seen = |v: &c64, s: &f64| v.re.is_finite() && v.im.is_finite() && s.is_finite();
    let data = LawData {
        omega: frequency_hz.iter().map(|f| TAU * f).collect(),
        values,
        weight: values
            .iter()
            .zip(sd)
            .map(|(v, s)| if seen(v, s) && *s > 0.0 { s.max(model_error).powi(-2) } else { 0.0 })
            .collect(),
    };
    let lines = data.weight.iter().filter(|w| **w > 0.0).count();
    if lines < 8 {
        return (LawShape::Other, vec![ZERO; values.len()], 0.0);
    }
    let total = data.chi2(&vec![ZERO; values.len()]);
    if total < 2.5 * lines as f64 {
        // 2|law|²/σ² is 2 a line for noise alone.
        return (LawShape::Nothing, vec![ZERO; values.len()], 0.0);
    }
    let n = (2.0 * lines as f64 / CORRELATED).max(4.0);
    let score = |t: &Tried| {
        let chi2 = data.chi2(&t.1).max(1e-6 * total);
        n * chi2.ln() + t.2 as f64 * n.ln()
    };
    let tried = data.try_unit(unit);
    let carried = |t: &Tried| 1.0 - data.chi2(&t.1) / total;
    let fewest = tried.iter().filter(|t| carried(t) > ENOUGH).map(|t| t.2).min();
    let best = tried
        .into_iter()
        .filter(|t| fewest.is_none_or(|k| t.2 == k && carried(t) > ENOUGH))
        .min_by(|a, b| score(a).total_cmp(&score(b)));
    match best {
        Some((shape, fitted, _)) => {
            let carried = 1.0 - data.chi2(&fitted) / total;
            if carried < CARRIED { (LawShape::Other, fitted, carried) } else { (shape, fitted, carried) }
        }
        None => (LawShape::Other, vec![ZERO; values.len()], 0.0),
    }
}

impl LawData<'_> {
    fn chi2(&self, fitted: &[c64]) -> f64 {
        self.values
            .iter()
            .zip(fitted)
            .zip(&self.weight)
            .filter(|(_, w)| **w > 0.0)
            .map(|((v, f), w)| 2.0 * w * (v - f).norm_sqr())
            .sum()
    }

    /// Real factor of each law in a weighted sum, least squares.
    fn real(&self, laws: &[Vec<c64>]) -> Option<Vec<f64>> {
        let k = laws.len();
        let scale: Vec<f64> = laws
            .iter()
            .map(|l| {
                let own: f64 = l.iter().zip(&self.weight).map(|(l, w)| w * l.norm_sqr()).sum();
                if own > 0.0 { own.sqrt().recip() } else { 0.0 }
            })
            .collect();
        let product = |a: &[c64], b: &[c64]| -> f64 {
            let both = a.iter().zip(b).zip(&self.weight).filter(|(_, w)| **w > 0.0);
            both.map(|((a, b), w)| w * (a.conj() * b).re).sum()
        };
        let matrix = Mat::from_fn(k, k, |i, j| {
            let own = product(&laws[i], &laws[j]) * scale[i] * scale[j];
            // Keeps laws that repeat each other solvable.
            own + if i == j { 1e-12 } else { 0.0 }
        });
        let right = Mat::from_fn(k, 1, |i, _| product(&laws[i], self.values) * scale[i]);
        let x = solve(&matrix, &right).ok()?;
        Some((0..k).map(|i| x[(i, 0)] * scale[i]).collect())
    }

    fn law(&self, of: impl Fn(c64) -> c64) -> Vec<c64> {
        self.omega.iter().map(|w| of(c64::new(0.0, *w))).collect()
    }

    fn try_unit(&self, unit: LawUnit) -> Vec<Tried> {
        let mut all: Vec<Tried> = vec![];
        let one = self.law(|_| c64::new(1.0, 0.0));
        let relative = unit == LawUnit::Relative;
        // A constant gain beside the shape of a relative change.
        let beside = |law: Vec<c64>| {
            if relative { vec![law, one.clone()] } else { vec![law] }
        };
        if let Some((a, fitted)) = self.sum(std::slice::from_ref(&one)) {
            all.push((LawShape::Constant(a[0]), fitted, 1));
        }
        let square = self.law(|s| s * s);
        let first = self.law(|s| s);
        let half = self.law(|s| s.sqrt());
        let simple: [(&[c64], fn(f64) -> LawShape); 3] =
            [(&square, LawShape::Mass), (&first, LawShape::Damper), (&half, LawShape::HalfOrder)];
        let stiffness = unit == LawUnit::Stiffness;
        for (law, shape) in simple.into_iter().filter(|_| stiffness || relative) {
            let laws = beside(law.to_vec());
            if let Some((a, fitted)) = self.sum(&laws) {
                all.push((shape(a[0]), fitted, laws.len()));
            }
        }
        if relative {
            all.extend(self.delay(&one));
            all.extend(self.lag(&one));
        }
        if stiffness && let Some((a, fitted)) = self.sum(&[one, square, first]) {
            all.push((LawShape::SpringMassDamper(a[0], a[1], a[2]), fitted, 3));
        }
        // An absorber's force grows as N(s) of third degree over second; a filter's change is proper.
        all.extend(self.resonance(if stiffness { 4 } else { 3 }));
        all
    }

    /// The weighted sum of laws that fits best, with its factors.
    fn sum(&self, laws: &[Vec<c64>]) -> Option<(Vec<f64>, Vec<c64>)> {
        let a = self.real(laws)?;
        let fitted = (0..self.values.len())
            .map(|k| {
                let terms = laws.iter().zip(&a);
                terms.fold(ZERO, |sum, (law, a)| sum + law[k] * *a)
            })
            .collect();
        Some((a, fitted))
    }

    /// (1 + g) e^(−jωτ) − 1.
    fn delay(&self, one: &[c64]) -> Option<Tried> {
        let fitted = |t: f64| -> Option<Vec<c64>> {
            let turned = self.law(|s| (-s * t).exp());
            // 1 + X is what a factor multiplies.
            let shifted: Vec<c64> = self.values.iter().map(|v| v + 1.0).collect();
            let data = LawData { omega: self.omega.clone(), values: &shifted, weight: self.weight.clone() };
            let (_, fitted) = data.sum(&[turned])?;
            Some(fitted.iter().zip(one).map(|(f, one)| f - one).collect())
        };
        let cost = |t: f64| fitted(t).map_or(f64::INFINITY, |f| self.chi2(&f));
        let (from, to, count) = DELAYS_S;
        let ratio = (to / from).powf(1.0 / count as f64);
        let tried = (0..=count).map(|k| from * ratio.powi(k as i32));
        let t = tried.flat_map(|t| [t, -t]).min_by(|a, b| cost(*a).total_cmp(&cost(*b)))?;
        let t = refine(t, ratio, &cost);
        Some((LawShape::Delay(t), fitted(t)?, 2))
    }

    /// g + jω b/(1 + jω/ω_c).
    fn lag(&self, one: &[c64]) -> Option<Tried> {
        let with = |hz: f64| {
            let d = (TAU * hz).recip();
            self.sum(&[self.law(|s| s / (1.0 + s * d)), one.to_vec()])
        };
        let cost = |hz: f64| with(hz).map_or(f64::INFINITY, |(_, fitted)| self.chi2(&fitted));
        let ratio = 1.3;
        let tried = (0..28).map(|k| 50.0 * f64::powi(ratio, k));
        let hz = tried.min_by(|a, b| cost(*a).total_cmp(&cost(*b)))?;
        let hz = refine(hz, ratio, &cost);
        let (a, fitted) = with(hz)?;
        Some((LawShape::Lag(a[0], hz), fitted, 3))
    }

    /// N(s)/(1 + d₁s + d₂s²) with `terms` coefficients above.
    fn resonance(&self, terms: usize) -> Option<Tried> {
        // Frequencies of order one, so that powers stay comparable.
        let unit = self.omega.iter().copied().fold(0.0, f64::max).max(1.0);
        let powers = |s: c64, k: usize| (0..k).fold(c64::new(1.0, 0.0), |p, _| p * (s / unit));
        let mut below: Vec<c64> = vec![c64::new(1.0, 0.0); self.omega.len()];
        let mut numbers = vec![];
        // Eight rounds settle the weights of a linear fit that a resonance may be.
        for _ in 0..8 {
            let weighted = LawData {
                omega: self.omega.clone(),
                values: self.values,
                weight: self.weight.iter().zip(&below).map(|(w, d)| w / d.norm_sqr().max(1e-12)).collect(),
            };
            let mut laws: Vec<Vec<c64>> = (0..terms).map(|k| self.law(|s| powers(s, k))).collect();
            for k in 1..3 {
                let power = self.law(|s| powers(s, k));
                laws.push(
                    power.iter().zip(self.values).map(|(p, v)| -p * if v.re.is_finite() { *v } else { ZERO }).collect(),
                );
            }
            numbers = weighted.real(&laws)?;
            let (d1, d2) = (numbers[terms], numbers[terms + 1]);
            below = self.law(|s| 1.0 + powers(s, 1) * d1 + powers(s, 2) * d2);
        }
        let (d1, d2) = (numbers[terms], numbers[terms + 1]);
        if d2 <= 0.0 {
            return None;
        }
        let own = unit / d2.sqrt();
        let zeta = 0.5 * d1 / d2.sqrt();
        let inside =
            self.omega.first().is_some_and(|w| own > 0.5 * w) && self.omega.last().is_some_and(|w| own < 1.5 * w);
        // An overdamped or unstable denominator is no resonance.
        if !(0.0..0.9).contains(&zeta) || !inside {
            return None;
        }
        let fitted: Vec<c64> = self
            .law(|s| (0..terms).fold(ZERO, |sum, k| sum + powers(s, k) * numbers[k]))
            .iter()
            .zip(&below)
            .map(|(n, d)| n / d)
            .collect();
        let top = fitted.iter().map(|v| v.norm()).fold(0.0, f64::max);
        Some((LawShape::Resonance(own / TAU, zeta, top), fitted, terms + 2))
    }
}

/// Golden-section search round `x` within a factor.
fn refine(x: f64, ratio: f64, cost: &impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (x / ratio, x * ratio);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..30 {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        if cost(c) < cost(d) {
            b = d;
        } else {
            a = c;
        }
    }
    0.5 * (a + b)
}
