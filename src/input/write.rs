//! Spindle and tool values back to YAML that loads everywhere: numbers in shortest round-trip form that YAML 1.1
//! readers see as numbers too (1.5e+6, not 1.5e6), strings quoted where plain text would be something else.

use super::correction::CORRECTION_FILE;
use crate::rotor::{Disc, Material, Section};
use crate::spindle::effects::AXIS_NAMES;
use crate::spindle::machine::STIFFNESS_BAND_HZ;
use crate::spindle::{Effect, Location, Machine, RotorOnSupports, Side, Spindle, Tool};
use serde::Serialize;
use std::fmt::Display;

/// `spindle.yaml` and, where there are such, `tool.yaml` and `correction.csv` of a machine.
pub(crate) fn machine_files(machine: &Machine) -> Vec<(&'static str, String)> {
    let tool = (!machine.tool.is_absent()).then(|| ("tool.yaml", tool_yaml(&machine.tool)));
    let correction = machine.correction.as_ref().map(|correction| (CORRECTION_FILE, correction.text.clone()));
    [("spindle.yaml", spindle_yaml(&machine.spindle))].into_iter().chain(tool).chain(correction).collect()
}

/// The file of a rotor without magnets (formats.md, section 1).
pub fn rotor_yaml(rotor: &RotorOnSupports) -> String {
    let mut lines = vec![format!("name: {}", text(&rotor.name))];
    lines.extend(rotor_lines(&rotor.sections, &rotor.discs));
    lines.push(damping_line(&rotor.damping_ratio));
    lines.push(format!("gyroscopics: {}", rotor.gyroscopics));
    if !rotor.supports.is_empty() {
        lines.push("supports:".into());
    }
    lines.extend(rotor.supports.iter().map(|s| {
        let by_plane = |m: [[f64; 2]; 2]| format!("{{x: {}, y: {}}}", number(m[0][0]), number(m[1][1]));
        format!(
            "  - {{position_m: {}, stiffness_n_per_m: {}, damping_n_s_per_m: {}}}",
            number(s.position_m),
            by_plane(s.stiffness_n_per_m),
            by_plane(s.damping_n_s_per_m)
        )
    }));
    lines.join("\n") + "\n"
}

fn damping_line(ratios: &[f64]) -> String {
    let ratios: Vec<String> = ratios.iter().map(|z| number(*z)).collect();
    format!("  damping_ratio: [{}]", ratios.join(", "))
}

/// A spindle file (formats.md, section 1). Sections are cylinders, as everywhere in that format.
pub fn spindle_yaml(spindle: &Spindle) -> String {
    let mut lines = vec![format!("name: {}", text(&spindle.name))];
    lines.extend(rotor_lines(&spindle.sections, &spindle.discs));
    lines.push(damping_line(&spindle.damping_ratio));
    lines.push(format!("  flexible_modes: {}", spindle.flexible_modes));
    lines.push(format!("gyroscopics: {}", spindle.gyroscopics));
    lines.push("planes:".into());
    lines.extend(numbers(&spindle.planes).iter().map(|(key, value)| format!("  {key}: {}", number(*value))));
    lines.push("bearings:".into());
    for side in Side::ALL {
        let mut values = numbers(spindle.bearing(side));
        values.retain(|(key, value)| key != "sensor_gain" || *value != 1.0);
        lines.push(format!("  {}: {{{}}}", side.name(), pairs(&values)));
    }
    lines.push("electronics:".into());
    lines.extend(numbers(&spindle.electronics).iter().map(|(key, value)| format!("  {key}: {}", number(*value))));
    lines.push(format!("speed: {{max_rpm: {}}}", number(spindle.max_rpm)));
    lines.push(format!("backup_clearance_m: {}", number(spindle.backup_clearance_m)));
    if !spindle.backup_bearings.is_open() {
        lines.push(format!("backup_bearings: {{{}}}", pairs(&numbers(&spindle.backup_bearings))));
    }
    lines.extend(spindle.thrust.iter().map(|thrust| format!("thrust: {{{}}}", pairs(&numbers(thrust)))));
    if spindle.stiffness_band_hz != STIFFNESS_BAND_HZ {
        let (from, to) = spindle.stiffness_band_hz;
        let values = pairs(&[("from_hz", from), ("to_hz", to)]);
        lines.push(format!("stiffness_band: {{{values}}}"));
    }
    lines.extend(spindle.output_m.map(|output_m| format!("output_m: {}", number(output_m))));
    if spindle.effects.is_empty() {
        lines.push("effects: []".into());
    } else {
        lines.push("effects:".into());
        lines.extend(spindle.effects.iter().map(|e| format!("  - {}", effect(e))));
    }
    lines.join("\n") + "\n"
}

/// The lines of `rotor:` with materials, elements and discs, without damping and modes.
pub(crate) fn rotor_lines(sections: &[Section], discs: &[Disc]) -> Vec<String> {
    let mut lines = vec!["rotor:".to_owned(), "  materials:".to_owned()];
    let materials = materials(sections);
    lines.extend(materials.iter().map(|m| format!("    {}", material(m))));
    lines.push("  elements:".into());
    lines.extend(sections.iter().map(|s| format!("    - {}", section(s))));
    if !discs.is_empty() {
        lines.push("  discs:".into());
        lines.extend(discs.iter().map(|d| format!("    - {}", disc(d))));
    }
    lines
}

