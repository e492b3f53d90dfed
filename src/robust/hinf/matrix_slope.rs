//! Derivative of a number by the matrices of a system.

use crate::linalg::Mat;

/// Derivative of a number by the entries of A, B, C and D.
#[derive(Clone, Debug)]
pub(crate) struct MatrixSlope {
    /// n×n.
    pub a: Mat<f64>,
    /// n×(m1+m2).
    pub b: Mat<f64>,
    /// (p1+p2)×n.
    pub c: Mat<f64>,
    /// (p1+p2)×(m1+m2).
    pub d: Mat<f64>,
}

impl MatrixSlope {
    /// Zero, for a system of order `n`.
    pub(super) fn zero(n: usize, inputs: usize, outputs: usize) -> Self {
        Self {
            a: Mat::zeros(n, n),
            b: Mat::zeros(n, inputs),
            c: Mat::zeros(outputs, n),
            d: Mat::zeros(outputs, inputs),
        }
    }

    /// That of the transposed system.
    pub(super) fn transpose(&self) -> Self {
        let t = |m: &Mat<f64>| m.transpose().to_owned();
        Self { a: t(&self.a), b: t(&self.c), c: t(&self.b), d: t(&self.d) }
    }

    /// With that of one side added, which has the first rows and columns of the whole: A, [B1 B2], C1, [D11 D12] of the
    /// control side, A, B1, [C1; C2], [D11; D21] of the filter side.
    pub(super) fn plus(mut self, side: &Self) -> Self {
        add(&mut self.a, &side.a);
        add(&mut self.b, &side.b);
        add(&mut self.c, &side.c);
        add(&mut self.d, &side.d);
        self
    }

    /// The slope times a number.
    pub(super) fn times(self, factor: f64) -> Self {
        Self { a: self.a * factor, b: self.b * factor, c: self.c * factor, d: self.d * factor }
    }

    /// The derivative along a change of the matrices.
    pub(crate) fn along(&self, change: &[Mat<f64>; 4]) -> f64 {
        let parts = [&self.a, &self.b, &self.c, &self.d];
        parts
            .into_iter()
            .zip(change)
            .map(|(slope, change)| {
                (0..slope.ncols())
                    .flat_map(|j| (0..slope.nrows()).map(move |i| (i, j)))
                    .map(|at| slope[at] * change[at])
                    .sum::<f64>()
            })
            .sum()
    }
}

/// Adds a block to the upper left corner of a matrix.
fn add(whole: &mut Mat<f64>, block: &Mat<f64>) {
    let mut corner = whole.submatrix_mut(0, 0, block.nrows(), block.ncols());
    corner += block;
}
