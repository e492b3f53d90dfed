//! A finer mesh in the coordinates of the model's own.

use super::ritz::ReducedShaft;
use crate::linalg::Mat;
use crate::linalg::dense::Factored;
use crate::spindle::SpindleError;

/// s and 1 + sKC, factored.
#[derive(Debug)]
pub(super) struct FinerMesh {
    s: f64,
    unit: Factored,
}

impl FinerMesh {
    /// Changes a stiffness to that of a mesh `s` steps finer; nothing for s = 0.
    pub(super) fn new(shaft: &ReducedShaft, stiffness: &mut Mat<f64>, s: f64) -> Result<Option<Self>, SpindleError> {
        if s == 0.0 {
            return Ok(None);
        }
        let n = stiffness.nrows();
        let product = &*stiffness * &shaft.mesh;
        let unit = Mat::from_fn(n, n, |i, j| s * product[(i, j)] + f64::from(u8::from(i == j)));
        let unit = Factored::new(&unit);
        let moved = unit.solve(stiffness)?;
        *stiffness = Mat::from_fn(n, n, |i, j| 0.5 * (moved[(i, j)] + moved[(j, i)]));
        Ok(Some(Self { s, unit }))
    }

    /// Rows of the ports of the shaft in the changed coordinates; returns their constant receptance, ports × ports.
    pub(super) fn move_ports(&self, shaft: &ReducedShaft, rows: &mut [Vec<f64>]) -> Result<Vec<f64>, SpindleError> {
        let (n, p) = (shaft.len(), rows.len());
        let before = Mat::from_fn(n, p, |i, j| rows[j][i]);
        let after = self.unit.solve(&before)?;
        let still = before.transpose() * (&shaft.mesh * &after);
        for (j, row) in rows.iter_mut().enumerate() {
            for (i, a) in row.iter_mut().enumerate() {
                *a = after[(i, j)];
            }
        }
        Ok((0..p * p).map(|k| self.s * still[(k / p, k % p)]).collect())
    }
}
