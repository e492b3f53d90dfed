//! A controller of one plane in modal coordinates, stable by construction:
//!   K(z) = D + Σ_pairs [c bᵀ/(z − λ) + c̄ b̄ᵀ/(z − λ̄)] + Σ_real c bᵀ/(z − λ),
//! with λ = ρ exp(−e^a + jθ) for a pair and λ = ρ tanh(a) for a real pole, ρ = 1 or less for a least decay.
//! Parameters: per pair a, θ, Re c, Im c, Re b, Im b (two each), per real pole a, c, b, then D by rows. Signals are
//! counted in units of [`SIGNAL_SCALE_M`], so that b, c, D are of order one. One complex factor between c and b of a
//! pair is free; the metric of the step takes no notice of it.

use super::matrix2::{Matrix2, PackedMatrix, ZERO};
use super::structure::{FixedLaw, LawStructure, LoopLine};
use crate::augment::assembly::SIGNAL_SCALE_M;
use crate::controller::{ControllerError, in_step};
use crate::linalg::dense::balance;
use crate::linalg::dense::complex;
use crate::linalg::lanes::{Lanes, Reals, WIDTH};
use crate::linalg::{Mat, NumericError, c64, eigen_vectors_complex, solve_complex};
use crate::lti::{Discrete, StateSpace};

/// Parameters of a pair, of a real pole, of the feedthrough.
const PAIR: usize = 10;
const REAL: usize = 5;
const DIRECT: usize = 4;
/// Slowest decay per sample, beyond that of the largest radius, that a start may have; a pole on or outside that circle
/// is moved to it.
const SLOWEST: f64 = 1e-7;
/// Accepted change of the transfer matrix by the modal form, relative to its peak.
const LARGEST_CHANGE: f64 = 1e-6;

/// Numbers of poles: what fixes the meaning of a parameter vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModalLaw {
    pairs: usize,
    reals: usize,
    period_s: f64,
    /// ρ.
    largest_radius: f64,
}

impl ModalLaw {
    /// The law and the parameters of a sampled controller of one plane, A/m.
    pub(crate) fn of(system: &StateSpace<Discrete>) -> Result<(Self, Vec<f64>), ControllerError> {
        Self::within(system, 1.0)
    }

    /// The same with no pole beyond a radius of the z plane.
    pub(crate) fn within(
        system: &StateSpace<Discrete>,
        largest_radius: f64,
    ) -> Result<(Self, Vec<f64>), ControllerError> {
        const STEP: &str = "modal form for the polish";
        let n = system.order();
        let (balanced, scale) = balance(&system.a);
        let eigen = eigen_vectors_complex(&complex(&balanced)).map_err(in_step(STEP))?;
        let b = Mat::from_fn(n, 2, |i, j| c64::new(system.b[(i, j)] / scale[i], 0.0));
        let b = solve_complex(&eigen.vectors, &b);
        let c = Mat::from_fn(2, n, |i, j| c64::new(system.c[(i, j)] * scale[j], 0.0));
        let c = &c * &eigen.vectors;
        let (mut pairs, mut reals) = (vec![], vec![]);
        for (k, pole) in eigen.values.iter().enumerate() {
            let read = [c[(0, k)], c[(1, k)]];
            let write = [b[(k, 0)] * SIGNAL_SCALE_M, b[(k, 1)] * SIGNAL_SCALE_M];
            // Rounding leaves a real eigenvalue of a real matrix exactly real or in a pair.
            if pole.im.abs() <= 1e-12 {
                reals.extend(real_parameters(pole.re / largest_radius, &read, &write));
            } else if pole.im > 0.0 {
                pairs.extend(pair_parameters(*pole / largest_radius, &read, &write));
            }
        }
        let period_s = system.time.period_s;
        let law = Self { pairs: pairs.len() / PAIR, reals: reals.len() / REAL, period_s, largest_radius };
        let mut x = pairs;
        x.extend(reals);
        x.extend((0..DIRECT).map(|k| system.d[(k / 2, k % 2)] * SIGNAL_SCALE_M));
        if 2 * law.pairs + law.reals != n || !x.iter().all(|v| v.is_finite()) {
            return Err(inaccurate(f64::NAN));
        }
        let own_stable = eigen.values.iter().all(|z| z.norm() < largest_radius * (1.0 - SLOWEST));
        let back = law.system(&x).map_err(in_step(STEP))?;
        let change = crate::controller::modal::transfer_change(system, &back);
        // NaN must fail too.
        let accurate = change <= LARGEST_CHANGE;
        if own_stable && !accurate {
            return Err(inaccurate(change));
        }
        Ok((law, x))
    }

