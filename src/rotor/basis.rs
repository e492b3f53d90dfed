//! Reduced coordinates of one plane: kept modes, and what the cut ones still do.
//!
//! x_p = Σ_k φ_pk q_k,  q̈_k + … + ω_k² q_k = Σ_p φ_pk f_p, plus for the cut modes either their static flexibility R_pq
//! = Σ_cut φ_pk φ_qk/ω_k², or pseudo-modes: Ritz vectors u_q = Σ_cut φ_k φ_qk/ω_k² of every port q, mass-normalised
//! (MacNeal 1971, Rubin 1975), and of the gyroscopic moments of the low modes. With pseudo-modes the error falls with
//! the fourth power of frequency over the first cut mode.

use super::RotorError;
use super::modes::{PlanarModes, RIGID};
use crate::linalg::{Mat, definite_eigen, symmetric_eigen};

/// What stands for the modes that are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// Nothing.
    Dropped,
    /// Their static flexibility between the ports.
    StaticResidual,
    /// Pseudo-modes, one for each independent port and for the gyroscopic moment of each low mode.
    PseudoModes,
}

/// Reduced coordinates with the amplitudes at the ports.
#[derive(Clone, Debug)]
pub struct Basis {
    /// Angular frequencies, rad/s: two zeros, kept flexible modes, pseudo-modes.
    pub omega_rad_s: Vec<f64>,
    /// Number of true flexible modes among them.
    pub flexible: usize,
    /// Amplitudes, ports × coordinates.
    pub ports: Mat<f64>,
    /// Static flexibility of the cut modes, ports × ports, m/N; zero unless asked for.
    pub residual_m_per_n: Mat<f64>,
    /// Gyroscopic matrix in these coordinates, per rad/s.
    pub gyroscopic: Mat<f64>,
}

impl Basis {
    /// Keeps `flexible` modes of `modes` for the given port rows (amplitudes over all modes, see
    /// [`PlanarModes::amplitudes`]).
    ///
    /// # Errors
    /// [`RotorError::Numeric`] when an eigenvalue iteration fails.
    pub fn new(modes: &PlanarModes, ports: &[Vec<f64>], flexible: usize, cut: Cut) -> Result<Self, RotorError> {
        let (n, p) = (modes.len(), ports.len());
        let kept = (RIGID + flexible).min(n);
        let omega = &modes.omega_rad_s;
        let mut residual_m_per_n = Mat::zeros(p, p);
        if cut == Cut::StaticResidual {
            residual_m_per_n =
                Mat::from_fn(p, p, |i, j| (kept..n).map(|k| ports[i][k] * ports[j][k] / (omega[k] * omega[k])).sum());
        }
        // Combination of the modes that each coordinate is, modes × coordinates.
        let mut combination = Mat::from_fn(n, kept, |k, j| f64::from(u8::from(k == j)));
        let mut omega_rad_s = omega[..kept].to_vec();
        if cut == Cut::PseudoModes && kept < n {
            let mut loads = ports.to_vec();
            loads.extend(gyroscopic_loads(modes));
            let (vectors, frequencies) = pseudo_modes(modes, &loads, kept)?;
            let extra = vectors.ncols();
            combination = Mat::from_fn(n, kept + extra, |k, j| {
                if j < kept {
                    combination[(k, j)]
                } else if k < kept {
                    0.0
                } else {
                    vectors[(k - kept, j - kept)]
                }
            });
            omega_rad_s.extend(frequencies);
        }
        let shapes = &modes.shapes * &combination;
        let gyroscopic = shapes.transpose() * (&modes.matrices.gyroscopic * &shapes);
        let amplitudes = Mat::from_fn(p, n, |i, k| ports[i][k]);
        Ok(Self { omega_rad_s, flexible: kept - RIGID, ports: amplitudes * combination, residual_m_per_n, gyroscopic })
    }

    /// Number of coordinates of a plane.
    pub fn len(&self) -> usize {
        self.omega_rad_s.len()
    }

    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.omega_rad_s.is_empty()
    }
}

/// Lowest flexible modes whose gyroscopic moments get a Ritz vector of their own.
const GYROSCOPIC_MODES: usize = 5;

/// Modal amplitudes of the gyroscopic moments of the low modes (the tilting one and the first flexible ones): at speed
/// they load the cut modes all along the shaft, not only at the ports.
fn gyroscopic_loads(modes: &PlanarModes) -> Vec<Vec<f64>> {
    let n = modes.len();
    let low = modes.shapes.subcols(0, (RIGID + GYROSCOPIC_MODES).min(n));
    let loads = modes.shapes.transpose() * (&modes.matrices.gyroscopic * low);
    // Translation turns nothing.
    let columns = 1..loads.ncols();
    columns.map(|k| (0..n).map(|i| loads[(i, k)]).collect()).collect()
}

/// Orthonormal Ritz vectors in the space of the cut modes (cut modes × vectors) and their angular frequencies.
fn pseudo_modes(modes: &PlanarModes, loads: &[Vec<f64>], kept: usize) -> Result<(Mat<f64>, Vec<f64>), RotorError> {
    let cut = modes.len() - kept;
    let omega2 = |k: usize| modes.omega_rad_s[kept + k].powi(2);
    let mut columns: Vec<Vec<f64>> = vec![];
    for load in loads {
        let u: Vec<f64> = (0..cut).map(|k| load[kept + k] / omega2(k)).collect();
        let norm = u.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm > 0.0 {
            columns.push(u.iter().map(|x| x / norm).collect());
        }
    }
    let p = columns.len();
    let gram = Mat::from_fn(p, p, |i, j| columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum());
    let (values, directions) = symmetric_eigen(&gram)?;
    // Ports that coincide give the same vector; 1e-10 of a unit vector squared is still well above rounding.
    let used: Vec<usize> = (0..p).filter(|i| values[*i] > 1e-10).collect();
    let q = Mat::from_fn(cut, used.len(), |k, j| {
        let d = used[j];
        (0..p).map(|i| columns[i][k] * directions[(i, d)]).sum::<f64>() / values[d].sqrt()
    });
    let stiffness =
        Mat::from_fn(used.len(), used.len(), |i, j| (0..cut).map(|k| q[(k, i)] * omega2(k) * q[(k, j)]).sum());
    let ritz = definite_eigen(&stiffness, &(q.transpose() * &q))?;
    let frequencies = ritz.values.iter().map(|v| v.max(0.0).sqrt()).collect();
    Ok((q * ritz.vectors, frequencies))
}
