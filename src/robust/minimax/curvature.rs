//! Curvature of the Lagrangian of a descent, learnt from its steps: damped BFGS updates (Powell 1978) of a matrix that
//! stays positive semidefinite.
//!
//! Few values bind at a step, so that along most directions only curvature says how far it may go. With the weights w
//! of the values that bind at a step s, the slope of the Lagrangian Σ w v changes by y = Σ w (∇v(x + s) − ∇v(x)), and
//! the matrix learns B s = y.

use crate::linalg::Mat;
use crate::linalg::dense::dot;

/// B, parameters × parameters; none before the first step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Curvature(Option<Mat<f64>>);

/// Share of the curvature along a step that an update leaves at least (Powell 1978).
const DAMPED: f64 = 0.2;

impl Curvature {
    /// A known positive semidefinite B.
    pub(crate) fn of(b: Mat<f64>) -> Self {
        Self(Some(b))
    }

    /// B + λM for a metric M.
    pub(crate) fn beside(&self, metric: &Mat<f64>, weight: f64) -> Mat<f64> {
        Mat::from_fn(metric.nrows(), metric.ncols(), |i, j| {
            let own = self.0.as_ref().map_or(0.0, |b| b[(i, j)]);
            own + weight * metric[(i, j)]
        })
    }

    /// ½ sᵀBs.
    pub(crate) fn half_along(&self, step: &[f64]) -> f64 {
        self.0.as_ref().map_or(0.0, |b| 0.5 * dot(step, &times(b, step)))
    }

    /// Learns that the slope changes by `change` along the step. The first step sets the scale: B is the metric times
    /// the curvature along it.
    pub(crate) fn learn(&mut self, step: &[f64], change: &[f64], metric: impl FnOnce() -> Mat<f64>) {
        let along = dot(step, change);
        if self.0.is_none() && along > 0.0 {
            let metric = metric();
            let length = dot(step, &times(&metric, step));
            if length > 0.0 {
                let n = step.len();
                self.0 = Some(Mat::from_fn(n, n, |i, j| metric[(i, j)] * along / length));
            }
        }
        let Some(b) = &mut self.0 else { return };
        let image = times(b, step);
        let own = dot(step, &image);
        if !(own > 0.0 && along.is_finite()) {
            return;
        }
        let share = if along < DAMPED * own { (1.0 - DAMPED) * own / (own - along) } else { 1.0 };
        let pairs = change.iter().zip(&image);
        let change: Vec<f64> = pairs.map(|(y, b)| share * y + (1.0 - share) * b).collect();
        let along = dot(step, &change);
        let n = step.len();
        let learnt = Mat::from_fn(n, n, |i, j| b[(i, j)] + change[i] * change[j] / along - image[i] * image[j] / own);
        if learnt.is_all_finite() {
            *b = learnt;
        }
    }
}

fn times(b: &Mat<f64>, step: &[f64]) -> Vec<f64> {
    (0..step.len()).map(|i| (0..step.len()).map(|j| b[(i, j)] * step[j]).sum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A positive definite matrix of order four.
    fn hessian() -> Mat<f64> {
        let root = Mat::from_fn(4, 4, |i, j| 1.0 / (1.0 + i as f64 + 2.0 * j as f64));
        let product = &root * root.transpose();
        Mat::from_fn(4, 4, |i, j| product[(i, j)] + if i == j { 0.3 } else { 0.0 })
    }

    fn unit() -> Mat<f64> {
        Mat::identity(4, 4)
    }

    #[test]
    fn conjugate_steps_on_a_quadratic_teach_its_hessian() {
        let h = hessian();
        let mut learnt = Curvature::default();
        let mut steps: Vec<Vec<f64>> = vec![];
        for k in 0..4 {
            // The unit vectors made conjugate to the steps before (Gram and Schmidt in the metric H).
            let mut step: Vec<f64> = (0..4).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
            for before in &steps {
                let image = times(&h, before);
                let share = dot(&step, &image) / dot(before, &image);
                for (s, b) in step.iter_mut().zip(before) {
                    *s -= share * b;
                }
            }
            learnt.learn(&step, &times(&h, &step), unit);
            steps.push(step);
        }
        let found = learnt.beside(&unit(), 0.0);
        assert!((found - &h).norm_max() < 1e-12);
        let half = 0.5 * dot(&steps[2], &times(&h, &steps[2]));
        assert!((learnt.half_along(&steps[2]) - half).abs() < 1e-12);
    }

    #[test]
    fn what_curves_down_leaves_the_matrix_positive() {
        let mut learnt = Curvature::default();
        // Nothing is known before a step with curvature.
        learnt.learn(&[1.0, 0.0, 0.0, 0.0], &[-1.0, 0.0, 0.0, 0.0], unit);
        assert_eq!(learnt.half_along(&[1.0, 2.0, 3.0, 4.0]), 0.0);
        learnt.learn(&[1.0, 0.0, 0.0, 0.0], &[2.0, 0.1, 0.0, 0.0], unit);
        assert!((learnt.half_along(&[1.0, 0.0, 0.0, 0.0]) - 1.0).abs() < 1e-12);
        for k in 0..20 {
            let step = [(k as f64).sin(), 1.0, -0.3, (k as f64).cos()];
            let before = learnt.half_along(&step);
            learnt.learn(&step, &step.map(|s| -5.0 * s), unit);
            let after = learnt.half_along(&step);
            assert!(after > 0.0 && (after / before - DAMPED).abs() < 1e-9);
        }
        let values = crate::linalg::symmetric_eigen(&learnt.beside(&unit(), 0.0));
        let least = values.map_or(f64::NAN, |(values, _)| values[0]);
        assert!(least > 0.0, "{least}");
    }
}
