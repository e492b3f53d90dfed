//! Normal form of the H∞ problem: D12 = [0; I], D21 = [0, I], D22 = 0, balanced states (Safonov, Limebeer and Chiang
//! 1989). z and w are rotated, so norms stay; u = T_u ũ and ỹ = T_y y; D22 is taken out by loop shifting.

use super::matrix_slope::MatrixSlope;
use crate::augment::GeneralizedPlant;
use crate::linalg::{Mat, NumericError, solve, svd};
use crate::lti::connect::{block2, stack_cols, stack_rows};
use crate::lti::scale::balancing;
use crate::lti::{Continuous, StateSpace};
use crate::robust::error::SynthesisError;

/// Ratio of singular values of D12 (D21) below which a control (measurement) counts as free: the normal form divides
/// by it, and beyond 1e-11 nothing of the data is left after the division.
const RANK: f64 = 1e-11;

/// The problem as the Riccati equations want it.
#[derive(Clone, Debug)]
pub(crate) struct NormalForm {
    /// n×n.
    pub a: Mat<f64>,
    /// n×m1, disturbances rotated so that D21 = [0, I].
    pub b1: Mat<f64>,
    /// n×m2.
    pub b2: Mat<f64>,
    /// p1×n, errors rotated so that D12 = [0; I].
    pub c1: Mat<f64>,
    /// p2×n.
    pub c2: Mat<f64>,
    /// p1×m1.
    pub d11: Mat<f64>,
    control: Mat<f64>,
    measurement: Mat<f64>,
    d22: Mat<f64>,
    /// Rotations of the errors and of the disturbances: z = Z z̃, w = W w̃.
    errors: Mat<f64>,
    disturbances: Mat<f64>,
    /// x = diag(states)·x̃.
    states: Vec<f64>,
}

impl NormalForm {
    /// Normal form of a plant.
    pub(crate) fn new(plant: &GeneralizedPlant) -> Result<Self, SynthesisError> {
        let s = &plant.system;
        let (m2, p2) = (plant.controls, plant.measurements);
        if m2 == 0 || p2 == 0 || s.inputs() < m2 || s.outputs() < p2 {
            return Err(SynthesisError::Partition(format!(
                "{m2} controls and {p2} measurements of {} inputs and {} outputs",
                s.inputs(),
                s.outputs()
            )));
        }
        let (lacks_w, lacks_z) = (s.inputs() == m2, s.outputs() == p2);
        if lacks_w || lacks_z {
            let (w, z) = ("no disturbance inputs w", "no error outputs z");
            let words =
                if lacks_w && lacks_z { format!("{w} and {z}") } else { [z, w][usize::from(lacks_w)].to_owned() };
            return Err(SynthesisError::Partition(format!("{words}: the gain from w to z is what is made small")));
        }
        if ![&s.a, &s.b, &s.c, &s.d].iter().all(|m| m.is_all_finite()) {
            return Err(NumericError::NotFinite { what: "generalized plant" }.into());
        }
        let (n, m1, p1) = (s.order(), s.inputs() - m2, s.outputs() - p2);
        let d = |r: usize, c: usize, h: usize, w: usize| s.d.submatrix(r, c, h, w).to_owned();
        let (d12, d21) = (d(0, m1, p1, m2), d(p1, 0, p2, m1));
        let (z, control) = regular(&d12).map_err(|(smallest, largest)| SynthesisError::ControlCost {
            rows: p1,
            cols: m2,
            smallest,
            largest,
        })?;
        let (w, measurement) = regular(&d21.transpose().to_owned()).map_err(|(smallest, largest)| {
            SynthesisError::MeasurementNoise { rows: p2, cols: m1, smallest, largest }
        })?;
        let measurement = measurement.transpose().to_owned();
        let b1 = s.b.submatrix(0, 0, n, m1) * &w;
        let b2 = s.b.submatrix(0, m1, n, m2) * &control;
        let c1 = z.transpose() * s.c.submatrix(0, 0, p1, n);
        let c2 = &measurement * s.c.submatrix(p1, 0, p2, n);
        let scaled = StateSpace {
            a: s.a.clone(),
            b: stack_cols(&b1, &b2),
            c: stack_rows(&c1, &c2),
            d: Mat::zeros(p1 + p2, m1 + m2),
            time: Continuous,
        };
        let states = balancing(&scaled);
        let scaled = scaled.scale_states(&states);
        Ok(Self {
            b1: scaled.b.submatrix(0, 0, n, m1).to_owned(),
            b2: scaled.b.submatrix(0, m1, n, m2).to_owned(),
            c1: scaled.c.submatrix(0, 0, p1, n).to_owned(),
            c2: scaled.c.submatrix(p1, 0, p2, n).to_owned(),
            a: scaled.a,
            d11: z.transpose() * d(0, 0, p1, m1) * &w,
            control,
            measurement,
            d22: d(p1, m1, p2, m2),
            errors: z,
            disturbances: w,
            states,
        })
    }

