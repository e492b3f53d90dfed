//! What a derivative to a number of an effect consists of.

use super::electronics_change::Change;
use crate::spindle::effective::FeedbackLaw;
use crate::spindle::effects::Plane;

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
    Bond(usize, FeedbackLaw),
    /// A law of one unit at a probe whose slope is another probe.
    Shift(usize, usize, FeedbackLaw),
    /// The sensors of a bearing read a probe more.
    Signal(usize, usize),
    /// The magnets of a bearing act at a probe, too.
    Magnet(usize, usize),
    /// Mass, frequency in Hz, damping ratio of a housing mode.
    Housing(usize, usize),
}

impl Term {
    /// A plane, actuators front and rear, then sensors, reads or acts at a probe, too.
    pub(crate) fn of_plane(plane: usize, probe: usize) -> Self {
        match plane {
            0 | 1 => Self::Magnet(plane, probe),
            _ => Self::Signal(plane - 2, probe),
        }
    }
}

/// A sum of terms with factors.
pub(crate) type Sum = Vec<(f64, Term)>;

/// What a derivative to a number of an effect consists of.
#[derive(Clone, Debug, PartialEq)]
pub enum Number {
    /// A number that changes the shaft or what acts on it.
    Shaft(Sum),
    /// One of a law in one plane.
    InPlane(Sum, Plane),
    /// One that changes what stands round it.
    Electronics(Change),
}

impl Number {
    /// The derivative times a factor.
    pub fn scale_number(mut self, by: f64) -> Self {
        match &mut self {
            Self::Shaft(sum) | Self::InPlane(sum, _) => sum.iter_mut().for_each(|(factor, _)| *factor *= by),
            Self::Electronics(change) => change.factor *= by,
        }
        self
    }

    fn any(&self, of: impl Fn(&Term) -> bool) -> bool {
        matches!(self, Self::Shaft(sum) if sum.iter().any(|(_, term)| of(term)))
    }

    /// Whether it couples x and y.
    pub(crate) fn couples(&self) -> bool {
        self.any(|term| match term {
            Term::Bond(_, law) | Term::Shift(_, _, law) => *law == FeedbackLaw::Circulatory,
            _ => false,
        })
    }

    /// Whether it needs the strains of the shaft.
    pub(crate) fn bends(&self) -> bool {
        self.any(|term| matches!(term, Term::Modulus(_)))
    }
}
