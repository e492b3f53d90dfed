//! The plant of a hypothesis at one line, with its derivatives to the small parameters.
//!
//! In r = x + jy:  Z = diag(ω_k² − ω² + jω c_k − circ_k) + ωΩG,  X = Z⁻¹Φᵀ,  H = ΦX + housing,  magnets and added parts as
//! feedback at ports:  H_c = H + H_f κ (I − H_ff κ)⁻¹ H_f·.  With L = I + H_c κ the derivative to a stiffness is −(XLᵀ)ᵀ dK (XLᵀ).
//! The response F is 6×6: sensor signals and tool displacement (x, y) from commanded currents and tool force (x, y).
//! Modes far above the band answer as springs in the derivatives and in the gyroscopic coupling.
//!
//! A finer mesh, Z − sω⁴C, is brought back to mass and stiffness: −λ²C = −(K−λ)C(K−λ) + KCK − λ(KC+CK), whose first part is a constant
//! receptance and whose rest is a change of coordinates: with T = (1 + sKC)⁻¹ the stiffness is TK, ports are T b, and s bᵀCTb is added.

mod behind;
mod electronics;
mod finer;
mod gyroscopic;
pub mod law;
mod line;
pub mod port;
pub mod sensitivity;
mod shaft;
mod strain;

use super::DiagnoseError;
use super::nuisance::Layout;
use super::skeleton::Skeleton;
use crate::linalg::{Mat, c64};
use crate::rotor::modes::RIGID;
use crate::spindle::effective::{Housing, Motion};
use crate::spindle::{Effect, EffectKind, Location, Machine};
pub use electronics::Electronics;
use finer::Finer;
use gyroscopic::Gyroscopic;
use law::Law;
use line::Planar;
use port::Probe;
use shaft::{Modes, modes};
use std::f64::consts::TAU;
use strain::Strain;

/// Outputs and inputs of a line: four axes, tool x, tool y.
pub const SIDE: usize = 6;
/// Row-major 6×6 response.
pub type Square = [c64; SIDE * SIDE];
/// The response of nothing.
pub const ZERO: c64 = c64::new(0.0, 0.0);
/// Modes up to here are dynamic in derivatives and gyroscopic coupling, those above follow as springs, Hz: six times the end of a 4 kHz sweep.
const DYNAMIC_BELOW_HZ: f64 = 24_000.0;

const TOOL: usize = 0;
const OUT: [usize; 3] = [3, 4, TOOL];
const IN: [usize; 3] = [1, 2, TOOL];

/// The base machine in reduced coordinates, rigid and with a joint at the nose.
#[derive(Clone, Debug)]
pub struct Model {
    /// The machine as given.
    pub machine: Machine,
    /// The small parameters.
    pub layout: Layout,
    rigid: Skeleton,
    jointed: Skeleton,
}

/// A hypothesis assembled at one speed: everything that does not depend on frequency.
#[derive(Clone, Debug)]
pub struct Assembled {
    speed_rad_s: f64,
    omega: Vec<f64>,
    damping: Vec<f64>,
    turning: Vec<f64>,
    modal: Vec<f64>,
    dynamic: usize,
    gyroscopic: Option<Gyroscopic>,
    /// Amplitudes, ports × coordinates.
    ports: Vec<Vec<f64>>,
    /// Constant receptance between ports, ports×ports; empty with the mesh of the model.
    constant: Vec<f64>,
    /// Port, law, and how many units of it.
    feedback: Vec<(usize, Law, f64)>,
    housings: Vec<Housing>,
    electronics: Electronics,
    strain: Option<Strain>,
    coupled: bool,
}

/// Closed receptance of the shaft at a line: sensors and tool from bearings and tool.
#[derive(Clone, Copy, Debug)]
pub struct Receptance {
    plus: [c64; 9],
    /// Backwards, where that differs.
    minus: Option<[c64; 9]>,
}

/// F of a line and its derivatives to the logarithms of moduli, ks front, ks rear, ζ, and to the mesh, in that order.
#[derive(Clone, Debug)]
pub struct Line {
    /// What the shaft does to it.
    pub receptance: Receptance,
    /// F.
    pub response: Square,
    /// ∂F.
    pub derivatives: Vec<Square>,
}

