//! Units of universal files: the label of an axis as factor to SI with dimensions, and the system of units that dataset
//! 164 states.

use std::f64::consts::TAU;

/// Standard gravity, m/s²: accelerometers are often calibrated in g.
const GRAVITY_M_S2: f64 = 9.80665;
/// International inch, m.
const INCH_M: f64 = 0.0254;
/// Pound-force, N: the international pound under standard gravity.
const POUND_FORCE_N: f64 = 0.453_592_37 * GRAVITY_M_S2;

/// A unit: its size in SI and its exponents of metre, second and newton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UffUnit {
    /// SI units in one of it.
    pub si: f64,
    /// Exponents of metre, second and newton.
    pub dimensions: [i32; 3],
}

/// Unit of a force.
pub(super) const FORCE: [i32; 3] = [0, 0, 1];

impl UffUnit {
    const ONE: Self = Self { si: 1.0, dimensions: [0; 3] };

    const fn length(si: f64) -> Self {
        Self { si, dimensions: [1, 0, 0] }
    }

    const fn time(si: f64) -> Self {
        Self { si, dimensions: [0, 1, 0] }
    }

    const fn force(si: f64) -> Self {
        Self { si, dimensions: FORCE }
    }

    const fn acceleration(si: f64) -> Self {
        Self { si, dimensions: [1, -2, 0] }
    }

    pub(super) fn over(self, other: Self) -> Self {
        self.times(other.raise_unit(-1))
    }

    fn times(self, other: Self) -> Self {
        let (a, b) = (self.dimensions, other.dimensions);
        Self { si: self.si * other.si, dimensions: [0, 1, 2].map(|k: usize| a[k].saturating_add(b[k])) }
    }

    fn raise_unit(self, exponent: i32) -> Self {
        Self { si: self.si.powi(exponent), dimensions: self.dimensions.map(|d| d.saturating_mul(exponent)) }
    }
}

/// The unit of a label such as `m`, `in`, `g`, `m/s²`, `(1/N)*(m/s^2)`; none where the label is empty or `NONE`.
pub(super) fn read_unit(label: &str) -> Result<Option<UffUnit>, String> {
    // UTF-8 read byte by byte has these before and in place of its signs.
    let text = label.replace('Â', "").replace("Î¼", "µ").replace('μ', "µ").replace('²', "^2").replace('³', "^3");
    let text = text.replace("**", "^").replace("//", "/").replace("ms-2", "m/s^2").replace("ms-1", "m/s");
    let text = text.trim().trim_end_matches('.').to_owned();
    let bare = text.trim().to_lowercase();
    if matches!(bare.as_str(), "" | "none" | "unknown" | "-" | "?" | "none/none") {
        return Ok(None);
    }
    let capitals = !text.chars().any(char::is_lowercase);
    let mut parser = Parser { rest: text.chars().collect(), at: 0, capitals };
    let unit = parser.product()?;
    match parser.peek() {
        None => Ok(Some(unit)),
        Some(sign) => Err(format!("{sign:?} in {:?}", label.trim())),
    }
}

/// Recursive descent over products, quotients, powers and brackets.
struct Parser {
    rest: Vec<char>,
    at: usize,
    capitals: bool,
}

impl Parser {
    fn peek(&mut self) -> Option<char> {
        while self.rest.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.rest.get(self.at).copied()
    }

    fn take_while(&mut self, wanted: impl Fn(char) -> bool) -> String {
        let text: String = self.rest[self.at..].iter().copied().take_while(|c| wanted(*c)).collect();
        self.at += text.chars().count();
        text
    }

    fn product(&mut self) -> Result<UffUnit, String> {
        let mut unit = self.power()?;
        while let Some(sign) = self.peek() {
            match sign {
                '*' | '·' | '.' => {
                    self.at += 1;
                    unit = unit.times(self.power()?);
                }
                '/' => {
                    self.at += 1;
                    unit = unit.over(self.power()?);
                }
                '(' => unit = unit.times(self.power()?),
                _ if sign.is_alphabetic() => unit = unit.times(self.power()?),
                _ => break,
            }
        }
        Ok(unit)
    }

