//! Weights over frequency of a weights file, as points or as a transfer function, to [`Shape`].

use super::error::InputError;
use super::error_list::ErrorList;
use super::key::{Key, Range, keys, number};
use crate::augment::root::Root;
use crate::augment::shape::Shape;
use crate::augment::weights::GivenCurves;
use crate::linalg::{c64, polynomial_roots};
use crate::robust::dfit::factors::Factor;
use crate::robust::dfit::{Magnitudes, fit_up_to};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

const ANY: [Range; 2] = [[0.0, f64::INFINITY]; 2];

pub(super) const KEYS: &[Key] = keys! {
    number "points[]" "Hz, value" ANY "the limits of a specification over frequency";
    number "numerator[]" "" ANY "falling powers of s in rad/s";
    number "denominator[]" "" ANY "falling powers of s in rad/s";
};

/// Sizes over frequency, each in the place of one that changes from a level to another.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CurvesFile {
    /// Load at the tool, N.
    tool_load_n: Option<CurveFile>,
    /// Load at the front bearing, N.
    front_load_n: Option<CurveFile>,
    /// Load at the rear bearing, N.
    rear_load_n: Option<CurveFile>,
    /// Displacement allowed at the tool, m.
    tool_displacement_m: Option<CurveFile>,
    /// Displacement allowed at the front bearing, m.
    front_displacement_m: Option<CurveFile>,
    /// Displacement allowed at the rear bearing, m.
    rear_displacement_m: Option<CurveFile>,
    /// Control current allowed, A, in the place of limit and roll-off.
    current_a: Option<CurveFile>,
    /// Sensor noise that the design assumes, m; the bound on the complementary sensitivity is tighter by as much as it
    /// is above the key `sensor_noise_m`.
    sensor_noise_m: Option<CurveFile>,
    /// Relative error of the actuators.
    actuator: Option<CurveFile>,
    /// Error of the signals, m per A of the bearing's current.
    sensor_m_per_a: Option<CurveFile>,
}

/// A size over frequency: `points`, or `numerator` and `denominator`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CurveFile {
    /// Frequency in Hz and value, ascending in frequency; straight lines between them on logarithmic axes, constant
    /// beyond the first and the last.
    points: Option<Vec<[f64; 2]>>,
    /// Coefficients of falling powers of s in rad/s; only the magnitude counts, so roots lie in the left half plane.
    numerator: Option<Vec<f64>>,
    /// The same of the poles.
    denominator: Option<Vec<f64>>,
}

/// Which way a curve enters its weight.
#[derive(Clone, Copy, PartialEq)]
enum Sense {
    /// As it is: loads, errors.
    Direct,
    /// One over it: what is allowed.
    Inverse,
}

impl CurvesFile {
    /// Weights of loads, displacements and current; what is wrong with them is added to the errors.
    pub(super) fn weights(&self, errors: &mut ErrorList<'_>) -> GivenCurves {
        let mut of = |key: &str, curve: &Option<CurveFile>, sense| {
            let shape = shape(errors.file, key, curve.as_ref(), sense);
            errors.take_rule(shape).flatten()
        };
        GivenCurves {
            load: [
                of("tool_load_n", &self.tool_load_n, Sense::Direct),
                of("front_load_n", &self.front_load_n, Sense::Direct),
                of("rear_load_n", &self.rear_load_n, Sense::Direct),
            ],
            displacement: [
                of("tool_displacement_m", &self.tool_displacement_m, Sense::Inverse),
                of("front_displacement_m", &self.front_displacement_m, Sense::Inverse),
                of("rear_displacement_m", &self.rear_displacement_m, Sense::Inverse),
            ],
            current: of("current_a", &self.current_a, Sense::Inverse),
            noise: of("sensor_noise_m", &self.sensor_noise_m, Sense::Direct),
        }
    }

    pub(super) fn actuator(&self, file: &str) -> Result<Option<Shape>, InputError> {
        shape(file, "actuator", self.actuator.as_ref(), Sense::Direct)
    }

    pub(super) fn sensor(&self, file: &str) -> Result<Option<Shape>, InputError> {
        shape(file, "sensor_m_per_a", self.sensor_m_per_a.as_ref(), Sense::Direct)
    }
}

