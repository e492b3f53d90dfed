//! The derivatives to the numbers of every effect, as sums of terms.

use super::electronics_change::Change;
use super::probe::Probe;
use super::reduced::ReducedMachine;
use super::term::{Number, Sum, Term};
use crate::spindle::effective::FeedbackLaw;
use crate::spindle::{Bearings, Effect, EffectKind, Location, SpindleError};

impl ReducedMachine {
    /// Derivatives to the values of an effect, and then to its position if it has one. `effects` are all that are
    /// assembled, the one in question at `index`; what it needs to see is added to `probes`.
    pub fn sensitivity(&self, effects: &[Effect], index: usize, probes: &mut Vec<Probe>) -> Vec<Number> {
        let numbers = effects.get(index).map_or(0, |e| e.values.len());
        let changes: Vec<Number> =
            (0..numbers).filter_map(|n| Change::new(effects, index, n).map(Number::Electronics)).collect();
        if !changes.is_empty() {
            return changes;
        }
        let sums = self.sums(effects, index, probes).into_iter();
        match effects.get(index).map(|e| &e.location) {
            Some(Location::InPlane(_, plane)) => sums.map(|sum| Number::InPlane(sum, *plane)).collect(),
            _ => sums.map(Number::Shaft).collect(),
        }
    }

    /// Derivatives to the readings of the planes that are between nodes, with their planes.
    ///
    /// # Errors
    /// [`SpindleError`] when a plane is off the shaft.
    pub fn readings(&self, effects: &[Effect], probes: &mut Vec<Probe>) -> Result<Vec<(usize, Number)>, SpindleError> {
        let mut all = vec![];
        let planes = self.with(effects).effective().planes_m();
        for (plane, z) in planes.into_iter().enumerate() {
            if self.rigid.misread(z)?.is_some() {
                let probe = probes.len();
                probes.push(Probe::Misread(z));
                let term = Term::of_plane(plane, probe);
                all.push((plane, Number::Shaft(vec![(1.0, term)])));
            }
        }
        Ok(all)
    }

