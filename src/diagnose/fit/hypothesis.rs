//! The catalogue as hypotheses: every effect at every place it may have, in coordinates that are close to linear.
//!
//! Where an effect can vanish, its coordinate is 0 there: bandwidths as 1/f, the eddy corner as f^(−1/2), joints as
//! flexibility, the housing as 1/m, factors as logarithms. A fit can then start at the machine as it is.

use super::super::DiagnoseError;
use super::model::MOST_SD;
use crate::rotor::tilt::PARTS;
use crate::spindle::effects::LocationKind;
use crate::spindle::effects::entry::{Parameter, Starts};
use crate::spindle::effects::scale::MachineScale;
use crate::spindle::{Bearings, Effect, EffectKind, Location, Machine, Plane};

/// An effect with free numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// What it is.
    pub kind: EffectKind,
    /// Where; a position is a free number and this is where it starts.
    pub place: Location,
    /// Start of the free numbers, in fit coordinates.
    pub start: Vec<f64>,
    /// Prior standard deviation of the size, in fit coordinates, of an effect that is a nuisance parameter.
    pub(super) size_sd: Option<f64>,
    scale: MachineScale,
    span_m: (f64, f64),
}

/// Least relative error of one axis that is worth a name: five times the prior of what two axes differ by.
const LEAST_OF_AN_AXIS: f64 = 0.01;

impl Hypothesis {
    fn parameters(&self) -> &'static [Parameter] {
        self.kind.parameters()
    }

    /// The effect at fit coordinates `theta`.
    pub fn effect(&self, theta: &[f64]) -> Effect {
        let at = |i: usize| theta.get(i).copied().unwrap_or_default();
        let parameters = self.parameters().iter().enumerate();
        let values = parameters.map(|(i, p)| p.coordinate.value(at(i), &self.scale));
        let values = values.collect();
        let position_m = self.scale.position_unit_m() * theta.last().copied().unwrap_or_default();
        let location = self.place.moved_to(position_m);
        Effect { kind: self.kind, location, values }
    }

    /// Derivative of the number that coordinate `i` stands for, a value or the position, at fit coordinates `theta`.
    pub fn slope(&self, i: usize, theta: &[f64]) -> f64 {
        let at = theta.get(i).copied().unwrap_or_default();
        let own = self.parameters().get(i);
        own.map_or(self.scale.position_unit_m(), |p| p.coordinate.slope(at, &self.scale))
    }

    /// Keeps fit coordinates where the effect makes sense.
    pub fn clamp(&self, theta: &mut [f64]) {
        for (parameter, t) in self.parameters().iter().zip(theta.iter_mut()) {
            let (lo, hi) = (parameter.bounds)(&self.scale);
            *t = t.clamp(lo, hi);
        }
        if let (Some(_), Some(z)) = (self.place.position_m(), theta.last_mut()) {
            let ((from, to), unit) = (self.span_m, self.scale.position_unit_m());
            *z = z.clamp(from / unit, to / unit);
        }
    }

    /// Whether the effect is large enough to be worth a name.
    pub fn matters(&self, theta: &[f64]) -> bool {
        match self.place {
            Location::Axis(_) if matches!(self.kind, EffectKind::SensorGain | EffectKind::ForceConstant) => {
                self.size(theta).abs() > LEAST_OF_AN_AXIS
            }
            _ => (self.kind.entry().matters)(self.size(theta), theta, &self.scale),
        }
    }

    /// The same as a nuisance parameter: from the least size that is worth a name on it is further off than any prior
    /// allows.
    pub(crate) fn as_nuisance(&self) -> Self {
        let start = self.nothing();
        let of_size = |size: f64| {
            let mut theta = start.clone();
            theta.iter_mut().take(1).for_each(|t| *t += size);
            theta
        };
        // Thresholds lie within these thirty octaves; beyond, no size is worth a name.
        let (mut below, mut above) = (1e-6, 1e-6 * 2f64.powi(30));
        while above / below > 1.001 {
            let middle = (below * above).sqrt();
            if self.matters(&of_size(middle)) { above = middle } else { below = middle }
        }
        Self { size_sd: Some(above / MOST_SD), start, ..self.clone() }
    }

    /// Whether the effect is a nuisance parameter.
    pub(crate) fn is_nuisance(&self) -> bool {
        self.size_sd.is_some()
    }

    /// How many prior standard deviations the size is off, and the derivative to the first coordinate; nothing without
    /// a prior.
    pub(super) fn deviation(&self, theta: &[f64]) -> (f64, f64) {
        self.size_sd.map_or((0.0, 0.0), |sd| (self.size(theta) / sd, sd.recip()))
    }

    /// Coordinates of no effect, or of as little as they allow; numbers beside the size are those of the start.
    pub fn nothing(&self) -> Vec<f64> {
        let mut theta = self.start.clone();
        if self.in_place_of_another() {
            return theta;
        }
        if let Some(t) = theta.first_mut() {
            *t -= self.size(&self.start);
        }
        // A joint is rigid both ways.
        if self.kind == EffectKind::ToolJoint {
            theta.fill(0.0);
        }
        self.clamp(&mut theta);
        theta
    }

    /// Whether it is a law in place of another one, which no size of it makes vanish.
    pub(crate) fn in_place_of_another(&self) -> bool {
        matches!(self.kind.entry().starts, Starts::InPlaceOf(_))
    }

    /// Whether two hypotheses name the same effect at the same place; positions count as one place, as they are fitted.
    pub(crate) fn same_name(&self, other: &Self) -> bool {
        self.kind == other.kind && self.place.moved_to(0.0) == other.place.moved_to(0.0)
    }

    /// Whether the effect has one place only and few starts, so that its fit is always affordable.
    pub(crate) fn sole(&self) -> bool {
        self.place == Location::None && self.kind != EffectKind::HousingMode
    }

    /// The effect that this coordinate vector would have without any size: how far the fit is from no effect, in σ.
    pub fn size(&self, theta: &[f64]) -> f64 {
        let null = match self.kind.entry().starts {
            Starts::AtPresent(present) => present(&self.scale),
            _ => 0.0,
        };
        theta.first().map_or(0.0, |t| t - null)
    }
}

