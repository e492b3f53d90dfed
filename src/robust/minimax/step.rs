//! One step of the prox-linear method for a largest value under limits (Fletcher 1982; Drusvyatskiy and Paquette 2019):
//!
//!   minimise over p, t, s ≥ 0:   t + ρ Σ_g s_g + (λ/2)|p|²,   v_k + g_kᵀp ≤ t (objective),   v_k + g_kᵀp ≤ s_g
//!   (limits).
//!
//! A convex quadratic programme, solved in its dual form.

use super::active_set::weights;
pub use super::active_set::{LinearValue, StepRule};
use super::curvature::Curvature;
use crate::linalg::Mat;
use crate::linalg::dense::dot;
use crate::linalg::symmetric::DefiniteFactor;
use crate::robust::conic::{ProgrammeError, QuadraticProgramme, SparseRow};

/// A step with what the linear model promises.
#[derive(Clone, Debug)]
pub struct MinimaxStep {
    /// p.
    pub step: Vec<f64>,
    /// t + ρ Σ s at the step, without the proximal term.
    pub predicted: f64,
    /// Numbers and weights y of the values that bind: p = −Σ y g/λ.
    pub binding: Vec<(usize, f64)>,
}

/// A value with a smaller weight does not bind.
const BINDS: f64 = 1e-6;

/// The step for `values`; those of the numbers `likely` are expected to bind.
///
/// Few of the values bind at a step, and an active-set method finds them; where it does not come to its end, an
/// interior-point one stands in.
///
/// # Errors
/// [`ProgrammeError`] when the interior-point iteration breaks down.
pub fn minimax_step(values: &[LinearValue], likely: &[usize], rule: &StepRule) -> Result<MinimaxStep, ProgrammeError> {
    let weights = match weights(values, likely, rule) {
        Some(weights) => weights,
        None => by_interior_point(values, rule)?,
    };
    let n = values.first().map_or(0, |v| v.gradient.len());
    let mut step = vec![0.0; n];
    for (v, weight) in values.iter().zip(&weights) {
        if *weight != 0.0 {
            for (p, g) in step.iter_mut().zip(&v.gradient) {
                *p -= weight * g / rule.proximal;
            }
        }
    }
    let reached = levels(values, rule.limits, |v| v.value + dot(&v.gradient, &step));
    let objective = Some(reached[0]).filter(|level| level.is_finite());
    let over: f64 = reached[1..].iter().sum();
    let binding = weights.into_iter().enumerate();
    Ok(MinimaxStep {
        predicted: objective.unwrap_or(0.0) + rule.penalty * over,
        step,
        binding: binding.filter(|(_, weight)| *weight > BINDS).collect(),
    })
}

/// A step δx with ½ δxᵀ(λM + B)δx in the place of the proximal term, M a metric of the parameters, B a curvature and λ
/// the proximal weight.
pub(crate) struct CurvedProgramme {
    /// L of λM + B = L Lᵀ: |p|² = δxᵀ(λM + B)δx of p = Lᵀδx.
    factor: DefiniteFactor,
    /// The values with their gradients by p.
    values: Vec<LinearValue>,
    rule: StepRule,
}

impl CurvedProgramme {
    /// The programme of some values; `None` where λM + B is not positive definite.
    pub(crate) fn new(
        values: &[LinearValue],
        metric: &Mat<f64>,
        curvature: &Curvature,
        rule: &StepRule,
    ) -> Option<Self> {
        let n = metric.nrows();
        let factor = DefiniteFactor::new(&curvature.beside(metric, rule.proximal))?;
        let slopes = Mat::from_fn(n, values.len(), |i, k| values[k].gradient[i]);
        let turned = factor.solve_lower(slopes);
        let turned = values.iter().enumerate().map(|(k, v)| LinearValue {
            limit: v.limit,
            value: v.value,
            gradient: (0..n).map(|i| turned[(i, k)]).collect(),
        });
        Some(Self { values: turned.collect(), rule: StepRule { proximal: 1.0, ..*rule }, factor })
    }

    /// With other values, whose gradients are the same.
    pub(crate) fn revalue(&mut self, values: impl Iterator<Item = f64>) {
        for (own, value) in self.values.iter_mut().zip(values) {
            own.value = value;
        }
    }

    /// The step; the values of the numbers `likely` are expected to bind. `None` where the programme fails.
    pub(crate) fn step(&self, likely: &[usize]) -> Option<MinimaxStep> {
        let found = minimax_step(&self.values, likely, &self.rule).ok()?;
        let n = found.step.len();
        let step = self.factor.solve_upper(Mat::from_fn(n, 1, |i, _| found.step[i]));
        Some(MinimaxStep { step: (0..n).map(|i| step[(i, 0)]).collect(), ..found })
    }
}

