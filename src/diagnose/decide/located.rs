//! Effects on the shaft that begin at the place and with the size which a free law reads off.
//!
//! A linear step from nothing does not lead to a spring that moves resonances by many times their width; the law that
//! was recovered without a hypothesis says where it sits and how large it is.

use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::problem::Point;
use super::super::locate::localisation::{Localisation, PortScore};
use super::super::locate::place::Place;
use super::super::locate::recovered_law::LawShape;
use super::candidate::{Candidate, MODEL_ERRORS};
use super::screening::{ScreeningRound, matters};
use crate::spindle::{EffectKind, Location, Plane};

/// Places that are looked at: those near the best have laws of other shapes.
const PLACES: usize = 3;

/// What a law looks like: an effect at a place and its value.
struct Reading {
    kind: EffectKind,
    place: Location,
    value: f64,
}

impl Case<'_> {
    /// Adds to a round of single effects that explains nothing those which the best places read off.
    pub(crate) fn add_located(&self, localisation: &Localisation, round: &mut ScreeningRound) {
        let finalists = &mut round.finalists;
        if finalists.first().is_some_and(|c| self.within(c)) {
            return;
        }
        let placed = localisation.ports.iter().filter(|port| port.place.position_m().is_some());
        for port in placed.take(PLACES) {
            for reading in readings(port) {
                finalists.extend(self.begin_at(&reading, port).filter(matters));
            }
        }
        self.add_like_masses(finalists, MODEL_ERRORS[1]);
        self.rank(finalists);
    }

    /// The fit of a reading, with the nuisance parameters of its place; none where no machine has it (a mass that takes
    /// more away than is there).
    fn begin_at(&self, reading: &Reading, port: &PortScore) -> Option<Candidate> {
        let z = reading.place.position_m()?;
        let same = self.catalogue.iter().filter(|h| h.kind == reading.kind && h.place.moved_to(z) == reading.place);
        let off = |place: &Location| place.position_m().map_or(f64::INFINITY, |at| (at - z).abs());
        let h = same.min_by(|a, b| off(&a.place).total_cmp(&off(&b.place)))?;
        let mut theta = vec![reading.value / h.slope(0, &h.start), z / h.slope(1, &h.start)];
        h.clamp(&mut theta);
        // Fewer records have fewer axis gains; the numbers of the machine stand first.
        let mut p = self.origin().p;
        let machine = self.model.layout.machine.count();
        let known = if port.p.len() == p.len() { p.len() } else { machine };
        p[..known].copy_from_slice(&port.p[..known]);
        let from = Point { p, theta: vec![theta], ..self.origin() };
        self.finish(std::slice::from_ref(h), &from, MODEL_ERRORS[1], Subset::ALL).ok()
    }
}

/// Effects that the laws of a place look like.
fn readings(port: &PortScore) -> Vec<Reading> {
    let z = port.place.position_m().unwrap_or_default();
    let of_shape = |shape: LawShape| match shape {
        LawShape::Constant(k) => vec![(EffectKind::AddedStiffness, k)],
        LawShape::Damper(c) => vec![(EffectKind::AddedDamper, c)],
        LawShape::Mass(m) => vec![(EffectKind::AddedMass, m)],
        LawShape::SpringMassDamper(k, m, c) => {
            vec![(EffectKind::AddedStiffness, k), (EffectKind::AddedMass, m), (EffectKind::AddedDamper, c)]
        }
        _ => vec![],
    };
    match port.place {
        Place::Apart(_) => {
            let springs = port.laws.iter().filter_map(|law| match law.shape {
                LawShape::Constant(value) | LawShape::SpringMassDamper(value, ..) => {
                    let place = Location::InPlane(z, Plane::from_name(&law.name)?);
                    Some(Reading { kind: EffectKind::AddedStiffness, place, value })
                }
                _ => None,
            });
            springs.collect()
        }
        _ => {
            let laws = port.laws.iter().take(1).flat_map(|law| of_shape(law.shape));
            laws.map(|(kind, value)| Reading { kind, place: Location::Position(z), value }).collect()
        }
    }
}
