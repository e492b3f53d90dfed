//! The machine in reduced coordinates, with the nuisance parameters of the diagnosis.

use super::super::DiagnoseError;
use super::nuisance::Layout;
use crate::spindle::response::{Assembled, Assembly, ReducedMachine};
use crate::spindle::{Effect, Machine};

/// What answers for a hypothesis.
#[derive(Clone, Debug)]
pub struct Model {
    /// The response of the machine.
    pub reduced: ReducedMachine,
    /// The nuisance parameters with their priors.
    pub layout: Layout,
}

impl Model {
    /// Reduces a machine measured with sweeps whose axis gains scatter by `axis_gain_sd`.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the machine breaks a rule or an eigenvalue iteration fails.
    pub fn new(machine: &Machine, axis_gain_sd: &[[f64; 4]]) -> Result<Self, DiagnoseError> {
        let reduced = ReducedMachine::new(machine)?;
        Ok(Self {
            layout: Layout::new(reduced.parameters.clone(), axis_gain_sd),
            reduced,
        })
    }

    /// Assembles nuisance parameters `p` and further effects at a speed; `derivatives` prepares those of the moduli.
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
        let assembly = Assembly {
            effects,
            speed_rad_s,
            derivatives,
            probes: &[],
        };
        Ok(self.reduced.assemble(p, assembly)?)
    }
}