impl Model {
    /// Reduces a machine.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the machine breaks a rule or an eigenvalue iteration fails.
    pub fn new(machine: &Machine, axis_gain_sd: &[[f64; 4]]) -> Result<Self, DiagnoseError> {
        let layout = Layout::new(machine, axis_gain_sd);
        Ok(Self {
            machine: machine.clone(),
            rigid: Skeleton::new(machine, &layout.group_of_element, false)?,
            jointed: Skeleton::new(machine, &layout.group_of_element, true)?,
            layout,
        })
    }

    /// The electronics alone, for effects that leave the shaft as it is.
    pub fn electronics(&self, p: &[f64], effects: &[Effect]) -> Electronics {
        Electronics::new(&self.moved(p, effects))
    }

    fn with(&self, effects: &[Effect]) -> Machine {
        let mut machine = self.machine.clone();
        machine.spindle.effects.extend_from_slice(effects);
        machine
    }

    fn moved(&self, p: &[f64], effects: &[Effect]) -> Machine {
        self.layout.bearings(&self.with(effects), p)
    }

    /// First and last position on the shaft, m.
    pub fn span_m(&self) -> (f64, f64) {
        self.rigid.span_m()
    }

    /// Inertia against a force at a position, fast enough that only the coordinates of the model move, kg.
    ///
    /// # Errors
    /// [`DiagnoseError`] for a position off the shaft.
    pub fn inertia_kg(&self, position_m: f64, jointed: bool) -> Result<f64, DiagnoseError> {
        let skeleton = if jointed { &self.jointed } else { &self.rigid };
        let row = skeleton.row(position_m)?;
        Ok(row.iter().map(|a| a * a).sum::<f64>().recip())
    }

    /// Natural frequencies of the nominal shaft's flexible modes, rad/s.
    pub fn flexible_rad_s(&self) -> &[f64] {
        &self.rigid.flexible_rad_s
    }

    /// Assembles small parameters `p` and added effects at a speed; `derivatives` prepares those of the moduli.
    ///
    /// # Errors
    /// [`DiagnoseError`] when an effect leaves the shaft or an eigenvalue iteration fails.
    pub fn assemble(
        &self,
        p: &[f64],
        effects: &[Effect],
        speed_rad_s: f64,
        derivatives: bool,
    ) -> Result<Assembled, DiagnoseError> {
        self.assemble_with(p, effects, speed_rad_s, derivatives, &[])
    }