fn shape(file: &str, key: &str, curve: Option<&CurveFile>, sense: Sense) -> Result<Option<Shape>, InputError> {
    let refused =
        |rule: String, hint: &str| InputError::new(file, format!("over_frequency.{key}: {rule}")).with_hint(hint);
    let Some(curve) = curve else {
        return Ok(None);
    };
    let read = match (&curve.points, &curve.numerator, &curve.denominator) {
        (Some(points), None, None) => through(points, sense),
        (None, Some(numerator), Some(denominator)) => rational(numerator, denominator, sense),
        _ => Err((
            "needs either points, or numerator and denominator".to_owned(),
            "points: [[10, 40], [1000, 5]] goes from 40 at 10 Hz to 5 at 1000 Hz",
        )),
    };
    read.map(Some).map_err(|(rule, hint)| refused(rule, hint))
}

/// What is wrong, and what to do.
type Refused = (String, &'static str);

/// Highest order of a weight that is fitted to points: each order is a state of the synthesis for each place and plane.
const HIGHEST_ORDER: usize = 6;
/// ln of the ratio of fit to points that ends the search for a higher order: a tenth of a decibel in twenty.
const CLOSE: f64 = 0.02;
/// ln of the ratio beyond which points are refused: no designer means three decibels more than is written.
const FAR: f64 = 0.35;
/// Lines of the fit between the points, a decade.
const LINES_PER_DECADE: f64 = 40.0;
/// Lines between those of the fit at which it is raised.
const BETWEEN: usize = 10;
/// Most points, and most coefficients of a transfer function.
const MOST_POINTS: usize = 1000;
const MOST_COEFFICIENTS: usize = 9;

/// A stable, minimum-phase weight that is nowhere below the points.
fn through(points: &[[f64; 2]], sense: Sense) -> Result<Shape, Refused> {
    if !(2..=MOST_POINTS).contains(&points.len()) {
        let rule = format!("has {} points; 2 to {MOST_POINTS} are needed", points.len());
        return Err((rule, "a constant is a limit with two equal levels"));
    }
    for (k, [frequency_hz, value]) in points.iter().enumerate() {
        let ascends = k == 0 || *frequency_hz > points[k - 1][0];
        let good = |x: f64| x.is_finite() && x > 0.0;
        if !(good(*frequency_hz) && good(*value) && ascends) {
            let rule = format!("points[{k}]: [{frequency_hz}, {value}] must be positive and ascending in frequency");
            return Err((rule, "each point is a frequency in Hz and a value"));
        }
    }
    let (ln_hz, ln_value): (Vec<f64>, Vec<f64>) = points
        .iter()
        .map(|[hz, value]| (hz.ln(), if sense == Sense::Inverse { -value.ln() } else { value.ln() }))
        .unzip();
    // Half a decade of the constants beyond either end.
    let beyond = 0.5 * std::f64::consts::LN_10;
    let (from, to) = (ln_hz[0] - beyond, ln_hz[ln_hz.len() - 1] + beyond);
    let count = ((to - from) / std::f64::consts::LN_10 * LINES_PER_DECADE).ceil().max(2.0) as usize;
    let mut lines: Vec<f64> =
        (0..=count).map(|k| from + (to - from) * k as f64 / count as f64).chain(ln_hz.iter().copied()).collect();
    lines.sort_by(f64::total_cmp);
    // Points that fall on a line would be the same frequency twice.
    lines.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let omega = lines.iter().map(|l| TAU * l.exp()).collect();
    let written: Vec<f64> = lines.iter().map(|l| interpolate_between(&ln_hz, &ln_value, *l)).collect();
    let magnitude = written.iter().map(|l| l.exp()).collect();
    let failed = |error: String| (error, "give fewer points, or a transfer function");
    let data = Magnitudes::new(omega, magnitude, vec![1.0; lines.len()]).map_err(|e| failed(e.to_string()))?;
    let fits = fit_up_to(&data, HIGHEST_ORDER).map_err(|e| failed(e.to_string()))?;
    let close = fits.iter().position(|fit| fit.max_abs_ln_error <= CLOSE);
    let fit = &fits[close.unwrap_or(fits.len() - 1)];
    // The fit bends between its lines by a little more than at them.
    let finely = (0..=BETWEEN * count).map(|k| from + (to - from) * k as f64 / (BETWEEN * count) as f64);
    let error = finely.fold(fit.max_abs_ln_error, |error, l| {
        let own = fit.factors.ln_magnitude(TAU * l.exp());
        error.max((own - interpolate_between(&ln_hz, &ln_value, l)).abs())
    });
    if error > FAR {
        let rule = format!("a weight of order {HIGHEST_ORDER} misses the points by a factor of {:.2}", error.exp());
        return Err((rule, "draw the limit with gentler bends, or give a transfer function"));
    }
    let roots = |list: &[Factor]| list.iter().flat_map(factor_roots).collect::<Vec<_>>();
    // Raised by the error: the weight asks nowhere for less than is written.
    let gain = (fit.factors.ln_gain + error).exp();
    let shape = Shape::from_roots(gain, &roots(&fit.factors.zeros), &roots(&fit.factors.poles));
    let mut shape = shape.map_err(|e| failed(e.to_string()))?;
    shape.excess_over_points = (2.0 * error).exp_m1();
    Ok(shape)
}

/// Value at `x` of the line through points, constant beyond them.
fn interpolate_between(places: &[f64], values: &[f64], x: f64) -> f64 {
    let after = places.partition_point(|p| *p < x);
    match (after.checked_sub(1), values.get(after)) {
        (None, Some(first)) => *first,
        (Some(k), None) => values[k],
        (Some(k), Some(next)) => {
            let share = (x - places[k]) / (places[after] - places[k]);
            values[k] + share * (next - values[k])
        }
        (None, None) => 0.0,
    }
}

/// Roots of a fitted factor: a pair, or two real ones where its damping is one or more.
fn factor_roots(factor: &Factor) -> Vec<Root> {
    let omega = factor.ln_omega.exp();
    let real = |omega_rad_s: f64| Root { omega_rad_s, damping: None };
    match factor.ln_damping.map(f64::exp) {
        None => vec![real(omega)],
        Some(zeta) if zeta < 1.0 => vec![Root { omega_rad_s: omega, damping: Some(zeta) }],
        Some(zeta) => {
            let larger = zeta + (zeta * zeta - 1.0).sqrt();
            vec![real(omega / larger), real(omega * larger)]
        }
    }
}

/// The weight of a transfer function.
fn rational(numerator: &[f64], denominator: &[f64], sense: Sense) -> Result<Shape, Refused> {
    let (top, bottom) = (polynomial("numerator", numerator)?, polynomial("denominator", denominator)?);
    let ((over, zeros), (under, poles)) = match sense {
        Sense::Direct => (top, bottom),
        Sense::Inverse => (bottom, top),
    };
    Shape::from_roots(over / under, &zeros, &poles).map_err(|_| {
        let rule = match sense {
            Sense::Direct => "has more zeros than poles: it would grow without bound",
            Sense::Inverse => "has more poles than zeros: nothing would be allowed at high frequency",
        };
        (rule.to_owned(), "add a far zero or pole, such as s/1e6 + 1")
    })
}

/// |value at s = 0| and the roots of a polynomial.
fn polynomial(name: &str, coefficients: &[f64]) -> Result<(f64, Vec<Root>), Refused> {
    let list = coefficients.iter().skip_while(|c| **c == 0.0);
    let list: Vec<f64> = list.copied().collect();
    let (Some(lead), Some(last)) = (list.first(), list.last()) else {
        return Err((format!("{name} has no coefficient"), "falling powers of s, the constant last"));
    };
    let constant_hint = "a pole or zero at s = 0 has no finite level there: move it to a small frequency";
    if list.iter().any(|c| !c.is_finite()) || *last == 0.0 || list.len() > MOST_COEFFICIENTS {
        let rule = format!("{name} needs 1 to {MOST_COEFFICIENTS} finite coefficients, the last not zero");
        return Err((rule, constant_hint));
    }
    let n = list.len() - 1;
    // Roots of the polynomial in s over its mean corner, so that coefficients are of one size.
    let corner = if n == 0 { 1.0 } else { (last / lead).abs().powf(1.0 / n as f64) };
    let scaled = |k: usize| list[k] / lead * corner.powi(-i32::try_from(k).unwrap_or(0));
    let rising: Vec<c64> = (0..=n).rev().map(|k| c64::new(scaled(k), 0.0)).collect();
    let roots = polynomial_roots(&rising).map_err(|e| (format!("{name}: {e}"), constant_hint))?;
    if let Some(root) = roots.iter().find(|r| r.re >= 0.0) {
        let rule = format!(
            "{name} has a root at {:.4e} ± {:.4e}i rad/s, not in the left half plane",
            root.re * corner,
            (root.im * corner).abs()
        );
        return Err((rule, "only the magnitude counts: mirror the root to the left"));
    }
    let own = roots.iter().filter(|r| r.im >= 0.0).map(|r| Root::of(*r * corner));
    Ok((last.abs(), own.collect()))
}
