//! Whirl modes of a rotor at speed: gyroscopics, internal damping model, supports.
//!
//! With r = x + jy and isotropic supports  M r̈ + (C − jΩG) ṙ + K r = 0, solved in the modes of the free-free shaft at
//! rest (all of them, so nothing is lost); Im λ > 0 is forward whirl. With anisotropic supports both planes are kept:
//! G couples x to y as +ΩG and y to x as −ΩG.

use super::RotorError;
use super::assembly::Rotor;
use super::modes::{PlanarModes, RIGID};
use crate::linalg::{Mat, NumericError, c64, eigen_vectors, eigen_vectors_complex, eigenvalues_complex, solve_complex};
use std::f64::consts::TAU;

/// Damping of the shaft itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Damping {
    /// None.
    None,
    /// C = α M_shaft + β K_shaft.
    Proportional {
        /// α, 1/s.
        alpha: f64,
        /// β, s.
        beta: f64,
    },
    /// C = Σ 2ζ_k ω_k (M v_k)(M v_k)ᵀ over the first flexible modes, one ratio per mode; later modes undamped.
    Modal(Vec<f64>),
}

impl Damping {
    /// C of shaft and joints in the modes of the free-free shaft, n×n.
    fn modal_matrix(&self, modes: &PlanarModes) -> Mat<f64> {
        let n = modes.len();
        let project = |m: &Mat<f64>| modes.shapes.transpose() * (m * &modes.shapes);
        let mut c = project(&modes.matrices.joint_damping);
        match self {
            Self::None => {}
            Self::Proportional { alpha, beta } => {
                let shaft = project(&modes.matrices.shaft_mass);
                c = Mat::from_fn(n, n, |i, j| {
                    let own = modes.omega_rad_s[i].powi(2);
                    let stiffness = if i == j { beta * own } else { 0.0 };
                    c[(i, j)] + alpha * shaft[(i, j)] + stiffness
                });
            }
            Self::Modal(ratios) => {
                for (k, zeta) in ratios.iter().enumerate().take(n - RIGID) {
                    c[(k + RIGID, k + RIGID)] += 2.0 * zeta * modes.omega_rad_s[k + RIGID];
                }
            }
        }
        c
    }
}

/// A linear support: force on the rotor −K (x, y) − C (ẋ, ẏ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Position, m from the nose face.
    pub position_m: f64,
    /// [[kxx, kxy], [kyx, kyy]], N/m.
    pub stiffness_n_per_m: [[f64; 2]; 2],
    /// [[cxx, cxy], [cyx, cyy]], N s/m.
    pub damping_n_s_per_m: [[f64; 2]; 2],
}

impl Support {
    /// Place and stiffness in a plane, m and N/m; 0 is x, 1 is y.
    pub(crate) fn spring(&self, plane: usize) -> (f64, f64) {
        (self.position_m, self.stiffness_n_per_m[plane][plane])
    }

    /// Neither stiffness nor damping.
    pub(crate) fn at(position_m: f64) -> Self {
        Self { position_m, stiffness_n_per_m: [[0.0; 2]; 2], damping_n_s_per_m: [[0.0; 2]; 2] }
    }

    fn is_isotropic(&self) -> bool {
        let circulant = |m: [[f64; 2]; 2]| m[0][0] == m[1][1] && m[0][1] == -m[1][0];
        circulant(self.stiffness_n_per_m) && circulant(self.damping_n_s_per_m)
    }
}

/// What a rotor stands on, its damping, and its speed.
#[derive(Clone, Copy, Debug)]
pub struct RotorState<'a> {
    /// rad/s.
    pub speed_rad_s: f64,
    /// Of the shaft.
    pub damping: &'a Damping,
    /// Springs and dampers to ground.
    pub supports: &'a [Support],
}

/// One whirl mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhirlMode {
    /// |λ|, rad/s.
    pub natural_rad_s: f64,
    /// |Im λ|, rad/s.
    pub damped_rad_s: f64,
    /// −Re λ/|λ|.
    pub damping_ratio: f64,
    /// Forward +1, backward −1, 0 at rest; in between, (|f|² − |b|²)/(|f|² + |b|²) of the shape, with anisotropic
    /// supports.
    pub whirl: f64,
}

/// Eigenvalues of a rotor at one speed.
#[derive(Clone, Debug, Default)]
pub struct WhirlSpectrum {
    /// Oscillating modes, ascending in damped frequency.
    pub modes: Vec<WhirlMode>,
    /// Real eigenvalues with positive real part, rad/s, ascending: what a magnet without control does.
    pub unstable_real_poles_rad_s: Vec<f64>,
}

