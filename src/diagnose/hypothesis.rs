//! The catalogue as hypotheses: every effect at every place it may have, in coordinates that are close to linear.
//!
//! Where an effect can vanish, its coordinate is 0 there: bandwidths as 1/f, the eddy corner as f^(−1/2), joints as flexibility,
//! the housing as 1/m, factors as logarithms. A fit can then start at the machine as it is.

use super::DiagnoseError;
use super::coordinate::Coordinate;
use crate::spindle::{Bearings, Effect, EffectKind, Location, Machine};

/// An effect with free numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// What it is.
    pub kind: EffectKind,
    /// Where; a position is a free number and this is where it starts.
    pub place: Location,
    /// Start of the free numbers, in fit coordinates.
    pub start: Vec<f64>,
    nominal: f64,
    span_m: (f64, f64),
}

/// Fit coordinate of a position: m per unit.
const POSITION_UNIT_M: f64 = 0.05;

impl Hypothesis {
    /// The coordinates of the values.
    fn coordinates(&self) -> Vec<Coordinate> {
        let linear = |unit: f64| vec![Coordinate::Linear(unit)];
        match self.kind {
            EffectKind::LoopDelay => linear(1e-5),
            EffectKind::AmplifierBandwidth => vec![Coordinate::Slowness {
                nominal: self.nominal,
                unit: 1e-4,
            }],
            EffectKind::EddyCurrents => vec![Coordinate::InverseSquare(1e4)],
            EffectKind::SensorLowpass => vec![Coordinate::Inverse(1e4)],
            EffectKind::SensorOffset | EffectKind::ActuatorOffset => linear(1e-3),
            EffectKind::NegativeStiffness
            | EffectKind::ForceConstant
            | EffectKind::SensorGain
            | EffectKind::ModalDamping
            | EffectKind::RegionStiffness => vec![Coordinate::Logarithm],
            EffectKind::Gyroscopic | EffectKind::AxisMisalignment => linear(1.0),
            EffectKind::BearingCoupling => linear(1e-2),
            EffectKind::InternalDamping => linear(1e-6),
            EffectKind::CrossCoupling | EffectKind::AddedStiffness => linear(1e5),
            EffectKind::ToolJoint => vec![
                Coordinate::Inverse(1e9),
                Coordinate::Inverse(1e6),
                Coordinate::Linear(1.0),
            ],
            EffectKind::ToolMass => linear(5e-3),
            EffectKind::AddedMass => linear(5e-2),
            EffectKind::HousingMode => vec![
                Coordinate::Inverse(100.0),
                Coordinate::Logarithm,
                Coordinate::Logarithm,
            ],
        }
    }

    /// The effect at fit coordinates `theta`.
    pub fn effect(&self, theta: &[f64]) -> Effect {
        let at = |i: usize| theta.get(i).copied().unwrap_or_default();
        let coordinates = self.coordinates().into_iter().enumerate();
        let values = coordinates.map(|(i, c)| c.value(at(i))).collect();
        let location = match &self.place {
            Location::Position(_) => {
                let z = POSITION_UNIT_M * theta.last().copied().unwrap_or_default();
                Location::Position(z)
            }
            place => place.clone(),
        };
        Effect {
            kind: self.kind,
            location,
            values,
        }
    }

    /// Derivative of the number that coordinate `i` stands for, a value or the position, at fit coordinates `theta`.
    pub fn slope(&self, i: usize, theta: &[f64]) -> f64 {
        let at = theta.get(i).copied().unwrap_or_default();
        let own = self.coordinates().get(i).map(|c| c.slope(at));
        own.unwrap_or(POSITION_UNIT_M)
    }

