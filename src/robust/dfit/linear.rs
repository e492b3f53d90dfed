//! Rational minimax fit of |d|² by linear programmes: the differential correction of Cheney and Loeb for the ratio
//! error.
//!
//!   |d|² = N(x)/M(x), x = ω²,   minimise E with  N ≤ E m² M,  m² M ≤ E N  on the data,  N, M ≥ 0 everywhere
//!
//! The problem is quasi-convex: each programme lowers E from the present N, M, and the limit is the global optimum.
//! Basis: 1 and 1/(1 + x/pⱼ) with pⱼ spread evenly in log frequency, which stays well conditioned over many decades
//! (powers of x, and Chebyshev polynomials in a bilinear variable, do not). Positivity between and beyond the data is
//! asked on a finer grid; the factors taken from the roots are positive by construction.

use super::exchange::{Chosen, Exchange};
use super::factors::{Factor, Factors, joined};
use super::magnitudes::Magnitudes;
use crate::linalg::{Mat, c64, eigenvalues};
use crate::robust::mu::lmi::Row;

/// Programmes at most; the convergence is superlinear.
const MAX_ROUNDS: usize = 12;

/// Fit of a given order that starts from the values of another fit; `None` when a programme breaks down at once.
pub(crate) fn fit(data: &Magnitudes, order: usize, start: &Factors) -> Option<Factors> {
    let positive = |w: &&f64| **w > 0.0;
    let lo = data.omega_rad_s.iter().find(positive)?.ln();
    let hi = data.omega_rad_s.iter().rev().find(positive)?.ln();
    // Half a step inside the ends: every basis function bends within the data.
    let step = (hi - lo) / order as f64;
    let corners: Vec<f64> = (0..order)
        .map(|k| (2.0 * (lo + (k as f64 + 0.5) * step)).exp())
        .collect();
    let basis = |omega: f64| -> Vec<f64> {
        let x = omega * omega;
        std::iter::once(1.0)
            .chain(corners.iter().map(|p| 1.0 / (1.0 + x / p)))
            .collect()
    };
    let at_data: Vec<Vec<f64>> = data.omega_rad_s.iter().map(|w| basis(*w)).collect();
    let squared: Vec<f64> = data.magnitude.iter().map(|m| m * m).collect();
    let fine: Vec<Vec<f64>> = positivity_grid(lo, hi, 3 * data.omega_rad_s.len())
        .into_iter()
        .map(basis)
        .collect();
    // The start as values of N with M = 1; only ratios enter.
    let mut n: Vec<f64> = data
        .omega_rad_s
        .iter()
        .map(|w| (2.0 * start.ln_magnitude(*w)).exp())
        .collect();
    let mut m = vec![1.0; n.len()];
    let worst = |n: &[f64], m: &[f64]| {
        let ratios = n.iter().zip(m).zip(&squared);
        ratios
            .map(|((n, m), s)| {
                let r = n / (m * s);
                if *n > 0.0 && *m > 0.0 {
                    r.max(1.0 / r)
                } else {
                    f64::INFINITY
                }
            })
            .fold(1.0, f64::max)
    };
    let mut level = worst(&n, &m);
    let mut best = None;
    let mut binding: Chosen = vec![];
    for _ in 0..MAX_ROUNDS {
        let programme = correction(&at_data, &fine, &squared, (&n, &m), level, order);
        let Ok((end, next_binding)) = programme.solve(&binding) else {
            break;
        };
        binding = next_binding;
        let (a, b) = end.x[..2 * order + 2].split_at(order + 1);
        let value = |c: &[f64]| -> Vec<f64> {
            at_data
                .iter()
                .map(|row| row.iter().zip(c).map(|(r, c)| r * c).sum())
                .collect()
        };
        let (next_n, next_m) = (value(a), value(b));
        let next = worst(&next_n, &next_m);
        if next.is_nan() || next >= level {
            break;
        }
        let settled = level - next < 1e-5 * (level - 1.0);
        best = Some((a.to_vec(), b.to_vec()));
        (n, m, level) = (next_n, next_m, next);
        if settled {
            break;
        }
    }
    let (a, b) = best?;
    let mut found = Factors {
        ln_gain: 0.0,
        zeros: factors(&a, &corners)?,
        poles: factors(&b, &corners)?,
    };
    // The gain that centres the log error.
    let errors = data.omega_rad_s.iter().zip(&data.magnitude);
    let (low, high) = errors
        .map(|(w, m)| found.ln_magnitude(*w) - m.ln())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| {
            (l.min(e), h.max(e))
        });
    found.ln_gain = -0.5 * (low + high);
    found.ln_gain.is_finite().then_some(found)
}