/// The step of a [`CurvedProgramme`]; `None` where λM + B is not positive definite or the programme fails.
pub(crate) fn curved_step(
    values: &[LinearValue],
    likely: &[usize],
    shape: (&Mat<f64>, &Curvature),
    rule: &StepRule,
) -> Option<MinimaxStep> {
    CurvedProgramme::new(values, shape.0, shape.1, rule)?.step(likely)
}

/// 0 for the objective, 1 + g for limit g.
fn group(value: &LinearValue) -> usize {
    value.limit.map_or(0, |g| 1 + g)
}

/// Largest value of each group; limits count from zero.
fn levels<'a>(
    values: impl IntoIterator<Item = &'a LinearValue>,
    limits: usize,
    of: impl Fn(&LinearValue) -> f64,
) -> Vec<f64> {
    let mut found = vec![0.0; 1 + limits];
    found[0] = f64::NEG_INFINITY;
    for value in values {
        let level = &mut found[group(value)];
        *level = level.max(of(value));
    }
    found
}

/// The weights of the values by clarabel.
///
/// The dual has one variable per value, the weight y_k ≥ 0 of its slope in the step p = −Σ y_k g_k/λ:
///   minimise |Σ y_k g_k|²/2λ − Σ v_k y_k,   Σ y = 1 over the objective,   Σ y ≤ ρ over each limit.
/// Its matrix is as small as the number of values, the primal one has as many rows and all coordinates besides.
fn by_interior_point(values: &[LinearValue], rule: &StepRule) -> Result<Vec<f64>, ProgrammeError> {
    let m = values.len();
    let sum_over = |limit: Option<usize>, bound: f64| SparseRow {
        terms: (0..m).filter(|k| values[*k].limit == limit).map(|k| (k, 1.0)).collect(),
        bound,
    };
    let kept = |row: &SparseRow| !row.terms.is_empty();
    let not_negative = (0..m).map(|k| SparseRow { terms: vec![(k, -1.0)], bound: 0.0 });
    let groups = (0..rule.limits).map(|g| sum_over(Some(g), rule.penalty));
    let programme = QuadraticProgramme {
        quadratic: Mat::from_fn(m, m, |i, j| {
            if i <= j { dot(&values[i].gradient, &values[j].gradient) / rule.proximal } else { 0.0 }
        }),
        objective: values.iter().map(|v| -v.value).collect(),
        // Without an objective the level is free and costs nothing.
        equalities: Some(sum_over(None, 1.0)).into_iter().filter(kept).collect(),
        inequalities: groups.filter(kept).chain(not_negative).collect(),
    };
    programme.solve()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(value: f64, gradient: [f64; 2]) -> LinearValue {
        LinearValue { limit: None, value, gradient: gradient.to_vec() }
    }

    #[test]
    fn one_value_is_lowered_along_the_inverse_of_metric_and_curvature() {
        let metric = Mat::from_fn(2, 2, |i, j| [[2.0, 0.5], [0.5, 1.0]][i][j]);
        let curvature = Curvature::of(Mat::from_fn(2, 2, |i, j| [[1.0, -0.2], [-0.2, 3.0]][i][j]));
        let rule = StepRule { limits: 0, penalty: 0.0, proximal: 0.5 };
        let shape = (&metric, &curvature);
        let found = curved_step(&[value(1.0, [1.0, -2.0])], &[], shape, &rule);
        let found = found.expect("the matrix is positive definite").step;
        // λM + B = [[2, 0.05], [0.05, 3.5]].
        let determinant = 2.0 * 3.5 - 0.05 * 0.05;
        let exact = [-(3.5 + 0.05 * 2.0) / determinant, (2.0 * 2.0 + 0.05) / determinant];
        for (found, exact) in found.iter().zip(exact) {
            assert!((found - exact).abs() < 1e-10, "{found} and {exact}");
        }
    }

    #[test]
    fn a_programme_with_other_values_is_that_of_those_values() {
        let (metric, curvature) = (Mat::identity(2, 2), Curvature::default());
        let rule = StepRule { limits: 0, penalty: 0.0, proximal: 1.0 };
        let list = |a: f64, b: f64| [value(a, [1.0, 0.3]), value(b, [-1.0, 0.2])];
        let shape = (&metric, &curvature);
        let programme = CurvedProgramme::new(&list(0.0, 0.1), shape.0, shape.1, &rule);
        let mut programme = programme.expect("the metric is positive definite");
        programme.revalue([0.4, 0.2].into_iter());
        let found = programme.step(&[]).expect("the programme has an answer");
        let exact = curved_step(&list(0.4, 0.2), &[], shape, &rule);
        let exact = exact.expect("the programme has an answer");
        for (found, exact) in found.step.iter().zip(&exact.step) {
            assert!((found - exact).abs() < 1e-12, "{found} and {exact}");
        }
        assert!((found.predicted - exact.predicted).abs() < 1e-12);
    }
}
