//! The structure of Δ as index ranges of M, the scalings that belong to it, and the bound that a scaling proves.
//!
//! Δ = blockdiag(Δᵢ), Δᵢ is rows×cols; w = Δ z, z = M w, so M is (Σ cols) × (Σ rows). For every scaling
//!   D_L M D_R⁻¹ = M̃,   β² = λ_max( M̃ᴴM̃ + j(G̃M̃ − M̃ᴴG̃ᴴ) ),   μ(M) ≤ max(β², 0)^½
//! holds when D commutes with Δ and G̃ is Hermitian, block diagonal, and zero outside real blocks (Fan, Tits and Doyle
//! 1991). Symbols: D_L acts on z, D_R on w; both have dᵢI for a full block and the same full Dᵢ for a repeated scalar.

use crate::augment::Block;
use crate::linalg::hermitian::{hermitian_eigen, inverse_complex};
use crate::linalg::{Mat, NumericError, c64, max_singular_value_complex};
use std::ops::Range;
use thiserror::Error;

/// What is wrong with a μ problem, or which computation failed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MuError {
    /// The list of blocks is empty, or a block has no channel.
    #[error("the block structure is empty, or block {block} has no channel")]
    EmptyBlock {
        /// Number of the block, from 0.
        block: usize,
    },
    /// The matrix does not fit the blocks.
    #[error(
        "the blocks need a matrix with {rows} rows (sum of cols) and {cols} columns (sum of rows), found \
         {found_rows}×{found_cols}"
    )]
    Shape {
        /// Rows needed.
        rows: usize,
        /// Columns needed.
        cols: usize,
        /// Rows found.
        found_rows: usize,
        /// Columns found.
        found_cols: usize,
    },
    /// NaN or infinity in the data.
    #[error("NaN or infinity in the matrix at {omega_rad_s} rad/s")]
    NotFinite {
        /// Frequency, NaN for a constant matrix.
        omega_rad_s: f64,
    },
    /// The system must be stable for its structured singular value to mean anything.
    #[error("the system is not stable: a pole has real part {growth_rate:.3e} rad/s")]
    Unstable {
        /// Largest real part of the poles, rad/s.
        growth_rate: f64,
    },
    /// The sweep over frequency did not come to its end.
    #[error(
        "the certificate of the peak covers frequencies up to {covered_to_rad_s:.4e} rad/s only, after {steps} scalings"
    )]
    NotCovered {
        /// End of the covered range, rad/s.
        covered_to_rad_s: f64,
        /// Scalings used.
        steps: usize,
    },
    /// A dense computation failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// One block with the channels of M that it closes.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// The block.
    pub block: Block,
    /// Columns of M (entries of w) that the block feeds.
    pub w: Range<usize>,
    /// Rows of M (entries of z) that the block reads.
    pub z: Range<usize>,
}

impl Span {
    /// True for a full block or a scalar that occurs once and is complex: its scaling is a single number.
    pub(crate) fn has_scalar_scaling(&self) -> bool {
        match self.block {
            Block::ComplexFull { .. } => true,
            Block::ComplexScalar { n } => n == 1,
            Block::RealScalar { .. } => false,
        }
    }

    /// True for a real parameter.
    pub fn is_real(&self) -> bool {
        matches!(self.block, Block::RealScalar { .. })
    }

    /// True for δI, real or complex.
    pub fn is_scalar(&self) -> bool {
        !matches!(self.block, Block::ComplexFull { .. })
    }
}

/// The blocks of Δ with their channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    /// Blocks in list order.
    pub spans: Vec<Span>,
}

impl Structure {
    /// Channels of each block.
    ///
    /// # Errors
    /// [`MuError::EmptyBlock`] without blocks or for a block without channels.
    pub fn new(blocks: &[Block]) -> Result<Self, MuError> {
        if blocks.is_empty() {
            return Err(MuError::EmptyBlock { block: 0 });
        }
        let (mut w, mut z, mut spans) = (0, 0, vec![]);
        for (k, block) in blocks.iter().enumerate() {
            if block.rows() == 0 || block.cols() == 0 {
                return Err(MuError::EmptyBlock { block: k });
            }
            spans.push(Span { block: *block, w: w..w + block.rows(), z: z..z + block.cols() });
            w += block.rows();
            z += block.cols();
        }
        Ok(Self { spans })
    }

    /// Entries of w: columns of M.
    pub fn inputs(&self) -> usize {
        self.spans.last().map_or(0, |s| s.w.end)
    }

    /// Entries of z: rows of M.
    pub fn outputs(&self) -> usize {
        self.spans.last().map_or(0, |s| s.z.end)
    }

    /// Whether any block is real.
    pub(crate) fn has_real(&self) -> bool {
        self.spans.iter().any(Span::is_real)
    }