    /// The same with further ports, for [`Assembled::ported`].
    ///
    /// # Errors
    /// As [`Self::assemble`].
    pub fn assemble_with(
        &self,
        p: &[f64],
        effects: &[Effect],
        speed_rad_s: f64,
        derivatives: bool,
        probes: &[Probe],
    ) -> Result<Assembled, DiagnoseError> {
        let layout = &self.layout;
        let machine = self.moved(p, effects);
        let electronics = Electronics::new(&machine);
        let effective = &electronics.effective;
        let joint = effects.iter().find(|e| e.kind == EffectKind::ToolJoint);
        let skeleton = if joint.is_some() {
            &self.jointed
        } else {
            &self.rigid
        };
        let n = skeleton.len();
        let mut scale: Vec<f64> = (0..layout.groups).map(|g| p[g].exp()).collect();
        for effect in effects
            .iter()
            .filter(|e| e.kind == EffectKind::RegionStiffness)
        {
            if let (Location::Region(region), Some(factor)) =
                (&effect.location, effect.values.first())
            {
                for group in self.groups_of(region) {
                    scale[group] *= factor;
                }
            }
        }
        let mut k = skeleton.stiffness.clone();
        for (group, scale) in skeleton.groups.iter().zip(&scale) {
            if *scale != 1.0 {
                for j in 0..n {
                    let column = k.col_as_slice_mut(j).iter_mut();
                    for (k, own) in column.zip(group.col_as_slice(j)) {
                        *k += (scale - 1.0) * own;
                    }
                }
            }
        }
        if let (Some(effect), Some(rows)) = (joint, &skeleton.joint) {
            for (row, value) in rows.iter().zip(&effect.values) {
                k = Mat::from_fn(n, n, |i, j| k[(i, j)] + value * row[i] * row[j]);
            }
        }
        let finer = Finer::new(skeleton, &mut k, p[layout.mesh()])?;
        let mut masses = vec![];
        for effect in effects {
            let value = effect.values.first().copied().unwrap_or_default();
            let z = match (effect.kind, &effect.location) {
                (EffectKind::ToolMass, _) => skeleton.span_m().0,
                (EffectKind::AddedMass, Location::Position(z)) => *z,
                _ => continue,
            };
            // No mass has no place: its derivative to the place is exactly none, not rounding.
            if value == 0.0 {
                continue;
            }
            let mut row = [skeleton.row(z)?];
            if let Some(finer) = &finer {
                finer.move_ports(&mut row)?;
            }
            let [row] = row;
            masses.push((row, value));
        }
        let Modes {
            omega,
            shapes: turned,
        } = modes(&k, &masses)?;
        let dynamic = omega
            .iter()
            .filter(|w| **w < TAU * DYNAMIC_BELOW_HZ)
            .count()
            .clamp(RIGID + 4, n);
        let mut modal = vec![0.0; n];
        let mut damping = vec![0.0; n];
        let mut turning = vec![0.0; n];
        for k in RIGID..n {
            let zeta = machine.damping_ratio(k - RIGID) * p[layout.damping(k - RIGID)].exp();
            modal[k] = 2.0 * zeta * omega[k];
            damping[k] = modal[k] + effective.loss_time_s * omega[k] * omega[k];
            turning[k] = speed_rad_s * effective.loss_time_s * omega[k] * omega[k];
        }
        let [front, rear] = &effective.bearings;
        let mut rows = vec![];
        rows.push(skeleton.row(machine.tool_plane_m())?);
        for (plane, z) in effective.planes_m().into_iter().enumerate() {
            let mut row = skeleton.row(z)?;
            let share = p[layout.reading(plane)];
            if share != 0.0
                && let Some(more) = skeleton.misread(z)?
            {
                row.iter_mut()
                    .zip(&more)
                    .for_each(|(a, more)| *a += share * more);
            }
            rows.push(row);
        }
        let ks = [front.ks_n_per_m, rear.ks_n_per_m];
        let mut feedback = vec![(1, Law::Spring, -ks[0]), (2, Law::Spring, -ks[1])];
        for attached in &effective.attachments {
            let z = attached.position_m;
            for (law, value) in Law::parts(attached.gain) {
                feedback.push((rows.len(), law, value));
                rows.push(match attached.motion {
                    Motion::Displacement => skeleton.row(z)?,
                    Motion::Slope => skeleton.slope_row(z)?,
                });
            }
        }
        if let (Some(effect), Some([_, turning])) = (joint, &skeleton.joint) {
            let c = effect.values.get(2).copied().unwrap_or_default();
            if c != 0.0 {
                feedback.push((rows.len(), Law::Dashpot, c));
                rows.push(turning.clone());
            }
        }
        for probe in probes {
            rows.push(probe.row(skeleton)?);
        }
        let mut constant = vec![];
        if let Some(finer) = &finer {
            constant = finer.move_ports(&mut rows)?;
        }
        let modal_ports = turned.transpose() * Mat::from_fn(n, rows.len(), |i, p| rows[p][i]);
        let ports: Vec<Vec<f64>> = (0..rows.len())
            .map(|p| (0..n).map(|k| modal_ports[(k, p)]).collect())
            .collect();
        let gyroscopic = (speed_rad_s != 0.0).then(|| {
            Gyroscopic::new(
                speed_rad_s,
                effective.gyroscopic_factor,
                &skeleton.gyroscopic,
                &turned,
                &omega,
                &ports,
                dynamic,
            )
        });
        let strain =
            derivatives.then(|| Strain::new(skeleton, &scale, &turned, &omega, &ports, dynamic));
        let coupled = gyroscopic.is_some()
            || turning.iter().any(|t| *t != 0.0)
            || feedback
                .iter()
                .any(|(_, law, value)| *law == Law::Circulatory && *value != 0.0);
        Ok(Assembled {
            speed_rad_s,
            housings: effective.housings.clone(),
            omega,
            damping,
            turning,
            modal,
            dynamic,
            gyroscopic,
            ports,
            constant,
            feedback,
            electronics,
            strain,
            coupled,
        })
    }

    /// Modulus groups that a region has.
    pub fn groups_of(&self, region: &str) -> Vec<usize> {
        let tool = self.machine.tool.sections.iter().rev();
        let sections = tool.chain(&self.machine.spindle.sections);
        let mut groups: Vec<usize> = sections
            .zip(&self.layout.group_of_element)
            .filter(|(s, _)| s.region.as_deref() == Some(region))
            .map(|(_, g)| *g)
            .collect();
        groups.sort_unstable();
        groups.dedup();
        groups
    }
}
