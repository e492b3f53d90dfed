//! The magnetically levitated shaft without electronics, in the complex coordinate r = x + jy, at one speed.
//!
//! η̈ + (C − jΩG) η̇ + (K − jK_c) η = Φᵀ f,  x_p = φ_p η + Σ_q R_pq f_q, with η the modal coordinates of [`Basis`] and
//! one more for each housing mode. C is diagonal (2ζω, plus βω² of rotating damping), K = diag ω², K_c = Ωβ diag ω².
//! Magnets, springs to ground and circulatory forces are feedback at ports: f_p = g_p x_p + d_p ẋ_p, g complex. What
//! does not keep both planes alike acts on currents and signals (cross terms of ki, turned sensors), see
//! [`super::plant`], or is a spring in one plane, whose port stands open here and is closed there.

use super::SpindleError;
use super::band::sweep_end_rad_s;
use super::correction::{LawSite, PlacedLaw};
use super::effective::{Attachment, Effective, FeedbackLaw, Motion};
use super::machine::Machine;
use super::model_detail::ModelDetail;
use super::open_receptance::{Coordinates, OpenReceptance};
use super::response::damping::ModalDamping;
use super::response::feedback::{Feedback, PlaneLaw, close, laws_in_one_plane, list_attached};
use super::response::pairs::whole;
use super::whirl_form::WhirlModes;
use crate::linalg::{Mat, c64, solve_complex};
use crate::lti::partial_fractions::PartialFractions;
use crate::rotor::basis::Cut;
use crate::rotor::modes::RIGID;
use crate::rotor::{Basis, PlanarModes, Rotor};
use std::sync::{Arc, OnceLock};

/// Ports of the shaft that are found by name. Front and rear actuator plane are 3 and 4; those after
/// [`NAMED`] belong to effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub(crate) enum Port {
    /// Control force of the front bearing, its reaction on the housing.
    FrontControl = 0,
    /// Control force of the rear bearing.
    RearControl = 1,
    /// Tool plane.
    Tool = 2,
    /// Front sensor plane relative to the housing.
    FrontSensor = 5,
    /// Rear sensor plane relative to the housing.
    RearSensor = 6,
}

const NAMED: usize = 7;

/// Modes below this stay in [`ModelDetail::Full`], in ends of a sweep; pseudo-modes of the ports stand for the rest.
/// The error grows with the fourth power of f/f_cut: measured against the FE matrices, on a machine with a cut at
/// 24 kHz, 1e-6 at 3.4 kHz, 1.2e-5 beside an antiresonance at 4 kHz.
const FULL_BELOW: f64 = 6.0;
/// At least so many flexible modes stay in [`ModelDetail::Full`].
const FULL_AT_LEAST: usize = 8;

/// Lowest angular frequency at which a free rigid mode is evaluated, rad/s: at zero its compliance is infinite. The
/// closed magnet loop hides the difference to 1e-7.
const RIGID_FLOOR_RAD_S: f64 = 0.1;

/// A force −Δ(s) x against the displacement of a port.
#[derive(Clone, Debug)]
pub(crate) struct ShaftLaw {
    /// Port that the law reads and acts at.
    pub port: usize,
    /// Δ, N/m.
    pub law: PartialFractions,
}

/// The shaft on its magnets at one speed, one complex plane.
#[derive(Clone, Debug)]
pub(crate) struct Mechanics {
    omega_rad_s: Vec<f64>,
    /// Flexible modes that are true modes of the free-free shaft.
    flexible: usize,
    damping: ModalDamping,
    /// Ω × factor × G; `None` when zero.
    gyroscopic: Option<Mat<f64>>,
    ports: Mat<f64>,
    residual: Mat<f64>,
    feedback: Vec<Feedback>,
    /// Springs in one plane, open here.
    plane_laws: Vec<PlaneLaw>,
    /// Laws with poles, closed in the receptance and open for a realisation.
    shaft_laws: Vec<ShaftLaw>,
    /// Made when a response is first asked for.
    open: OnceLock<OpenReceptance>,
    /// Whirl modes, which do not depend on the ports: the same for this shaft at any of them.
    whirl: Arc<OnceLock<Option<WhirlModes>>>,
}

