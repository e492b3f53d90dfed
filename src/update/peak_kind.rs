//! Resonances and antiresonances.

/// What kind of peak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PeakKind {
    /// A pole of the free-free rotor.
    Resonance,
    /// A zero of one of its FRFs.
    Antiresonance,
}
