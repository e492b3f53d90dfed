//! The D step of D-K for scales of fixed order: the parameters of D(s) that minimise the peak of σ_max(D N D⁻¹) on a grid.
//!
//! Sequential linear programmes in a trust region on ln σ with its derivative
//!   ∂ ln σ / ∂ ln|dᵢ| = Σ_{k∈zᵢ} |u_k|² − Σ_{k∈wᵢ} |v_k|²,
//! u, v singular vectors of the scaled matrix. Fitting magnitudes point by point first and judging the fit afterwards loses
//! what this keeps: the peak of the fitted scale itself goes down, so the next γ cannot be above the present one.

use super::dfit_factors::Factors;
use super::dk_scale::{DScales, scaled_matrix};
use super::lmi::{Programme, Row};
use super::structure::Structure;
use crate::linalg::hermitian::singular_vectors;
use crate::linalg::{Mat, c64};
use rayon::prelude::*;

/// Responses of the closed loop on a grid.
#[derive(Clone, Debug)]
pub struct LoopGrid {
    /// Frequencies, rad/s.
    pub omega_rad_s: Vec<f64>,
    /// N(jω).
    pub response: Vec<Mat<c64>>,
    /// Range of ln of the corner frequencies of D.
    pub corner_limits: (f64, f64),
    /// Smallest ln ζ of a factor of D.
    pub least_ln_damping: f64,
}

/// ln σ of the largest singular values at one frequency with derivatives by ln|dᵢ|.
type Slopes = Vec<(f64, Vec<f64>)>;

/// Peak of σ_max(D N D⁻¹) on the grid; infinite when it cannot be computed.
pub fn peak(grid: &LoopGrid, structure: &Structure, scales: &DScales) -> f64 {
    let values: Vec<f64> = grid
        .omega_rad_s
        .par_iter()
        .zip(&grid.response)
        .map(|(w, m)| {
            let scaled = scaled_matrix(m, structure, &scales.magnitudes(*w));
            crate::linalg::max_singular_value_complex(&scaled)
        })
        .collect();
    values
        .into_iter()
        .fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
}

/// Lowers the peak for at most `rounds` programmes; never returns worse scales.
pub fn flatten(
    grid: &LoopGrid,
    structure: &Structure,
    start: DScales,
    rounds: usize,
) -> (DScales, f64) {
    let mut best = start;
    let mut level = peak(grid, structure, &best);
    let mut radius: f64 = 0.3;
    for _ in 0..rounds {
        if radius < 1e-4 || !level.is_finite() || level <= 0.0 {
            break;
        }
        let Some((trial, predicted)) = step(grid, structure, &best, level, radius) else {
            break;
        };
        let next = peak(grid, structure, &trial);
        let gain = (level - next) / (level - predicted).max(1e-300);
        if next < level {
            let settled = level - next < 1e-6 * level;
            (best, level) = (trial, next);
            if settled {
                break;
            }
        }
        if gain > 0.7 {
            radius = (2.0 * radius).min(1.5);
        } else if gain < 0.25 {
            radius *= 0.35;
        }
    }
    (best, level)
}

/// One trust-region step and the peak that its model predicts.
fn step(
    grid: &LoopGrid,
    structure: &Structure,
    scales: &DScales,
    level: f64,
    radius: f64,
) -> Option<(DScales, f64)> {
    let last = scales.factors.len().checked_sub(1)?;
    let counts: Vec<usize> = scales.factors[..last]
        .iter()
        .map(|f| f.parameters().len())
        .collect();
    let total: usize = counts.iter().sum();
    // A step changes ln σ by a few radii at most: values far below the peak cannot become active.
    let floor = level.ln() - 4.0 * radius - 0.1;
    let rows: Vec<Vec<Row>> = grid
        .omega_rad_s
        .par_iter()
        .zip(&grid.response)
        .map(|(w, m)| {
            let Some(slopes) = slopes(m, structure, &scales.magnitudes(*w)) else {
                return vec![];
            };
            slopes
                .into_iter()
                .filter(|(value, _)| *value > floor)
                .map(|(value, slope)| Row {
                    terms: model_terms(scales, last, *w, &slope, radius, total),
                    bound: level.ln() - value,
                })
                .collect()
        })
        .collect();
    let mut inequalities: Vec<Row> = rows.into_iter().flatten().collect();
    for k in 0..total {
        for sign in [1.0, -1.0] {
            inequalities.push(Row {
                terms: vec![(k, sign)],
                bound: 1.0,
            });
        }
    }
    let mut objective = vec![0.0; total + 1];
    objective[total] = 1.0;
    let programme = Programme {
        objective,
        inequalities,
        ..Programme::default()
    };
    let end = programme.solve().ok()?;
    // The variable is ln(peak/level).
    let predicted = level * end.x[total].exp();
    if predicted >= level * (1.0 - 1e-9) {
        return None;
    }
    let mut next = scales.clone();
    let mut first = 0;
    for (factors, count) in next.factors[..last].iter_mut().zip(&counts) {
        let values: Vec<f64> = factors
            .parameters()
            .iter()
            .zip(&end.x[first..first + count])
            .map(|(p, s)| p + radius * s)
            .collect();
        *factors = factors.with_parameters(&values, grid.corner_limits, grid.least_ln_damping);
        first += count;
    }
    Some((next, predicted))
}

fn model_terms(
    scales: &DScales,
    last: usize,
    omega: f64,
    slope: &[f64],
    radius: f64,
    total: usize,
) -> Vec<(usize, f64)> {
    let mut terms = vec![(total, -1.0)];
    let mut first = 0;
    for (factors, s) in scales.factors[..last].iter().zip(slope) {
        let gradient = gradient(factors, omega);
        terms.extend(
            gradient
                .iter()
                .enumerate()
                .map(|(k, g)| (first + k, g * s * radius)),
        );
        first += gradient.len();
    }
    terms
}

fn gradient(factors: &Factors, omega: f64) -> Vec<f64> {
    factors.ln_magnitude_with_gradient(omega.min(1e60)).1
}

/// The two largest singular values: the second becomes the first where they cross.
fn slopes(m: &Mat<c64>, structure: &Structure, d: &[f64]) -> Option<Slopes> {
    let (u, s, v) = singular_vectors(&scaled_matrix(m, structure, d)).ok()?;
    let one = |k: usize| {
        let part = |m: &Mat<c64>, r: std::ops::Range<usize>| -> f64 {
            r.map(|i| m[(i, k)].norm_sqr()).sum()
        };
        let spans = structure.spans.iter();
        let slope = spans.map(|p| part(&u, p.z.clone()) - part(&v, p.w.clone()));
        (s[k].max(1e-300).ln(), slope.collect())
    };
    Some((0..s.len().min(2)).map(one).collect())
}
