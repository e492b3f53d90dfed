//! Derivatives of F to the numbers of an effect, magnets closed.
//!
//! With H the closed receptance between all ports, a force law dκ at a port q gives  dH_oi = H_oq dκ H_qi; a law κ whose place moves, q' its
//! slope port,  dH_oi = κ (H_oq' H_qi + H_oq H_q'i); a sensor that moves reads H_q'i instead of H_oi; what stands between ports a and b before the
//! magnets are closed gives  Σ (1 + Hκ)_oa dh (1 + κH)_bi.

use super::super::DiagnoseError;
use super::behind::Behind;
use super::electronics::Change;
use super::law::Law;
use super::port::Probe;
use super::{Assembled, IN, Model, OUT, Planar, RIGID, ZERO};
use crate::linalg::c64;
use crate::spindle::{Bearings, Effect, EffectKind, Location};
use std::f64::consts::TAU;
use std::ops::Deref;

/// A part of a derivative. Probes are numbered in the order in which they were asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    /// The logarithm of the modulus of a group.
    Modulus(usize),
    /// The logarithm of the negative stiffness of a bearing.
    NegativeStiffness(usize),
    /// The logarithm of the damping ratio of a flexible mode, counted from 0.
    Damping(usize),
    /// The loss time of the shaft's material, s.
    Loss,
    /// The factor of the gyroscopic moments.
    Gyroscopic,
    /// A law of one unit at a probe.
    Bond(usize, Law),
    /// A law of one unit at a probe whose slope is another probe.
    Shift(usize, usize, Law),
    /// The sensors of a bearing read a probe more.
    Signal(usize, usize),
    /// The magnets of a bearing act at a probe, too.
    Magnet(usize, usize),
    /// Mass, frequency in Hz, damping ratio of a housing mode.
    Housing(usize, usize),
}

impl Term {
    /// A plane, actuators front and rear, then sensors, reads or acts at a probe, too.
    fn of_plane(plane: usize, probe: usize) -> Self {
        match plane {
            0 | 1 => Self::Magnet(plane, probe),
            _ => Self::Signal(plane - 2, probe),
        }
    }
}

/// A sum of terms with factors.
pub type Sum = Vec<(f64, Term)>;

/// What a derivative to a number of an effect consists of.
#[derive(Clone, Debug, PartialEq)]
pub enum Number {
    /// A number that changes the shaft or what acts on it.
    Shaft(Sum),
    /// One that changes what stands round it.
    Electronics(Change),
}

impl Number {
    /// The derivative times a factor.
    pub fn scaled(mut self, by: f64) -> Self {
        match &mut self {
            Self::Shaft(sum) => sum.iter_mut().for_each(|(factor, _)| *factor *= by),
            Self::Electronics(change) => change.factor *= by,
        }
        self
    }

    fn any(&self, of: impl Fn(&Term) -> bool) -> bool {
        matches!(self, Self::Shaft(sum) if sum.iter().any(|(_, term)| of(term)))
    }

    /// Whether it couples x and y.
    pub(super) fn couples(&self) -> bool {
        self.any(|term| match term {
            Term::Bond(_, law) | Term::Shift(_, _, law) => *law == Law::Circulatory,
            _ => false,
        })
    }

    /// Whether it needs the strains of the shaft.
    pub fn bends(&self) -> bool {
        self.any(|term| matches!(term, Term::Modulus(_)))
    }
}

impl Model {
    /// Derivatives to the values of an effect, and then to its position if it has one. `effects` are all that are assembled, the one in
    /// question at `index`; what it needs to see is added to `probes`.
    pub fn sensitivity(
        &self,
        effects: &[Effect],
        index: usize,
        probes: &mut Vec<Probe>,
    ) -> Vec<Number> {
        if let Some(change) = Change::new(effects, index) {
            return vec![Number::Electronics(change)];
        }
        let sums = self.sums(effects, index, probes);
        sums.into_iter().map(Number::Shaft).collect()
    }

    /// Derivatives to the readings of the planes that are between nodes, with their planes.
    ///
    /// # Errors
    /// [`DiagnoseError`] when a plane is off the shaft.
    pub fn readings(
        &self,
        effects: &[Effect],
        probes: &mut Vec<Probe>,
    ) -> Result<Vec<(usize, Number)>, DiagnoseError> {
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
            probes.push(p);
            probes.len() - 1
        };
        // A law at a port, and the same at a port that moves: its own derivative to the position.
        let placed = |probe: &mut dyn FnMut(Probe) -> usize, [at, along]: [Probe; 2], law: Law| {
            let (at, along) = (probe(at), probe(along));
            vec![
                vec![(1.0, Term::Bond(at, law))],
                vec![(value, Term::Shift(at, along, law))],
            ]
        };
        let across = |z: f64| [Probe::Station(z), Probe::Slope(z)];
        let bearings = |which: &Bearings| -> Vec<usize> {
            [0, 1].into_iter().filter(|b| which.includes(*b)).collect()
        };
        match (effect.kind, &effect.location) {
            (EffectKind::AddedStiffness, Location::Position(z)) => {
                placed(&mut probe, across(*z), Law::Spring)
            }
            (EffectKind::TiltingStiffness, Location::Position(z)) => {
                let ports = [Probe::Slope(*z), Probe::Curvature(*z)];
                placed(&mut probe, ports, Law::Spring)
            }
            (EffectKind::CrossCoupling, Location::Position(z)) => {
                placed(&mut probe, across(*z), Law::Circulatory)
            }
            (EffectKind::AddedMass, Location::Position(z)) => {
                placed(&mut probe, across(*z), Law::Mass)
            }
            (EffectKind::ToolMass, _) => {
                let tip = probe(Probe::Station(self.span_m().0));
                vec![vec![(1.0, Term::Bond(tip, Law::Mass))]]
            }
            (EffectKind::ToolJoint, _) => {
                let across = probe(Probe::JointAcross);
                let turning = probe(Probe::JointTurning);
                vec![
                    vec![(1.0, Term::Bond(across, Law::Spring))],
                    vec![(1.0, Term::Bond(turning, Law::Spring))],
                    vec![(1.0, Term::Bond(turning, Law::Dashpot))],
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
                (0..3)
                    .map(|number| vec![(1.0, Term::Housing(before, number))])
                    .collect()
            }
            // An effect without its place does nothing.
            _ => effect.values.iter().map(|_| vec![]).collect(),
        }
    }
}

