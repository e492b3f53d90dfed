//! Rigid-body dynamics that a bearing acts on: what searches of a law draw their starts from.

use crate::spindle::{Machine, Side, SpindleError};

/// A bearing and the rigid rotor as it shows there.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigidBearing {
    /// Force per current, N/A.
    pub ki_n_per_a: f64,
    pub ks_n_per_m: f64,
    /// Mass that the rigid rotor shows at the actuator, kg.
    pub mass_kg: f64,
    /// √(k_s/m), or what the first bending mode allows where k_s is small, rad/s.
    pub omega_rad_s: f64,
}

/// A magnet with little negative stiffness is drawn as with this share of the first bending frequency.
const SHARE_OF_BENDING: f64 = 0.05;

/// Both bearings of a machine whose lowest flexible mode is `bending_rad_s`.
pub(super) fn rigid_bearings(machine: &Machine, bending_rad_s: f64) -> Result<[RigidBearing; 2], SpindleError> {
    let rigid = machine.rotor()?.mass_properties();
    let bearing = |side: Side, position_m: f64| {
        let own = machine.spindle.bearing(side);
        let lever = position_m - rigid.centre_of_gravity_m;
        let mass_kg = 1.0 / (1.0 / rigid.mass_kg + lever * lever / rigid.diametral_inertia_kg_m2);
        RigidBearing {
            ki_n_per_a: own.ki_n_per_a,
            ks_n_per_m: own.ks_n_per_m,
            mass_kg,
            omega_rad_s: (own.ks_n_per_m.abs() / mass_kg).sqrt().max(SHARE_OF_BENDING * bending_rad_s),
        }
    };
    let planes = &machine.spindle.planes;
    Ok([bearing(Side::Front, planes.front_actuator_m), bearing(Side::Rear, planes.rear_actuator_m)])
}
