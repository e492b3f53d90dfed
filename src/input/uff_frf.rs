//! Which functions of a universal file are frequency responses of a structure, and their conversion to compliance in
//! m/N. Mobility v/F = jω x/F, accelerance a/F = −ω² x/F (ISO 7626-1). What is measured is taken from the data types of
//! the axes and from their unit labels, units without a label from dataset 164; what cannot be told, and labels that
//! contradict the one or the other, are refused.

use super::error::InputError;
use super::uff::UffFunction;
use super::uff_units::{FORCE, SAME_FACTOR, UffUnit, read_frequency_unit, read_unit};
use crate::identify::spectra::Motion;
use crate::linalg::c64;

/// An FRF converted to compliance.
#[derive(Clone, Debug, PartialEq)]
pub struct UffFrf {
    /// Its number among the functions of the file, from 1.
    pub number: usize,
    /// ID line 1.
    pub description: String,
    /// Response node and direction.
    pub response: (i64, i64),
    /// Reference node and direction.
    pub reference: (i64, i64),
    /// What the file does not say and was taken for granted.
    pub notes: Vec<String>,
    /// Lines, Hz, ascending, positive.
    pub frequency_hz: Vec<f64>,
    /// Compliance, m/N.
    pub compliance: Vec<c64>,
}

impl UffFrf {
    /// True when response and reference are the same point in the same axis, either sense.
    pub(crate) fn is_driving_point(&self) -> bool {
        self.response.0 == self.reference.0 && self.response.1.abs() == self.reference.1.abs()
    }

    pub(crate) fn label(&self) -> String {
        format!(
            "{}: {:?} (response {}:{}, reference {}:{})",
            self.number, self.description, self.response.0, self.response.1, self.reference.0, self.reference.1
        )
    }
}

