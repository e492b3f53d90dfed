//! The rotating shaft without magnets as a sum over its whirl modes, so that a frequency costs O(modes·ports²).
//!
//! With z = (Λ^{1/2}η, η̇), Λ = diag ω²:  ż = A z + (0, Φᵀf),  A = [[0, Λ^{1/2}], [−(Λ − jK_c)Λ^{−1/2}, −C + jΩG]].
//! Without C and K_c A is skew-Hermitian, so with the light damping of a shaft its eigenvectors V are almost orthogonal
//! and safe to use. x_p(jω) = φ_p η̇/(jω) = Σ_k (φ_p V_k)(V⁻¹ Φᵀ)_{kq}/(jω (jω − λ_k)) f_q; free translation is λ = 0,
//! exactly.

use super::response::pairs::pairs;
use crate::linalg::lanes::{Lanes, WIDTH, groups};
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
    /// Pairs of ports.
    pairs: usize,
    /// Displacement of one of a pair by the pole times the drive of the pole by a force at the other: [`TOGETHER`]
    /// groups of pairs by each pole, then the next ones; zero behind the last pair.
    residues: Vec<[Lanes; TOGETHER]>,
}

/// Groups of pairs summed side by side: their sums stay in registers, and none waits for the one before it.
const TOGETHER: usize = 4;

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
    pub(crate) fn between_ports(&self, ports: &Mat<f64>) -> WhirlForm {
        let (count, n) = (self.poles.len(), ports.ncols());
        let zero = c64::new(0.0, 0.0);
        let read = Mat::from_fn(ports.nrows(), count, |i, k| {
            (0..n).fold(zero, |sum, c| sum + self.velocities[(c, k)] * ports[(i, c)])
        });
        let drive = Mat::from_fn(ports.nrows(), count, |i, k| {
            (0..n).fold(zero, |sum, c| sum + self.drives[(k, c)] * ports[(i, c)])
        });
        let between: Vec<(usize, usize)> = pairs(ports.nrows(), ports.nrows()).collect();
        let residue = |pair: usize, k: usize| match between.get(pair) {
            Some((i, j)) => read[(*i, k)] * drive[(*j, k)],
            None => zero,
        };
        let chunks = groups(between.len()).div_ceil(TOGETHER);
        let residues = (0..chunks).flat_map(|chunk| (0..count).map(move |k| (chunk, k)));
        let residues = residues.map(|(chunk, k)| {
            std::array::from_fn(|g| {
                let first = WIDTH * (TOGETHER * chunk + g);
                Lanes::from_fn(|l| residue(first + l, k))
            })
        });
        WhirlForm { poles: self.poles.clone(), pairs: between.len(), residues: residues.collect() }
    }
}

impl WhirlForm {
    /// Receptance of every pair of ports at a signed angular frequency, real and imaginary parts apart.
    pub(crate) fn receptance(&self, omega_rad_s: f64) -> (Vec<f64>, Vec<f64>) {
        // 1/(s (s − λ)) at s = jω.
        let gain = |pole: &c64| {
            let (re, im) = (omega_rad_s * (pole.im - omega_rad_s), -omega_rad_s * pole.re);
            let square = re * re + im * im;
            c64::new(re / square, -im / square)
        };
        let gains: Vec<c64> = self.poles.iter().map(gain).collect();
        let (mut all_re, mut all_im) = (vec![0.0; self.pairs], vec![0.0; self.pairs]);
        let chunks = self.residues.chunks_exact(gains.len().max(1));
        let parts = all_re.chunks_mut(TOGETHER * WIDTH).zip(all_im.chunks_mut(TOGETHER * WIDTH));
        for (residues, (own_re, own_im)) in chunks.zip(parts) {
            let mut sums = [Lanes::ZERO; TOGETHER];
            for (gain, residues) in gains.iter().zip(residues) {
                for (sum, group) in sums.iter_mut().zip(residues) {
                    *sum = sum.plus(*gain, group);
                }
            }
            let own = own_re.chunks_mut(WIDTH).zip(own_im.chunks_mut(WIDTH));
            for ((own_re, own_im), sum) in own.zip(&sums) {
                let (re, im) = sum.parts();
                own_re.copy_from_slice(&re[..own_re.len()]);
                own_im.copy_from_slice(&im[..own_im.len()]);
            }
        }
        (all_re, all_im)
    }
}
