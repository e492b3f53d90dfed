//! Rational minimax fit of |d|² by linear programmes: differential correction (Cheney and Loeb) for the ratio error.
//!
//!   |d|² = N(x)/M(x), x = ω²,   minimise E with  N ≤ E m² M,  m² M ≤ E N  on the data,  N, M ≥ 0 everywhere
//!
//! A programme says whether a level E can be reached, and by how much; levels are aimed at between those that can and
//! those that cannot. Where rounding leaves that open, a programme on the present level follows, which always lowers
//! it. The problem is quasi-convex, so the level ends near the global optimum.
//!
//! Basis: 1 and 1/(1 + x/pⱼ) with pⱼ spread evenly in log frequency, which stays well conditioned over many decades
//! (powers of x, and Chebyshev polynomials in a bilinear variable, do not). Positivity between and beyond the data is
//! asked on a finer grid; the factors taken from the roots are positive by construction.

use super::exchange::{Chosen, Exchange};
use super::factors::{Factor, Factors, join_roots};
use super::magnitudes::Magnitudes;
use crate::linalg::svd::svd;
use crate::linalg::{Mat, c64, eigenvalues};
use crate::robust::conic::SparseRow;

/// N₀ and M₀ of the first programme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Units {
    Start,
    /// M₀ = 1, for a start with poles far from the data: its own M₀ spans so many decades that rounding decides.
    Flat,
}

/// Programmes at most: six are usual.
const PROGRAMMES: usize = 24;
/// Where between a level out of reach and one reached the next is sought, in the logarithm: one that is out of reach
/// costs no more than one that is not, and its N and M are better units too.
const AIM: f64 = 0.4;
/// A polish follows: levels that differ by this share are close.
const CLOSE: f64 = 0.1;
/// The same where no programme has lowered the level of the start yet.
const CLOSEST: f64 = 0.01;
/// A programme misses its level by more than this, relative to its rows, if it cannot be reached: a hundred times what
/// the interior-point method leaves.
const MISSED: f64 = 1e-6;
/// Rounds of least squares.
const LEAST_SQUARES: usize = 5;
/// Smallest M₀ relative to the largest: rows are divided by it, and the interior-point method leaves 1e-8.
const FLOOR: f64 = 1e-6;

/// Fit of a given order that starts from another one of this order; `None` when no programme improves on it.
pub(crate) fn fit(data: &Magnitudes, start: &Factors, units: Units) -> Option<Factors> {
    let problem = FitProgramme::new(data, start.order())?;
    let (n, m) = problem.values_of(data, start, units);
    let mut state = BestFractions::new(n, m, &problem.squared);
    for (a, b) in problem.least_squares(&state.m) {
        state.take(&problem, &a, &b);
    }
    let (mut below, mut share) = (0.0, AIM);
    let mut likely: Chosen = vec![];
    for _ in 0..PROGRAMMES {
        let gap = (state.above - below) / state.above;
        if gap <= CLOSE && (state.best.is_some() || gap <= CLOSEST) {
            break;
        }
        let aim = below + share * (state.above - below);
        let programme = problem.correction(&state, aim.exp(), share == 1.0);
        let Ok((end, next, settled)) = programme.solve(&likely) else {
            break;
        };
        likely = next;
        let (a, rest) = end.x.split_at(problem.size());
        let (b, rest) = rest.split_at(problem.size());
        let missed = end.is_accurate && rest[0] > MISSED;
        if missed {
            below = aim;
        }
        if state.take(&problem, a, b) {
            share = AIM;
        } else if !missed && settled {
            if share == 1.0 {
                break;
            }
            share = 1.0;
        }
    }
    let (a, b) = state.best?;
    problem.realise_factors(data, &a, &b)
}

/// The data on the basis.
struct FitProgramme {
    /// pⱼ.
    corners: Vec<f64>,
    /// Basis at the data.
    at_data: Vec<Vec<f64>>,
    /// Basis where positivity is asked.
    fine: Vec<Vec<f64>>,
    /// m².
    squared: Vec<f64>,
}

/// The best N and M so far.
struct BestFractions {
    /// Values on the data.
    n: Vec<f64>,
    m: Vec<f64>,
    /// ln E.
    above: f64,
    /// Coefficients, where they are not those of the start.
    best: Option<(Vec<f64>, Vec<f64>)>,
}

impl BestFractions {
    fn new(n: Vec<f64>, m: Vec<f64>, squared: &[f64]) -> Self {
        Self { above: ln_level(&n, &m, squared), n, m, best: None }
    }

