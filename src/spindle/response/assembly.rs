//! Assembly of a reduced machine at a speed, for parameters and further effects.
//!
//! Modes far above the band answer as springs in the derivatives and in the gyroscopic coupling.
//!
//! A finer mesh, Z − sω⁴C, is brought back to mass and stiffness: −λ²C = −(K−λ)C(K−λ) + KCK − λ(KC+CK), whose first
//! part is a constant receptance and whose rest is a change of coordinates: with T = (1 + sKC)⁻¹ the stiffness is TK,
//! ports are T b, and s bᵀCTb is added.

use super::assembled::Assembled;
use super::damping::ModalDamping;
use super::feedback::{Feedback, PlaneLaw, laws_in_one_plane, list_attached};
use super::gyroscopic::Gyroscopic;
use super::moved_shaft::{Move, MovedShaft};
use super::pairs::products;
use super::probe::Probe;
use super::reduced::ReducedMachine;
use super::ritz::ReducedShaft;
use super::shaft_modes::Modes;
use super::strain::Strain;
use crate::linalg::Mat;
use crate::rotor::modes::RIGID;
use crate::spindle::band::sweep_end_rad_s;
use crate::spindle::effective::{Attachment, FeedbackLaw, Motion};
use crate::spindle::{Effect, EffectKind, Effective, Location, Machine, SpindleError};
use std::borrow::Cow;

/// Modes up to here, in ends of a sweep, are dynamic in derivatives and gyroscopic coupling, those above follow as
/// springs.
const DYNAMIC: f64 = 6.0;
/// Modes up to here couple with each other gyroscopically, those between couple with these.
const COUPLED: f64 = 3.0;

/// What is assembled, and for what.
#[derive(Clone, Copy, Debug, Default)]
pub struct Assembly<'a> {
    /// Effects beside those of the machine.
    pub effects: &'a [Effect],
    /// Speed, rad/s.
    pub speed_rad_s: f64,
    /// Whether derivatives to moduli and mesh are wanted.
    pub derivatives: bool,
    /// Whether added masses act as forces at their ports round the modes without them, which leaves them the damping of
    /// those modes: many masses then share one eigenvalue problem.
    pub masses_at_ports: bool,
    /// Further ports.
    pub further: &'a [Probe],
    /// Ports behind those, of which the responses between one and another are not needed.
    pub probes: &'a [Probe],
}

/// Rows of all ports over the Ritz coordinates, and the laws at them.
struct Ports {
    rows: Vec<Vec<f64>>,
    feedback: Vec<Feedback>,
    plane_laws: Vec<PlaneLaw>,
}

impl ReducedMachine {
    /// Assembles the machine with parameters `p` (see `parameters`) and further effects.
    ///
    /// # Errors
    /// [`SpindleError`] when an effect leaves the shaft or an eigenvalue iteration fails.
    pub fn assemble(&self, p: &[f64], assembly: Assembly) -> Result<Assembled, SpindleError> {
        let (parameters, effects) = (&self.parameters, assembly.effects);
        let machine = self.move_machine(p, effects);
        let effective = machine.effective();
        let joint = effects.iter().find(|e| e.kind == EffectKind::ToolJoint);
        let shaft = match joint {
            Some(_) => self.joint_shaft()?,
            None => &self.rigid,
        };
        let scale = self.modulus_factors(p, effects);
        let whole = Move { scale: &scale, joint, mesh: p[parameters.mesh()], effects };
        let at_ports = if assembly.masses_at_ports { whole.masses(shaft) } else { vec![] };
        let by = if at_ports.is_empty() { whole } else { Move { effects: &[], ..whole } };
        let moved = self.recent.shaft(shaft, by)?;
        let MovedShaft { modes, finer } = &*moved;
        let omega = &modes.omega;
        let end_rad_s = sweep_end_rad_s(&self.machine, self.flexible_rad_s());
        let below = |ends: f64| omega.iter().filter(|w| **w < ends * end_rad_s).count();
        let dynamic = below(DYNAMIC).clamp(RIGID + 4, shaft.len());
        let near = below(COUPLED).clamp(RIGID, dynamic);
        let zeta = |k: usize| machine.damping_ratio(k) * p[parameters.damping(k)].exp();
        let damping = ModalDamping::new(omega, zeta, effective.loss_time_s, assembly.speed_rad_s);
        let mut ports = self.ports(shaft, &machine, &effective, p)?;
        add_joint_damping(&mut ports, shaft, joint);
        for mass in &at_ports {
            ports.feedback.push(Feedback { port: ports.rows.len(), law: FeedbackLaw::Mass, value: mass.value });
            ports.rows.push(mass.row(shaft)?);
        }
        for probe in assembly.further.iter().chain(assembly.probes) {
            ports.rows.push(probe.row(shaft)?);
        }
        // Springs in one plane are closed between all ports.
        let driven =
            if ports.plane_laws.is_empty() { ports.rows.len() - assembly.probes.len() } else { ports.rows.len() };
        let constant = match finer {
            Some(finer) => finer.move_ports(shaft, &mut ports.rows)?,
            None => vec![],
        };
        let amplitudes = amplitudes(modes, &ports.rows);
        let speed_rad_s = assembly.speed_rad_s;
        let gyroscopic = if speed_rad_s == 0.0 {
            None
        } else {
            let matrix = with_discs(shaft, effects)?;
            let mut gyroscopic = Gyroscopic::new(speed_rad_s, &matrix, modes, &amplitudes, dynamic, near);
            gyroscopic.factor = effective.gyroscopic_factor;
            Some(gyroscopic)
        };
        let strain = assembly.derivatives.then(|| Strain::new(shaft, &scale, modes, &amplitudes[..driven], dynamic));
        let circulates = |f: &Feedback| f.law == FeedbackLaw::Circulatory && f.value != 0.0;
        let coupled = gyroscopic.is_some()
            || damping.circulatory.iter().any(|t| *t != 0.0)
            || ports.feedback.iter().any(circulates);
        Ok(Assembled {
            speed_rad_s,
            omega: modes.omega.clone(),
            damping,
            dynamic,
            gyroscopic,
            driven,
            products: products(&amplitudes, driven),
            ports: amplitudes,
            constant,
            feedback: ports.feedback,
            plane_laws: ports.plane_laws,
            effective,
            strain,
            coupled,
        })
    }

