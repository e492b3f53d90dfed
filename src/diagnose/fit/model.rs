//! The machine in reduced coordinates, with the nuisance parameters of the diagnosis.

use super::super::DiagnoseError;
use super::super::data::levitated::Levitation;
use super::nuisance::Layout;
use crate::spindle::effects::AXIS_NAMES;
use crate::spindle::response::{Assembled, Assembly, ReducedMachine};
use crate::spindle::{Effect, Machine};

/// Most prior standard deviations that a nuisance parameter may be off. Of fifty normal ones the largest exceeds four
/// in three of a thousand machines: what is beyond is a finding, not a small error.
pub(crate) const MOST_SD: f64 = 4.0;

/// A number of the machine that is further off than a careful updating leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct FurtherOff {
    /// The parameter in words.
    pub parameter: String,
    /// How far, in what a careful updating leaves.
    pub usual_deviations: f64,
    /// Relative change of the number.
    pub relative_change: f64,
}

/// What answers for a hypothesis.
#[derive(Clone, Debug)]
pub struct Model {
    /// The response of the machine.
    pub reduced: ReducedMachine,
    /// The nuisance parameters with their priors.
    pub layout: Layout,
    /// The loop in which responses that are far apart are compared; none compares them as they are.
    pub(in crate::diagnose) levitation: Option<Levitation>,
    /// As [`Assembly::masses_at_ports`], to compare many masses.
    pub(in crate::diagnose) masses_at_ports: bool,
}

impl Model {
    /// Reduces a machine measured with sweeps whose axis gains scatter by `axis_gain_sd`.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the machine breaks a rule or an eigenvalue iteration fails.
    pub fn new(machine: &Machine, axis_gain_sd: &[[f64; 4]]) -> Result<Self, DiagnoseError> {
        let reduced = ReducedMachine::new(machine)?;
        let mass_kg = machine.rotor()?.mass_properties().mass_kg;
        Ok(Self {
            levitation: Some(Levitation::of(machine, mass_kg)),
            layout: Layout::new(reduced.parameters.clone(), axis_gain_sd),
            masses_at_ports: false,
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
        let masses_at_ports = self.masses_at_ports;
        let assembly = Assembly { effects, speed_rad_s, derivatives, masses_at_ports, ..Assembly::default() };
        Ok(self.reduced.assemble(p, assembly)?)
    }

    /// Nuisance parameters that are further from the machine as given than any prior allows, the furthest first: their
    /// names, and how many prior standard deviations they are off.
    pub fn list_strained(&self, p: &[f64]) -> Vec<(String, f64)> {
        let off = |(k, p): (usize, &f64)| (k, self.layout.deviation(k, *p).0.abs());
        let all = p.iter().enumerate().map(off);
        let mut far: Vec<(usize, f64)> = all.filter(|(_, off)| *off > MOST_SD).collect();
        far.sort_by(|a, b| b.1.total_cmp(&a.1));
        far.into_iter().map(|(k, off)| (self.name_of(k), off)).collect()
    }

    /// Whether a nuisance parameter is that far off.
    pub(crate) fn is_strained(&self, p: &[f64]) -> bool {
        let far = |(k, p): (usize, &f64)| self.layout.deviation(k, *p).0.abs() > MOST_SD;
        p.iter().enumerate().any(far)
    }

    /// Where priors were widened: parameters that are further off than a careful updating leaves, the furthest first.
    pub(crate) fn further_off(&self, p: &[f64]) -> Vec<FurtherOff> {
        let width = self.layout.width;
        if width == 1.0 {
            return vec![];
        }
        let widened = 0..self.layout.machine.mesh();
        let off = widened.map(|k| FurtherOff {
            parameter: self.name_of(k),
            usual_deviations: width * self.layout.deviation(k, p[k]).0.abs(),
            relative_change: p[k].exp_m1(),
        });
        let mut far: Vec<FurtherOff> = off.filter(|f| f.usual_deviations > MOST_SD).collect();
        far.sort_by(|a, b| b.usual_deviations.total_cmp(&a.usual_deviations));
        far
    }

    /// A nuisance parameter in words.
    pub(crate) fn name_of(&self, k: usize) -> String {
        let layout = &self.layout;
        let machine = &layout.machine;
        for (at, words) in [
            ([0, 1].map(|b| machine.ki(b)), "force constant"),
            ([0, 1].map(|b| machine.ks(b)), "negative stiffness"),
            ([0, 1].map(|b| machine.gain(b)), "sensor gain"),
        ] {
            if let Some(b) = at.iter().position(|i| *i == k) {
                return format!("{} bearing, {words}", ["front", "rear"][b]);
            }
        }
        let regions = self.reduced.machine.regions().into_iter();
        let mut own = regions.filter(|r| self.reduced.groups_of(r).contains(&k));
        match own.next() {
            Some(region) => format!("modulus of {region}"),
            None if k < machine.groups => format!("modulus of element group {}", k + 1),
            None if k < machine.mesh() => {
                format!("damping of flexible mode {}", k + 1 - machine.damping(0))
            }
            None if k == machine.mesh() => "mesh of the shaft".into(),
            None if k < machine.count() => "reading of a plane between two nodes".into(),
            None => {
                let (sweep, axis) = ((k - machine.count()) / 4, (k - machine.count()) % 4);
                format!("sensor gain of {} in sweep {}", AXIS_NAMES[axis], sweep + 1)
            }
        }
    }
}
