//! Which peak of the model is which measured peak: alignment of two ascending sequences with gaps, by position in the
//! pattern of poles and zeros and not by index.
//!
//! Antiresonances are first carried to the model's scale with the resonances as fixed points (piecewise linear in log
//! f), so that what is compared is where a zero lies between its poles. Then dynamic programming finds the cheapest
//! order-preserving assignment (Needleman and Wunsch 1970): |Δ ln f| for a pair, a price for every peak left over on
//! either side.

/// Price of leaving a measured peak without partner, in ln f: a factor 1.5 off is no longer the same peak.
const MEASURED_UNMATCHED: f64 = 0.4;
/// Price of passing over a peak of the model that lies below or between matched ones: people overlook shallow peaks.
const MODEL_PASSED: f64 = 0.1;
/// Price of giving a partner to a peak that is known to exist but has no frequency; none would cost [`MODEL_PASSED`].
const PLACEHOLDER_PAIRED: f64 = 0.0;

/// Index of the model peak that belongs to each measured one. Both lists ascend; `None` among the measured is a
/// placeholder. `priority[k]` scales the price of passing over model peak k (0 for one that hardly shows).
pub(crate) fn align(measured_ln: &[Option<f64>], model_ln: &[f64], priority: &[f64]) -> Vec<Option<usize>> {
    let (n, m) = (measured_ln.len(), model_ln.len());
    // cost[i][j]: the first i measured and j model peaks settled.
    let mut cost = vec![vec![f64::INFINITY; m + 1]; n + 1];
    let mut step = vec![vec![0u8; m + 1]; n + 1];
    cost[0][0] = 0.0;
    for i in 0..=n {
        for j in 0..=m {
            let here = cost[i][j];
            if j < m {
                // Peaks of the model above the last measured one are free: nobody claims to have measured so far.
                let passed = if i == n { 0.0 } else { MODEL_PASSED * priority.get(j).copied().unwrap_or(1.0) };
                relax(&mut cost, &mut step, (i, j + 1), here + passed, 1);
            }
            if i < n {
                let alone = measured_ln[i].map_or(MODEL_PASSED, |_| MEASURED_UNMATCHED);
                relax(&mut cost, &mut step, (i + 1, j), here + alone, 2);
                if j < m {
                    let pair = measured_ln[i].map_or(PLACEHOLDER_PAIRED, |f| (f - model_ln[j]).abs());
                    relax(&mut cost, &mut step, (i + 1, j + 1), here + pair, 3);
                }
            }
        }
    }
    let mut partners = vec![None; n];
    let (mut i, mut j) = (n, m);
    while i > 0 || j > 0 {
        match step[i][j] {
            1 => j -= 1,
            2 => i -= 1,
            _ => {
                (i, j) = (i - 1, j - 1);
                partners[i] = measured_ln[i].map(|_| j);
            }
        }
    }
    partners
}

fn relax(cost: &mut [Vec<f64>], step: &mut [Vec<u8>], to: (usize, usize), value: f64, kind: u8) {
    if value < cost[to.0][to.1] {
        cost[to.0][to.1] = value;
        step[to.0][to.1] = kind;
    }
}

/// Carries a measured log frequency to the model's scale: fixed points are pairs (measured, model) of resonances,
/// ascending.
pub(crate) fn warp(fixed_ln: &[(f64, f64)], f_ln: f64) -> f64 {
    let (Some(first), Some(last)) = (fixed_ln.first(), fixed_ln.last()) else {
        return f_ln;
    };
    if f_ln <= first.0 {
        return f_ln + first.1 - first.0;
    }
    if f_ln >= last.0 {
        return f_ln + last.1 - last.0;
    }
    for pair in fixed_ln.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if f_ln <= b.0 {
            return a.1 + (b.1 - a.1) * (f_ln - a.0) / (b.0 - a.0);
        }
    }
    f_ln
}
