//! A diagnosis in plain words: the effect, its size, its interval, and what to do about it.

use super::readable::four_digits;
use crate::diagnose::place::Place;
use crate::diagnose::{Diagnosis, NamedEffect, Verdict};
use crate::spindle::{Effect, EffectKind, Location};

/// The verdict in one sentence or two: what is missing, how much, how sure, what to do, and how far the gap fell.
pub fn sentence(d: &Diagnosis) -> String {
    let gap = format!(
        "The gap falls from {:.2} σ to {:.2} σ, on held-out data ({}) from {:.2} σ to {:.2} σ.",
        d.gap_before, d.gap_after, d.held_out, d.gap_before_held_out, d.gap_after_held_out
    );
    match d.verdict {
        Verdict::Adequate => format!(
            "The model describes the measurement: no discrepancy is detectable beyond small parameters (force constants, sensor \
             gains, moduli, damping).{} {gap}",
            smallest(d)
        ),
        Verdict::Named => {
            let found: Vec<String> = d.effects.iter().map(statement).collect();
            let advice: Vec<String> = d.effects.iter().map(advice).collect();
            format!(
                "{}: {}. {gap}",
                capital(&found.join(", and ")),
                advice.join("; and ")
            )
        }
        Verdict::Tie => {
            let members: Vec<String> = d
                .tie
                .iter()
                .map(|r| {
                    let all: Vec<String> = r.effects.iter().map(statement).collect();
                    all.join(", and ")
                })
                .collect();
            let next = d.next_measurement.as_ref().map_or(String::new(), |n| {
                format!(" The measurement that would tell: {n}.")
            });
            format!(
                "Either {}: these data cannot tell them apart.{next} {gap}",
                members.join(", or ")
            )
        }
        Verdict::Unexplained => {
            let nowhere = d
                .localisation
                .ports
                .first()
                .is_none_or(|p| p.place == Place::Nowhere);
            let place = match d.localisation.named() {
                Some(port) if !nowhere => {
                    // Noise alone leaves about 1.
                    let lead = if port.chi2_after < 2.0 {
                        "; it sits most likely at"
                    } else {
                        "; no single place explains all of it, most is explained at"
                    };
                    format!(
                        "{lead}: {}, and looks like {} (χ² per residual {:.1} without, {:.1} with a free law there)",
                        port.port,
                        port.shape(),
                        port.chi2_before,
                        port.chi2_after
                    )
                }
                _ => "; no single place stands out".to_owned(),
            };
            let correction = d.correction.as_ref().map_or(String::new(), |_| {
                let ((ub, ua), (hb, ha)) = (d.gaps(false), d.gaps(true));
                format!(
                    " With the law recovered there as a correction without a name the gap falls from {ub:.2} σ to {ua:.2} σ on the \
                     records it was taken from, and from {hb:.2} σ to {ha:.2} σ on held-out data ({}): use correction.csv for predictions, \
                     and look for the cause before a design.",
                    d.held_out
                )
            });
            format!("Something is missing that is in no catalogue{place}.{correction}")
        }
    }
}

/// The smallest sizes that would have been seen, for a few effects that matter most to a design.
fn smallest(d: &Diagnosis) -> String {
    const SHOWN: [EffectKind; 4] = [
        EffectKind::LoopDelay,
        EffectKind::ToolMass,
        EffectKind::ToolJoint,
        EffectKind::AxisMisalignment,
    ];
    let found = SHOWN
        .iter()
        .filter_map(|kind| d.detectable.iter().find(|e| e.effect.kind == *kind));
    let words: Vec<String> = found.map(|e| size(&e.effect)).collect();
    if words.is_empty() {
        String::new()
    } else {
        format!(" Smallest detectable sizes: {}.", words.join("; "))
    }
}

/// An effect without an interval, in words.
pub fn size(effect: &Effect) -> String {
    statement(&NamedEffect {
        effect: effect.clone(),
        standard_deviations: vec![],
        intervals: vec![],
        position_sd_m: None,
    })
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or(String::new(), |c| c.to_uppercase().chain(letters).collect())
}