    pub(crate) fn order(&self) -> usize {
        2 * self.pairs + self.reals
    }

    /// The controller in real modal coordinates, A/m.
    pub(crate) fn system(&self, x: &[f64]) -> Result<StateSpace<Discrete>, NumericError> {
        let n = self.order();
        let (mut a, mut b, mut c) = (Mat::zeros(n, n), Mat::zeros(n, 2), Mat::zeros(2, n));
        for k in 0..self.pairs {
            // w⁺ = λ w + b y with w = w₁ + j w₂, u = 2 Re(c w).
            let p = PolePair::read(&x[k * PAIR..(k + 1) * PAIR], self.largest_radius);
            let (i, j) = (2 * k, 2 * k + 1);
            (a[(i, i)], a[(i, j)]) = (p.pole.re, -p.pole.im);
            (a[(j, i)], a[(j, j)]) = (p.pole.im, p.pole.re);
            for q in 0..2 {
                (b[(i, q)], b[(j, q)]) = (p.b[q].re / SIGNAL_SCALE_M, p.b[q].im / SIGNAL_SCALE_M);
                (c[(q, i)], c[(q, j)]) = (2.0 * p.c[q].re, -2.0 * p.c[q].im);
            }
        }
        for k in 0..self.reals {
            let p = &x[self.pairs * PAIR + k * REAL..];
            let i = 2 * self.pairs + k;
            a[(i, i)] = self.largest_radius * p[0].tanh();
            for q in 0..2 {
                c[(q, i)] = p[1 + q];
                b[(i, q)] = p[3 + q] / SIGNAL_SCALE_M;
            }
        }
        let d = &x[self.pairs * PAIR + self.reals * REAL..];
        let d = Mat::from_fn(2, 2, |i, j| d[2 * i + j] / SIGNAL_SCALE_M);
        let period_s = self.period_s;
        StateSpace::new(a, b, c, d, Discrete { period_s })
    }
}

impl LawStructure for ModalLaw {
    fn natural_steps(&self, x: &[f64]) -> Vec<f64> {
        let size = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt().max(1e-12);
        let (pairs, rest) = x.split_at(self.pairs * PAIR);
        let (reals, direct) = rest.split_at(self.reals * REAL);
        let mut steps = vec![];
        for p in pairs.chunks_exact(PAIR) {
            // A pole moves by its distance from the circle.
            steps.extend([1.0, p[0].exp()]);
            steps.extend([size(&p[2..6]); 4]);
            steps.extend([size(&p[6..10]); 4]);
        }
        for p in reals.chunks_exact(REAL) {
            steps.push(1.0);
            steps.extend([size(&p[1..3]); 2]);
            steps.extend([size(&p[3..5]); 2]);
        }
        steps.extend([size(direct); DIRECT]);
        steps
    }

    fn with<'a>(&'a self, x: &[f64]) -> Box<dyn FixedLaw + 'a> {
        let (pairs, rest) = x.split_at(self.pairs * PAIR);
        let (reals, direct) = rest.split_at(self.reals * REAL);
        Box::new(FixedModal {
            pairs: pairs.chunks_exact(PAIR).map(|p| PolePair::read(p, self.largest_radius)).collect(),
            reals: reals.chunks_exact(REAL).map(|p| Real::read(p, self.largest_radius)).collect(),
            direct: [0, 1].map(|i| [0, 1].map(|j| direct[2 * i + j])),
        })
    }
}

/// The law with its poles and residues.
struct FixedModal {
    pairs: Vec<PolePair>,
    reals: Vec<Real>,
    direct: [[f64; 2]; 2],
}

impl FixedLaw for FixedModal {
    fn parameters(&self) -> usize {
        self.pairs.len() * PAIR + self.reals.len() * REAL + DIRECT
    }

    fn add_gains(&self, lines: &[LoopLine], to: &mut Vec<Matrix2>) {
        to.extend(lines.iter().map(|line| self.gain(line)));
    }

