//! Which functions of a universal file are frequency responses of a structure, and their conversion to compliance in
//! m/N. Mobility v/F = jω x/F, accelerance a/F = −ω² x/F (ISO 7626-1). What is measured is taken from the data types of
//! the axes, else from their unit labels; what cannot be told is refused.

use super::error::InputError;
use super::uff::UffFunction;
use crate::linalg::c64;
use std::f64::consts::TAU;

/// Standard gravity, m/s²: accelerometers are often calibrated in g.
const GRAVITY_M_S2: f64 = 9.80665;

/// An FRF converted to compliance.
#[derive(Clone, Debug, PartialEq)]
pub struct UffFrf {
    /// ID line 1.
    pub description: String,
    /// Response node and direction.
    pub response: (i64, i64),
    /// Reference node and direction.
    pub reference: (i64, i64),
    /// Lines, Hz, ascending, positive.
    pub frequency_hz: Vec<f64>,
    /// Compliance, m/N.
    pub compliance: Vec<c64>,
}

impl UffFrf {
    /// True when response and reference are the same point and direction.
    pub(crate) fn is_driving_point(&self) -> bool {
        self.response == self.reference
    }

    /// Short description for messages.
    pub(crate) fn label(&self) -> String {
        format!(
            "{:?} (response {}:{}, reference {}:{})",
            self.description, self.response.0, self.response.1, self.reference.0, self.reference.1
        )
    }
}

#[derive(Clone, Copy)]
enum Motion {
    Displacement,
    Velocity,
    Acceleration,
}

/// All frequency responses of the file as compliances.
///
/// # Errors
/// [`InputError`] when none can be used, with the reason for every function.
pub fn frfs(file: &str, functions: &[UffFunction]) -> Result<Vec<UffFrf>, InputError> {
    let mut good = vec![];
    let mut reasons = vec![];
    for function in functions {
        match convert(function) {
            Ok(frf) => good.push(frf),
            Err(reason) => reasons.push(format!("line {}, {:?}: {reason}", function.line, function.description)),
        }
    }
    if good.is_empty() {
        let why = if reasons.is_empty() { "no dataset 58 or 58b".to_owned() } else { reasons.join("; ") };
        return Err(InputError::new(file, format!("no frequency response to use: {why}")).with_hint(
            "needed is a complex frequency response (function type 4) of displacement, velocity or acceleration \
                 over force",
        ));
    }
    Ok(good)
}

/// Coherence with the response and reference of an FRF, on its lines; `None` when the file has none.
pub(crate) fn coherence_for(functions: &[UffFunction], frf: &UffFrf) -> Option<Vec<f64>> {
    let of = functions
        .iter()
        .find(|f| f.function_type == 6 && f.response == frf.response && f.reference == frf.reference)?;
    let pairs: Vec<(f64, f64)> = of.x.iter().copied().zip(of.y.iter().map(|v| v.re)).collect();
    frf.frequency_hz
        .iter()
        .map(|f| {
            let same = |x: f64| (x - f).abs() <= 1e-6 * f;
            pairs.iter().find(|(x, c)| same(*x) && *c > 0.0 && *c <= 1.0).map(|(_, c)| *c)
        })
        .collect()
}