    /// The zero derivative by the matrices of the normal form.
    pub(crate) fn zero_slope(&self) -> MatrixSlope {
        let inputs = self.b1.ncols() + self.b2.ncols();
        MatrixSlope::zero(self.a.nrows(), inputs, self.c1.nrows() + self.c2.nrows())
    }

    /// A derivative by the matrices of the normal form as one by those of the plant: [w; u] and [z; y] together.
    pub(crate) fn pulled_back(&self, slope: &MatrixSlope) -> MatrixSlope {
        let inputs = diagonal(&self.disturbances, &self.control);
        let outputs = diagonal(&self.errors, &self.measurement.transpose().to_owned());
        let t = &self.states;
        let b = &slope.b * inputs.transpose();
        let c = &outputs * &slope.c;
        MatrixSlope {
            a: Mat::from_fn(t.len(), t.len(), |i, j| slope.a[(i, j)] * t[j] / t[i]),
            b: Mat::from_fn(t.len(), b.ncols(), |i, j| b[(i, j)] / t[i]),
            c: Mat::from_fn(c.nrows(), t.len(), |i, j| c[(i, j)] * t[j]),
            d: &outputs * &slope.d * inputs.transpose(),
        }
    }

    pub(crate) fn controls(&self) -> usize {
        self.b2.ncols()
    }

    pub(crate) fn measurements(&self) -> usize {
        self.c2.nrows()
    }

    /// The controller of the original plant from that of the normal form:
    /// K₀ = T_u K̃ T_y, K = K₀(I + D22 K₀)⁻¹.
    pub(crate) fn original_controller(
        &self,
        k: &StateSpace<Continuous>,
    ) -> Result<StateSpace<Continuous>, NumericError> {
        let k0 = k.scale_outputs(&self.control).scale_inputs(&self.measurement);
        let m2 = self.controls();
        // u = C x + D (y − D22 u)
        let closure = Mat::<f64>::identity(m2, m2) + &k0.d * &self.d22;
        let both = solve(&closure, &stack_cols(&k0.c, &k0.d))
            .map_err(|_| NumericError::IllPosed { what: "I + D_K·D22 of the controller" })?;
        let n = k0.order();
        let (cu, du) = (both.submatrix(0, 0, m2, n).to_owned(), both.submatrix(0, n, m2, k0.inputs()).to_owned());
        let bd = &k0.b * &self.d22;
        StateSpace::new(&k0.a - &bd * &cu, &k0.b - &bd * &du, cu, du, Continuous)
    }
}

/// [a 0; 0 b].
fn diagonal(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let zero = |rows: &Mat<f64>, columns: &Mat<f64>| Mat::zeros(rows.nrows(), columns.ncols());
    block2(a, &zero(a, b), &zero(b, a), b)
}

/// Orthogonal Q and invertible T with QᵀD T = [0; I]; the two singular values when D has no full column rank.
fn regular(d: &Mat<f64>) -> Result<(Mat<f64>, Mat<f64>), (f64, f64)> {
    let (rows, cols) = (d.nrows(), d.ncols());
    let norms: Vec<f64> = (0..cols).map(|j| d.col(j).norm_l2()).collect();
    let unit: Vec<f64> = norms.iter().map(|x| if *x > 0.0 { *x } else { 1.0 }).collect();
    let equal = Mat::from_fn(rows, cols, |i, j| d[(i, j)] / unit[j]);
    let f = svd(&equal).map_err(|_| (f64::NAN, f64::NAN))?;
    let largest = f.s.first().copied().unwrap_or(0.0);
    let smallest = if rows < cols { 0.0 } else { f.s[cols - 1] };
    // A column that is negligible beside the others counts by its own size as well.
    let spread = norms.iter().copied().fold(f64::INFINITY, f64::min);
    if smallest <= RANK * largest || spread == 0.0 {
        return Err((smallest, largest));
    }
    let q =
        Mat::from_fn(rows, rows, |i, j| if j < rows - cols { f.u[(i, cols + j)] } else { f.u[(i, j - (rows - cols))] });
    let t = Mat::from_fn(cols, cols, |i, j| f.v[(i, j)] / f.s[j] / unit[i]);
    Ok((q, t))
}