/// A whirl mode with the orbits of places along the shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct WhirlShape {
    /// Its direction is that of these orbits.
    pub mode: WhirlMode,
    /// Amplitudes X and Y of each place, x = Re(X e^{jωt}): the largest orbit has |X|² + |Y|² = 1 and begins on +x. At
    /// rest on supports that are equal in x and y the motion is shown in x.
    pub orbits: Vec<[c64; 2]>,
}

impl WhirlShape {
    fn of(value: c64, mut orbits: Vec<[c64; 2]>, at_rest: bool) -> Self {
        let size = |orbit: &[c64; 2]| orbit[0].norm_sqr() + orbit[1].norm_sqr();
        let largest = orbits.iter().max_by(|a, b| size(a).total_cmp(&size(b))).copied().unwrap_or_default();
        let begin = if largest[0].norm() > 0.0 { largest[0] / largest[0].norm() } else { c64::new(1.0, 0.0) };
        let scale = begin.conj() / size(&largest).sqrt().max(f64::MIN_POSITIVE);
        orbits.iter_mut().flatten().for_each(|amplitude| *amplitude *= scale);
        let sum = |sign: f64| -> f64 { orbits.iter().map(|[x, y]| (*x + c64::new(0.0, sign) * y).norm_sqr()).sum() };
        let (forward, backward) = (sum(1.0), sum(-1.0));
        let whirl = if at_rest { 0.0 } else { (forward - backward) / (forward + backward) };
        let (natural_rad_s, damped_rad_s) = (value.norm(), value.im.abs());
        let mode = WhirlMode { natural_rad_s, damped_rad_s, damping_ratio: -value.re / natural_rad_s, whirl };
        Self { mode, orbits }
    }
}

/// Below this |Im λ| an eigenvalue counts as not oscillating, rad/s: 0.5 Hz is far below every mode of a spindle and
/// far above the rounding of the double zero of free translation.
const OSCILLATING_RAD_S: f64 = TAU * 0.5;

/// Largest relative residual of eigenvectors that are shown: a thousandth of what a picture resolves.
const SHAPE_RESIDUAL: f64 = 1e-6;

/// A rotor on supports in the modes of the free-free shaft: ω², C, ΩG, and what the supports add between the planes.
struct ModalRotor {
    omega2: Vec<f64>,
    /// States are (s q, q̇): rows and columns of like size.
    scale: Vec<f64>,
    damping: Mat<f64>,
    turn: Mat<f64>,
    stiffness: [[Mat<f64>; 2]; 2],
    viscous: [[Mat<f64>; 2]; 2],
}

impl ModalRotor {
    /// In the modes of the free-free shaft at rest.
    fn of(
        rotor: &Rotor,
        modes: &PlanarModes,
        speed_rad_s: f64,
        damping: &Damping,
        supports: &[Support],
    ) -> Result<Self, RotorError> {
        let n = modes.len();
        let project = |m: &Mat<f64>| modes.shapes.transpose() * (m * &modes.shapes);
        let gyroscopic = project(&modes.matrices.gyroscopic);
        let omega2 = |k: usize| modes.omega_rad_s[k].powi(2);
        let rows = supports
            .iter()
            .map(|s| Ok(modes.amplitudes(&rotor.shape_at("support", s.position_m)?)))
            .collect::<Result<Vec<_>, RotorError>>()?;
        let form = |part: fn(&Support) -> [[f64; 2]; 2], a: usize, b: usize| {
            Mat::from_fn(n, n, |i, j| {
                supports.iter().zip(&rows).map(|(s, row)| part(s)[a][b] * row[i] * row[j]).sum::<f64>()
            })
        };
        let stiffness = |a, b| form(|s| s.stiffness_n_per_m, a, b);
        let viscous = |a, b| form(|s| s.damping_n_s_per_m, a, b);
        // States (s q, q̇) with s² = ω² + the supports' share, at least 1: rows and columns of like size.
        let share = |k: usize| -> f64 {
            let stiff = |s: &Support| s.stiffness_n_per_m[0][0].abs().max(s.stiffness_n_per_m[1][1].abs());
            supports.iter().zip(&rows).map(|(s, row)| stiff(s) * row[k] * row[k]).sum()
        };
        Ok(Self {
            omega2: (0..n).map(omega2).collect(),
            scale: (0..n).map(|k| (omega2(k) + share(k)).max(1.0).sqrt()).collect(),
            damping: damping.modal_matrix(modes),
            turn: Mat::from_fn(n, n, |i, j| speed_rad_s * gyroscopic[(i, j)]),
            stiffness: [0, 1].map(|a| [0, 1].map(|b| stiffness(a, b))),
            viscous: [0, 1].map(|a| [0, 1].map(|b| viscous(a, b))),
        })
    }

