//! Linear programmes with many rows of which few bind: solved on some rows, then on those as well that the answer
//! breaks.
//!
//! Rows come in curves: neighbours on a curve say nearly the same, as the errors of a fit at neighbouring frequencies
//! do. Of each stretch that is broken the row that is broken most joins the programme. It ends when no row is broken,
//! so the answer is that of all rows (the exchange of Remez, for one that changes all points at once).

use crate::robust::mu::lmi::{Optimum, Programme, ProgrammeError, Row};

/// What a row may be broken by, relative to the terms of its sum: what the interior-point method leaves.
const BROKEN: f64 = 1e-8;
/// A row with less slack than this, on the same scale, is likely to bind in the next programme too.
const NEARLY: f64 = 1e-2;
/// Rounds after which all rows are taken.
const ROUNDS: usize = 12;

/// minimise cᵀx subject to rows that always count and curves of rows.
pub(super) struct Exchange {
    /// c.
    pub objective: Vec<f64>,
    /// Rows of every round, bounds of the variables for instance.
    pub always: Vec<Row>,
    /// The curves.
    pub curves: Vec<Vec<Row>>,
}

/// Rows of each curve, ascending.
pub(super) type Chosen = Vec<Vec<usize>>;

impl Exchange {
    /// The minimiser, and the rows that bind or nearly do; `likely` are those of a programme that differs little.
    ///
    /// # Errors
    /// As [`Programme::solve`], of all rows.
    pub(super) fn solve(&self, likely: &Chosen) -> Result<(Optimum, Chosen), ProgrammeError> {
        let every = |curve: &Vec<Row>| (0..curve.len()).collect::<Vec<usize>>();
        let all: Chosen = self.curves.iter().map(every).collect();
        let mut chosen = self.first(likely);
        for _ in 0..ROUNDS {
            // A part of the rows may bound nothing: then all of them decide.
            let Ok(end) = self.on(&chosen) else { break };
            let broken = self.broken(&end.x);
            if broken.iter().all(Vec::is_empty) {
                let next = self.nearly_binding(&chosen, &end.x);
                return Ok((end, next));
            }
            for (own, more) in chosen.iter_mut().zip(broken) {
                own.extend(more);
                own.sort_unstable();
                own.dedup();
            }
        }
        let end = self.on(&all)?;
        let next = self.nearly_binding(&all, &end.x);
        Ok((end, next))
    }

    /// The likely rows, and some of each curve at even distances.
    fn first(&self, likely: &Chosen) -> Chosen {
        let variables = self.objective.len();
        let first = |(k, curve): (usize, &Vec<Row>)| {
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
    fn broken(&self, x: &[f64]) -> Chosen {
        let of_curve = |curve: &Vec<Row>| {
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
        let of_curve = |(curve, own): (&Vec<Row>, &Vec<usize>)| {
            let near = own.iter().filter(|k| excess(&curve[**k], x) > -NEARLY);
            near.copied().collect()
        };
        self.curves.iter().zip(chosen).map(of_curve).collect()
    }
}

/// By how much aᵀx exceeds b, over the size of the terms.
fn excess(row: &Row, x: &[f64]) -> f64 {
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

    /// The best straight line under x² − e ≤ a + b x ≤ x² + e on [0, 1]: a = −1/8, b = 1, e = 1/8 (Chebyshev).
    #[test]
    fn the_best_line_is_that_of_all_rows() {
        let rows = |sign: f64| {
            let row = |k: i32| {
                let x = f64::from(k) / 1000.0;
                Row {
                    terms: vec![(0, sign), (1, sign * x), (2, -1.0)],
                    bound: sign * x * x,
                }
            };
            (0..=1000).map(row).collect::<Vec<Row>>()
        };
        let exchange = Exchange {
            objective: vec![0.0, 0.0, 1.0],
            always: vec![],
            curves: vec![rows(1.0), rows(-1.0)],
        };
        let (end, binding) = exchange.solve(&vec![]).expect("bounded");
        for (found, expected) in end.x.iter().zip([-0.125, 1.0, 0.125]) {
            assert!((found - expected).abs() < 1e-6, "{:?}", end.x);
        }
        // The line lies above the parabola in the middle, and below it at the ends.
        assert!(binding[0].contains(&500) && binding[1].contains(&0) && binding[1].contains(&1000));
        let again = exchange.solve(&binding).expect("bounded").0;
        assert!((again.x[2] - 0.125).abs() < 1e-7);
    }
}