    fn add_gradients(&self, line: &LoopLine, _: &Matrix2, parts: &mut [(Matrix2, Vec<f64>)]) {
        for (q, _) in parts.iter_mut() {
            *q = q.map(|row| row.map(|v| v / SIGNAL_SCALE_M));
        }
        let first = self.pairs.len() * PAIR;
        for four in parts.chunks_mut(WIDTH) {
            let q = [0, 1].map(|i| [0, 1].map(|j| Lanes::of_list(four, |(q, _)| q[i][j])));
            for (k, p) in self.pairs.iter().enumerate() {
                let (g, h) = p.resolvents(line.z);
                add_to(four, k * PAIR, &p.gradients(g, h, &q));
            }
            for (k, p) in self.reals.iter().enumerate() {
                let g = (line.z - p.pole).inv();
                add_to(four, first + k * REAL, &p.gradients(g, &q));
            }
        }
        let direct = first + self.reals.len() * REAL;
        for (q, out) in parts {
            for i in 0..2 {
                for j in 0..2 {
                    out[direct + 2 * i + j] += q[j][i].re;
                }
            }
        }
    }
}

impl FixedModal {
    /// K at a line, A/m.
    fn gain(&self, line: &LoopLine) -> Matrix2 {
        let mut k = [[ZERO; 2]; 2];
        for p in &self.pairs {
            let (g, h) = p.resolvents(line.z);
            for i in 0..2 {
                for j in 0..2 {
                    let cb = p.residue[i][j];
                    k[i][j] += cb * g + cb.conj() * h;
                }
            }
        }
        for p in &self.reals {
            let g = (line.z - p.pole).inv();
            for i in 0..2 {
                for j in 0..2 {
                    k[i][j] += g * (p.c[i] * p.b[j]);
                }
            }
        }
        for i in 0..2 {
            for j in 0..2 {
                k[i][j] = (k[i][j] + self.direct[i][j]) / SIGNAL_SCALE_M;
            }
        }
        k
    }
}

/// Adds derivatives by some parameters, from one on, to those of up to four values.
fn add_to(four: &mut [(Matrix2, Vec<f64>)], from: usize, gradients: &[Reals]) {
    for (l, (_, out)) in four.iter_mut().enumerate() {
        for (out, own) in out[from..].iter_mut().zip(gradients) {
            *out += own.as_array()[l];
        }
    }
}

/// A real pole with its residue c bᵀ.
struct Real {
    pole: f64,
    /// ρ.
    largest: f64,
    c: [f64; 2],
    b: [f64; 2],
}

impl Real {
    /// Derivatives of four values by its parameters, g = (z − λ)⁻¹.
    fn gradients(&self, g: c64, q: &PackedMatrix) -> [Reals; REAL] {
        let zero = Lanes::ZERO;
        let (mut whole, mut c, mut b) = (zero, [zero; 2], [zero; 2]);
        let times = |q: &Lanes, factor: f64| q.times(Reals::splat(factor));
        for i in 0..2 {
            for j in 0..2 {
                whole = whole.sum(&times(&q[j][i], self.c[i] * self.b[j]));
                c[i] = c[i].sum(&times(&q[j][i], self.b[j]));
                b[j] = b[j].sum(&times(&q[j][i], self.c[i]));
            }
        }
        let by_pole = whole.rounded_times(g).rounded_times(g).reals().0;
        let [c, b] = [c, b].map(|both| both.map(|own| own.rounded_times(g).reals().0));
        let by_pole = by_pole * (self.largest - self.pole * self.pole / self.largest);
        [by_pole, c[0], c[1], b[0], b[1]]
    }

    fn read(x: &[f64], largest: f64) -> Self {
        Self { pole: largest * x[0].tanh(), largest, c: [x[1], x[2]], b: [x[3], x[4]] }
    }
}

/// A pair of poles with the residue c bᵀ of the upper one.
struct PolePair {
    pole: c64,
    /// e^a: decay per sample.
    decay: f64,
    c: [c64; 2],
    b: [c64; 2],
    /// c bᵀ.
    residue: Matrix2,
}

