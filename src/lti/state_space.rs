//! The linear time-invariant system  δx = A x + B u,  y = C x + D u  with its time base in the type.
//! δ is d/dt for [`Continuous`] and the forward shift for [`Discrete`]; the compiler keeps the two apart.
//! Symbols: n states, m inputs, p outputs; a is n×n, b n×m, c p×n, d p×m.

use crate::linalg::{Mat, NumericError, c64, eigenvalues, solve_complex};

/// Where a system lives: continuous or sampled time.
pub trait TimeBase: Copy + std::fmt::Debug + PartialEq + Send + Sync {
    /// True for sampled time.
    const IS_SAMPLED: bool;
    /// The point of the complex plane (s or z) that belongs to `omega_rad_s`.
    fn point(&self, omega_rad_s: f64) -> c64;
    /// Distance of a pole from the stability boundary, negative when stable:
    /// Re λ (rad/s) in continuous time, ln|λ|/Tₛ in sampled time.
    fn growth_rate(&self, pole: c64) -> f64;
    /// Largest growth rate over poles, 1/s; negative for a stable system, −∞ without poles.
    fn largest_growth_rate(&self, poles: &[c64]) -> f64 {
        let rates = poles.iter().map(|pole| self.growth_rate(*pole));
        rates.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Continuous time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continuous;

/// Sampled time with a period in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrete {
    /// Sample period, s.
    pub period_s: f64,
}

impl TimeBase for Continuous {
    const IS_SAMPLED: bool = false;
    fn point(&self, omega_rad_s: f64) -> c64 {
        c64::new(0.0, omega_rad_s)
    }
    fn growth_rate(&self, pole: c64) -> f64 {
        pole.re
    }
}

impl TimeBase for Discrete {
    const IS_SAMPLED: bool = true;
    fn point(&self, omega_rad_s: f64) -> c64 {
        c64::from_polar(1.0, omega_rad_s * self.period_s)
    }
    fn growth_rate(&self, pole: c64) -> f64 {
        // A pole at 0 is a delay and decays faster than any other: ln of the smallest number stands for −∞.
        pole.norm().max(f64::MIN_POSITIVE).ln() / self.period_s
    }
}

impl Discrete {
    /// Frequency of the w plane, v = (2/Tₛ)tan(ωTₛ/2), that the bilinear map takes ω to, rad/s.
    pub fn w_frequency(&self, omega_rad_s: f64) -> f64 {
        2.0 / self.period_s * (0.5 * omega_rad_s * self.period_s).tan()
    }

    /// Frequency ω that belongs to one of the w plane, rad/s; π/Tₛ to infinity.
    pub fn true_frequency(&self, w_plane_rad_s: f64) -> f64 {
        2.0 / self.period_s * (0.5 * w_plane_rad_s * self.period_s).atan()
    }