/// The shaft as complex second-order matrices between its named ports and those of springs in one plane, s in number;
/// feedback closed, these springs open.
#[derive(Clone, Debug)]
pub(crate) struct ClosedMatrices {
    /// Stiffness with magnets, n×n.
    pub k: Mat<c64>,
    /// Damping with gyroscopics, n×n.
    pub c: Mat<c64>,
    /// Forces (front control, rear control, tool, front and rear actuator, springs) to η̈, n×(5 + s).
    pub b: Mat<c64>,
    /// η to displacements (front, rear sensor, tool, front and rear actuator, springs), (5 + s)×n.
    pub c_out: Mat<c64>,
    /// Feedthrough, (5 + s)×(5 + s).
    pub d: Mat<c64>,
}

impl Mechanics {
    /// The shaft of a machine at a speed.
    pub(crate) fn new(
        machine: &Machine,
        effective: &Effective,
        speed_rad_s: f64,
        detail: ModelDetail,
    ) -> Result<Self, SpindleError> {
        let rotor = machine.rotor()?;
        let modes = PlanarModes::new(&rotor)?;
        let Ports { rows, mut feedback, plane_laws, shaft_laws } = Ports::new(machine, effective, &rotor, &modes)?;
        let (flexible, cut) = match detail {
            ModelDetail::Full => {
                let flexible = &modes.omega_rad_s[RIGID..];
                let cut_rad_s = FULL_BELOW * sweep_end_rad_s(machine, flexible);
                let below = flexible.iter().take_while(|w| **w < cut_rad_s).count();
                (below.max(FULL_AT_LEAST), Cut::PseudoModes)
            }
            ModelDetail::Modes { flexible, static_residual: true } => (flexible, Cut::StaticResidual),
            ModelDetail::Modes { flexible, .. } => (flexible, Cut::Dropped),
        };
        let basis = Basis::new(&modes, &rows, flexible, cut)?;
        let (n, p) = (basis.len(), rows.len());
        let housings = &effective.housings;
        let size = n + housings.len();
        let mut omega_rad_s = basis.omega_rad_s.clone();
        let zeta = |k: usize| machine.damping_ratio(k);
        let mut damping = ModalDamping::new(&omega_rad_s, zeta, effective.loss_time_s, speed_rad_s);
        for housing in housings {
            omega_rad_s.push(housing.omega_rad_s);
            damping.push(2.0 * housing.damping_ratio * housing.omega_rad_s);
        }
        let relative = [
            Port::FrontControl as usize,
            Port::RearControl as usize,
            Port::FrontSensor as usize,
            Port::RearSensor as usize,
        ];
        let ports = Mat::from_fn(p, size, |i, k| {
            if k < n {
                basis.ports[(i, k)]
            } else if relative.contains(&i) {
                -housings[k - n].mass_kg.sqrt().recip()
            } else {
                0.0
            }
        });
        // A dashpot reads the kept modes only: through the residual it would turn into a derivative of the force.
        let laws = feedback.iter().map(|f| (f.law, f.port)).chain(plane_laws.iter().map(|l| (l.law, l.port)));
        let damped: Vec<usize> = laws.filter(|(law, _)| *law == FeedbackLaw::Dashpot).map(|(_, port)| port).collect();
        let residual = Mat::from_fn(p, p, |i, j| {
            if damped.contains(&i) || damped.contains(&j) { 0.0 } else { basis.residual_m_per_n[(i, j)] }
        });
        feedback.retain(|f| f.value != 0.0);
        let factor = speed_rad_s * effective.gyroscopic_factor;
        let gyroscopic = (factor != 0.0).then(|| {
            Mat::from_fn(size, size, |i, j| if i < n && j < n { factor * basis.gyroscopic[(i, j)] } else { 0.0 })
        });
        Ok(Self {
            omega_rad_s,
            flexible: basis.flexible,
            damping,
            gyroscopic,
            ports,
            residual,
            feedback,
            plane_laws,
            shaft_laws,
            open: OnceLock::new(),
            whirl: Arc::default(),
        })
    }