impl PolePair {
    /// Derivatives of four values by its parameters, g = (z − λ)⁻¹ and h = (z − λ̄)⁻¹.
    fn gradients(&self, g: c64, h: c64, q: &PackedMatrix) -> [Reals; PAIR] {
        let [b, c] = [&self.b, &self.c];
        let [bc, cc] = [b, c].map(|both| both.map(|z| z.conj()));
        let sum = |q: [&Lanes; 2], factors: &[c64; 2]| {
            let [first, second] = q;
            first.rounded_times(factors[0]).sum(&second.rounded_times(factors[1]))
        };
        // tr(Q c bᵀ) = bᵀ Q c.
        let rows = |by: &[c64; 2]| [0, 1].map(|j| sum([&q[j][0], &q[j][1]], by));
        let columns = |by: &[c64; 2]| [0, 1].map(|i| sum([&q[0][i], &q[1][i]], by));
        let (qc, qcc, qb, qbc) = (rows(c), rows(&cc), columns(b), columns(&bc));
        let along = sum(qc.each_ref(), b).rounded_times(g).rounded_times(g);
        let across = sum(qcc.each_ref(), &bc).rounded_times(h).rounded_times(h);
        let along = along.rounded_times(self.pole);
        let across = across.rounded_times(self.pole.conj());
        let ((re, im), (re_across, im_across)) = (along.reals(), across.reals());
        // j λ along, −j λ̄ across.
        let mut all = [Reals::splat(0.0); PAIR];
        (all[0], all[1]) = ((re + re_across) * -self.decay, im_across - im);
        for i in 0..2 {
            for (first, one, two) in [(2, &qb[i], &qbc[i]), (6, &qc[i], &qcc[i])] {
                let (one, two) = (one.rounded_times(g), two.rounded_times(h));
                all[first + i] = one.sum(&two).reals().0;
                all[first + 2 + i] = -one.minus(&two).reals().1;
            }
        }
        all
    }

    fn read(x: &[f64], largest: f64) -> Self {
        let z = |re: usize, im: usize| c64::new(x[re], x[im]);
        let (c, b) = ([z(2, 4), z(3, 5)], [z(6, 8), z(7, 9)]);
        let decay = x[0].exp();
        Self {
            pole: c64::from_polar(largest * (-decay).exp(), x[1]),
            decay,
            residue: c.map(|c| b.map(|b| c * b)),
            c,
            b,
        }
    }

    /// 1/(z − λ), 1/(z − λ̄).
    fn resolvents(&self, z: c64) -> (c64, c64) {
        ((z - self.pole).inv(), (z - self.pole.conj()).inv())
    }
}

/// Factor that gives |c| = |b|.
fn even_coefficient(c: &[c64; 2], b: &[c64; 2]) -> f64 {
    let size = |v: &[c64; 2]| (v[0].norm_sqr() + v[1].norm_sqr()).sqrt();
    let ratio = (size(b) / size(c)).sqrt();
    if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
}

fn pair_parameters(pole: c64, c: &[c64; 2], b: &[c64; 2]) -> Vec<f64> {
    let t = even_coefficient(c, b);
    let (c, b) = (c.map(|v| v * t), b.map(|v| v / t));
    let radius = pole.norm().clamp(1e-12, 1.0 - SLOWEST);
    let mut x = vec![(-radius.ln()).ln(), pole.arg()];
    x.extend([c[0].re, c[1].re, c[0].im, c[1].im]);
    x.extend([b[0].re, b[1].re, b[0].im, b[1].im]);
    x
}

fn real_parameters(pole: f64, c: &[c64; 2], b: &[c64; 2]) -> Vec<f64> {
    let t = even_coefficient(c, b);
    // An eigenvector may come with any phase: the product c bᵀ is real.
    let phase = c.iter().max_by(|p, q| p.norm().total_cmp(&q.norm()));
    let phase = phase.map_or(1.0.into(), |v| c64::from_polar(1.0, -v.arg()));
    let inside = pole.clamp(-1.0 + SLOWEST, 1.0 - SLOWEST);
    vec![inside.atanh(), (c[0] * phase).re * t, (c[1] * phase).re * t, (b[0] / phase).re / t, (b[1] / phase).re / t]
}

fn inaccurate(error: f64) -> ControllerError {
    ControllerError::Inaccurate { step: "modal form for the polish", error, allowed: LARGEST_CHANGE }
}