/// All frequency responses of the file as compliances.
///
/// # Errors
/// [`InputError`] when none can be used, with the reason for every function.
pub fn frfs(file: &str, functions: &[UffFunction]) -> Result<Vec<UffFrf>, InputError> {
    let mut good = vec![];
    let mut reasons = vec![];
    for (k, function) in functions.iter().enumerate() {
        match frf_of(k + 1, function) {
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

/// The compliance of the function with this number, from 1.
pub(super) fn frf_of(number: usize, function: &UffFunction) -> Result<UffFrf, String> {
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
    let hz = read_frequency_unit(&function.abscissa.units)
        .map_err(|label| format!("the unit {label} of the abscissa is not understood: Hz, kHz, rad/s or rpm"))?;
    let (motion, factor, notes) = motion(function)?;
    let (mut frequency_hz, mut compliance) = (vec![], vec![]);
    for (f, y) in function.x.iter().zip(&function.y) {
        if !(f.is_finite() && y.re.is_finite() && y.im.is_finite()) {
            return Err(format!("a value at {f} Hz is not a number"));
        }
        let f = &(hz * f);
        // Compliance is not defined from velocity or acceleration at 0 Hz; no rotor FRF is used there.
        if *f <= 0.0 {
            continue;
        }
        if frequency_hz.last().is_some_and(|last| f <= last) {
            return Err(format!("frequencies do not ascend at {f} Hz"));
        }
        let h = y * motion.to_displacement(*f, 0.0);
        frequency_hz.push(*f);
        compliance.push(h * factor);
    }
    if frequency_hz.is_empty() {
        return Err("no line above 0 Hz".into());
    }
    Ok(UffFrf {
        number,
        description: function.description.clone(),
        response: function.response,
        reference: function.reference,
        notes,
        frequency_hz,
        compliance,
    })
}

impl Motion {
    /// What a type of the ordinate is; none where the type is general or unknown.
    pub(super) fn of_type(function: &UffFunction) -> Result<Option<Self>, String> {
        match function.ordinate.kind {
            8 => Ok(Some(Self::Displacement)),
            11 => Ok(Some(Self::Velocity)),
            12 => Ok(Some(Self::Acceleration)),
            0 | 1 => Ok(None),
            other => Err(format!(
                "the ordinate (type {other}, {:?} in {:?}) is no displacement, velocity or acceleration",
                function.ordinate.label, function.ordinate.units
            )),
        }
    }

    /// What is measured in a unit of these exponents of metre and second.
    pub(crate) fn of_exponents(exponents: [i32; 2]) -> Option<Self> {
        let all = [Self::Displacement, Self::Velocity, Self::Acceleration];
        all.into_iter().find(|motion| motion.exponents() == exponents)
    }

    /// Exponents of metre, second and newton.
    pub(super) fn dimensions(self) -> [i32; 3] {
        let [length, time] = self.exponents();
        [length, time, 0]
    }

    fn exponents(self) -> [i32; 2] {
        match self {
            Self::Displacement => [1, 0],
            Self::Velocity => [1, -1],
            Self::Acceleration => [1, -2],
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
        }
    }
}

/// What moves, the factor from file units to SI, and what was taken for granted.
fn motion(function: &UffFunction) -> Result<(Motion, f64, Vec<String>), String> {
    if !matches!(function.denominator.kind, 0 | 1 | 9 | 13) {
        return Err(format!("the denominator (type {}) is not a force", function.denominator.kind));
    }
    let typed = Motion::of_type(function)?;
    let read = |label: &str| read_unit(label).map_err(|part| format!("the unit {label:?} is not understood: {part}"));
    let (ordinate, denominator) = (read(&function.ordinate.units)?, read(&function.denominator.units)?);
    check_system(function, ordinate, denominator)?;
    let mut notes = vec![];
    let force = match denominator {
        Some(unit) if unit.dimensions == FORCE => unit.si,
        Some(_) => return Err(format!("the unit {:?} of the denominator is no force", function.denominator.units)),
        None => function.system.as_ref().map_or(1.0, |s| s.force_n),
    };
    let (found, factor) = match ordinate {
        Some(unit) => {
            let [length, time, newton] = unit.dimensions;
            // A label such as m/s²/N holds the force already.
            let per_force = match newton {
                0 => unit.si / force,
                _ => unit.si,
            };
            let found = Motion::of_exponents([length, time]).filter(|_| matches!(newton, 0 | -1)).ok_or(format!(
                "the unit {:?} of the ordinate is no displacement, velocity or acceleration, over force or not",
                function.ordinate.units
            ))?;
            if newton == 0 && denominator.is_none() && function.system.is_none() {
                notes.push("the file states no unit of force: taken as N".to_owned());
            }
            (found, per_force)
        }
        None => {
            let Some(typed) = typed else {
                return Err(format!(
                    "neither data types nor units ({:?} over {:?}) say whether this is compliance, mobility or \
                     accelerance",
                    function.ordinate.units, function.denominator.units
                ));
            };
            if function.system.is_none() {
                let both = if denominator.is_none() { " and force: taken as SI" } else { ": taken as SI" };
                notes.push(format!("the file states no unit of {}{both}", typed.name()));
            }
            (typed, function.system.as_ref().map_or(1.0, |s| s.length_m) / force)
        }
    };
    match typed {
        Some(typed) if typed != found => Err(format!(
            "the ordinate has the data type of a {}, but the unit {:?} of a {}",
            typed.name(),
            function.ordinate.units,
            found.name()
        )),
        _ => Ok((found, factor, notes)),
    }
}

/// Labels in other units than those of dataset 164 leave open which of them holds.
fn check_system(function: &UffFunction, ordinate: Option<UffUnit>, denominator: Option<UffUnit>) -> Result<(), String> {
    let Some(system) = &function.system else {
        return Ok(());
    };
    for (axis, unit) in [(&function.ordinate, ordinate), (&function.denominator, denominator)] {
        let Some(unit) = unit else {
            continue;
        };
        // Gravity is a unit of its own in every system.
        let (free, of_force) = (read_unit("g").ok().flatten().map_or(1.0, |g| g.si), system.force_n);
        let [length, _, force] = unit.dimensions;
        let expected = system.length_m.powi(length) * of_force.powi(force);
        let same = |expected: f64| (unit.si / expected - 1.0).abs() < SAME_FACTOR;
        let gravity = unit.dimensions[..2] == [1, -2] && same(free * of_force.powi(force));
        if !same(expected) && !gravity {
            return Err(format!(
                "the unit {:?} is not that of dataset 164, whose length is {:.6} m and whose force is {:.6} N: which \
                 of them holds is not clear",
                axis.units, system.length_m, system.force_n
            ));
        }
    }
    Ok(())
}