    /// Keeps fit coordinates where the effect makes sense.
    pub fn clamp(&self, theta: &mut [f64]) {
        let limit = |t: &mut f64, lo: f64, hi: f64| *t = t.clamp(lo, hi);
        let (lo, hi) = match self.kind {
            // Half a sample is the least total delay; nominal is in s.
            EffectKind::LoopDelay => (-self.nominal / 1e-5, 100.0),
            EffectKind::AmplifierBandwidth => (1e4 * (2e-6 - 1.0 / self.nominal), 1e2),
            EffectKind::EddyCurrents => (0.02, 50.0),
            EffectKind::SensorLowpass => (0.02, 50.0),
            EffectKind::SensorOffset | EffectKind::ActuatorOffset => (-30.0, 30.0),
            EffectKind::NegativeStiffness
            | EffectKind::ForceConstant
            | EffectKind::SensorGain
            | EffectKind::RegionStiffness => (-2.0, 2.0),
            EffectKind::ModalDamping => (-4.0, 4.0),
            EffectKind::Gyroscopic => (-1.0, 3.0),
            EffectKind::AxisMisalignment => (-45.0, 45.0),
            EffectKind::BearingCoupling => (-50.0, 50.0),
            EffectKind::InternalDamping => (-100.0, 100.0),
            EffectKind::CrossCoupling | EffectKind::AddedStiffness => (-200.0, 200.0),
            EffectKind::ToolJoint => (1e-3, 100.0),
            EffectKind::ToolMass => (-10.0, 100.0),
            EffectKind::AddedMass => (-10.0, 60.0),
            EffectKind::HousingMode => (1e-3, 50.0),
        };
        if let Some(t) = theta.first_mut() {
            limit(t, lo, hi);
        }
        match (self.kind, &mut theta[..]) {
            (EffectKind::ToolJoint, [_, r, c]) => {
                limit(r, 1e-3, 1000.0);
                limit(c, -20.0, 500.0);
            }
            (EffectKind::HousingMode, [_, f, z]) => {
                limit(f, 10f64.ln(), 6000f64.ln());
                limit(z, 1e-4f64.ln(), 0.7f64.ln());
            }
            _ => {}
        }
        if let (Location::Position(_), Some(z)) = (&self.place, theta.last_mut()) {
            limit(
                z,
                self.span_m.0 / POSITION_UNIT_M,
                self.span_m.1 / POSITION_UNIT_M,
            );
        }
    }

    /// Whether the effect is large enough to be worth a name: a fifth or less of the smallest that spindles have in practice.
    /// What is smaller, the data may show and a mesh may cause.
    pub fn matters(&self, theta: &[f64]) -> bool {
        let size = self.size(theta).abs();
        let at = |i: usize| theta.get(i).copied().unwrap_or_default();
        match self.kind {
            // 0.5 µs.
            EffectKind::LoopDelay => size > 0.05,
            // 2 % of the bandwidth.
            EffectKind::AmplifierBandwidth => size * 1e-4 * self.nominal > 0.02,
            // Corners below 1 MHz and 200 kHz.
            EffectKind::EddyCurrents => size > 0.1,
            EffectKind::SensorLowpass => size > 0.05,
            // 0.2 mm.
            EffectKind::SensorOffset | EffectKind::ActuatorOffset => size > 0.2,
            EffectKind::NegativeStiffness => size > 0.03,
            // 5 %, five times what careful updating leaves open.
            EffectKind::RegionStiffness => size > 0.05,
            EffectKind::ForceConstant | EffectKind::SensorGain => size > 0.02,
            // A factor of 1.4, or of 0.45: a ratio known to 20 % is that low once in three hundred, as a logarithm it seems much rarer.
            EffectKind::ModalDamping => size > if self.size(theta) < 0.0 { 0.8 } else { 0.35 },
            EffectKind::Gyroscopic => size > 0.03,
            // 0.1 degree.
            EffectKind::AxisMisalignment => size > 0.1,
            // 0.1 % of the force constant.
            EffectKind::BearingCoupling => size > 0.1,
            EffectKind::InternalDamping => size > 0.02,
            // 2000 N/m and 20 000 N/m.
            EffectKind::CrossCoupling => size > 0.02,
            EffectKind::AddedStiffness => size > 0.2,
            // 2·10¹⁰ N/m and 2·10⁷ N m/rad: as stiff as solid steel.
            EffectKind::ToolJoint => size > 0.05 || at(1) > 0.05,
            // 0.3 g and 2 g.
            EffectKind::ToolMass => size > 0.06,
            EffectKind::AddedMass => size > 0.04,
            // 5 t.
            EffectKind::HousingMode => size > 0.02,
        }
    }

