//! Contact of the rotor with its backup bearings: what the spindle file says, and what follows from the rotor where it
//! says nothing.

use super::SpindleError;
use super::rule::{BrokenRules, positive, rule};
use crate::rotor::Rotor;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Contact stiffness of a backup bearing in its mount where the file gives none, N/m. Deep-groove bearings of spindle
/// size have about 1e8 N/m; resilient rings in series leave a third of that.
const STIFFNESS_N_PER_M: f64 = 3.0e7;
/// Damping of the contact as a share of the critical damping of half the rotor on it, where the file gives none.
const DAMPING_RATIO: f64 = 0.15;
/// Friction coefficient where the file gives none: lubricated steel, and steel on bronze.
const FRICTION: f64 = 0.1;

/// What a spindle file says of the contact with the backup bearings; `None` for what it leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BackupBearings {
    /// Contact stiffness; 3e7 N/m unless given.
    pub contact_stiffness_n_per_m: Option<f64>,
    /// Contact damping; unless given 15 % of the critical damping of half the rotor on the contact stiffness.
    pub contact_damping_n_s_per_m: Option<f64>,
    /// Friction coefficient; 0.1 unless given.
    pub friction: Option<f64>,
    /// Radius of the rotor where it touches; unless given that of the shaft at the actuators, on average.
    pub contact_radius_m: Option<f64>,
}

/// The contact with every value known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackupContact {
    /// Contact stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Contact damping, N s/m.
    pub damping_n_s_per_m: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Radius of the rotor in the backup bearings, m.
    pub radius_m: f64,
}

impl BackupBearings {
    /// True when the file leaves everything open.
    pub(crate) fn is_open(&self) -> bool {
        *self == Self::default()
    }

    pub(super) fn check(&self, broken: &mut BrokenRules) {
        let path = |key: &str| format!("backup_bearings.{key}");
        let sizes = [
            ("contact_stiffness_n_per_m", self.contact_stiffness_n_per_m),
            ("contact_radius_m", self.contact_radius_m),
        ];
        for (key, value) in sizes {
            broken.note(value.map_or(Ok(()), |value| positive(&path(key), value)));
        }
        let zero = "must be zero or a positive number";
        for (key, value) in [("contact_damping_n_s_per_m", self.contact_damping_n_s_per_m), ("friction", self.friction)]
        {
            let value = value.unwrap_or(0.0);
            broken.note(rule(value >= 0.0 && value.is_finite(), path(key), value, zero));
        }
    }

    /// The contact with what the file leaves open taken from the rotor of the spindle and the places of its actuators.
    pub(super) fn contact(&self, rotor: &Rotor, actuators_m: [f64; 2]) -> Result<BackupContact, SpindleError> {
        let stiffness = self.contact_stiffness_n_per_m.unwrap_or(STIFFNESS_N_PER_M);
        let half = 0.5 * rotor.mass_properties().mass_kg;
        let mut radius = 0.0;
        for at in actuators_m {
            let (k, s) = rotor.element_at("actuator", at).map_err(SpindleError::Rotor)?;
            let [near, far] = rotor.sections()[k].outer_diameter_m;
            radius += 0.5 * (near + s * (far - near)) / actuators_m.len() as f64;
        }
        Ok(BackupContact {
            stiffness_n_per_m: stiffness,
            damping_n_s_per_m: self
                .contact_damping_n_s_per_m
                .unwrap_or(2.0 * DAMPING_RATIO * (stiffness * half).sqrt()),
            friction: self.friction.unwrap_or(FRICTION),
            radius_m: self.contact_radius_m.unwrap_or(radius),
        })
    }
}
