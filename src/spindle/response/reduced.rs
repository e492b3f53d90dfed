//! A machine whose shaft stands in Ritz coordinates, rigid and with a joint at the nose.

use super::moved_shaft::Recent;
use super::parameters::MachineParameters;
use super::ritz::ReducedShaft;
use crate::spindle::{Effect, Effective, Machine, SpindleError};
use std::sync::OnceLock;

/// The base machine in reduced coordinates, rigid and with a joint at the nose.
#[derive(Clone, Debug)]
pub struct ReducedMachine {
    /// The machine as given.
    pub machine: Machine,
    /// The parameters that responses are differentiated to.
    pub parameters: MachineParameters,
    pub(super) rigid: ReducedShaft,
    /// Made when an effect needs it: most machines are only compared as they are.
    jointed: OnceLock<Result<ReducedShaft, SpindleError>>,
    /// Shafts with parameters that were assembled last.
    pub(super) recent: Recent,
}

impl ReducedMachine {
    /// Reduces a machine.
    ///
    /// # Errors
    /// [`SpindleError`] when the machine breaks a rule or an eigenvalue iteration fails.
    pub fn new(machine: &Machine) -> Result<Self, SpindleError> {
        let parameters = MachineParameters::new(machine);
        let group = &parameters.group_of_element;
        Ok(Self {
            machine: machine.clone(),
            rigid: ReducedShaft::new(machine, group, false)?,
            jointed: OnceLock::new(),
            recent: Recent::default(),
            parameters,
        })
    }

    /// The shaft with a joint at the nose.
    pub(super) fn joint_shaft(&self) -> Result<&ReducedShaft, SpindleError> {
        let groups = &self.parameters.group_of_element;
        let made = self.jointed.get_or_init(|| ReducedShaft::new(&self.machine, groups, true));
        made.as_ref().map_err(Clone::clone)
    }

    /// Bearings and electronics alone, for effects that leave the shaft as it is.
    pub fn effective(&self, p: &[f64], effects: &[Effect]) -> Effective {
        self.move_machine(p, effects).effective()
    }

    /// The machine with further effects.
    pub(super) fn with(&self, effects: &[Effect]) -> Machine {
        let mut machine = self.machine.clone();
        machine.spindle.effects.extend_from_slice(effects);
        machine
    }

    /// The same with bearings moved by the parameters `p`.
    pub(super) fn move_machine(&self, p: &[f64], effects: &[Effect]) -> Machine {
        self.parameters.bearings(&self.with(effects), p)
    }

    /// First and last position on the shaft, m.
    pub fn span_m(&self) -> (f64, f64) {
        self.rigid.span_m()
    }

    /// Inertia against a force at a position, fast enough that only the coordinates of the model move, kg.
    ///
    /// # Errors
    /// [`SpindleError`] for a position off the shaft.
    pub fn inertia_kg(&self, position_m: f64, jointed: bool) -> Result<f64, SpindleError> {
        let shaft = if jointed { self.joint_shaft()? } else { &self.rigid };
        let row = shaft.row(position_m)?;
        Ok(row.iter().map(|a| a * a).sum::<f64>().recip())
    }

    /// Natural frequencies of the nominal shaft's flexible modes, rad/s.
    pub fn flexible_rad_s(&self) -> &[f64] {
        &self.rigid.flexible_rad_s
    }

    /// Modulus groups that a region has.
    pub(crate) fn groups_of(&self, region: &str) -> Vec<usize> {
        let tool = self.machine.tool.sections.iter().rev();
        let sections = tool.chain(&self.machine.spindle.sections);
        let mut groups: Vec<usize> = sections
            .zip(&self.parameters.group_of_element)
            .filter(|(s, _)| s.region.as_deref() == Some(region))
            .map(|(_, g)| *g)
            .collect();
        groups.sort_unstable();
        groups.dedup();
        groups
    }
}