    /// Coordinates of no effect, or of as little as they allow; numbers beside the size are those of the start.
    pub fn nothing(&self) -> Vec<f64> {
        let mut theta = self.start.clone();
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

    /// Whether two hypotheses name the same effect at the same place; positions count as one place, as they are fitted.
    pub fn same_name(&self, other: &Self) -> bool {
        self.kind == other.kind
            && (self.place == other.place
                || matches!(
                    (&self.place, &other.place),
                    (Location::Position(_), Location::Position(_))
                ))
    }

    /// Whether the effect has one place only and few starts, so that its fit is always affordable.
    pub fn sole(&self) -> bool {
        self.place == Location::None && self.kind != EffectKind::HousingMode
    }

    /// The effect that this coordinate vector would have without any size: how far the fit is from no effect, in σ.
    pub fn size(&self, theta: &[f64]) -> f64 {
        let null = match self.kind {
            EffectKind::Gyroscopic => self.nominal,
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

/// What a set of records can show: turning or not, and the highest frequency.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    /// Some record was taken at speed.
    pub turning: bool,
    /// Highest line, rad/s.
    pub top_rad_s: f64,
}

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
    let effective = machine.effective();
    let mut all = vec![];
    let make = |kind: EffectKind, place: Location, nominal: f64, start: &[f64]| Hypothesis {
        kind,
        place,
        start: start.to_vec(),
        nominal,
        span_m,
    };
    for kind in EffectKind::ALL {
        let already = machine.of_kind(kind).next().is_some();
        match kind {
            EffectKind::LoopDelay => {
                let spare = effective.delay_s - 0.5 * machine.spindle.electronics.sample_period_s();
                all.push(make(kind, Location::None, spare.max(0.0), &[0.0]));
            }
            EffectKind::Gyroscopic if scope.turning => {
                let factor = effective.gyroscopic_factor;
                all.push(make(kind, Location::None, factor, &[factor]));
            }
            EffectKind::InternalDamping => all.push(make(kind, Location::None, 0.0, &[0.0])),
            EffectKind::ToolMass => {
                // 0, 5 and 15 g: the resonance of a slender tool moves by more than its width.
                for start in [0.0, 1.0, 3.0] {
                    all.push(make(kind, Location::None, 0.0, &[start]));
                }
            }
            EffectKind::ToolJoint if !already => {
                // A stiff joint, and one as soft as collets get.
                for start in [[1.0, 1.0, 0.0], [6.0, 10.0, 0.5]] {
                    all.push(make(kind, Location::None, 0.0, &start));
                }
            }
            EffectKind::HousingMode => {
                // One start per octave or so: the basin of a resonance is not much wider.
                let mut hz = 60.0;
                while hz < scope.top_rad_s / std::f64::consts::TAU {
                    all.push(make(
                        kind,
                        Location::None,
                        0.0,
                        &[0.5, f64::ln(hz), 0.05f64.ln()],
                    ));
                    hz *= 1.45;
                }
            }
            EffectKind::AmplifierBandwidth
            | EffectKind::EddyCurrents
            | EffectKind::SensorLowpass
            | EffectKind::SensorOffset
            | EffectKind::ActuatorOffset
            | EffectKind::NegativeStiffness
            | EffectKind::ForceConstant
            | EffectKind::SensorGain
            | EffectKind::BearingCoupling
            | EffectKind::AxisMisalignment => {
                let start = match kind {
                    EffectKind::EddyCurrents | EffectKind::SensorLowpass => 0.1,
                    _ => 0.0,
                };
                for which in [Bearings::Front, Bearings::Rear, Bearings::Both] {
                    let nominal = machine.spindle.electronics.amplifier_bandwidth_hz;
                    all.push(make(kind, Location::Bearing(which), nominal, &[start]));
                }
            }
            EffectKind::CrossCoupling | EffectKind::AddedMass | EffectKind::AddedStiffness => {
                let points = 9;
                for i in 0..points {
                    let z = span_m.0 + (span_m.1 - span_m.0) * (i as f64 + 0.5) / points as f64;
                    all.push(make(
                        kind,
                        Location::Position(z),
                        0.0,
                        &[0.0, z / POSITION_UNIT_M],
                    ));
                }
            }
            EffectKind::ModalDamping => {
                // A mode a little above the band still shapes its end.
                let seen = flexible_rad_s
                    .iter()
                    .take_while(|w| **w < 1.3 * scope.top_rad_s);
                for mode in 1..=seen.count() {
                    all.push(make(kind, Location::Mode(mode), 0.0, &[0.0]));
                }
            }
            EffectKind::RegionStiffness => {
                for region in machine.regions() {
                    all.push(make(kind, Location::Region(region), 0.0, &[0.0]));
                }
            }
            EffectKind::Gyroscopic | EffectKind::ToolJoint => {}
        }
    }
    Ok(all)
}