    /// Angular frequencies of all coordinates, rad/s: two rigid, true flexible modes, pseudo-modes, housing.
    pub(crate) fn omega_rad_s(&self) -> &[f64] {
        &self.omega_rad_s
    }

    /// Number of true flexible modes, which follow the two rigid ones.
    pub(crate) fn flexible(&self) -> usize {
        self.flexible
    }

    /// The same shaft with one more port for each of the first `modes` coordinates behind the two rigid ones, in their
    /// order: a force on η̈ of the mode, read as its η.
    #[must_use]
    pub(crate) fn with_modal_ports(&self, modes: usize) -> Self {
        let (p, n) = (self.ports.nrows(), self.omega_rad_s.len());
        let m = modes.min(self.flexible);
        let old = |i: usize, j: usize| i < p && j < p;
        Self {
            ports: Mat::from_fn(p + m, n, |i, k| {
                if i < p { self.ports[(i, k)] } else { f64::from(u8::from(k == RIGID + i - p)) }
            }),
            residual: Mat::from_fn(p + m, p + m, |i, j| if old(i, j) { self.residual[(i, j)] } else { 0.0 }),
            open: OnceLock::new(),
            ..self.clone()
        }
    }

    /// The same shaft with the natural frequencies of the first flexible modes multiplied by these factors: their modal
    /// stiffness changes by the square, masses, shapes and dampers stay.
    #[must_use]
    pub(crate) fn with_scaled_modes(&self, factors: &[f64]) -> Self {
        let mut scaled = self.clone();
        (scaled.open, scaled.whirl) = (OnceLock::new(), Arc::default());
        let flexible = scaled.omega_rad_s.iter_mut().skip(RIGID);
        for (omega, factor) in flexible.take(self.flexible).zip(factors) {
            *omega *= factor;
        }
        scaled
    }

    /// The springs in one plane, which [`Self::receptance`] and [`Self::close_loop`] leave open.
    pub(crate) fn plane_laws(&self) -> &[PlaneLaw] {
        &self.plane_laws
    }

    /// The laws with poles, which [`Self::close_loop`] leaves open.
    pub(crate) fn shaft_laws(&self) -> &[ShaftLaw] {
        &self.shaft_laws
    }

    /// True when the two planes do not couple, so that the response at −ω is the conjugate of that at ω; springs in one
    /// plane, which stand outside of it, do not count.
    pub(crate) fn planes_are_decoupled(&self) -> bool {
        self.gyroscopic.is_none()
            && self.damping.circulatory.iter().all(|c| *c == 0.0)
            && self.feedback.iter().all(|f| f.law != FeedbackLaw::Circulatory)
    }

    /// The same shaft seen at some of its ports, in this order, and at those of its feedback.
    #[must_use]
    pub(crate) fn at_ports(&self, ports: &[usize]) -> Self {
        let mut kept = ports.to_vec();
        for port in self.feedback.iter().map(|f| f.port).chain(self.shaft_laws.iter().map(|l| l.port)) {
            if !kept.contains(&port) {
                kept.push(port);
            }
        }
        let number = |port: usize| kept.iter().position(|p| *p == port);
        let laws = self.shaft_laws.iter().filter_map(|l| number(l.port).map(|port| ShaftLaw { port, ..l.clone() }));
        let feedback = self.feedback.iter().filter_map(|f| number(f.port).map(|port| Feedback { port, ..*f }));
        let (p, n) = (kept.len(), self.omega_rad_s.len());
        Self {
            ports: Mat::from_fn(p, n, |i, k| self.ports[(kept[i], k)]),
            residual: Mat::from_fn(p, p, |i, j| self.residual[(kept[i], kept[j])]),
            feedback: feedback.collect(),
            shaft_laws: laws.collect(),
            plane_laws: vec![],
            open: OnceLock::new(),
            ..self.clone()
        }
    }

    /// The same shaft for a few frequencies: its equations are solved at each, which costs less than whirl modes that
    /// serve many.
    #[must_use]
    pub(crate) fn for_few_frequencies(self) -> Self {
        let open = match self.gyroscopic {
            Some(_) => OnceLock::from(OpenReceptance::Equations),
            None => OnceLock::new(),
        };
        Self { open, ..self }
    }

