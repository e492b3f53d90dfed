//! A machine assembled at one speed in Ritz coordinates: the receptance of its ports at one signed frequency.
//!
//! In r = x + jy:  Z = diag(ω_k² − ω² + jω c_k − circ_k) + ωΩG,  X = Z⁻¹Φᵀ,  H = ΦX + housing, with the laws at ports
//! closed round it ([`super::feedback`]).

use super::channels::{IN, ON_HOUSING, OUT, Square, ZERO};
use super::damping::ModalDamping;
use super::feedback::{Feedback, PlaneLaw, close};
use super::gyroscopic::Gyroscopic;
use super::pairs::{over_coordinates, pairs};
use super::strain::Strain;
use crate::linalg::c64;
use crate::spindle::Effective;

/// A machine assembled at one speed: everything that does not depend on frequency.
#[derive(Clone, Debug)]
pub struct Assembled {
    pub(super) speed_rad_s: f64,
    pub(super) omega: Vec<f64>,
    pub(super) damping: ModalDamping,
    pub(super) dynamic: usize,
    pub(super) gyroscopic: Option<Gyroscopic>,
    /// Amplitudes, ports × coordinates.
    pub(super) ports: Vec<Vec<f64>>,
    /// Number of ports, the first ones, at which forces act: responses between two of the others are not computed.
    pub(super) driven: usize,
    /// Of each coordinate, its amplitudes at two ports multiplied, in the order of [`pairs`].
    pub(super) products: Vec<f64>,
    /// Constant receptance between ports, ports×ports; empty with the mesh of the model.
    pub(super) constant: Vec<f64>,
    /// Laws at ports.
    pub(super) feedback: Vec<Feedback>,
    /// Springs in one plane, open in [`PlanarLine`].
    pub(super) plane_laws: Vec<PlaneLaw>,
    pub(super) effective: Effective,
    pub(super) strain: Option<Strain>,
    pub(super) coupled: bool,
}

/// Closed receptance of the shaft at a line: sensors and tool from bearings and tool.
#[derive(Clone, Debug)]
pub struct Receptance {
    /// Forwards.
    pub plus: [c64; 9],
    /// Backwards, where that differs.
    pub minus: Option<[c64; 9]>,
    /// With x and y apart, where springs in one plane make them differ; the others leave such springs open.
    pub(super) planes: Option<Box<Square>>,
}

/// One signed frequency in the complex plane.
pub(crate) struct PlanarLine {
    /// X = Z⁻¹Φᵀ, dynamic coordinates × ports at which forces act.
    pub x: Vec<c64>,
    /// Number of ports at which forces act.
    driven: usize,
    /// Receptance with all loops closed, all ports × those at which forces act.
    closed: Vec<c64>,
}

impl PlanarLine {
    /// Entry of the closed receptance, which is symmetric, between two ports, at one of which forces act.
    pub(super) fn entry(&self, a: usize, b: usize) -> c64 {
        let (row, column) = if b < self.driven { (a, b) } else { (b, a) };
        self.closed[row * self.driven + column]
    }
}

impl Assembled {
    /// Number of ports; those of the probes are the last.
    pub fn ports(&self) -> usize {
        self.ports.len()
    }

    /// Negative stiffness, front and rear, N/m.
    pub(crate) fn negative_stiffness(&self) -> [f64; 2] {
        [0, 1].map(|b| self.effective.bearings[b].ks_n_per_m)
    }

    /// Whether springs in one plane make x and y differ.
    pub(crate) fn has_plane_laws(&self) -> bool {
        !self.plane_laws.is_empty()
    }

    /// Whether x and y are coupled.
    pub(crate) fn is_coupled(&self) -> bool {
        self.coupled
    }

    /// Speed as gyroscopic moments count it, rad/s.
    pub(super) fn turning_rad_s(&self) -> f64 {
        self.speed_rad_s * self.effective.gyroscopic_factor
    }

    /// The port of every feedback.
    pub(super) fn feedback_ports(&self) -> Vec<usize> {
        self.feedback.iter().map(|f| f.port).collect()
    }

    /// Force per displacement of every feedback, N/m.
    pub(super) fn gains(&self, w: f64) -> Vec<c64> {
        self.feedback.iter().map(|f| f.gain(w)).collect()
    }

    /// The 3×3 part between sensors, tool and magnets.
    pub(super) fn pick(&self, at: &PlanarLine) -> [c64; 9] {
        std::array::from_fn(|k| at.entry(OUT[k / 3], IN[k % 3]))
    }

    /// (ω_k² − ω² + jωc_k − circ_k)⁻¹ of all coordinates, real and imaginary parts apart.
    fn inverses(&self, w: f64) -> (Vec<f64>, Vec<f64>) {
        let damping = self.damping.total.iter().zip(&self.damping.circulatory);
        let both = self.omega.iter().zip(damping);
        both.map(|(omega, (total, circulatory))| {
            let (re, im) = (omega * omega - w * w, w * total - circulatory);
            let norm = re * re + im * im;
            (re / norm, -im / norm)
        })
        .unzip()
    }

    pub(super) fn planar(&self, w: f64) -> PlanarLine {
        let (ports, p) = (self.ports.len(), self.driven);
        let diagonal = |k: usize| {
            c64::new(self.omega[k] * self.omega[k] - w * w, w * self.damping.total[k] - self.damping.circulatory[k])
        };
        let inverses = self.inverses(w);
        let d = self.dynamic;
        let mut x = vec![ZERO; d * p];
        match &self.gyroscopic {
            None => {
                for (k, x) in x.chunks_mut(p).enumerate() {
                    let inverse = c64::new(inverses.0[k], inverses.1[k]);
                    for (x, port) in x.iter_mut().zip(&self.ports) {
                        *x = inverse * port[k];
                    }
                }
            }
            Some(g) => x = g.solve(w, d, &self.ports[..p], &diagonal),
        }
        let mut h = vec![ZERO; ports * p];
        for (row, constant) in h.chunks_mut(p).zip(self.constant.chunks(ports)) {
            for (h, c) in row.iter_mut().zip(constant) {
                *h += c;
            }
        }
        if let Some(g) = &self.gyroscopic {
            for (k, x) in x.chunks(p).enumerate() {
                for (i, row) in h.chunks_mut(p).enumerate() {
                    let a = self.ports[i][k] - w * g.factor * g.ports[k * ports + i];
                    // The rest follows from symmetry.
                    for (h, x) in row.iter_mut().zip(x).take(i + 1) {
                        *h += x * a;
                    }
                }
            }
        }
        // Coordinates that are not coupled.
        let alone = if self.gyroscopic.is_some() { d } else { 0 };
        let count = pairs(ports, p).count();
        let own = inverses.0.into_iter().zip(inverses.1).skip(alone);
        let (re, im) = over_coordinates(&self.products[alone * count..], own, count);
        let parts = re.into_iter().zip(im);
        for ((i, j), (re, im)) in pairs(ports, p).zip(parts) {
            h[i * p + j] += c64::new(re, im);
        }
        for housing in &self.effective.housings {
            let own = housing.omega_rad_s;
            let z = c64::new(own * own - w * w, 2.0 * housing.damping_ratio * own * w) * housing.mass_kg;
            for i in ON_HOUSING {
                for j in ON_HOUSING.start..=i {
                    h[i * p + j] += z.inv();
                }
            }
        }
        for i in 0..p {
            for j in i + 1..p {
                h[i * p + j] = h[j * p + i];
            }
        }
        PlanarLine { x, driven: p, closed: close(&h, p, &self.feedback_ports(), &self.gains(w)) }
    }
}