    fn power(&mut self) -> Result<UffUnit, String> {
        let base = self.base()?;
        if self.peek() == Some('^') {
            self.at += 1;
        }
        let negative = self.peek() == Some('-');
        if negative {
            self.at += 1;
        }
        let digits = self.take_while(|c| c.is_ascii_digit());
        match digits.parse::<i32>() {
            Ok(exponent) if exponent <= 9 => Ok(base.raise_unit(if negative { -exponent } else { exponent })),
            _ if digits.is_empty() && !negative => Ok(base),
            _ => Err(format!("the exponent \"{}{digits}\"", if negative { "-" } else { "" })),
        }
    }

    fn base(&mut self) -> Result<UffUnit, String> {
        match self.peek() {
            Some('(' | '[') => {
                self.at += 1;
                let unit = self.product()?;
                if !matches!(self.peek(), Some(')' | ']')) {
                    return Err("an open bracket".to_owned());
                }
                self.at += 1;
                Ok(unit)
            }
            Some('1') => {
                self.at += 1;
                Ok(UffUnit::ONE)
            }
            Some('"') => {
                self.at += 1;
                Ok(UffUnit::length(INCH_M))
            }
            Some(c) if c.is_alphabetic() => {
                let name = self.take_while(|c| c.is_alphabetic() || c == '\'');
                // `g0` and `gn` are standard gravity.
                if matches!(name.as_str(), "g" | "G") && self.rest.get(self.at) == Some(&'0') {
                    self.at += 1;
                }
                find_unit(&name, self.capitals).ok_or(format!("{name:?}"))
            }
            Some(other) => Err(format!("{other:?}")),
            None => Err("an end after a sign".to_owned()),
        }
    }
}

/// The unit of a name; prefixes are read as written (`mN` is no `MN`), names in a label of capitals in any case.
fn find_unit(name: &str, capitals: bool) -> Option<UffUnit> {
    let lower = name.to_lowercase();
    if let Some(unit) = word(&lower) {
        // `Nm` is a torque, `nm` a length.
        return Some(unit);
    }
    if name.chars().count() == 1 || capitals {
        // Milli or mega, nano or newton: capitals do not tell.
        let unclear = capitals && matches!(lower.as_str(), "mn" | "nm");
        return if unclear { None } else { find_prefixed(if lower == "n" { "N" } else { &lower }) };
    }
    match name {
        "Nm" => Some(UffUnit { si: 1.0, dimensions: [1, 0, 1] }),
        _ => find_prefixed(name),
    }
}

/// A prefix before m, s, N or g.
fn find_prefixed(name: &str) -> Option<UffUnit> {
    let newton_of_capitals = name.strip_suffix('n').filter(|p| matches!(*p, "k" | "da" | "u"));
    let (prefix, base) = match name.char_indices().last()? {
        (at, 'm') => (&name[..at], UffUnit::length(1.0)),
        (at, 's') => (&name[..at], UffUnit::time(1.0)),
        (at, 'N') => (&name[..at], UffUnit::force(1.0)),
        (at, 'g') => (&name[..at], UffUnit::acceleration(GRAVITY_M_S2)),
        _ => (newton_of_capitals?, UffUnit::force(1.0)),
    };
    let mass = base.dimensions == [1, -2, 0] && !matches!(prefix, "" | "m" | "u" | "µ");
    let factor = match prefix {
        "" => 1.0,
        "k" => 1e3,
        "M" if base.dimensions == FORCE => 1e6,
        "da" => 10.0,
        "d" => 1e-1,
        "c" => 1e-2,
        "m" => 1e-3,
        "u" | "µ" => 1e-6,
        "n" => 1e-9,
        "p" => 1e-12,
        _ => return None,
    };
    (!mass).then_some(UffUnit { si: base.si * factor, ..base })
}