    fn sums(&self, effects: &[Effect], index: usize, probes: &mut Vec<Probe>) -> Vec<Sum> {
        let Some(effect) = effects.get(index) else {
            return vec![];
        };
        let value = effect.values.first().copied().unwrap_or_default();
        let mut probe = |p: Probe| {
            let known = probes.iter().position(|q| *q == p);
            known.unwrap_or_else(|| {
                probes.push(p);
                probes.len() - 1
            })
        };
        // A law at a port, and the same at a port that moves: its own derivative to the position.
        let placed = |probe: &mut dyn FnMut(Probe) -> usize, [at, along]: [Probe; 2], law: FeedbackLaw| {
            let (at, along) = (probe(at), probe(along));
            vec![vec![(1.0, Term::Bond(at, law))], vec![(value, Term::Shift(at, along, law))]]
        };
        let across = |z: f64| [Probe::Station(z), Probe::Slope(z)];
        let bearings = |which: &Bearings| -> Vec<usize> { [0, 1].into_iter().filter(|b| which.includes(*b)).collect() };
        match (effect.kind, &effect.location) {
            (EffectKind::AddedStiffness, Location::Position(z) | Location::InPlane(z, _)) => {
                placed(&mut probe, across(*z), FeedbackLaw::Spring)
            }
            (EffectKind::TiltingStiffness, Location::Position(z)) => {
                // A position off the shaft has no flexibility; assembly refuses it.
                let tilt = self.rigid.tilt_at(*z).ok();
                let (at, along) = (probe(Probe::Tilt(*z)), probe(Probe::TiltAlong(*z)));
                let (by_value, by_place) = tilt.map_or((1.0, 0.0), |t| t.seen_derivatives(value));
                let seen = tilt.map_or(value, |t| t.seen_stiffness(value));
                vec![
                    vec![(by_value, Term::Bond(at, FeedbackLaw::Spring))],
                    vec![
                        (seen, Term::Shift(at, along, FeedbackLaw::Spring)),
                        (by_place, Term::Bond(at, FeedbackLaw::Spring)),
                    ],
                ]
            }
            (EffectKind::CrossCoupling, Location::Position(z)) => {
                placed(&mut probe, across(*z), FeedbackLaw::Circulatory)
            }
            (EffectKind::AddedDamper, Location::Position(z) | Location::InPlane(z, _)) => {
                placed(&mut probe, across(*z), FeedbackLaw::Dashpot)
            }
            (EffectKind::AddedMass, Location::Position(z)) => placed(&mut probe, across(*z), FeedbackLaw::Mass),
            (EffectKind::AddedDisc, Location::Position(z)) => disc_terms(effect, *z, &mut probe),
            (EffectKind::ToolMass, _) => {
                let tip = probe(Probe::Station(self.span_m().0));
                vec![vec![(1.0, Term::Bond(tip, FeedbackLaw::Mass))]]
            }
            (EffectKind::ToolJoint, _) => {
                let across = probe(Probe::JointAcross);
                let turning = probe(Probe::JointTurning);
                vec![
                    vec![(1.0, Term::Bond(across, FeedbackLaw::Spring))],
                    vec![(1.0, Term::Bond(turning, FeedbackLaw::Spring))],
                    vec![(1.0, Term::Bond(turning, FeedbackLaw::Dashpot))],
                ]
            }
            (EffectKind::SensorOffset | EffectKind::ActuatorOffset, Location::Bearing(which)) => {
                let planes = self.with(effects).effective().planes_m();
                let signal = effect.kind == EffectKind::SensorOffset;
                let term = |b: usize| {
                    let plane = if signal { 2 + b } else { b };
                    let slope = probe(Probe::Slope(planes[plane]));
                    (1.0, Term::of_plane(plane, slope))
                };
                vec![bearings(which).into_iter().map(term).collect()]
            }
            (EffectKind::NegativeStiffness, Location::Bearing(which)) => {
                let term = |b: usize| (value.recip(), Term::NegativeStiffness(b));
                vec![bearings(which).into_iter().map(term).collect()]
            }
            (EffectKind::RegionStiffness, Location::Region(region)) => {
                let groups = self.groups_of(region).into_iter();
                vec![groups.map(|g| (value.recip(), Term::Modulus(g))).collect()]
            }
            (EffectKind::ModalDamping, Location::Mode(mode)) if *mode >= 1 => {
                vec![vec![(value.recip(), Term::Damping(mode - 1))]]
            }
            (EffectKind::InternalDamping, _) => vec![vec![(1.0, Term::Loss)]],
            // The last of several counts.
            (EffectKind::Gyroscopic, _) => {
                let mut later = effects[index + 1..].iter();
                let replaced = later.any(|e| e.kind == EffectKind::Gyroscopic);
                let factor = f64::from(u8::from(!replaced));
                vec![vec![(factor, Term::Gyroscopic)]]
            }
            (EffectKind::HousingMode, _) => {
                let housing = |e: &&Effect| e.kind == EffectKind::HousingMode;
                let before = self.machine.of_kind(EffectKind::HousingMode).count()
                    + effects[..index].iter().filter(housing).count();
                (0..3).map(|number| vec![(1.0, Term::Housing(before, number))]).collect()
            }
            // An effect without its place does nothing.
            _ => effect.values.iter().map(|_| vec![]).collect(),
        }
    }
}

/// Derivatives to mass, polar and diametral inertia of a disc, and to its position.
fn disc_terms(effect: &Effect, z: f64, probe: &mut dyn FnMut(Probe) -> usize) -> Vec<Sum> {
    let probes = [Probe::Station(z), Probe::Slope(z), Probe::Rotation(z), Probe::RotationAlong(z)];
    let [at, slope, turned, along] = probes.map(probe);
    let of = |i: usize| effect.values.get(i).copied().unwrap_or_default();
    let (mass, turning) = (FeedbackLaw::Mass, FeedbackLaw::Gyroscopic);
    vec![
        vec![(1.0, Term::Bond(at, mass))],
        vec![(1.0, Term::Bond(turned, turning))],
        vec![(1.0, Term::Bond(turned, mass))],
        vec![
            (of(0), Term::Shift(at, slope, mass)),
            (of(1), Term::Shift(turned, along, turning)),
            (of(2), Term::Shift(turned, along, mass)),
        ],
    ]
}