/// Zero, points between and three decades beyond the data.
fn positivity_grid(lo: f64, hi: f64, points: usize) -> Vec<f64> {
    let (lo, hi) = (lo - 7.0, hi + 7.0);
    let step = (hi - lo) / points as f64;
    let inner = (0..=points).map(|k| (lo + k as f64 * step).exp());
    std::iter::once(0.0).chain(inner).collect()
}

/// minimise t: N − E m²M ≤ t m²M₀ and m²M − E N ≤ t N₀ on the data; |coefficients of M| ≤ 1.
fn correction(
    at_data: &[Vec<f64>],
    fine: &[Vec<f64>],
    squared: &[f64],
    (n0, m0): (&[f64], &[f64]),
    level: f64,
    order: usize,
) -> Exchange {
    let size = order + 1;
    let t = 2 * size;
    let row = |phi: &[f64], fn_: f64, fm: f64, ft: f64| -> Row {
        let numerator = phi.iter().enumerate().map(|(j, p)| (j, fn_ * p));
        let denominator = phi.iter().enumerate().map(|(j, p)| (size + j, fm * p));
        let mut terms: Vec<(usize, f64)> = numerator.chain(denominator).collect();
        terms.retain(|(_, v)| *v != 0.0);
        if ft != 0.0 {
            terms.push((t, ft));
        }
        Row { terms, bound: 0.0 }
    };
    let [mut above, mut below, mut of_n, mut of_m] = [const { vec![] }; 4];
    for (((phi, s), n), m) in at_data.iter().zip(squared).zip(n0).zip(m0) {
        // Rows are divided by the present denominators, so that t means the same everywhere.
        above.push(row(phi, 1.0 / (s * m), -level / m, -1.0));
        below.push(row(phi, -level / n, s / n, -1.0));
    }
    for phi in fine {
        of_n.push(row(phi, -1.0, 0.0, 0.0));
        of_m.push(row(phi, 0.0, -1.0, 0.0));
    }
    let mut always = vec![];
    for j in 0..size {
        for sign in [1.0, -1.0] {
            always.push(Row {
                terms: vec![(size + j, sign)],
                bound: 1.0,
            });
        }
    }
    let mut objective = vec![0.0; t + 1];
    objective[t] = 1.0;
    Exchange {
        objective,
        always,
        curves: vec![above, below, of_n, of_m],
    }
}

/// Stable factors of a positive a₀ + Σ aⱼ/(1 + x/pⱼ) over its own denominator, from its roots in x.
fn factors(a: &[f64], corners: &[f64]) -> Option<Vec<Factor>> {
    let k = corners.len();
    let largest = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    // A vanishing value at infinity is a root far beyond the data.
    let direct = if a[0].abs() > 1e-10 * largest {
        a[0]
    } else {
        1e-10 * largest
    };
    let companion = Mat::from_fn(k, k, |i, j| {
        let own = if i == j { -corners[i] } else { 0.0 };
        own - a[j + 1] * corners[j] / direct
    });
    let roots: Vec<c64> = eigenvalues(&companion).ok()?;
    let (mut reals, mut list) = (vec![], vec![]);
    for r in roots {
        if r.im == 0.0 {
            // A positive root is a touch of zero that rounding has split: mirrored.
            reals.push(0.5 * r.re.abs().max(1e-300).ln());
        } else if r.im > 0.0 {
            let damping2 = (0.5 * (1.0 - r.re / r.norm())).max(1e-8);
            list.push(Factor {
                ln_omega: 0.5 * r.norm().ln(),
                ln_damping: Some(0.5 * damping2.ln()),
            });
        }
    }
    reals.sort_by(f64::total_cmp);
    for pair in reals.chunks(2) {
        list.push(match pair {
            [a, b] => joined(*a, *b),
            [a] => Factor {
                ln_omega: *a,
                ln_damping: None,
            },
            _ => return None,
        });
    }
    list.sort_by(|a, b| {
        let kind = b.degree().cmp(&a.degree());
        kind.then(a.ln_omega.total_cmp(&b.ln_omega))
    });
    Some(list)
}