    /// Force per modal displacement of both planes at a frequency, rad/s.
    fn dynamic_stiffness(&self, w: f64) -> Mat<c64> {
        let n = self.scale.len();
        Mat::from_fn(2 * n, 2 * n, |i, j| {
            let (p, q) = (i / n, j / n);
            let (i, j) = (i % n, j % n);
            let turn = [[0.0, 1.0], [-1.0, 0.0]][p][q] * self.turn[(i, j)];
            let own = if p == q && i == j { self.omega2[i] - w * w } else { 0.0 };
            let damping = if p == q { self.damping[(i, j)] } else { 0.0 };
            c64::new(own + self.stiffness[p][q][(i, j)], w * (damping + self.viscous[p][q][(i, j)] + turn))
        })
    }

    /// System matrix in r = x + jy: a circulant [[a, b], [−b, a]] of the supports acts as a − jb.
    fn isotropic(&self) -> Mat<c64> {
        let n = self.scale.len();
        let (ka, kb) = (&self.stiffness[0][0], &self.stiffness[0][1]);
        let (da, db) = (&self.viscous[0][0], &self.viscous[0][1]);
        Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => c64::new(0.0, 0.0),
            (true, false) => c64::new(if i + n == j { self.scale[i] } else { 0.0 }, 0.0),
            (false, true) => {
                let (i, j) = (i - n, j);
                let own = if i == j { self.omega2[i] } else { 0.0 };
                -c64::new(own + ka[(i, j)], -kb[(i, j)]) / self.scale[j]
            }
            (false, false) => {
                let (i, j) = (i - n, j - n);
                let real = self.damping[(i, j)] + da[(i, j)];
                -c64::new(real, -self.turn[(i, j)] - db[(i, j)])
            }
        })
    }

    /// System matrix of both planes.
    fn two_planes(&self) -> Mat<f64> {
        let n = self.scale.len();
        let size = 2 * n;
        let plane = |i: usize| (i / n, i % n);
        Mat::from_fn(2 * size, 2 * size, |i, j| match (i < size, j < size) {
            (true, true) => 0.0,
            (true, false) if i + size == j => self.scale[i % n],
            (true, false) => 0.0,
            (false, true) => {
                let ((p, i), (q, j)) = (plane(i - size), plane(j));
                let own = if p == q && i == j { self.omega2[i] } else { 0.0 };
                -(own + self.stiffness[p][q][(i, j)]) / self.scale[j]
            }
            (false, false) => {
                let ((p, i), (q, j)) = (plane(i - size), plane(j - size));
                let own = if p == q { self.damping[(i, j)] } else { 0.0 };
                let turn = match (p, q) {
                    (0, 1) => self.turn[(i, j)],
                    (1, 0) => -self.turn[(i, j)],
                    _ => 0.0,
                };
                -(own + self.viscous[p][q][(i, j)] + turn)
            }
        })
    }
}

