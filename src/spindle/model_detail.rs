//! How much of the shaft a model keeps.

/// How much of the shaft a plant keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelDetail {
    /// The full FE model: its modes up to six times the end of a sweep (24 kHz for one to 4 kHz), and Ritz vectors of
    /// all ports and gyroscopic moments for the rest.
    Full,
    /// Two rigid and so many flexible modes per plane.
    Modes {
        /// Flexible modes.
        flexible: usize,
        /// Whether the cut modes leave their static flexibility.
        static_residual: bool,
    },
}
