//! What holds the shaft of a machine to the ground beside the control of its magnets.

use super::effective::Motion;
use super::{Effect, EffectKind, Location, Machine};
use crate::rotor::Support;

impl Machine {
    /// Springs, dampers and circulatory laws that effects put between shaft and ground.
    pub fn supports(&self) -> Vec<Support> {
        let attached = self.effective().attachments.into_iter();
        let displaced = attached.filter(|a| a.motion == Motion::Displacement);
        displaced.map(|a| a.support()).collect()
    }

    /// The same with the magnets off: without the springs in one plane by which a magnet differs from its mean.
    pub fn supports_without_magnets(&self) -> Vec<Support> {
        let mut off = self.clone();
        off.spindle.effects.retain(|effect| !self.is_of_magnet(effect));
        off.supports()
    }

    /// True of a spring in one plane at an actuator whose negative acts in the other plane: the negative stiffness of a
    /// magnet that differs from its mean, as files give it by axis.
    fn is_of_magnet(&self, effect: &Effect) -> bool {
        let in_plane = |e: &Effect| match (e.kind, &e.location) {
            (EffectKind::AddedStiffness, Location::InPlane(z, plane)) => Some((*z, *plane, e.values.first().copied()?)),
            _ => None,
        };
        let Some((z, plane, spring_n_per_m)) = in_plane(effect) else {
            return false;
        };
        let planes = &self.spindle.planes;
        let opposite = |other: &Effect| {
            // Both come from one mean, rounded.
            let negative = |spring: f64| (spring + spring_n_per_m).abs() <= 1e-9 * spring_n_per_m.abs();
            in_plane(other).is_some_and(|(at, own, spring)| at == z && own != plane && negative(spring))
        };
        (z == planes.front_actuator_m || z == planes.rear_actuator_m) && self.spindle.effects.iter().any(opposite)
    }
}
