//! Diagonal scaling of a state by powers of two (exact in floating point), Parlett & Reinsch, Numerische Mathematik 13
//! (1969) 293–304.

/// Sweeps over all states: twenty settle spreads of 1e10. Balancing is a help, not a condition.
const SWEEPS: usize = 20;

/// T of x = T x̃ for which the size of row i and that of column i are alike. `sizes` returns both under a scaling: the
/// row falls and the column grows with tᵢ. A state without a row or a column keeps its scale.
pub(crate) fn balanced(n: usize, sizes: impl Fn(&[f64], usize) -> (f64, f64)) -> Vec<f64> {
    let mut t = vec![1.0f64; n];
    for _ in 0..SWEEPS {
        let mut changed = false;
        for i in 0..n {
            let (row, column) = sizes(&t, i);
            if row > 0.0 && column > 0.0 {
                // The ratio itself can leave the range of numbers.
                let f = (0.25 * (row.log2() - column.log2())).round().exp2();
                if f != 1.0 && f.is_finite() {
                    t[i] *= f;
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
    }
    t
}
