//! Blocks of the structured uncertainty Δ = blockdiag(Δ₁, Δ₂, …), in list order.
//! Δᵢ maps its `cols` outputs of M to its `rows` inputs of M, so M is (Σ cols) × (Σ rows).

/// One block of Δ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// A full complex matrix, rows × cols.
    ComplexFull {
        /// Inputs of M that the block feeds.
        rows: usize,
        /// Outputs of M that the block reads.
        cols: usize,
    },
    /// δ·I with a complex scalar δ.
    ComplexScalar {
        /// Repetitions.
        n: usize,
    },
    /// δ·I with a real scalar δ.
    RealScalar {
        /// Repetitions.
        n: usize,
    },
}

impl Block {
    /// Inputs of M that the block feeds.
    pub fn rows(&self) -> usize {
        match *self {
            Self::ComplexFull { rows, .. } => rows,
            Self::ComplexScalar { n } | Self::RealScalar { n } => n,
        }
    }

    /// Outputs of M that the block reads.
    pub fn cols(&self) -> usize {
        match *self {
            Self::ComplexFull { cols, .. } => cols,
            Self::ComplexScalar { n } | Self::RealScalar { n } => n,
        }
    }
}
