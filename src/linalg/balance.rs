//! Diagonal scaling of a state by powers of two (exact in floating point), Parlett & Reinsch, Numerische Mathematik 13
//! (1969) 293–304.

/// Sweeps over all states: twenty settle spreads of 1e10. Balancing is a help, not a condition.
const SWEEPS: usize = 20;

/// T of x = T x̃ for which the size of row i and that of column i are alike. `sizes` returns both under a scaling: the
/// row falls and the column grows with tᵢ. A state without a row or a column keeps its scale.
pub(crate) fn balance_scales(n: usize, sizes: impl Fn(&[f64], usize) -> (f64, f64)) -> Vec<f64> {
    let mut t = vec![1.0f64; n];
    for _ in 0..SWEEPS {
        let mut changed = false;
        for i in 0..n {
            let (row, column) = sizes(&t, i);
            let f = evening_factor(row, column);
            if f != 1.0 {
                t[i] *= f;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    t
}

/// The power of two nearest to the fourth root of row/column; one where either is zero or not finite.
pub(super) fn evening_factor(row: f64, column: f64) -> f64 {
    // The ratio itself can overflow or underflow.
    let f = (0.25 * (row.log2() - column.log2())).round().exp2();
    if f.is_normal() { f } else { 1.0 }
}
