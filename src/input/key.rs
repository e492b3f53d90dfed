//! A number of a file as the tables of keys state it: unit, plausible and possible range, reason. That a file must have
//! it, or what it is where it does not, stands at its field.

/// One number of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Its name inside its group; `[]` behind it for each entry of a list.
    pub name: &'static str,
    /// Unit; empty for a plain number.
    pub unit: &'static str,
    /// Whether it must be above zero, by a rule of its own.
    pub is_positive: bool,
    /// Range of the size that real machines keep to. Zero is accepted without a word where it is possible.
    pub plausible: [f64; 2],
    /// Range of the size outside which the value is refused.
    pub possible: [f64; 2],
    /// Where the ranges come from.
    pub reason: &'static str,
}

/// Keys that stand together: `at` is their path, `*` any name, `[]` any entry of a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyGroup {
    /// Path from the top of the file; empty at the top.
    pub at: &'static str,
    /// Its keys.
    pub keys: &'static [Key],
}

pub(super) type Range = [f64; 2];

/// A list of keys, one a row: which of the functions below makes it, the name, the unit, the plausible and the possible
/// range, the reason.
macro_rules! keys {
    ($($kind:ident $name:literal $unit:literal $ranges:tt $reason:expr;)*) => {
        &[$($kind($name, $unit, $ranges, $reason)),*]
    };
}
pub(super) use keys;

pub(super) const fn number(name: &'static str, unit: &'static str, ranges: [Range; 2], reason: &'static str) -> Key {
    let [plausible, possible] = ranges;
    Key { name, unit, is_positive: false, plausible, possible, reason }
}

pub(super) const fn positive(name: &'static str, unit: &'static str, ranges: [Range; 2], reason: &'static str) -> Key {
    Key { is_positive: true, ..number(name, unit, ranges, reason) }
}

pub(super) const fn group(at: &'static str, keys: &'static [Key]) -> KeyGroup {
    KeyGroup { at, keys }
}