impl Rotor {
    /// Whirl modes at `speed_rad_s` up to `to_hz`.
    ///
    /// # Errors
    /// [`RotorError::OffShaft`] for a support beyond the ends, [`RotorError::Numeric`] when an iteration fails.
    pub fn whirl(
        &self,
        speed_rad_s: f64,
        damping: &Damping,
        supports: &[Support],
        to_hz: f64,
    ) -> Result<WhirlSpectrum, RotorError> {
        let modes = PlanarModes::new(self)?;
        let n = modes.len();
        let reduced = ModalRotor::of(self, &modes, speed_rad_s, damping, supports)?;
        let at_rest = speed_rad_s == 0.0;
        if supports.iter().all(Support::is_isotropic) {
            let values = eigenvalues_complex(&reduced.isotropic())?;
            let whirl = |v: &c64| if at_rest { 0.0 } else { v.im.signum() };
            return Ok(spectrum(values.iter().map(|v| (*v, whirl(v))), to_hz));
        }
        let (values, vectors) = eigen_vectors(&reduced.two_planes())?;
        let whirl = |k: usize| {
            if at_rest {
                return 0.0;
            }
            let (mut forward, mut backward) = (0.0, 0.0);
            for dof in (0..modes.shapes.nrows()).step_by(2) {
                let amplitude = |p: usize| {
                    (0..n).fold(c64::new(0.0, 0.0), |sum, m| {
                        let shape = modes.shapes[(dof, m)] / reduced.scale[m];
                        sum + vectors[(p * n + m, k)] * shape
                    })
                };
                let (x, y) = (amplitude(0), amplitude(1) * c64::new(0.0, 1.0));
                forward += (x + y).norm_sqr();
                backward += (x - y).norm_sqr();
            }
            (forward - backward) / (forward + backward)
        };
        // Conjugate pairs: one of each, the one with Im λ > 0, stands for the mode.
        let listed = (0..values.len()).map(|k| (values[k], k));
        let direction = |v: c64, k: usize| if v.im > OSCILLATING_RAD_S { whirl(k) } else { 0.0 };
        let kept: Vec<(c64, f64)> = listed.filter(|(v, _)| v.im >= 0.0).map(|(v, k)| (v, direction(v, k))).collect();
        Ok(spectrum(kept, to_hz))
    }

    /// Oscillating modes up to `to_hz` with the orbits at `places_m`, ascending in damped frequency.
    ///
    /// # Errors
    /// As [`Self::whirl`], and [`RotorError::OffShaft`] for a place beyond the ends.
    pub fn whirl_shapes(
        &self,
        state: &RotorState<'_>,
        places_m: &[f64],
        to_hz: f64,
    ) -> Result<Vec<WhirlShape>, RotorError> {
        let modes = PlanarModes::new(self)?;
        let n = modes.len();
        let reduced = ModalRotor::of(self, &modes, state.speed_rad_s, state.damping, state.supports)?;
        let at_rest = state.speed_rad_s == 0.0;
        let rows = places_m.iter().map(|z| Ok(modes.amplitudes(&self.shape_at("place", *z)?)));
        let rows = rows.collect::<Result<Vec<Vec<f64>>, RotorError>>()?;
        let read = |vectors: &Mat<c64>, k: usize, plane: usize, row: &[f64]| -> c64 {
            (0..n).map(|m| vectors[(plane * n + m, k)] * (row[m] / reduced.scale[m])).sum()
        };
        let is_isotropic = state.supports.iter().all(Support::is_isotropic);
        let (values, vectors) = if is_isotropic {
            let found = eigen_vectors_complex(&reduced.isotropic())?;
            (found.values, found.vectors)
        } else {
            eigen_vectors(&reduced.two_planes())?
        };
        let orbit = |k: usize, row: &Vec<f64>| {
            if !is_isotropic {
                return [read(&vectors, k, 0, row), read(&vectors, k, 1, row)];
            }
            // r = φ e^{λt}: forward as it is, backward as the conjugate of both.
            let phi = read(&vectors, k, 0, row);
            if at_rest {
                [phi, c64::new(0.0, 0.0)]
            } else if values[k].im > 0.0 {
                [phi, c64::new(0.0, -1.0) * phi]
            } else {
                [phi.conj(), c64::new(0.0, 1.0) * phi.conj()]
            }
        };
        // One of a conjugate pair stands for the mode; at speed r has no such pairs.
        let is_listed = |v: &c64| {
            let (lowest, highest) = (OSCILLATING_RAD_S, TAU * to_hz);
            v.im.abs() > lowest && v.im.abs() <= highest && (v.im > 0.0 || is_isotropic && !at_rest)
        };
        let listed: Vec<usize> = (0..values.len()).filter(|k| is_listed(&values[*k])).collect();
        if is_isotropic {
            // Vectors of the free translations, which are not listed, may be wrong.
            let own = Mat::from_fn(vectors.nrows(), listed.len(), |i, j| vectors[(i, listed[j])]);
            let matrix = reduced.isotropic();
            let residual =
                &matrix * &own - Mat::from_fn(own.nrows(), own.ncols(), |i, j| own[(i, j)] * values[listed[j]]);
            let residual = residual.norm_max() / matrix.norm_max();
            if residual > SHAPE_RESIDUAL {
                return Err(NumericError::NoConvergence { what: "whirl shapes", iterations: 0, residual }.into());
            }
        }
        let shape = |k: usize| WhirlShape::of(values[k], rows.iter().map(|row| orbit(k, row)).collect(), at_rest);
        let mut found: Vec<WhirlShape> = listed.into_iter().map(shape).collect();
        let order =
            |a: &WhirlMode, b: &WhirlMode| a.damped_rad_s.total_cmp(&b.damped_rad_s).then(a.whirl.total_cmp(&b.whirl));
        found.sort_by(|a, b| order(&a.mode, &b.mode));
        Ok(found)
    }