impl Assembled {
    /// A derivative of the 3×3 receptance between sensors, tool and bearings at a signed frequency; `first` is the port of the first
    /// probe, `strains` are the derivatives to the moduli where they are needed.
    pub(super) fn sensitive(
        &self,
        at: &Planar,
        w: f64,
        first: usize,
        sum: &Sum,
        behind: &impl Deref<Target = Behind>,
        strains: &impl Deref<Target = Vec<Vec<c64>>>,
    ) -> [c64; 9] {
        let mut all = [ZERO; 9];
        for (factor, term) in sum {
            let whole = self.of_coordinates(*term, w, behind, strains);
            for (n, entry) in all.iter_mut().enumerate() {
                let own = match &whole {
                    Some(whole) => whole.get(n).copied().unwrap_or(ZERO),
                    None => self.at_ports(at, w, first, *term, n),
                };
                *entry += own * *factor;
            }
        }
        all
    }

    /// Derivatives to what the coordinates of the shaft have.
    fn of_coordinates(
        &self,
        term: Term,
        w: f64,
        behind: &impl Deref<Target = Behind>,
        strains: &impl Deref<Target = Vec<Vec<c64>>>,
    ) -> Option<Vec<c64>> {
        let modes = RIGID..self.dynamic;
        Some(match term {
            Term::Modulus(group) => strains.get(group).cloned().unwrap_or_default(),
            Term::Damping(mode) => {
                let own = (RIGID + mode).min(self.dynamic)..(RIGID + mode + 1).min(self.dynamic);
                self.through(behind, own, |k| c64::new(0.0, w * self.modal[k]))
            }
            Term::Loss => {
                let seen = w - self.speed_rad_s;
                self.through(behind, modes, |k| {
                    c64::new(0.0, seen * self.omega[k] * self.omega[k])
                })
            }
            Term::Gyroscopic => {
                let own = self.gyroscopic.as_ref();
                own.map_or(vec![], |g| g.slope(behind, w))
            }
            _ => return None,
        })
    }

    /// Entry n of the derivative to what acts at ports.
    fn at_ports(&self, at: &Planar, w: f64, first: usize, term: Term, n: usize) -> c64 {
        let p = self.ports.len();
        let (o, i) = (OUT[n / 3], IN[n % 3]);
        let h = |a: usize, b: usize| at.closed[a * p + b];
        // A law at a place whose slope port moves it.
        let moved = |q: usize, slope: usize| h(o, slope) * h(q, i) + h(o, q) * h(slope, i);
        match term {
            Term::NegativeStiffness(b) => {
                let magnet = Self::MAGNETS[b];
                h(o, magnet) * h(magnet, i) * self.negative_stiffness()[b]
            }
            Term::Bond(q, law) => h(o, first + q) * law.gain(w) * h(first + q, i),
            Term::Shift(q, slope, law) => moved(first + q, first + slope) * law.gain(w),
            Term::Signal(b, slope) if o == 3 + b => h(first + slope, i),
            Term::Signal(..) => ZERO,
            Term::Magnet(b, slope) => {
                let magnet = Self::MAGNETS[b];
                let through = moved(magnet, first + slope) * self.negative_stiffness()[b];
                match i == magnet {
                    true => through + h(o, first + slope),
                    false => through,
                }
            }
            Term::Housing(index, number) => {
                let Some(housing) = self.housings.get(index) else {
                    return ZERO;
                };
                let own = housing.omega_rad_s;
                let spring = c64::new(own * own - w * w, 2.0 * housing.damping_ratio * own * w);
                let compliance = (spring * housing.mass_kg).inv();
                let slope = match number {
                    0 => c64::new(housing.mass_kg.recip(), 0.0),
                    1 => c64::new(2.0 * own, 2.0 * housing.damping_ratio * w) * TAU / spring,
                    _ => c64::new(0.0, 2.0 * own * w) / spring,
                };
                // Bearings and sensors stand on the housing, the tool does not.
                let on = |port: usize| c64::new(f64::from(u8::from((1..5).contains(&port))), 0.0);
                let ks = self.negative_stiffness();
                let (mut left, mut right) = (on(o), on(i));
                for (magnet, ks) in Self::MAGNETS.into_iter().zip(ks) {
                    left += h(o, magnet) * ks;
                    right += h(magnet, i) * ks;
                }
                -(left * compliance * slope * right)
            }
            _ => ZERO,
        }
    }
}