fn place(location: &Location) -> String {
    match location {
        Location::Bearing(b) => match b.name() {
            "both" => "both bearings".to_owned(),
            name => format!("the {name} bearing"),
        },
        Location::Position(z) => format!("z = {:.0} mm", 1e3 * z),
        Location::Mode(mode) => format!("flexible mode {mode}"),
        Location::Region(region) => format!("region {region}"),
        Location::None => String::new(),
    }
}

/// Decimals that an interval deserves: down to the first digit of its half width.
fn digits(half: f64) -> usize {
    if half > 0.0 && half.is_finite() {
        (-half.log10().floor()).clamp(0.0, 6.0) as usize
    } else {
        2
    }
}

/// A number in a unit with its 90 % interval: `30.0 µs (90 % 29.9…30.1)`.
fn ranged(e: &NamedEffect, i: usize, to: impl Fn(f64) -> f64, unit: &str) -> String {
    let value = to(e.effect.values.get(i).copied().unwrap_or_default());
    let Some((a, b)) = e.intervals.get(i).map(|(a, b)| (to(*a), to(*b))) else {
        return format!("{}{unit}", four_digits(value));
    };
    let (a, b) = (a.min(b), a.max(b));
    let half = 0.5 * (b - a);
    if value.abs() >= 1e5 || half > 10.0 * value.abs() {
        return format!("{value:.3e}{unit} (90 % {a:.3e}…{b:.3e})");
    }
    let d = digits(half);
    format!("{value:.d$}{unit} (90 % {a:.d$}…{b:.d$})")
}

/// An effect with its size and interval.
pub fn statement(e: &NamedEffect) -> String {
    let at = place(&e.effect.location);
    let scaled = |i: usize, factor: f64, unit: &str| ranged(e, i, |v| factor * v, unit);
    let percent = || ranged(e, 0, |v| 100.0 * (v - 1.0), " %");
    let value = e.effect.values.first().copied().unwrap_or_default();
    let either = |factor: f64, unit: &str, [less, more]: [&'static str; 2]| match value < 0.0 {
        true => (scaled(0, -factor, unit), less),
        false => (scaled(0, factor, unit), more),
    };
    let grams = || either(1e3, " g", ["less", "more"]);
    match e.effect.kind {
        EffectKind::LoopDelay => {
            let (time, way) = either(1e6, " µs", ["faster", "slower"]);
            format!("the loop is {time} {way} than the model")
        }
        EffectKind::AmplifierBandwidth => {
            format!(
                "the amplifier of {at} has a bandwidth of {}",
                scaled(0, 1.0, " Hz")
            )
        }
        EffectKind::EddyCurrents => format!(
            "eddy currents weaken {at} from a corner of {} on",
            scaled(0, 1.0, " Hz")
        ),
        EffectKind::SensorLowpass => format!(
            "the sensors of {at} have a low-pass at {}",
            scaled(0, 1.0, " Hz")
        ),
        EffectKind::SensorOffset => format!(
            "the sensor plane of {at} sits {} off, + to the rear",
            scaled(0, 1e3, " mm")
        ),
        EffectKind::ActuatorOffset => format!(
            "the actuator plane of {at} sits {} off, + to the rear",
            scaled(0, 1e3, " mm")
        ),
        EffectKind::NegativeStiffness => {
            format!("the negative stiffness of {at} is {} off", percent())
        }
        EffectKind::ForceConstant => format!("the force constant of {at} is {} off", percent()),
        EffectKind::SensorGain => format!("the sensor gain of {at} is {} off", percent()),
        EffectKind::BearingCoupling => format!(
            "x and y of {at} are coupled by {} of the force constant",
            scaled(0, 100.0, " %")
        ),
        EffectKind::AxisMisalignment => {
            format!(
                "the sensor axes of {at} are turned by {}",
                scaled(0, 1.0, "°")
            )
        }
        EffectKind::Gyroscopic => {
            format!("the gyroscopic effect counts {} times", scaled(0, 1.0, ""))
        }
        EffectKind::InternalDamping => format!(
            "the rotor has internal damping with a loss time of {}",
            scaled(0, 1e6, " µs")
        ),
        EffectKind::CrossCoupling => format!(
            "a circulatory stiffness of {} acts at {at}",
            scaled(0, 1.0, " N/m")
        ),
        EffectKind::ModalDamping => format!(
            "the damping of {at} is {} times that of the model",
            scaled(0, 1.0, "")
        ),
        EffectKind::ToolJoint => format!(
            "the tool sits in a flexible joint of {} and {}",
            scaled(0, 1e-6, " N/µm"),
            scaled(1, 1e-3, " kN m/rad")
        ),
        EffectKind::ToolMass => {
            let (mass, way) = grams();
            format!("the tip of the tool carries {mass} {way} than the model")
        }
        EffectKind::AddedMass => {
            let (mass, way) = grams();
            format!("{mass} {way} sit at {at} than in the model")
        }
        EffectKind::HousingMode => format!(
            "the housing, {}, resonates at {} with a damping ratio of {}",
            scaled(0, 1.0, " kg"),
            scaled(1, 1.0, " Hz"),
            scaled(2, 1.0, "")
        ),
        EffectKind::RegionStiffness => format!("the modulus of {at} is {} off", percent()),
        EffectKind::AddedStiffness => {
            format!("a stiffness of {} acts at {at}", scaled(0, 1.0, " N/m"))
        }
    }
}