    /// Displacement over force, m/N, [[xx, xy], [yx, yy]] at each frequency: read at the first of `places_m`, with the
    /// force at the second. No mode of the mesh is left out.
    ///
    /// # Errors
    /// [`RotorError::OffShaft`] for a place beyond the ends, [`RotorError::Numeric`] when the modes cannot be computed.
    pub fn receptance(
        &self,
        state: &RotorState<'_>,
        places_m: [f64; 2],
        frequency_hz: &[f64],
    ) -> Result<Vec<[[c64; 2]; 2]>, RotorError> {
        let modes = PlanarModes::new(self)?;
        let n = modes.len();
        let reduced = ModalRotor::of(self, &modes, state.speed_rad_s, state.damping, state.supports)?;
        let row = |what, z| Ok::<_, RotorError>(modes.amplitudes(&self.shape_at(what, z)?));
        let (output, input) = (row("response", places_m[0])?, row("force", places_m[1])?);
        let force = Mat::from_fn(2 * n, 2, |i, p| c64::new(if i / n == p { input[i % n] } else { 0.0 }, 0.0));
        let at = |hz: &f64| {
            let moved = solve_complex(&reduced.dynamic_stiffness(TAU * hz), &force);
            let read = |p: usize, q: usize| (0..n).map(|k| moved[(p * n + k, q)] * output[k]).sum();
            [0, 1].map(|p| [0, 1].map(|q| read(p, q)))
        };
        Ok(frequency_hz.iter().map(at).collect())
    }

    /// Synchronous critical speeds of the rotor on undamped isotropic supports (stiffness kxx), rad/s, ascending:
    /// (forward, backward), from  K v = ω²(M ∓ G) v. Above the last entry there are none.
    ///
    /// # Errors
    /// [`RotorError::OffShaft`] for a support beyond the ends; [`RotorError::Numeric`] without enough supports.
    pub fn critical_speeds_rad_s(&self, supports: &[Support]) -> Result<(Vec<f64>, Vec<f64>), RotorError> {
        let matrices = self.plane_matrices();
        let mut k = matrices.stiffness.clone();
        for support in supports {
            let row = self.shape_at("support", support.position_m)?;
            for (i, a) in &row {
                for (j, b) in &row {
                    k[(*i, *j)] += support.stiffness_n_per_m[0][0] * a * b;
                }
            }
        }
        // K is definite, M − G need not be: solve for 1/ω².
        let solve = |sign: f64| -> Result<Vec<f64>, RotorError> {
            let n = self.dofs();
            let m = Mat::from_fn(n, n, |i, j| matrices.mass[(i, j)] - sign * matrices.gyroscopic[(i, j)]);
            let inverse = crate::linalg::definite_eigen(&m, &k)?.values;
            let largest = inverse.last().copied().unwrap_or_default();
            // Rounding level of the inverse eigenvalues; smaller ones are infinite speeds.
            let found = inverse.iter().rev().filter(|v| **v > 1e-13 * largest);
            Ok(found.map(|v| v.sqrt().recip()).collect())
        };
        Ok((solve(1.0)?, solve(-1.0)?))
    }
}

fn spectrum(values: impl IntoIterator<Item = (c64, f64)>, to_hz: f64) -> WhirlSpectrum {
    let mut found = WhirlSpectrum::default();
    for (value, whirl) in values {
        if value.im.abs() > OSCILLATING_RAD_S {
            found.modes.push(WhirlMode {
                natural_rad_s: value.norm(),
                damped_rad_s: value.im.abs(),
                damping_ratio: -value.re / value.norm(),
                whirl,
            });
        } else if value.re > OSCILLATING_RAD_S {
            found.unstable_real_poles_rad_s.push(value.re);
        }
    }
    found.modes.retain(|m| m.damped_rad_s <= TAU * to_hz);
    found.modes.sort_by(|a, b| a.damped_rad_s.total_cmp(&b.damped_rad_s).then(a.whirl.total_cmp(&b.whirl)));
    found.unstable_real_poles_rad_s.sort_by(f64::total_cmp);
    found
}
