//! A diagnosis in plain words: the effect, its size, its interval, and what to do about it.

use super::readable::four_digits;
use crate::diagnose::data::measurement::RecordId;
use crate::diagnose::fit::model::FurtherOff;
use crate::diagnose::locate::place::Place;
use crate::diagnose::{Diagnosis, FoundFault, NamedEffect, Verdict};
use crate::spindle::correction::is_taken;
use crate::spindle::effects::AXIS_NAMES;
use crate::spindle::effects::entry::Shown;
use crate::spindle::{Effect, EffectKind, Location};

/// The verdict in one sentence or two: what is missing, how much, how sure, what to do, and how far the gap fell.
pub fn sentence(d: &Diagnosis) -> String {
    format!("{}{}", polluted_lines(d), verdict_sentence(d))
}

/// Which lines something outside the loop disturbs; empty where none.
fn polluted_lines(d: &Diagnosis) -> String {
    let each = d.polluted_lines.iter().map(|own| format!("In sweep {} {}; left out. ", own.sweep + 1, own.words()));
    each.collect()
}

/// What the records show and is too small for a name; empty where nothing.
fn small_effects(d: &Diagnosis) -> String {
    let each: Vec<String> = d.small_effects.iter().map(statement).collect();
    if each.is_empty() {
        return String::new();
    }
    format!(" Too small to matter, and not in the corrected machine: {}.", each.join("; "))
}

