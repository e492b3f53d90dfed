//! The rotating shaft without magnets as a sum over its whirl modes, so that a frequency costs O(modes·ports²).
//!
//! With z = (Λ^{1/2}η, η̇), Λ = diag ω²:  ż = A z + (0, Φᵀf),  A = [[0, Λ^{1/2}], [−(Λ − jK_c)Λ^{−1/2}, −C + jΩG]].
//! Without C and K_c A is skew-Hermitian, so with the light damping of a shaft its eigenvectors V are almost orthogonal
//! and safe to use. x_p(jω) = φ_p η̇/(jω) = Σ_k (φ_p V_k)(V⁻¹ Φᵀ)_{kq}/(jω (jω − λ_k)) f_q; free translation is λ = 0,
//! exactly.

use super::response::pairs::pairs;
use crate::linalg::planar::{Planar, add_fused};
use crate::linalg::{Mat, c64, eigen_vectors_complex, solve_complex};

/// Whirl modes of the rotating shaft, which serve all its ports.
#[derive(Clone, Debug)]
pub(crate) struct WhirlModes {
    poles: Vec<c64>,
    /// η̇ of the coordinates in each mode, coordinates × poles.
    velocities: Mat<c64>,
    /// Drive of each mode by a force on η̈ of a coordinate, poles × coordinates.
    drives: Mat<c64>,
}

/// Poles and port amplitudes of the whirl modes.
#[derive(Clone, Debug)]
pub(crate) struct WhirlForm {
    poles: Vec<c64>,
    /// Pairs of ports × poles: displacement of one by the pole times the drive of the pole by a force at the other.
    residues: Planar,
}

/// Largest residual of an eigenpair, and of V V⁻¹ − I, at which the form is used; rounding leaves 1e-13.
const TRUSTED: f64 = 1e-10;

impl WhirlModes {
    /// The modes of a shaft with the given angular frequencies, damping 2ζω, circulatory stiffness and Ω·G; `None` when
    /// the eigenvectors are not accurate, as near a repeated eigenvalue.
    pub(crate) fn new(
        omega_rad_s: &[f64],
        damping: &[f64],
        circulatory: &[f64],
        gyroscopic: &Mat<f64>,
    ) -> Option<Self> {
        let n = omega_rad_s.len();
        let flexible: Vec<usize> = (0..n).filter(|k| omega_rad_s[*k] > 0.0).collect();
        let m = flexible.len();
        let zero = c64::new(0.0, 0.0);
        let a = Mat::from_fn(m + n, m + n, |i, j| match (i < m, j < m) {
            (true, true) => zero,
            (true, false) if flexible[i] == j - m => c64::new(omega_rad_s[j - m], 0.0),
            (false, true) if flexible[j] == i - m => {
                let w = omega_rad_s[i - m];
                c64::new(-w, circulatory[i - m] / w)
            }
            (false, false) => {
                let (i, j) = (i - m, j - m);
                let own = if i == j { -damping[i] } else { 0.0 };
                c64::new(own, gyroscopic[(i, j)])
            }
            _ => zero,
        });
        let eigen = eigen_vectors_complex(&a).ok()?;
        let inverse = solve_complex(&eigen.vectors, &Mat::identity(m + n, m + n));
        let unit = &eigen.vectors * &inverse - Mat::<c64>::identity(m + n, m + n);
        // NaN must fail too.
        let trusted = eigen.residual < TRUSTED && unit.norm_max() < TRUSTED;
        trusted.then(|| Self {
            poles: eigen.values,
            velocities: eigen.vectors.submatrix(m, 0, n, m + n).to_owned(),
            drives: inverse.submatrix(0, m, m + n, n).to_owned(),
        })
    }

    /// The form between ports with these amplitudes, ports × coordinates.
    pub(crate) fn between(&self, ports: &Mat<f64>) -> WhirlForm {
        let (count, n) = (self.poles.len(), ports.ncols());
        let zero = c64::new(0.0, 0.0);
        let read = Mat::from_fn(ports.nrows(), count, |i, k| {
            (0..n).fold(zero, |sum, c| sum + self.velocities[(c, k)] * ports[(i, c)])
        });
        let drive = Mat::from_fn(ports.nrows(), count, |i, k| {
            (0..n).fold(zero, |sum, c| sum + self.drives[(k, c)] * ports[(i, c)])
        });
        let between: Vec<(usize, usize)> = pairs(ports.nrows(), ports.nrows()).collect();
        WhirlForm {
            poles: self.poles.clone(),
            residues: Planar::from_fn(between.len(), count, |pair, k| {
                let (i, j) = between[pair];
                parts(read[(i, k)] * drive[(j, k)])
            }),
        }
    }
}

impl WhirlForm {
    /// Receptance of every pair of ports at a signed angular frequency, real and imaginary parts apart.
    pub(crate) fn receptance(&self, omega_rad_s: f64) -> (Vec<f64>, Vec<f64>) {
        let count = self.residues.rows();
        let s = c64::new(0.0, omega_rad_s);
        let (mut re, mut im) = (vec![0.0; count], vec![0.0; count]);
        for (k, pole) in self.poles.iter().enumerate() {
            let gain = parts((s * (s - pole)).inv());
            add_fused((&mut re, &mut im), gain, self.residues.part(0, count, k));
        }
        (re, im)
    }
}

/// Real and imaginary part.
fn parts(z: c64) -> (f64, f64) {
    (z.re, z.im)
}