    /// Factor of the modulus of every group: the parameters, and the effects on regions.
    fn modulus_factors(&self, p: &[f64], effects: &[Effect]) -> Vec<f64> {
        let mut scale: Vec<f64> = (0..self.parameters.groups).map(|g| p[g].exp()).collect();
        let of_regions = effects.iter().filter(|e| e.kind == EffectKind::RegionStiffness);
        for effect in of_regions {
            if let (Location::Region(region), Some(factor)) = (&effect.location, effect.values.first()) {
                for group in self.groups_of(region) {
                    scale[group] *= factor;
                }
            }
        }
        scale
    }

    /// Tool, planes and attachments, with the laws at them. A plane between two nodes reads what the parameters say
    /// more.
    fn ports(
        &self,
        shaft: &ReducedShaft,
        machine: &Machine,
        effective: &Effective,
        p: &[f64],
    ) -> Result<Ports, SpindleError> {
        let mut rows = vec![shaft.row(machine.tool_plane_m())?];
        for (plane, z) in effective.planes_m().into_iter().enumerate() {
            let mut row = shaft.row(z)?;
            let share = p[self.parameters.reading(plane)];
            if share != 0.0
                && let Some(more) = shaft.misread(z)?
            {
                row.iter_mut().zip(&more).for_each(|(a, more)| *a += share * more);
            }
            rows.push(row);
        }
        let magnet = |(b, port): (usize, usize)| Feedback {
            port,
            law: FeedbackLaw::Spring,
            value: -effective.bearings[b].ks_n_per_m,
        };
        let mut feedback: Vec<Feedback> = [1, 2].into_iter().enumerate().map(magnet).collect();
        for attachment in list_attached(effective) {
            let Attachment { position_m: z, law, value, .. } = *attachment;
            let (row, value) = match attachment.motion {
                Motion::Displacement => (shaft.row(z)?, value),
                Motion::Slope => (shaft.tilt_row(z)?, shaft.tilt_at(z)?.seen_stiffness(value)),
            };
            feedback.push(Feedback { port: rows.len(), law, value });
            rows.push(row);
        }
        let plane_laws = laws_in_one_plane(effective, &mut rows, |z| shaft.row(z))?;
        Ok(Ports { rows, feedback, plane_laws })
    }
}

/// The gyroscopic matrix of a shaft with the discs that effects add.
///
/// # Errors
/// [`SpindleError`] for a disc off the shaft.
fn with_discs<'a>(shaft: &'a ReducedShaft, effects: &[Effect]) -> Result<Cow<'a, Mat<f64>>, SpindleError> {
    let mut matrix = Cow::Borrowed(&shaft.gyroscopic);
    for effect in effects.iter().filter(|e| e.kind == EffectKind::AddedDisc) {
        if let (Location::Position(z), Some(polar)) = (&effect.location, effect.values.get(1)) {
            let [row, _] = shaft.rotation_rows(*z)?;
            let sum = Mat::from_fn(shaft.len(), shaft.len(), |i, j| matrix[(i, j)] + polar * row[i] * row[j]);
            matrix = Cow::Owned(sum);
        }
    }
    Ok(matrix)
}

fn add_joint_damping(ports: &mut Ports, shaft: &ReducedShaft, joint: Option<&Effect>) {
    if let (Some(effect), Some([_, turning])) = (joint, &shaft.joint) {
        let value = effect.values.get(2).copied().unwrap_or_default();
        if value != 0.0 {
            ports.feedback.push(Feedback { port: ports.rows.len(), law: FeedbackLaw::Dashpot, value });
            ports.rows.push(turning.clone());
        }
    }
}

/// Amplitudes of the modes at ports, ports × modes.
fn amplitudes(modes: &Modes, rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = modes.omega.len();
    let modal = modes.shapes.transpose() * Mat::from_fn(n, rows.len(), |i, p| rows[p][i]);
    (0..rows.len()).map(|p| (0..n).map(|k| modal[(k, p)]).collect()).collect()
}