fn convert(function: &UffFunction) -> Result<UffFrf, String> {
    let name = match function.function_type {
        0 | 4 => None,
        1 => Some("a time record"),
        2 => Some("an auto spectrum"),
        3 => Some("a cross spectrum"),
        5 => Some("a transmissibility"),
        6 => Some("a coherence"),
        9 => Some("a power spectral density"),
        12 => Some("a spectrum"),
        _ => Some("no frequency response"),
    };
    if let Some(name) = name {
        return Err(format!("function type {} is {name}, not a frequency response", function.function_type));
    }
    if !function.complex {
        return Err("the ordinate is real: a frequency response without phase is no use".into());
    }
    let frequency = match function.abscissa.kind {
        18 => true,
        0 | 1 => {
            let text = format!("{} {}", function.abscissa.label, function.abscissa.units);
            let text = text.to_lowercase();
            text.contains("hz") || text.contains("freq")
        }
        _ => false,
    };
    if !frequency {
        return Err(format!(
            "the abscissa (type {}, {:?} in {:?}) is not frequency",
            function.abscissa.kind, function.abscissa.label, function.abscissa.units
        ));
    }
    let (motion, factor) = motion(function)?;
    let (mut frequency_hz, mut compliance) = (vec![], vec![]);
    for (f, y) in function.x.iter().zip(&function.y) {
        if !(f.is_finite() && y.re.is_finite() && y.im.is_finite()) {
            return Err(format!("a value at {f} Hz is not a number"));
        }
        // Compliance is not defined from velocity or acceleration at 0 Hz; no rotor FRF is used there.
        if *f <= 0.0 {
            continue;
        }
        if frequency_hz.last().is_some_and(|last| f <= last) {
            return Err(format!("frequencies do not ascend at {f} Hz"));
        }
        let s = c64::new(0.0, TAU * f);
        let h = match motion {
            Motion::Displacement => *y,
            Motion::Velocity => y / s,
            Motion::Acceleration => y / (s * s),
        };
        frequency_hz.push(*f);
        compliance.push(h * factor);
    }
    if frequency_hz.is_empty() {
        return Err("no line above 0 Hz".into());
    }
    Ok(UffFrf {
        description: function.description.clone(),
        response: function.response,
        reference: function.reference,
        frequency_hz,
        compliance,
    })
}

/// What moves, and the factor from file units to SI.
fn motion(function: &UffFunction) -> Result<(Motion, f64), String> {
    let label: String = format!("{} / {}", function.ordinate.units, function.denominator.units);
    if !matches!(function.denominator.kind, 0 | 1 | 9 | 13) {
        return Err(format!("the denominator (type {}) is not a force", function.denominator.kind));
    }
    let typed = match function.ordinate.kind {
        8 => Some(Motion::Displacement),
        11 => Some(Motion::Velocity),
        12 => Some(Motion::Acceleration),
        0 | 1 => None,
        other => {
            return Err(format!(
                "the ordinate (type {other}, {:?} in {:?}) is no displacement, velocity or acceleration",
                function.ordinate.label, function.ordinate.units
            ));
        }
    };
    let from_units = units(&label);
    match (typed, from_units) {
        (Some(motion), Some((_, factor))) => Ok((motion, factor)),
        (Some(motion), None) => Ok((motion, function.si_length / function.si_force)),
        (None, Some(found)) => Ok(found),
        (None, None) => Err(format!(
            "neither data types nor units ({:?} over {:?}) say whether this is compliance, mobility or accelerance",
            function.ordinate.units, function.denominator.units
        )),
    }
}

/// Motion and factor to SI from a units label such as `m/s²/N`, `(1/N)*(m/s^2)`, `mm/N`, `g/N`.
fn units(label: &str) -> Option<(Motion, f64)> {
    let text: String = label
        .to_lowercase()
        .replace(['²'], "2")
        .chars()
        .filter(|c| !c.is_whitespace() && !matches!(c, '(' | ')' | '^' | '*'))
        .collect();
    if !text.contains('n') || text.contains("none") && text.matches("none").count() > 1 {
        return None;
    }
    let force = if text.contains("kn") { 1e-3 } else { 1.0 };
    let length = if text.contains("mm") {
        1e-3
    } else if text.contains("µm") || text.contains("um") {
        1e-6
    } else {
        1.0
    };
    if text.contains("m/s2") || text.contains("m/sec2") || text.contains("ms-2") {
        Some((Motion::Acceleration, length * force))
    } else if text.contains("m/s") || text.contains("ms-1") {
        Some((Motion::Velocity, length * force))
    } else if text.starts_with("g/") || text.contains("/ng") || text.contains("1/ng") {
        Some((Motion::Acceleration, GRAVITY_M_S2 * force))
    } else if text.contains("m/n") || text.contains("m/kn") || text.contains("nm") || text.contains("m//n") {
        Some((Motion::Displacement, length * force))
    } else {
        None
    }
}
