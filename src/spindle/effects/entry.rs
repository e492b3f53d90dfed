//! What an entry of the table of effects consists of.

use super::coordinate::Coordinate;
use super::kind::EffectKind;
use super::location::LocationKind;
use super::scale::MachineScale;

/// What an effect changes; this decides which part of a model has to be computed again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Amplifiers, sensors and delay: the receptance of the shaft stays.
    Electronics,
    /// The shaft or what acts on it.
    Shaft,
}

/// A kind of place at which an effect can be what is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// A position of the shaft.
    Shaft,
    /// Between tool and nose.
    Joint,
    /// The stator under both bearings.
    Housing,
    /// The sensors of a bearing.
    Sensors,
    /// The currents of a bearing.
    Currents,
    /// All currents, or equally all sensors.
    Loop,
    /// The orientation of a bearing's sensor axes.
    SensorAxes,
    /// The coupling of a bearing's axes.
    AxisCoupling,
    /// The axial position of a bearing's sensors.
    SensorPlane,
    /// The axial position of a bearing's magnet.
    ActuatorPlane,
}

/// Where fits of an effect start, in fit coordinates.
#[derive(Clone, Copy, Debug)]
pub enum Starts {
    /// At each of these, at every place that the location allows.
    At(&'static [&'static [f64]]),
    /// At the value that the machine has.
    AtPresent(fn(&MachineScale) -> f64),
    /// Here; a law in place of another one, which no size of it makes vanish.
    InPlaceOf(fn(&MachineScale) -> Vec<f64>),
    /// One for each factor 1.45 of frequency over the band, because the basin of a resonance is not much wider.
    OverTheBand {
        /// The first coordinate.
        first: f64,
        /// The damping ratio.
        damping_ratio: f64,
    },
}

/// How a sentence shows a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shown {
    /// The value times a factor, with its unit.
    Scaled(f64, &'static str),
    /// 100 (value − 1), in percent.
    PercentOff,
    /// The size of the value times a factor, with its unit; `{way}` becomes the first word below zero, else the second.
    Either(f64, &'static str, [&'static str; 2]),
}

/// Bounds of a fit coordinate, from the size of the machine.
pub type Bounds = fn(&MachineScale) -> (f64, f64);

/// One number of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// The key in files, with its unit.
    pub name: &'static str,
    /// Whether the model makes sense for positive values only.
    pub positive: bool,
    /// How the value follows from its fit coordinate.
    pub coordinate: Coordinate,
    /// Bounds of the fit coordinate, from the size of the machine.
    pub bounds: Bounds,
    /// How sentences show it.
    pub shown: Shown,
}

/// Everything that muspin knows about an effect, besides its action.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The kind.
    pub kind: EffectKind,
    /// The name in files.
    pub name: &'static str,
    /// The location it needs.
    pub location: LocationKind,
    /// Whether one axis of a bearing can have it, or one plane at a position.
    pub one_axis: bool,
    /// Its numbers, in file order.
    pub parameters: &'static [Parameter],
    /// What it changes.
    pub domain: Domain,
    /// Whether the last of several effects of this kind replaces the earlier ones.
    pub replaces: bool,
    /// Whether it couples the two planes even at rest.
    pub couples_planes: bool,
    /// Whether only a turning rotor shows it.
    pub at_speed_only: bool,
    /// Whether the file can hold only one.
    pub single: bool,
    /// Whether its position is on the spindle, not on the tool.
    pub on_spindle: bool,
    /// Where it can be what is missing; empty: only a fit tells.
    pub sites: &'static [Site],
    /// Where fits start.
    pub starts: Starts,
    /// Whether its size is worth a name, from its size, its coordinates and the size of the machine: a fifth or less of
    /// the smallest size that occurs in practice. The data may show a smaller one, and a coarse mesh may cause it.
    pub matters: fn(f64, &[f64], &MachineScale) -> bool,
    /// The finding as a sentence: `{at}` the place, `{0}` … the numbers, `{way}` the direction.
    pub sentence: &'static str,
    /// What to do about it.
    pub advice: &'static str,
}

/// A frequency as it is.
pub(super) const HERTZ: Shown = Shown::Scaled(1.0, " Hz");

/// What most effects have in common.
pub(super) const COMMON: Entry = Entry {
    kind: EffectKind::LoopDelay,
    name: "",
    location: LocationKind::None,
    one_axis: false,
    parameters: &[],
    domain: Domain::Shaft,
    replaces: false,
    couples_planes: false,
    at_speed_only: false,
    single: false,
    on_spindle: false,
    sites: &[],
    // At no effect.
    starts: Starts::At(&[&[0.0]]),
    matters: |_, _, _| true,
    sentence: "",
    advice: "",
};

/// What effects on the electronics of a bearing have in common.
pub(super) const ELECTRONIC: Entry = Entry { location: LocationKind::Bearing, domain: Domain::Electronics, ..COMMON };

/// A parameter whose value may have either sign.
pub(super) const fn signed_parameter(
    name: &'static str,
    coordinate: Coordinate,
    bounds: Bounds,
    shown: Shown,
) -> Parameter {
    Parameter { name, positive: false, coordinate, bounds, shown }
}

/// A parameter whose value must be positive.
pub(super) const fn positive(name: &'static str, coordinate: Coordinate, bounds: Bounds, shown: Shown) -> Parameter {
    Parameter { positive: true, ..signed_parameter(name, coordinate, bounds, shown) }
}
