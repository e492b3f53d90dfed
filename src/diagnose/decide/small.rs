//! Effects that are too small for a name, as nuisance parameters of the machine as it is.
//!
//! Every rig has a ring that is turned by a few hundredths of a degree and a plane that sits a tenth of a millimetre
//! off. Such an effect matters to nobody, but precise records show it, and one that does matter would take it up.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::problem::Point;
use super::candidate::Standing;
use super::selection::complete;
use crate::spindle::{Bearings, EffectKind, Location};

/// What no rotor and no bearing is without.
const KINDS: [EffectKind; 5] = [
    EffectKind::SensorOffset,
    EffectKind::ActuatorOffset,
    EffectKind::BearingCoupling,
    EffectKind::AxisMisalignment,
    EffectKind::ToolMass,
];

impl Case<'_> {
    /// The machine with all small effects, where these explain the records.
    pub(crate) fn explain_by_small(&self) -> Result<Option<Standing>, DiagnoseError> {
        let mut effects: Vec<Hypothesis> = vec![];
        // Both bearings are front and rear together: a third coordinate would share out what one bearing has, until
        // each part is too small for a name.
        let both = Location::Bearing(Bearings::Both);
        for h in self.catalogue.iter().filter(|h| KINDS.contains(&h.kind) && h.place != both) {
            if !effects.iter().any(|e| e.same_name(h)) {
                effects.push(h.as_nuisance());
            }
        }
        let from = Point { theta: effects.iter().map(|h| h.start.clone()).collect(), ..self.origin() };
        let standing = self.fit_down(&effects, &from, Subset::ALL)?;
        let both = effects.iter().zip(&standing.candidate.fit.at.theta);
        let small = both.into_iter().all(|(h, theta)| !h.matters(theta));
        Ok((small && complete(self, &standing)?).then_some(standing))
    }
}