    /// The poles as points of the s plane, s = ln(z)/Tₛ, rad/s; those of pure delays left out.
    pub(crate) fn continuous_poles(&self, poles: Vec<c64>) -> Vec<c64> {
        poles
            .into_iter()
            // A pole that decays by this factor in one sample is a delay: s lies beyond twice the sample rate.
            .filter(|z| z.norm() > 1e-6)
            .map(|z| z.ln() / self.period_s)
            .collect()
    }
}

/// A linear time-invariant system in state space.
#[derive(Clone, Debug)]
pub struct StateSpace<T: TimeBase> {
    /// State matrix, n×n.
    pub a: Mat<f64>,
    /// Input matrix, n×m.
    pub b: Mat<f64>,
    /// Output matrix, p×n.
    pub c: Mat<f64>,
    /// Feedthrough, p×m.
    pub d: Mat<f64>,
    /// Time base.
    pub time: T,
}

/// Rows of a pencil whose sizes differ by more than this: of sixteen digits an elimination leaves the smaller four.
const FAR_APART: f64 = 1e12;

impl<T: TimeBase> StateSpace<T> {
    /// A system from its four matrices.
    ///
    /// # Errors
    /// [`NumericError::Dimension`] when the shapes do not fit, [`NumericError::NotFinite`] for NaN or infinity.
    pub fn new(a: Mat<f64>, b: Mat<f64>, c: Mat<f64>, d: Mat<f64>, time: T) -> Result<Self, NumericError> {
        let n = a.nrows();
        if a.ncols() != n || b.nrows() != n || c.ncols() != n || d.nrows() != c.nrows() || d.ncols() != b.ncols() {
            return Err(NumericError::Dimension {
                what: "state space",
                expected: format!("A n×n, B n×m, C p×n, D p×m with n = {n}"),
                found: format!(
                    "A {}×{}, B {}×{}, C {}×{}, D {}×{}",
                    a.nrows(),
                    a.ncols(),
                    b.nrows(),
                    b.ncols(),
                    c.nrows(),
                    c.ncols(),
                    d.nrows(),
                    d.ncols()
                ),
            });
        }
        if ![&a, &b, &c, &d].iter().all(|m| m.is_all_finite()) {
            return Err(NumericError::NotFinite { what: "state space" });
        }
        Ok(Self { a, b, c, d, time })
    }

    /// A memoryless gain, p×m.
    pub fn gain(d: Mat<f64>, time: T) -> Self {
        let (p, m) = (d.nrows(), d.ncols());
        Self { a: Mat::zeros(0, 0), b: Mat::zeros(0, m), c: Mat::zeros(p, 0), d, time }
    }

    /// The same matrices on another time base.
    pub fn with_time<U: TimeBase>(self, time: U) -> StateSpace<U> {
        StateSpace { a: self.a, b: self.b, c: self.c, d: self.d, time }
    }

    /// Number of states n.
    pub fn order(&self) -> usize {
        self.a.nrows()
    }

    /// Number of inputs m.
    pub fn inputs(&self) -> usize {
        self.d.ncols()
    }

    /// Number of outputs p.
    pub fn outputs(&self) -> usize {
        self.d.nrows()
    }

    /// Poles: eigenvalues of A, rad/s or in the z plane.
    ///
    /// # Errors
    /// [`NumericError`] when the eigenvalue iteration fails.
    pub fn poles(&self) -> Result<Vec<c64>, NumericError> {
        eigenvalues(&self.a)
    }

    /// True when the other system has the same matrices in the same time base.
    pub(crate) fn is_same(&self, other: &Self) -> bool
    where
        T: PartialEq,
    {
        let pairs = [(&self.a, &other.a), (&self.b, &other.b), (&self.c, &other.c), (&self.d, &other.d)];
        self.time == other.time && pairs.iter().all(|(a, b)| a == b)
    }

    /// Largest growth rate over all poles, 1/s; negative for a stable system, −∞ for a gain.
    ///
    /// # Errors
    /// [`NumericError`] when the eigenvalue iteration fails.
    pub fn growth_rate(&self) -> Result<f64, NumericError> {
        Ok(self.time.largest_growth_rate(&self.poles()?))
    }

    /// Transfer matrix C(ζI − A)⁻¹B + D at a point ζ of the s or z plane, p×m.
    pub fn transfer(&self, point: c64) -> Mat<c64> {
        let (n, m, p) = (self.order(), self.inputs(), self.outputs());
        let real = |x: f64| c64::new(x, 0.0);
        if n == 0 {
            return Mat::from_fn(p, m, |i, j| real(self.d[(i, j)]));
        }
        let entry = |i: usize, j: usize| real(-self.a[(i, j)]) + if i == j { point } else { real(0.0) };
        let unit = self.units_of_rows(point);
        let pencil = Mat::from_fn(n, n, |i, j| unit[i] * entry(i, j));
        let x = solve_complex(&pencil, &Mat::from_fn(n, m, |i, j| real(unit[i] * self.b[(i, j)])));
        Mat::from_fn(p, m, |i, j| (0..n).fold(real(self.d[(i, j)]), |sum, k| sum + x[(k, j)] * self.c[(i, k)]))
    }

