//! A rotor without magnets: shaft, tool and what it stands on or hangs from; without supports it is free-free.

use super::rule::{BrokenRules, rule};
use super::{SpindleError, Tool};
use crate::linalg::c64;
use crate::rotor::whirl::{RotorState, WhirlSpectrum};
use crate::rotor::{Damping, Disc, Rotor, Section, Support};

/// A rotor on springs and dampers.
#[derive(Clone, Debug, PartialEq)]
pub struct RotorOnSupports {
    /// Name.
    pub name: String,
    /// Elements from z = 0 to the tail.
    pub sections: Vec<Section>,
    /// Discs.
    pub discs: Vec<Disc>,
    /// Damping ratios of the free-free flexible modes; the last serves all higher modes.
    pub damping_ratio: Vec<f64>,
    /// False for a model that was built for standstill.
    pub gyroscopics: bool,
    /// Springs and dampers to ground.
    pub supports: Vec<Support>,
    /// The tool in it, if any.
    pub tool: Option<Tool>,
}

impl RotorOnSupports {
    /// The assembled shaft with its tool, free of its supports.
    ///
    /// # Errors
    /// [`SpindleError`] when a part breaks a rule.
    pub fn rotor(&self) -> Result<Rotor, SpindleError> {
        let shaft = Rotor::new(0.0, self.sections.clone(), &self.discs).map_err(SpindleError::Rotor)?;
        match &self.tool {
            Some(tool) => Rotor::join(&tool.rotor()?, &shaft, None).map_err(SpindleError::Shaft),
            None => Ok(shaft),
        }
    }

    pub(super) fn damping(&self, rotor: &Rotor) -> Damping {
        let list = &self.damping_ratio;
        let ratio = |k: usize| list.get(k).or(list.last()).copied().unwrap_or_default();
        Damping::Modal((0..rotor.dofs()).map(ratio).collect())
    }

    pub(super) fn seen_speed(&self, speed_rad_s: f64) -> f64 {
        if self.gyroscopics { speed_rad_s } else { 0.0 }
    }

    /// Whirl modes on the supports at a speed, up to a frequency.
    ///
    /// # Errors
    /// [`SpindleError`] when a part breaks a rule or the eigenvalues fail.
    pub fn whirl(&self, speed_rad_s: f64, to_hz: f64) -> Result<WhirlSpectrum, SpindleError> {
        let rotor = self.rotor()?;
        Ok(rotor.whirl(self.seen_speed(speed_rad_s), &self.damping(&rotor), &self.supports, to_hz)?)
    }

    /// Displacement over force, m/N, [[xx, xy], [yx, yy]] at each frequency: read at the first place, the force at the
    /// second, m.
    ///
    /// # Errors
    /// As [`Self::whirl`], and for a place beyond the ends.
    pub fn receptance(
        &self,
        speed_rad_s: f64,
        places_m: [f64; 2],
        frequency_hz: &[f64],
    ) -> Result<Vec<[[c64; 2]; 2]>, SpindleError> {
        let rotor = self.rotor()?;
        let (speed_rad_s, damping) = (self.seen_speed(speed_rad_s), self.damping(&rotor));
        let state = RotorState { speed_rad_s, damping: &damping, supports: &self.supports };
        Ok(rotor.receptance(&state, places_m, frequency_hz)?)
    }

    /// Place and stiffness of its springs in a plane, m and N/m; 0 is x, 1 is y.
    pub fn springs(&self, axis: usize) -> Vec<(f64, f64)> {
        let axis = axis.min(1);
        self.supports.iter().map(|s| s.spring(axis)).collect()
    }

    /// Where the tip of the tool is, or the first end without one, m.
    pub fn tool_plane_m(&self) -> f64 {
        self.tool.as_ref().map_or(0.0, |tool| -tool.tool_plane_m)
    }

    /// Every rule that shaft, damping and supports break.
    pub(crate) fn broken_rules(&self) -> Vec<SpindleError> {
        let mut broken = BrokenRules::default();
        let rotor = broken.rotor(&self.sections, &self.discs, SpindleError::Rotor);
        let length_m: f64 = self.sections.iter().map(|s| s.length_m).sum();
        let none = SpindleError::Name {
            path: "rotor.damping_ratio".into(),
            name: "[]".into(),
            rule: "needs at least one value".into(),
        };
        broken.note(if self.damping_ratio.is_empty() { Err(none) } else { Ok(()) });
        for (k, support) in self.supports.iter().enumerate().filter(|_| rotor.is_some()) {
            let z = support.position_m;
            let on_shaft = z >= 0.0 && z <= length_m * (1.0 + 1e-9);
            let text = format!("must lie on the shaft, between 0 and {length_m:.6}");
            broken.note(rule(on_shaft, format!("supports[{k}].position_m"), z, &text));
        }
        broken.list()
    }
}
