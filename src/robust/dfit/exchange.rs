//! Linear programmes with many rows of which few bind: solved on some rows, and next time on those as well that the
//! answer breaks.
//!
//! Rows come in curves: neighbours on a curve say nearly the same, as the errors of a fit at neighbouring frequencies
//! do. Of each stretch that is broken the row that is broken most joins the next programme. Programmes that differ
//! little need no end of their own: repeated on the rows that the one before leaves, they end at the answer of all rows
//! (the exchange of Remez, for one that changes all points at once).

use crate::robust::conic::{Optimum, Programme, ProgrammeError, SparseRow};

/// What a row may be broken by, relative to the terms of its sum: what the interior-point method leaves.
const BROKEN: f64 = 1e-8;
/// A row with less slack than this, on the same scale, is likely to bind in the next programme too.
const NEARLY: f64 = 1e-2;

/// minimise cᵀx subject to rows that always count and curves of rows.
pub(super) struct Exchange {
    /// c.
    pub objective: Vec<f64>,
    /// Rows of every round, bounds of the variables for instance.
    pub always: Vec<SparseRow>,
    pub curves: Vec<Vec<SparseRow>>,
}

/// Rows of each curve, ascending.
pub(super) type Chosen = Vec<Vec<usize>>;

impl Exchange {
    /// The minimiser on the rows that are `likely` to bind and on some of each curve: its value is not above that of
    /// all rows. With it the rows that bind, nearly do or are broken, and whether none is broken that was left out.
    pub(super) fn solve(&self, likely: &Chosen) -> Result<(Optimum, Chosen, bool), ProgrammeError> {
        let mut chosen = self.first(likely);
        let end = match self.on(&chosen) {
            Ok(end) => end,
            // A part of the rows may bound nothing: then all of them decide.
            Err(_) => {
                let every = |curve: &Vec<SparseRow>| (0..curve.len()).collect::<Vec<usize>>();
                chosen = self.curves.iter().map(every).collect();
                self.on(&chosen)?
            }
        };
        let mut next = self.nearly_binding(&chosen, &end.x);
        let broken = self.break_levels(&end.x);
        let mut pairs = broken.iter().zip(&chosen);
        let settled = pairs.all(|(more, own)| more.iter().all(|row| own.contains(row)));
        for (own, more) in next.iter_mut().zip(broken) {
            own.extend(more);
            own.sort_unstable();
            own.dedup();
        }
        Ok((end, next, settled))
    }

    /// The likely rows, and some of each curve at even distances.
    fn first(&self, likely: &Chosen) -> Chosen {
        let variables = self.objective.len();
        let first = |(k, curve): (usize, &Vec<SparseRow>)| {
            let count = (variables + 2).min(curve.len());
            let last = curve.len().saturating_sub(1);
            let mut own = likely.get(k).cloned().unwrap_or_default();
            own.retain(|row| *row <= last);
            own.extend((0..count).map(|i| i * last / count.saturating_sub(1).max(1)));
            own.sort_unstable();
            own.dedup();
            own
        };
        self.curves.iter().enumerate().map(first).collect()
    }

    fn on(&self, chosen: &Chosen) -> Result<Optimum, ProgrammeError> {
        let curves = self.curves.iter().zip(chosen);
        let rows = curves.flat_map(|(curve, own)| own.iter().map(|k| curve[*k].clone()));
        let programme = Programme {
            objective: self.objective.clone(),
            inequalities: rows.chain(self.always.iter().cloned()).collect(),
            ..Programme::default()
        };
        programme.solve()
    }

    /// Of each curve the rows that are broken more than their neighbours.
    fn break_levels(&self, x: &[f64]) -> Chosen {
        let of_curve = |curve: &Vec<SparseRow>| {
            let excess: Vec<f64> = curve.iter().map(|row| excess(row, x)).collect();
            let beside = |k: Option<usize>| k.and_then(|k| excess.get(k)).copied();
            let tops = (0..excess.len()).filter(|k| {
                let own = excess[*k];
                let before = beside(k.checked_sub(1)).unwrap_or(f64::NEG_INFINITY);
                let after = beside(Some(k + 1)).unwrap_or(f64::NEG_INFINITY);
                own > BROKEN && own >= before && own > after
            });
            tops.collect()
        };
        self.curves.iter().map(of_curve).collect()
    }

    fn nearly_binding(&self, chosen: &Chosen, x: &[f64]) -> Chosen {
        let of_curve = |(curve, own): (&Vec<SparseRow>, &Vec<usize>)| {
            let near = own.iter().filter(|k| excess(&curve[**k], x) > -NEARLY);
            near.copied().collect()
        };
        self.curves.iter().zip(chosen).map(of_curve).collect()
    }
}

/// By how much aᵀx exceeds b, over the size of the terms.
fn excess(row: &SparseRow, x: &[f64]) -> f64 {
    let (mut sum, mut size) = (-row.bound, row.bound.abs());
    for (k, value) in &row.terms {
        let term = value * x[*k];
        sum += term;
        size += term.abs();
    }
    if size > 0.0 { sum / size } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best straight line under x⁴ − e ≤ a + b x ≤ x⁴ + e on [0, 1] (Chebyshev): b = 1, the slope of the chord, and
    /// a = −e, e half the distance of the chord at x* where the slope is the same, 4x*³ = 1.
    #[test]
    fn the_best_line_is_that_of_all_rows() {
        let rows = |sign: f64| {
            let row = |k: i32| {
                let x = f64::from(k) / 1000.0;
                SparseRow { terms: vec![(0, sign), (1, sign * x), (2, -1.0)], bound: sign * x.powi(4) }
            };
            (0..=1000).map(row).collect::<Vec<SparseRow>>()
        };
        let touch = 0.25f64.cbrt();
        let e = 0.5 * (touch - touch.powi(4));
        let exchange = Exchange { objective: vec![0.0, 0.0, 1.0], always: vec![], curves: vec![rows(1.0), rows(-1.0)] };
        let (mut end, mut binding, mut settled) = exchange.solve(&vec![]).expect("bounded");
        // A part of the rows promises too much, and three more programmes are enough.
        assert!(end.x[2] < e - 1e-3 && !settled, "{}", end.x[2]);
        for _ in 0..3 {
            (end, binding, settled) = exchange.solve(&binding).expect("bounded");
        }
        assert!(settled);
        // The points are a thousandth apart.
        for (found, expected) in end.x.iter().zip([-e, 1.0, e]) {
            assert!((found - expected).abs() < 2e-6, "{:?}", end.x);
        }
        // The line lies above the curve in the middle, and below it at the ends.
        assert!(binding[0].contains(&630) && binding[1].contains(&0) && binding[1].contains(&1000));
    }
}
