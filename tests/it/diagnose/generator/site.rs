//! Places of hidden effects.

use super::Draw;
use muspin::spindle::{Bearings, Effect, EffectKind, Location, Machine, Plane};

/// A factor on the negative stiffness of front x alone, as what it is: a spring in one plane.
pub fn one_axis_pulls(machine: &Machine, factor: f64) -> Effect {
    let planes = &machine.spindle.planes;
    let location = Location::InPlane(planes.front_actuator_m, Plane::X);
    let values = vec![machine.spindle.front.ks_n_per_m * (1.0 - factor)];
    Effect::new(EffectKind::AddedStiffness, location, values).expect("effect")
}

/// A place for an effect of a kind: positions from a range, m, modes up to a number.
pub fn drawn_site(
    kind: EffectKind,
    machine: &Machine,
    draw: &mut Draw,
    (from_m, to_m): (f64, f64),
    modes: usize,
) -> Location {
    match kind {
        EffectKind::CrossCoupling
        | EffectKind::AddedMass
        | EffectKind::AddedDisc
        | EffectKind::AddedStiffness
        | EffectKind::AddedDamper
        | EffectKind::TiltingStiffness => Location::Position(draw.uniform(from_m, to_m)),
        EffectKind::SensorCrosstalk | EffectKind::CurrentPickup => {
            let from = draw.uniform(0.0, 4.0 - 1e-9) as usize;
            Location::Across { from, to: (from + 1 + draw.uniform(0.0, 3.0 - 1e-9) as usize) % 4 }
        }
        EffectKind::ModalDamping => Location::Mode(1 + draw.uniform(0.0, modes as f64 - 1e-3) as usize),
        EffectKind::RegionStiffness => {
            let regions = machine.regions();
            let pick = draw.uniform(0.0, regions.len() as f64 - 1e-9) as usize;
            Location::Region(regions[pick].clone())
        }
        EffectKind::LoopDelay
        | EffectKind::Gyroscopic
        | EffectKind::InternalDamping
        | EffectKind::ToolJoint
        | EffectKind::ToolMass
        | EffectKind::HousingMode => Location::None,
        _ => Location::Bearing(match draw.uniform(0.0, 3.0) as usize {
            0 => Bearings::Front,
            1 => Bearings::Rear,
            _ => Bearings::Both,
        }),
    }
}