/// The effects of hypotheses at their fit coordinates.
pub fn effects(hypotheses: &[Hypothesis], theta: &[Vec<f64>]) -> Vec<Effect> {
    let both = hypotheses.iter().zip(theta);
    both.map(|(h, t)| h.effect(t)).collect()
}

/// What a set of records can show: turning or not, and the frequencies.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    /// Some record was taken at speed.
    pub turning: bool,
    /// Lowest line, rad/s.
    pub first_rad_s: f64,
    /// Highest line, rad/s.
    pub top_rad_s: f64,
}

/// Starts over the band begin at this part of the first bending frequency, or at the lowest line where that is higher:
/// the basin of a start reaches further down.
const LOWEST_START: f64 = 0.05;

/// Places of a hypothesis on the shaft from which its position is fitted.
const STATIONS: usize = 9;

/// All hypotheses for a machine.
///
/// # Errors
/// [`DiagnoseError`] when the machine breaks a rule.
pub fn catalogue(
    machine: &Machine,
    span_m: (f64, f64),
    flexible_rad_s: &[f64],
    scope: Scope,
) -> Result<Vec<Hypothesis>, DiagnoseError> {
    let scale = scale_of(machine, flexible_rad_s)?;
    let mut all = vec![];
    for kind in EffectKind::all() {
        let entry = kind.entry();
        let taken = entry.single && machine.of_kind(kind).next().is_some();
        let taken = taken || (kind.needs_tool() && machine.tool.is_absent());
        if taken || (entry.at_speed_only && !scope.turning) {
            continue;
        }
        // The nose face is at zero.
        let span_m = if entry.on_spindle { (span_m.0.max(0.0), span_m.1) } else { span_m };
        let starts = starts(entry.starts, &scale, scope);
        let mut places = match kind {
            EffectKind::TiltingStiffness => tilting_places(machine),
            _ => places(machine, entry.location, span_m, flexible_rad_s, scope),
        };
        if entry.one_axis {
            places.extend(of_one_axis(&places));
        }
        for place in places {
            for start in &starts {
                let mut start = start.clone();
                if let Some(z) = place.position_m() {
                    start.push(z / scale.position_unit_m());
                }
                all.push(Hypothesis { kind, place: place.clone(), start, size_sd: None, scale, span_m });
            }
        }
    }
    Ok(all)
}

/// Every axis of the bearings, or every position in each plane.
fn of_one_axis(places: &[Location]) -> Vec<Location> {
    let positions: Vec<f64> = places.iter().filter_map(Location::position_m).collect();
    if positions.is_empty() {
        (0..4).map(Location::Axis).collect()
    } else {
        Plane::ALL.into_iter().flat_map(|plane| positions.iter().map(move |z| Location::InPlane(*z, plane))).collect()
    }
}