/// A tool file (formats.md, section 2), its materials included.
pub fn tool_yaml(tool: &Tool) -> String {
    let mut lines = vec![format!("name: {}", text(&tool.name)), "materials:".into()];
    lines.extend(materials(&tool.sections).iter().map(|m| format!("  {}", material(m))));
    lines.push("elements:".into());
    lines.extend(tool.sections.iter().map(|s| format!("  - {}", section(s))));
    if !tool.discs.is_empty() {
        lines.push("discs:".into());
        lines.extend(tool.discs.iter().map(|d| format!("  - {}", disc(d))));
    }
    lines.push(format!("tool_plane_m: {}", number(tool.tool_plane_m)));
    lines.extend(tool.teeth.map(|teeth| format!("teeth: {teeth}")));
    lines.join("\n") + "\n"
}

/// One effect as a flow mapping.
pub fn effect(effect: &Effect) -> String {
    let mut parts = vec![format!("effect: {}", effect.kind.name())];
    match &effect.location {
        Location::None => {}
        Location::Bearing(b) => parts.push(format!("bearing: {}", b.name())),
        Location::Axis(axis) => {
            let name = AXIS_NAMES.get(*axis).copied().unwrap_or_default();
            parts.push(format!("axis: {name}"));
        }
        Location::Across { from, to } => {
            let name = |axis: &usize| AXIS_NAMES.get(*axis).copied().unwrap_or_default();
            parts.push(format!("from: {}, to: {}", name(from), name(to)));
        }
        Location::Position(z) => parts.push(format!("position_m: {}", number(*z))),
        Location::InPlane(z, plane) => {
            parts.push(format!("position_m: {}, axis: {}", number(*z), plane.name()));
        }
        Location::Mode(mode) => parts.push(format!("mode: {mode}")),
        Location::Region(region) => parts.push(format!("region: {}", text(region))),
    }
    let names = effect.kind.parameters().iter();
    parts.extend(names.zip(&effect.values).map(|(p, v)| format!("{}: {}", p.name, number(*v))));
    format!("{{{}}}", parts.join(", "))
}

/// A number in shortest round-trip form with a decimal point, and a signed exponent where there is one.
pub fn number(x: f64) -> String {
    let plain = format!("{x:?}");
    let Some((mantissa, exponent)) = plain.split_once('e') else {
        return plain;
    };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{mantissa}{point}e{sign}{exponent}")
}

/// Plain where that is safe, else in double quotes.
pub fn text(value: &str) -> String {
    let plain = value.chars().next().is_some_and(char::is_alphabetic)
        && value.chars().all(|c| c.is_alphanumeric() || "-_".contains(c))
        && !["true", "false", "null", "yes", "no", "on", "off", "y", "n", "nan", "inf"]
            .contains(&value.to_lowercase().as_str());
    if plain {
        return value.to_owned();
    }
    // A JSON string is a YAML double-quoted scalar.
    serde_json::Value::from(value).to_string()
}

/// Keys and values of a group as the file has it, without those that are left open.
fn numbers(group: &impl Serialize) -> Vec<(String, f64)> {
    let group = serde_json::to_value(group).unwrap_or_default();
    let all = group.as_object().into_iter().flatten();
    all.filter_map(|(key, value)| Some((key.clone(), value.as_f64()?))).collect()
}

fn pairs<K: Display>(values: &[(K, f64)]) -> String {
    let parts: Vec<String> = values.iter().map(|(k, v)| format!("{k}: {}", number(*v))).collect();
    parts.join(", ")
}

/// Materials in order of first use.
fn materials(sections: &[Section]) -> Vec<&Material> {
    let mut found: Vec<&Material> = vec![];
    for section in sections {
        if found.iter().all(|m| m.name != section.material.name) {
            found.push(&section.material);
        }
    }
    found
}

fn material(m: &Material) -> String {
    let values = [
        ("youngs_modulus_pa", m.youngs_modulus_pa),
        ("density_kg_m3", m.density_kg_m3),
        ("poisson_ratio", m.poisson_ratio),
    ];
    format!("{}: {{{}}}", text(&m.name), pairs(&values))
}

fn section(s: &Section) -> String {
    let mut parts = vec![pairs(&[
        ("length_m", s.length_m),
        ("outer_diameter_m", s.outer_diameter_m[0]),
        ("inner_diameter_m", s.inner_diameter_m[0]),
    ])];
    parts.push(format!("material: {}", text(&s.material.name)));
    if s.mass_outer_diameter_m != s.outer_diameter_m {
        parts.push(pairs(&[("mass_outer_diameter_m", s.mass_outer_diameter_m[0])]));
    }
    if s.mass_inner_diameter_m != s.inner_diameter_m {
        parts.push(pairs(&[("mass_inner_diameter_m", s.mass_inner_diameter_m[0])]));
    }
    if s.modulus_scale != 1.0 {
        parts.push(pairs(&[("modulus_scale", s.modulus_scale)]));
    }
    if let Some(region) = &s.region {
        parts.push(format!("region: {}", text(region)));
    }
    format!("{{{}}}", parts.join(", "))
}

fn disc(d: &Disc) -> String {
    let values = [
        ("position_m", d.position_m),
        ("mass_kg", d.mass_kg),
        ("polar_inertia_kg_m2", d.polar_inertia_kg_m2),
        ("diametral_inertia_kg_m2", d.diametral_inertia_kg_m2),
    ];
    format!("{{{}}}", pairs(&values))
}