    /// Units (powers of two) that make the rows of ζI − A alike where they are so far apart that an elimination loses
    /// the smaller ones, as in the companion form of a filter far beyond every frequency; else ones.
    fn units_of_rows(&self, point: c64) -> Vec<f64> {
        let n = self.order();
        let size = |i: usize| (0..n).map(|j| self.a[(i, j)].abs()).fold(point.norm(), f64::max);
        let sizes: Vec<f64> = (0..n).map(size).collect();
        let positive = || sizes.iter().filter(|size| **size > 0.0);
        let (least, most) = positive().fold((f64::INFINITY, 0.0f64), |(a, b), s| (a.min(*s), b.max(*s)));
        let unit = |size: &f64| if *size > 0.0 { size.log2().round().exp2().recip() } else { 1.0 };
        if most > FAR_APART * least { sizes.iter().map(unit).collect() } else { vec![1.0; n] }
    }

    /// The subsystem from the listed inputs to the listed outputs, in the order given.
    ///
    /// # Panics
    /// When an index is out of range.
    pub fn select(&self, outputs: &[usize], inputs: &[usize]) -> Self {
        let n = self.order();
        Self {
            a: self.a.clone(),
            b: Mat::from_fn(n, inputs.len(), |i, j| self.b[(i, inputs[j])]),
            c: Mat::from_fn(outputs.len(), n, |i, j| self.c[(outputs[i], j)]),
            d: Mat::from_fn(outputs.len(), inputs.len(), |i, j| self.d[(outputs[i], inputs[j])]),
            time: self.time,
        }
    }

    /// The system without the states that are not wanted.
    pub(crate) fn keep_states(&self, wanted: impl Fn(usize) -> bool) -> Self {
        let keep: Vec<usize> = (0..self.order()).filter(|i| wanted(*i)).collect();
        let n = keep.len();
        Self {
            a: Mat::from_fn(n, n, |i, j| self.a[(keep[i], keep[j])]),
            b: Mat::from_fn(n, self.inputs(), |i, j| self.b[(keep[i], j)]),
            c: Mat::from_fn(self.outputs(), n, |i, j| self.c[(i, keep[j])]),
            d: self.d.clone(),
            time: self.time,
        }
    }

    /// The system with its outputs multiplied from the left by a constant matrix.
    pub fn scale_outputs(&self, left: &Mat<f64>) -> Self {
        Self { a: self.a.clone(), b: self.b.clone(), c: left * &self.c, d: left * &self.d, time: self.time }
    }

    /// The system with its inputs multiplied from the right by a constant matrix.
    pub(crate) fn scale_inputs(&self, right: &Mat<f64>) -> Self {
        Self { a: self.a.clone(), b: &self.b * right, c: self.c.clone(), d: &self.d * right, time: self.time }
    }

    /// The same transfer matrix in the coordinates x = diag(scale)·x̃.
    pub fn scale_states(&self, scale: &[f64]) -> Self {
        let n = self.order();
        Self {
            a: Mat::from_fn(n, n, |i, j| self.a[(i, j)] * scale[j] / scale[i]),
            b: Mat::from_fn(n, self.inputs(), |i, j| self.b[(i, j)] / scale[i]),
            c: Mat::from_fn(self.outputs(), n, |i, j| self.c[(i, j)] * scale[j]),
            d: self.d.clone(),
            time: self.time,
        }
    }
}

impl StateSpace<Discrete> {
    /// Poles as points of the s plane, rad/s: for grids and damping tables.
    pub(crate) fn continuous_poles(&self) -> Result<Vec<c64>, NumericError> {
        Ok(self.time.continuous_poles(self.poles()?))
    }
}