/// The size of a machine, of which the free shaft has these flexible natural frequencies.
fn scale_of(machine: &Machine, flexible_rad_s: &[f64]) -> Result<MachineScale, DiagnoseError> {
    let (spindle, effective) = (&machine.spindle, machine.effective());
    let sample_period_s = spindle.electronics.sample_period_s();
    let rotor = machine.rotor()?.mass_properties();
    let bearings = [&spindle.front, &spindle.rear];
    let [nose_n_per_m, nose_n_m_per_rad] = spindle.joint_at_nose([1.0; 2]);
    Ok(MachineScale {
        sample_period_s,
        spare_delay_s: (effective.delay_s - 0.5 * sample_period_s).max(0.0),
        amplifier_bandwidth_hz: spindle.electronics.amplifier_bandwidth_hz,
        gyroscopic_factor: effective.gyroscopic_factor,
        rotor_mass_kg: rotor.mass_kg,
        bending_time_s: flexible_rad_s.first().map_or(sample_period_s, |w| w.recip()),
        bearing_span_m: spindle.planes.bearing_span_m(),
        ki_n_per_a: 0.5 * effective.bearings.iter().map(|b| b.ki_n_per_a).sum::<f64>(),
        negative_stiffness_n_per_m: effective.bearings.iter().map(|b| b.ks_n_per_m.abs()).sum(),
        force_per_gap_n_per_m: bearings.iter().map(|b| b.max_force_n / b.gap_m).sum(),
        nose_n_per_m,
        nose_n_m_per_rad,
    })
}

fn starts(starts: Starts, scale: &MachineScale, scope: Scope) -> Vec<Vec<f64>> {
    match starts {
        Starts::At(all) => all.iter().map(|start| start.to_vec()).collect(),
        Starts::AtPresent(present) => vec![vec![present(scale)]],
        Starts::InPlaceOf(start) => vec![start(scale)],
        Starts::OverTheBand { first, damping_ratio } => {
            let lowest = scope.first_rad_s.max(LOWEST_START / scale.bending_time_s);
            std::iter::successors(Some(lowest), |w| Some(w * 1.45))
                .take_while(|w| *w < scope.top_rad_s)
                .map(|w| vec![first, (w / std::f64::consts::TAU).ln(), damping_ratio.ln()])
                .collect()
        }
    }
}

/// Places of a moment: the middle of every part of an element of the spindle on which a slope is read. From part to
/// part the row goes from the rotation of the section at the ends to the slope with the shear in the middle and back,
/// so that a fit does not leave its part.
fn tilting_places(machine: &Machine) -> Vec<Location> {
    let (mut left_m, mut all) = (0.0, vec![]);
    for section in &machine.spindle.sections {
        let part_m = section.length_m / PARTS as f64;
        let middles = (0..PARTS).map(|k| left_m + (k as f64 + 0.5) * part_m);
        all.extend(middles.map(Location::Position));
        left_m += section.length_m;
    }
    all
}

fn places(
    machine: &Machine,
    location: LocationKind,
    span_m: (f64, f64),
    flexible_rad_s: &[f64],
    scope: Scope,
) -> Vec<Location> {
    match location {
        LocationKind::None => vec![Location::None],
        LocationKind::Bearing => [Bearings::Front, Bearings::Rear, Bearings::Both].map(Location::Bearing).to_vec(),
        LocationKind::Across => {
            let pairs = (0..4).flat_map(|from| (0..4).map(move |to| Location::Across { from, to }));
            pairs.filter(|pair| !matches!(pair, Location::Across { from, to } if from == to)).collect()
        }
        LocationKind::Position => (0..STATIONS)
            .map(|i| (i as f64 + 0.5) / STATIONS as f64)
            .map(|share| Location::Position(span_m.0 + (span_m.1 - span_m.0) * share))
            .collect(),
        LocationKind::Mode => {
            // A mode a little above the band still shapes its end.
            let in_reach = |w: &&f64| **w < 1.3 * scope.top_rad_s;
            let seen = flexible_rad_s.iter().take_while(in_reach).count();
            (1..=seen).map(Location::Mode).collect()
        }
        LocationKind::Region => machine.regions().into_iter().map(Location::Region).collect(),
    }
}