fn verdict_sentence(d: &Diagnosis) -> String {
    let gap = format!(
        "The gap falls from {:.2} σ to {:.2} σ, on held-out data ({}) from {:.2} σ to {:.2} σ.",
        d.gap_before, d.gap_after, d.held_out, d.gap_before_held_out, d.gap_after_held_out
    );
    match d.verdict {
        Verdict::Adequate => format!(
            "The model describes the measurement: no discrepancy is detectable beyond nuisance parameters (force \
             constants, sensor gains, moduli, damping).{}{}{} {gap}",
            small_effects(d),
            further_off(d),
            smallest(d)
        ),
        Verdict::Named if d.effects.is_empty() => format!("{}{gap}", faults(d)),
        Verdict::Named => {
            let found: Vec<String> = d.effects.iter().map(statement).collect();
            let advice: Vec<String> = d.effects.iter().map(advice).collect();
            format!("{}{}: {}. {gap}", faults(d), capital(&found.join(", and ")), advice.join("; and "))
        }
        Verdict::Probable => {
            let found: Vec<String> = d.effects.iter().map(statement).collect();
            format!("{}Probable: {}.{} {gap}", faults(d), found.join(", and "), further_off(d))
        }
        Verdict::Tie => {
            let members: Vec<String> = d
                .tie
                .iter()
                .map(|r| {
                    let faults = r.record_faults.iter().map(fault_words);
                    let all = faults.chain(r.effects.iter().map(statement));
                    all.collect::<Vec<String>>().join(", and ")
                })
                .collect();
            let next = d
                .next_measurement
                .as_ref()
                .map_or(String::new(), |n| format!(" The measurement that would tell: {n}."));
            format!("Either {}: these data cannot tell them apart.{next} {gap}", members.join(", or "))
        }
        Verdict::Unexplained => {
            let nowhere = d.localisation.ports.first().is_none_or(|p| p.place == Place::Nowhere);
            let place = match d.localisation.named_port() {
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
            let correction = d.correction.as_ref().map_or(String::new(), |c| {
                let taken = if is_taken(&c.place.name_in_files()) {
                    "design, compare and simulate take it (--correction correction.csv)"
                } else {
                    "correction.csv has it, but no model takes a law at this place"
                };
                let ((ub, ua), (hb, ha)) = (d.gaps(false), d.gaps(true));
                format!(
                    " With the law recovered there as a correction without a name the gap falls from {ub:.2} σ to \
                     {ua:.2} σ on the records it was taken from, and from {hb:.2} σ to {ha:.2} σ on held-out data \
                     ({}): {taken}; look for the cause first.",
                    d.held_out
                )
            });
            let unsafe_words = match d.correction {
                Some(_) => String::new(),
                None => unsafe_prediction(d),
            };
            format!(
                "Something is missing that is in no catalogue{place}.{}{}{correction}{unsafe_words}",
                say_tried(d),
                say_strained(d)
            )
        }
    }
}

/// Gap, σ, from which on what leaves it has no name: more than noise and a careful model leave at most lines.
const FAR_GAP: f64 = 2.0;

/// What came nearest among all that was tried, and the gap that it leaves.
fn say_tried(d: &Diagnosis) -> String {
    let names: Vec<String> = d.nearest.iter().map(size).collect();
    if names.is_empty() {
        return format!(
            " No effect of the catalogue and no known mistake of a rig lowers the gap of {:.2} σ beyond chance.",
            d.gap_nearest
        );
    }
    if d.gap_nearest >= FAR_GAP {
        return format!(
            " No effect of the catalogue and no known mistake of a rig comes near: the nearest leaves a gap of \
             {:.1} σ.",
            d.gap_nearest
        );
    }
    let slope = if d.slope_read { " Sensors that read the slope of the shaft on such an arm come nearer." } else { "" };
    format!(
        " Of all effects and mistakes of a rig that were tried the nearest is: {}; it leaves a gap of {:.2} σ.{slope}",
        names.join(", and "),
        d.gap_nearest
    )
}

/// Which nuisance parameters would have to be off beyond their priors.
fn say_strained(d: &Diagnosis) -> String {
    let Some((name, off)) = d.strained.first() else {
        return String::new();
    };
    format!(
        " With it a nuisance parameter ({name}) would be off by {off:.0} times its usual uncertainty, which is no \
         small error: check it first."
    )
}

/// Which numbers of the machine an updating has to move first.
fn further_off(d: &Diagnosis) -> String {
    let words = |f: &FurtherOff| format!("{} by {:+.0} %", f.parameter, 100.0 * f.relative_change);
    let named: Vec<String> = d.further_off.iter().take(3).map(words).collect();
    if named.is_empty() {
        return String::new();
    }
    let more = match d.further_off.len() - named.len() {
        0 => String::new(),
        n => format!(", and {n} more"),
    };
    format!(
        " Some of these are further off than a careful updating leaves ({}{more}): update the model before a \
         design.",
        named.join("; ")
    )
}

/// That no model predicts, and where the machine as given fails most.
fn unsafe_prediction(d: &Diagnosis) -> String {
    let (from, to) = d.misfit.band_hz;
    format!(
        " No correction improves the held-out data ({}): no prediction of this machine is safe, least of all from \
         {from:.0} to {to:.0} Hz from {} to {}.",
        d.held_out,
        AXIS_NAMES[d.misfit.input % 4],
        AXIS_NAMES[d.misfit.output % 4]
    )
}

/// What is wrong with the records, as sentences; empty where nothing is.
fn faults(d: &Diagnosis) -> String {
    let each = |f: &FoundFault| format!("{}: {}. ", capital(&fault_words(f)), f.fault.remedy());
    d.record_faults.iter().map(each).collect()
}

/// A fault with its record.
pub(crate) fn fault_words(f: &FoundFault) -> String {
    let name = f.name.as_ref().map_or(String::new(), |n| format!(" ({n})"));
    let record = match f.record {
        RecordId::Sweep(s) => format!("sweep {}", s + 1),
        RecordId::Hammer(t) => format!("hammer test {}", t + 1),
    };
    format!("in {record} {}{name}", f.fault.words())
}

/// The smallest sizes that would have been seen, for a few effects that matter most to a design.
fn smallest(d: &Diagnosis) -> String {
    const SHOWN: [EffectKind; 4] =
        [EffectKind::LoopDelay, EffectKind::ToolMass, EffectKind::ToolJoint, EffectKind::AxisMisalignment];
    let found = SHOWN.iter().filter_map(|kind| d.detectable.iter().find(|e| e.effect.kind == *kind));
    let words: Vec<String> = found.map(|e| size(&e.effect)).collect();
    if words.is_empty() { String::new() } else { format!(" Smallest detectable sizes: {}.", words.join("; ")) }
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
    letters.next().map_or(String::new(), |c| c.to_uppercase().chain(letters).collect())
}

fn place(location: &Location) -> String {
    match location {
        Location::Bearing(b) => match b.name() {
            "both" => "both bearings".to_owned(),
            name => format!("the {name} bearing"),
        },
        Location::Axis(axis) => AXIS_NAMES[*axis % 4].into(),
        Location::Across { from, to } => format!("{} into {}", AXIS_NAMES[*from % 4], AXIS_NAMES[*to % 4]),
        Location::Position(z) => format!("z = {:.0} mm", 1e3 * z),
        Location::InPlane(z, plane) => format!("z = {:.0} mm in {}", 1e3 * z, plane.name()),
        Location::Mode(mode) => format!("flexible mode {mode}"),
        Location::Region(region) => format!("region {region}"),
        // Of the whole machine only the delay names its place.
        Location::None => "the loop".to_owned(),
    }
}

/// Decimals that an interval deserves: down to the first digit of its half width.
fn digits(half: f64) -> usize {
    if half > 0.0 && half.is_finite() { (-half.log10().floor()).clamp(0.0, 6.0) as usize } else { 2 }
}

/// A number in a unit with its 90 % interval: `30.0 µs (90 % 29.9…30.1)`.
fn say_range(e: &NamedEffect, i: usize, to: impl Fn(f64) -> f64, unit: &str) -> String {
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
    let entry = e.effect.kind.entry();
    let mut text = entry.sentence.replace("{at}", &place(&e.effect.location));
    for (i, parameter) in entry.parameters.iter().enumerate() {
        let shown = match parameter.shown {
            Shown::Scaled(factor, unit) => say_range(e, i, |v| factor * v, unit),
            Shown::PercentOff => say_range(e, i, |v| 100.0 * (v - 1.0), " %"),
            Shown::Either(factor, unit, [below, above]) => {
                let negative = e.effect.values.get(i).is_some_and(|v| *v < 0.0);
                let (sign, way) = if negative { (-1.0, below) } else { (1.0, above) };
                text = text.replace("{way}", way);
                say_range(e, i, |v| sign * factor * v, unit)
            }
        };
        text = text.replace(&format!("{{{i}}}"), &shown);
    }
    text
}

/// What to do about an effect.
pub fn advice(e: &NamedEffect) -> String {
    e.effect.kind.entry().advice.to_owned()
}
