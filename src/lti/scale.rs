//! Diagonal state scaling that evens out the rows of [A B] and the columns of [A; C] (powers of two, so exact).

use super::state_space::{StateSpace, TimeBase};
use crate::linalg::balance::balanced;

/// Diagonal T for x = T x̃ such that row i of [T⁻¹AT, T⁻¹B] and column i of [T⁻¹AT; CT] have like norms.
/// States that nothing drives or nothing reads keep their scale.
pub(crate) fn balancing<T: TimeBase>(system: &StateSpace<T>) -> Vec<f64> {
    let n = system.order();
    let b: Vec<f64> = (0..n).map(|i| (0..system.inputs()).map(|j| system.b[(i, j)].powi(2)).sum()).collect();
    let c: Vec<f64> = (0..n).map(|j| (0..system.outputs()).map(|i| system.c[(i, j)].powi(2)).sum()).collect();
    balanced(n, |t, i| {
        let (mut row, mut col) = (b[i] / t[i].powi(2), c[i] * t[i].powi(2));
        for j in 0..n {
            if i != j {
                row += (system.a[(i, j)] * t[j] / t[i]).powi(2);
                col += (system.a[(j, i)] * t[i] / t[j]).powi(2);
            }
        }
        (row, col)
    })
}