    pub(crate) fn ports(&self) -> usize {
        self.ports.nrows()
    }

    /// [`Self::receptance`] forwards, and backwards where that is not its conjugate.
    pub(crate) fn both_ways(&self, omega_rad_s: f64) -> (Vec<c64>, Option<Vec<c64>>) {
        let backward = !self.planes_are_decoupled();
        (self.receptance(omega_rad_s), backward.then(|| self.receptance(-omega_rad_s)))
    }

    /// Complex receptance between all ports at a signed angular frequency (ω < 0: backward), magnets closed, row-major.
    pub(crate) fn receptance(&self, omega_rad_s: f64) -> Vec<c64> {
        let p = self.ports();
        let w =
            if omega_rad_s.abs() < RIGID_FLOOR_RAD_S { RIGID_FLOOR_RAD_S.copysign(omega_rad_s) } else { omega_rad_s };
        let coordinates = Coordinates {
            omega_rad_s: &self.omega_rad_s,
            damping: &self.damping,
            gyroscopic: self.gyroscopic.as_ref(),
            ports: &self.ports,
            whirl: &self.whirl,
        };
        let form = self.open.get_or_init(|| coordinates.open_receptance());
        let mut open = whole(p, &coordinates.receptance(form, w));
        for (k, open) in open.iter_mut().enumerate() {
            *open += self.residual[(k / p, k % p)];
        }
        let ports: Vec<usize> =
            self.feedback.iter().map(|f| f.port).chain(self.shaft_laws.iter().map(|l| l.port)).collect();
        if ports.is_empty() {
            return open;
        }
        let gains = self.feedback.iter().map(|f| f.gain(w)).chain(self.shaft_laws.iter().map(|l| -l.law.at(w)));
        close(&open, p, &ports, &gains.collect::<Vec<c64>>())
    }

    /// Second-order matrices with the feedback closed, for a realisation.
    pub(crate) fn close_loop(&self) -> ClosedMatrices {
        let (n, m) = (self.omega_rad_s.len(), self.feedback.len());
        let f = &self.feedback;
        let real = |x: f64| c64::new(x, 0.0);
        // Springs and circulatory laws; a dashpot stands in the damping.
        let gains: Vec<c64> = f.iter().map(|f| f.gain(0.0)).collect();
        let open = self.plane_laws.iter().map(|s| s.port).chain(self.shaft_laws.iter().map(|l| l.port));
        let springs: Vec<usize> = open.collect();
        let inputs = [&[0usize, 1, 2, 3, 4], springs.as_slice()].concat();
        let outputs = [&[5usize, 6, 2, 3, 4], springs.as_slice()].concat();
        let count = inputs.len();
        // κT with T = (I − R_ff κ)⁻¹: forces of the feedback ports from their modal displacements.
        let unit = Mat::from_fn(m, m, |i, j| {
            let own = f64::from(u8::from(i == j));
            real(own) - gains[j] * self.residual[(f[i].port, f[j].port)]
        });
        let t = solve_complex(&unit, &Mat::identity(m, m));
        let force = Mat::from_fn(m, m, |i, j| gains[i] * t[(i, j)]);
        let phi_f = Mat::from_fn(m, n, |i, k| real(self.ports[(f[i].port, k)]));
        let r_fu = Mat::from_fn(m, count, |i, j| real(self.residual[(f[i].port, inputs[j])]));
        let r_yf = Mat::from_fn(count, m, |i, j| real(self.residual[(outputs[i], f[j].port)]));
        let on_modes = phi_f.transpose() * &force;
        let magnets = &on_modes * &phi_f;
        let (b_extra, c_extra) = (&on_modes * &r_fu, &r_yf * (&force * &phi_f));
        let d_extra = &r_yf * (&force * &r_fu);
        ClosedMatrices {
            k: Mat::from_fn(n, n, |i, j| {
                let own = if i == j {
                    c64::new(self.omega_rad_s[i].powi(2), -self.damping.circulatory[i])
                } else {
                    real(0.0)
                };
                own - magnets[(i, j)]
            }),
            c: Mat::from_fn(n, n, |i, j| {
                let own = if i == j { self.damping.total[i] } else { 0.0 };
                let dashpots: f64 = f
                    .iter()
                    .filter(|f| f.law == FeedbackLaw::Dashpot)
                    .map(|f| f.value * self.ports[(f.port, i)] * self.ports[(f.port, j)])
                    .sum();
                let turn = self.gyroscopic.as_ref().map_or(0.0, |g| g[(i, j)]);
                c64::new(own + dashpots, -turn)
            }),
            b: Mat::from_fn(n, count, |k, j| b_extra[(k, j)] + self.ports[(inputs[j], k)]),
            c_out: Mat::from_fn(count, n, |i, k| c_extra[(i, k)] + self.ports[(outputs[i], k)]),
            d: Mat::from_fn(count, count, |i, j| d_extra[(i, j)] + self.residual[(outputs[i], inputs[j])]),
        }
    }
}