    /// Takes coefficients of a lower level; false for others.
    fn take(&mut self, problem: &FitProgramme, a: &[f64], b: &[f64]) -> bool {
        let (n, m) = (values(&problem.at_data, a), values(&problem.at_data, b));
        let level = ln_level(&n, &m, &problem.squared);
        let lower = level < self.above;
        if lower {
            *self = Self { n, m, above: level, best: Some((a.to_vec(), b.to_vec())) };
        }
        lower
    }
}

impl FitProgramme {
    /// `None` without a positive frequency.
    fn new(data: &Magnitudes, order: usize) -> Option<Self> {
        let positive = |w: &&f64| **w > 0.0;
        let lo = data.omega_rad_s.iter().find(positive)?.ln();
        let hi = data.omega_rad_s.iter().rev().find(positive)?.ln();
        // Half a step inside the ends: every basis function bends within the data.
        let step = (hi - lo) / order as f64;
        let corners: Vec<f64> = (0..order).map(|k| (2.0 * (lo + (k as f64 + 0.5) * step)).exp()).collect();
        let basis = |omega: f64| -> Vec<f64> {
            let x = omega * omega;
            std::iter::once(1.0).chain(corners.iter().map(|p| 1.0 / (1.0 + x / p))).collect()
        };
        let fine = positivity_grid(lo, hi, 3 * data.omega_rad_s.len());
        Some(Self {
            at_data: data.omega_rad_s.iter().map(|w| basis(*w)).collect(),
            fine: fine.into_iter().map(basis).collect(),
            squared: data.magnitude.iter().map(|m| m * m).collect(),
            corners,
        })
    }

    /// Number of coefficients of N, and of M.
    fn size(&self) -> usize {
        self.corners.len() + 1
    }

    /// N and M of a fit on the data, over the denominator of the basis.
    fn values_of(&self, data: &Magnitudes, fit: &Factors, units: Units) -> (Vec<f64>, Vec<f64>) {
        let poles = Factors { ln_gain: 0.0, zeros: fit.poles.clone(), poles: vec![] };
        let basis = |w: f64| self.corners.iter().map(|p| (w * w / p).ln_1p()).sum::<f64>();
        let unit = |w: &f64| match units {
            Units::Flat => 1.0,
            Units::Start => (2.0 * poles.ln_magnitude(*w) - basis(*w)).exp(),
        };
        let m: Vec<f64> = data.omega_rad_s.iter().map(unit).collect();
        let floor = FLOOR * m.iter().copied().fold(0.0, f64::max);
        let m: Vec<f64> = m.into_iter().map(|m| m.max(floor)).collect();
        let pairs = data.omega_rad_s.iter().zip(&m);
        let n = pairs.map(|(w, m)| m * (2.0 * fit.ln_magnitude(*w)).exp());
        (n.collect(), m)
    }

    /// Coefficients of N and M by least squares, minimise Σ ((N − m²M)/(m²M₀))² with M₀ from the round before
    /// (Sanathanan and Koerner 1963): data of a rational function are met exactly. Neither need be positive.
    fn least_squares(&self, first: &[f64]) -> Vec<(Vec<f64>, Vec<f64>)> {
        let size = self.size();
        let mut before = first.to_vec();
        let mut found = vec![];
        for _ in 0..LEAST_SQUARES {
            let entry = |i: usize, j: usize| {
                if j < size {
                    self.at_data[i][j] / (self.squared[i] * before[i])
                } else {
                    -self.at_data[i][j - size] / before[i]
                }
            };
            let rows = self.squared.len();
            let Ok(parts) = svd(&Mat::from_fn(rows, 2 * size, entry)) else {
                break;
            };
            let last: Vec<f64> = (0..2 * size).map(|j| parts.v[(j, 2 * size - 1)]).collect();
            let sign = last[size..].iter().sum::<f64>().signum();
            let signed: Vec<f64> = last.iter().map(|v| sign * v).collect();
            let (a, b) = signed.split_at(size);
            before = values(&self.at_data, b).iter().map(|m| m.abs()).collect();
            found.push((a.to_vec(), b.to_vec()));
            if before.contains(&0.0) {
                break;
            }
        }
        found
    }