    /// Checks that a matrix fits and is finite.
    ///
    /// # Errors
    /// [`MuError::Shape`] or [`MuError::NotFinite`].
    pub fn check(&self, m: &Mat<c64>) -> Result<(), MuError> {
        if m.nrows() != self.outputs() || m.ncols() != self.inputs() {
            return Err(MuError::Shape {
                rows: self.outputs(),
                cols: self.inputs(),
                found_rows: m.nrows(),
                found_cols: m.ncols(),
            });
        }
        if !m.is_all_finite() {
            return Err(MuError::NotFinite { omega_rad_s: f64::NAN });
        }
        Ok(())
    }
}

/// A scaling and the upper bound that it proves.
#[derive(Clone, Debug)]
pub struct Scaling {
    /// D_L on z, square.
    pub left: Mat<c64>,
    /// D_R on w, square.
    pub right: Mat<c64>,
    /// G̃ in scaled coordinates, w×z; zero without real blocks.
    pub skew: Mat<c64>,
}

impl Scaling {
    /// D = I, G = 0.
    pub fn identity(structure: &Structure) -> Self {
        let (q, p) = (structure.inputs(), structure.outputs());
        Self { left: Mat::identity(p, p), right: Mat::identity(q, q), skew: Mat::zeros(q, p) }
    }

    /// One positive number per block, G = 0.
    pub fn diagonal(structure: &Structure, d: &[f64]) -> Self {
        let mut scaling = Self::identity(structure);
        for (span, d) in structure.spans.iter().zip(d) {
            for k in span.z.clone() {
                scaling.left[(k, k)] = c64::new(*d, 0.0);
            }
            for k in span.w.clone() {
                scaling.right[(k, k)] = c64::new(*d, 0.0);
            }
        }
        scaling
    }

    /// Diagonals of D_L and D_R⁻¹ when both are real diagonal matrices.
    fn diagonals(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let of = |m: &Mat<c64>| {
            let n = m.nrows();
            let off = (0..n).any(|j| (0..n).any(|i| i != j && m[(i, j)] != c64::new(0.0, 0.0)));
            let real = (0..n).all(|i| m[(i, i)].im == 0.0);
            (real && !off).then(|| (0..n).map(|i| m[(i, i)].re).collect::<Vec<f64>>())
        };
        let right = of(&self.right)?;
        Some((of(&self.left)?, right.iter().map(|d| 1.0 / d).collect()))
    }

    /// D_L M D_R⁻¹.
    pub fn apply(&self, m: &Mat<c64>) -> Mat<c64> {
        match self.diagonals() {
            Some((l, r)) => Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * (l[i] * r[j])),
            None => &self.left * m * inverse_complex(&self.right),
        }
    }

    /// The upper bound of μ(M) that this scaling proves, by direct evaluation; NaN when it cannot be evaluated.
    pub fn bound_at(&self, m: &Mat<c64>) -> f64 {
        self.squared_bound(m).map_or(f64::NAN, |b| b.max(0.0).sqrt())
    }

    /// As [`Self::bound_at`]; where the Frobenius norm of the scaled matrix, which is never below the bound, is at most
    /// `enough`, that norm: a fraction of the time.
    pub(crate) fn bound_from(&self, m: &Mat<c64>, enough: f64) -> f64 {
        if self.skew.norm_max() == 0.0
            && let Some((l, r)) = self.diagonals()
        {
            let column = |j: usize| -> f64 {
                let entries = (0..m.nrows()).map(|i| l[i] * l[i] * m[(i, j)].norm_sqr());
                r[j] * r[j] * entries.sum::<f64>()
            };
            let norm = (0..m.ncols()).map(column).sum::<f64>().sqrt();
            // NaN is not enough.
            if norm <= enough {
                return norm;
            }
        }
        self.bound_at(m)
    }

    /// λ_max of the scaled inequality: the square of the bound, negative when even μ = 0 is proved with room to spare.
    pub(crate) fn squared_bound(&self, m: &Mat<c64>) -> Result<f64, NumericError> {
        let scaled = self.apply(m);
        if self.skew.norm_max() == 0.0 {
            return Ok(max_singular_value_complex(&scaled).powi(2));
        }
        let h = quadratic_form(&scaled, &self.skew);
        Ok(hermitian_eigen(&h)?.0.last().copied().unwrap_or(0.0))
    }
}

/// MᴴM + j(GM − MᴴGᴴ).
pub(crate) fn quadratic_form(m: &Mat<c64>, g: &Mat<c64>) -> Mat<c64> {
    let gm = g * m;
    let mut h = m.adjoint() * m;
    for j in 0..h.ncols() {
        for i in 0..h.nrows() {
            h[(i, j)] += c64::new(0.0, 1.0) * (gm[(i, j)] - gm[(j, i)].conj());
        }
    }
    h
}