/// Amplitudes of all ports over all modes, and what acts at them.
struct Ports {
    rows: Vec<Vec<f64>>,
    feedback: Vec<Feedback>,
    plane_laws: Vec<PlaneLaw>,
    shaft_laws: Vec<ShaftLaw>,
}

impl Ports {
    fn new(machine: &Machine, effective: &Effective, rotor: &Rotor, modes: &PlanarModes) -> Result<Self, SpindleError> {
        let at =
            |what: &str, z: f64| -> Result<Vec<f64>, SpindleError> { Ok(modes.amplitudes(&rotor.shape_at(what, z)?)) };
        let [front, rear] = &effective.bearings;
        let (front_actuator, rear_actuator) =
            (at("front actuator", front.actuator_m)?, at("rear actuator", rear.actuator_m)?);
        let mut rows = vec![
            front_actuator.clone(),
            rear_actuator.clone(),
            at("tool plane", machine.tool_plane_m())?,
            front_actuator,
            rear_actuator,
            at("front sensor", front.sensor_m)?,
            at("rear sensor", rear.sensor_m)?,
        ];
        debug_assert_eq!(rows.len(), NAMED);
        let magnet = |port: Port, ks_n_per_m: f64| Feedback {
            port: port as usize,
            law: FeedbackLaw::Spring,
            value: -ks_n_per_m,
        };
        let mut feedback =
            vec![magnet(Port::FrontControl, front.ks_n_per_m), magnet(Port::RearControl, rear.ks_n_per_m)];
        for attachment in list_attached(effective) {
            let Attachment { position_m: z, law, value, .. } = *attachment;
            let (row, value) = match attachment.motion {
                Motion::Displacement => (at("attachment", z)?, value),
                Motion::Slope => {
                    let tilt = rotor.tilt_at("attachment", z)?;
                    let dofs = rotor.element_dofs(tilt.element);
                    let row: Vec<(usize, f64)> = dofs.into_iter().zip(tilt.row).collect();
                    (modes.amplitudes(&row), tilt.seen_stiffness(value))
                }
            };
            feedback.push(Feedback { port: rows.len(), law, value });
            rows.push(row);
        }
        for ([a, b], joint) in rotor.joints() {
            if joint.damping_n_m_s_per_rad != 0.0 {
                feedback.push(Feedback {
                    port: rows.len(),
                    law: FeedbackLaw::Dashpot,
                    value: joint.damping_n_m_s_per_rad,
                });
                rows.push(modes.amplitudes(&[(2 * a + 1, 1.0), (2 * b + 1, -1.0)]));
            }
        }
        let plane_laws = laws_in_one_plane(effective, &mut rows, |z| at("attachment", z))?;
        let mut shaft_laws = vec![];
        for PlacedLaw { site, law } in &effective.laws {
            if let LawSite::Shaft(z) = site {
                shaft_laws.push(ShaftLaw { port: rows.len(), law: law.clone() });
                rows.push(at("correction", *z)?);
            }
        }
        Ok(Self { rows, feedback, plane_laws, shaft_laws })
    }
}