    /// minimise t: N − E m²M ≤ t m²M₀ and m²M − E N ≤ t N₀ on the data, with M of the size of M₀ in the mean. On the
    /// `present` level t is not above zero, and coefficients of M between −1 and 1 allow it to fall further.
    fn correction(&self, now: &BestFractions, level: f64, present: bool) -> Exchange {
        let size = self.size();
        let t = 2 * size;
        let row = |phi: &[f64], fn_: f64, fm: f64, ft: f64| -> SparseRow {
            let numerator = phi.iter().enumerate().map(|(j, p)| (j, fn_ * p));
            let denominator = phi.iter().enumerate().map(|(j, p)| (size + j, fm * p));
            let mut terms: Vec<(usize, f64)> = numerator.chain(denominator).collect();
            terms.retain(|(_, v)| *v != 0.0);
            if ft != 0.0 {
                terms.push((t, ft));
            }
            SparseRow { terms, bound: 0.0 }
        };
        let [mut above, mut below, mut of_n, mut of_m] = [const { vec![] }; 4];
        let present_values = now.n.iter().zip(&now.m);
        for ((phi, s), (n, m)) in self.at_data.iter().zip(&self.squared).zip(present_values) {
            // Rows are divided by the present denominators, so that t means the same everywhere.
            above.push(row(phi, 1.0 / (s * m), -level / m, -1.0));
            below.push(row(phi, -level / n, s / n, -1.0));
        }
        for phi in &self.fine {
            of_n.push(row(phi, -1.0, 0.0, 0.0));
            of_m.push(row(phi, 0.0, -1.0, 0.0));
        }
        let mut objective = vec![0.0; t + 1];
        objective[t] = 1.0;
        Exchange {
            objective,
            always: if present {
                (0..size).flat_map(|j| bound_between(&[(size + j, 1.0)], -1.0)).collect()
            } else {
                bound_between(&self.mean(&now.m), 0.5).into()
            },
            curves: vec![above, below, of_n, of_m],
        }
    }

    /// The mean of M/M₀ over the data as terms of M.
    fn mean(&self, m0: &[f64]) -> Vec<(usize, f64)> {
        let size = self.size();
        let count = self.at_data.len() as f64;
        let of = |j: usize| {
            let shares = self.at_data.iter().zip(m0).map(|(phi, m)| phi[j] / m);
            (size + j, shares.sum::<f64>() / count)
        };
        (0..size).map(of).collect()
    }

    /// Poles and zeros of N/M with the gain that centres the log error.
    fn realise_factors(&self, data: &Magnitudes, a: &[f64], b: &[f64]) -> Option<Factors> {
        let mut found = Factors { ln_gain: 0.0, zeros: factors(a, &self.corners)?, poles: factors(b, &self.corners)? };
        let errors = data.omega_rad_s.iter().zip(&data.magnitude);
        let (low, high) = errors
            .map(|(w, m)| found.ln_magnitude(*w) - m.ln())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(e), h.max(e)));
        found.ln_gain = -0.5 * (low + high);
        found.ln_gain.is_finite().then_some(found)
    }
}

/// `least` ≤ aᵀx ≤ 1.
fn bound_between(terms: &[(usize, f64)], least: f64) -> [SparseRow; 2] {
    [(1.0, 1.0), (-1.0, -least)]
        .map(|(sign, bound)| SparseRow { terms: terms.iter().map(|(k, v)| (*k, sign * v)).collect(), bound })
}

/// Values of a function on the data.
fn values(at_data: &[Vec<f64>], coefficients: &[f64]) -> Vec<f64> {
    let value = |row: &Vec<f64>| row.iter().zip(coefficients).map(|(r, c)| r * c).sum();
    at_data.iter().map(value).collect()
}

/// Largest |ln(N/(m²M))|, infinite where one of them is not positive.
fn ln_level(n: &[f64], m: &[f64], squared: &[f64]) -> f64 {
    let ratios = n.iter().zip(m).zip(squared);
    ratios
        .map(|((n, m), s)| if *n > 0.0 && *m > 0.0 { (n / (m * s)).ln().abs() } else { f64::INFINITY })
        .fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
}

/// Zero, points between and three decades beyond the data.
fn positivity_grid(lo: f64, hi: f64, points: usize) -> Vec<f64> {
    let (lo, hi) = (lo - 7.0, hi + 7.0);
    let step = (hi - lo) / points as f64;
    let inner = (0..=points).map(|k| (lo + k as f64 * step).exp());
    std::iter::once(0.0).chain(inner).collect()
}

/// Stable factors of a positive a₀ + Σ aⱼ/(1 + x/pⱼ) over its own denominator, from its roots in x.
fn factors(a: &[f64], corners: &[f64]) -> Option<Vec<Factor>> {
    let k = corners.len();
    let largest = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    // A vanishing value at infinity is a root far beyond the data.
    let direct = if a[0].abs() > 1e-10 * largest { a[0] } else { 1e-10 * largest };
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
            list.push(Factor { ln_omega: 0.5 * r.norm().ln(), ln_damping: Some(0.5 * damping2.ln()) });
        }
    }
    reals.sort_by(f64::total_cmp);
    for pair in reals.chunks(2) {
        list.push(match pair {
            [a, b] => join_roots(*a, *b),
            [a] => Factor { ln_omega: *a, ln_damping: None },
            _ => return None,
        });
    }
    list.sort_by(|a, b| {
        let kind = b.degree().cmp(&a.degree());
        kind.then(a.ln_omega.total_cmp(&b.ln_omega))
    });
    Some(list)
}
