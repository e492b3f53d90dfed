//! Recovery from contact with the backup bearings: whether and when the rotor comes free again, and the push that
//! causes contact.

use super::time::TimeResponse;
use crate::spindle::{Machine, Side, SpindleError};
use std::f64::consts::PI;

/// Zone A of ISO 14839-2 ends at this part of the clearance.
const ZONE_A: f64 = 0.3;

/// What became of the rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Recovery {
    /// It never touched a backup bearing.
    Clear,
    /// It touched and came free again.
    Recovered {
        /// From the first touch until it stays within zone A of ISO 14839-2 (30 % of the clearance), free of contact,
        /// s.
        after_s: f64,
    },
    /// It touched, and in the last quarter of the run it still touches, leaves zone A or needs all its current.
    Lost,
}

impl Recovery {
    /// Reads a response.
    pub fn of(machine: &Machine, response: &TimeResponse) -> Self {
        let Some((first_s, last_s)) = response.contact_s else {
            return if response.diverged { Self::Lost } else { Self::Clear };
        };
        let samples = &response.samples;
        let (Some(end), false) = (samples.last(), response.diverged) else {
            return Self::Lost;
        };
        let zone = ZONE_A * machine.spindle.backup_clearance_m;
        let outside = samples.iter().rfind(|s| {
            let d = &s.displacements_m;
            d[2].hypot(d[3]) > zone || d[4].hypot(d[5]) > zone
        });
        let free_s = outside.map_or(last_s, |s| last_s.max(s.time_s));
        let quiet_s = response.last_limited_s.map_or(free_s, |limited| free_s.max(limited));
        if quiet_s < 0.75 * end.time_s { Self::Recovered { after_s: free_s - first_s } } else { Self::Lost }
    }

    pub(crate) fn sentence(self) -> String {
        match self {
            Self::Clear => "the rotor stays clear of the backup bearings".to_owned(),
            Self::Recovered { after_s } => {
                format!("the rotor touches the backup bearings and recovers in {:.1} ms", 1e3 * after_s)
            }
            Self::Lost => "the rotor touches the backup bearings and does not recover".to_owned(),
        }
    }
}

/// Peak of a half-sine push at the tool, N, whose energy in the free rigid rotor is what both bearings can take out
/// within the clearance at their current limit: J²/(2 m_t) = s Σ k_i û, J = 2 F T/π, 1/m_t = 1/m + (z_t − z_c)²/I_d. A
/// rigid rotor with linear magnets touches its backup bearings after a harder push, whatever the controller.
///
/// # Errors
/// [`SpindleError`] when the rotor cannot be built.
pub fn touching_force_n(machine: &Machine, current_limit_a: f64, length_s: f64) -> Result<f64, SpindleError> {
    let body = machine.rotor()?.mass_properties();
    let lever = machine.tool_plane_m() - body.centre_of_gravity_m;
    let mass = 1.0 / (1.0 / body.mass_kg + lever * lever / body.diametral_inertia_kg_m2);
    let held: f64 = Side::ALL.into_iter().map(|side| machine.spindle.bearing(side).ki_n_per_a * current_limit_a).sum();
    let impulse = (2.0 * mass * held * machine.spindle.backup_clearance_m).sqrt();
    Ok(PI * impulse / (2.0 * length_s))
}