/// A unit that is written as a word, in lower case.
fn word(name: &str) -> Option<UffUnit> {
    Some(match name {
        "meter" | "meters" | "metre" | "metres" => UffUnit::length(1.0),
        "millimeter" | "millimeters" | "millimetre" | "millimetres" => UffUnit::length(1e-3),
        "micron" | "microns" | "micrometer" | "micrometers" | "micrometre" | "micrometres" => UffUnit::length(1e-6),
        "in" | "inch" | "inches" => UffUnit::length(INCH_M),
        "mil" | "mils" | "thou" => UffUnit::length(INCH_M / 1e3),
        "ft" | "foot" | "feet" => UffUnit::length(12.0 * INCH_M),
        "sec" | "second" | "seconds" => UffUnit::time(1.0),
        "newton" | "newtons" => UffUnit::force(1.0),
        "millinewton" | "millinewtons" => UffUnit::force(1e-3),
        "kilonewton" | "kilonewtons" => UffUnit::force(1e3),
        "lbf" | "lb" | "lbs" | "pound" | "pounds" => UffUnit::force(POUND_FORCE_N),
        "ozf" | "oz" => UffUnit::force(POUND_FORCE_N / 16.0),
        "kip" | "kips" | "klbf" => UffUnit::force(1e3 * POUND_FORCE_N),
        "pdl" | "poundal" | "poundals" => UffUnit::force(0.453_592_37 * 12.0 * INCH_M),
        "kgf" | "kp" => UffUnit::force(GRAVITY_M_S2),
        "gf" => UffUnit::force(1e-3 * GRAVITY_M_S2),
        "dyn" | "dyne" | "dynes" => UffUnit::force(1e-5),
        "gn" | "g's" | "gs" => UffUnit::acceleration(GRAVITY_M_S2),
        "gal" => UffUnit::acceleration(1e-2),
        _ => return None,
    })
}

/// Hz in one of the unit of a frequency; an empty label is Hz.
pub(super) fn read_frequency_unit(label: &str) -> Result<f64, String> {
    let text: String = label.to_lowercase().chars().filter(|c| !c.is_whitespace()).collect();
    match text.as_str() {
        "" | "none" | "hz" | "hertz" | "1/s" | "1/sec" | "cps" | "cycles/s" | "cycles/sec" => Ok(1.0),
        "khz" => Ok(1e3),
        "rad/s" | "rad/sec" | "radians/s" | "radians/sec" => Ok(TAU.recip()),
        "rpm" | "cpm" | "1/min" | "cycles/min" => Ok(60f64.recip()),
        _ => Err(format!("{:?}", label.trim())),
    }
}

/// The system of units of a file, from dataset 164.
#[derive(Clone, Debug, PartialEq)]
pub struct UffSystem {
    /// Metres in its unit of length.
    pub length_m: f64,
    /// Newtons in its unit of force.
    pub force_n: f64,
}

/// Codes of dataset 164 with their units of length (m) and force (N); 9 is defined by its factors.
const SYSTEMS: [(i64, f64, f64); 9] = [
    (1, 1.0, 1.0),
    (2, 12.0 * INCH_M, POUND_FORCE_N),
    (3, 1.0, GRAVITY_M_S2),
    (4, 12.0 * INCH_M, 0.453_592_37 * 12.0 * INCH_M),
    (5, 1e-3, 1e-3),
    (6, 1e-2, 1e-2),
    (7, INCH_M, POUND_FORCE_N),
    (8, 1e-3, GRAVITY_M_S2),
    (10, 1e-3, 1.0),
];

/// Relative difference of two factors for the same unit: files print four digits and more, other units differ by tens
/// of percent.
pub(super) const SAME_FACTOR: f64 = 2e-3;

/// The system of a code with the factors beside it (file values are divided by them to get SI).
pub(super) fn read_system(code: Option<i64>, factors: &[f64]) -> Result<UffSystem, String> {
    let known = SYSTEMS.iter().find(|(known, ..)| Some(*known) == code);
    let stated = match factors {
        [length, force, ..] if *length > 0.0 && *force > 0.0 && length.is_finite() && force.is_finite() => {
            Some(UffSystem { length_m: length.recip(), force_n: force.recip() })
        }
        _ => None,
    };
    let shown = code.map_or("none".to_owned(), |c| c.to_string());
    match (known, stated) {
        (Some((_, length_m, force_n)), Some(stated)) => {
            let near = |a: f64, b: f64| (a / b - 1.0).abs() < SAME_FACTOR;
            if near(stated.length_m, *length_m) && near(stated.force_n, *force_n) {
                return Ok(UffSystem { length_m: *length_m, force_n: *force_n });
            }
            Err(format!(
                "units code {shown} has a length of {length_m:.6} m and a force of {force_n:.6} N, its factors say \
                 {:.6} m and {:.6} N",
                stated.length_m, stated.force_n
            ))
        }
        (Some((_, length_m, force_n)), None) => Ok(UffSystem { length_m: *length_m, force_n: *force_n }),
        (None, Some(stated)) => Ok(stated),
        (None, None) => Err(format!("units code {shown} has no factors of length and force that can be read")),
    }
}