/// What to do about an effect.
pub fn advice(e: &NamedEffect) -> String {
    match e.effect.kind {
        EffectKind::LoopDelay => "design with the corrected file, and look for computing or PWM time that the model leaves out",
        EffectKind::AmplifierBandwidth => "measure command to coil current, and check current controller and bus voltage",
        EffectKind::EddyCurrents => "look for solid or thick laminated parts in the flux path, and design with the corrected file",
        EffectKind::SensorLowpass => "check the anti-alias filter and the demodulation of these sensors",
        EffectKind::SensorOffset => "check where the sensor ring sits on the drawing, and design with the corrected file",
        EffectKind::ActuatorOffset => "check where the magnet sits on the drawing, and design with the corrected file",
        EffectKind::NegativeStiffness => "check bias current and air gap (ks grows with i0² and falls with the cube of the gap)",
        EffectKind::ForceConstant => "check bias current, air gap and the scale of the current command",
        EffectKind::SensorGain => "calibrate against the clearance from touch-down to touch-down",
        EffectKind::BearingCoupling => "look for flux leakage or unequal poles between the axes",
        EffectKind::AxisMisalignment => "turn the sensor ring back, or rotate its signals in the controller",
        EffectKind::Gyroscopic => "design with the corrected file at every speed",
        EffectKind::InternalDamping => "verify stability at full speed with the corrected file, and check shrink fits",
        EffectKind::CrossCoupling => "repeat with motor and coolant off to find its source, and verify stability at speed with the corrected file",
        EffectKind::ModalDamping => "design with the corrected file, and check the fits that damp this mode",
        EffectKind::ToolJoint => "clean and re-clamp the taper, check the drawbar force, and repeat; if it stays, design with the corrected file",
        EffectKind::ToolMass => "weigh the tool, and correct the tool file",
        EffectKind::AddedMass => "look for a part that is not in the drawing, or coolant in the bore",
        EffectKind::HousingMode => "confirm with an accelerometer on the housing and the mount clamped, and design with the corrected file",
        EffectKind::RegionStiffness => "check the shrink fit or lamination stack of this region, and design with the corrected file",
        EffectKind::AddedStiffness => "repeat with the motor off (its pull is negative), and look for seals or cables there",
    }
    .to_owned()
}
