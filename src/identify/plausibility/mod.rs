//! Is a record what it says it is: units, signs, order of channels, conjugation, frequencies.
//!
//! A record is compared with the nominal machine before anything is read from it. Nominal machines are a few per cent
//! off in stiffness and gains, up to a third in resonances; a mistake in a record is a power of ten, a reversed sign,
//! an exchanged channel. `checks` says in physical terms what does not fit, `search` which mistake undoes it,
//! `faults` names mistakes as the file format does. A record that no known mistake explains and that still
//! contradicts the machine is said to be implausible.

pub(crate) mod channels;
pub(crate) mod checks;
pub(crate) mod correction;
pub(crate) mod faults;
pub(crate) mod hammer;
pub(crate) mod hypotheses;
pub(crate) mod search;
pub(crate) mod spectrum;
pub(crate) mod sweep;

pub use faults::{HammerQuantity, RecordFault, Signal};
pub use hammer::hammer_plausibility;
pub use sweep::sweep_plausibility;

/// One physical check of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Name in files.
    pub name: &'static str,
    /// What the record shows, in the unit that `words` gives.
    pub value: f64,
    /// The range that is plausible.
    pub expected: String,
    /// True when the value lies in it.
    pub ok: bool,
    /// True when a value outside alone makes the record implausible; otherwise it is a remark.
    pub decides: bool,
    /// The finding as a sentence.
    pub words: String,
}

/// What is known about the plausibility of one record.
#[derive(Clone, Debug, PartialEq)]
pub struct Plausibility {
    /// The record as it was named.
    pub record: String,
    /// Checks in a fixed order; those that the record does not allow are absent.
    pub checks: Vec<Check>,
    /// Mistakes that explain the record; empty when it needs none or none is known.
    pub faults: Vec<RecordFault>,
}

impl Plausibility {
    /// True when no mistake was found and no check that decides fails.
    pub fn plausible(&self) -> bool {
        self.faults.is_empty() && self.checks.iter().all(|c| c.ok || !c.decides)
    }

    /// What is wrong and what to do, as sentences; `None` for a plausible record.
    pub fn statement(&self) -> Option<String> {
        if self.plausible() {
            return None;
        }
        if self.faults.is_empty() {
            let failed: Vec<&str> =
                self.checks.iter().filter(|c| c.decides && !c.ok).map(|c| c.words.as_str()).collect();
            return Some(format!(
                "{}: the record is implausible and no known mistake explains it: {}; check that spindle and tool \
                 are those that were measured, and the wiring",
                self.record,
                failed.join("; ")
            ));
        }
        let list = |each: &dyn Fn(&RecordFault) -> String| self.faults.iter().map(each).collect::<Vec<_>>().join("; ");
        Some(format!(
            "{}: the record is implausible: {}; to correct it, {}",
            self.record,
            list(&RecordFault::words),
            list(&RecordFault::remedy)
        ))
    }

    /// Remarks: checks that fail without deciding; none where a mistake was found, which is behind them.
    pub(crate) fn remarks(&self) -> impl Iterator<Item = String> {
        let silent = !self.faults.is_empty();
        let failed = self.checks.iter().filter(move |c| !silent && !c.ok && !c.decides);
        failed.map(|c| format!("{}: {}", self.record, c.words))
    }
}
