//! What is missing in the model of a rotor without magnets, from hammer tests, with the corrected file.

use super::failure::Failure;
use super::update::taps_of;
use crate::diagnose::Verdict;
use crate::diagnose::rotor_alone::{RotorDiagnosis, diagnose_rotor};
use crate::input::{Measurement, rotor_yaml, tool_yaml};
use crate::report::page_summary::diagnosis_verdict;
use crate::report::pictures::Picture;
use crate::report::plot::Figure;
use crate::report::plot::diagnosis::ranking;
use crate::report::summary::omit_absent;
use crate::report::updating::{error_table, errors_figure};
use crate::report::whole::Report;
use crate::rotor::{Disc, Section};
use crate::spindle::RotorOnSupports;
use crate::update::alternatives::RotorParameter;
use crate::update::single_change::FittedChange;
use serde_json::{Value, json};

/// Diagnoses a rotor from the hammer tests of a measurement; the notes say which are left out.
pub(crate) fn diagnose_taps(
    rotor: &RotorOnSupports,
    measurement: &Measurement,
) -> Result<(RotorDiagnosis, Vec<String>), Failure> {
    let shaft = rotor.rotor()?;
    let (targets, notes) = taps_of(measurement, &shaft, rotor.tool_plane_m(), &|axis| rotor.springs(axis))?;
    Ok((diagnose_rotor(&shaft, &targets)?, notes))
}

/// Whether the records are explained.
pub(crate) fn is_explained(found: &RotorDiagnosis) -> bool {
    found.verdict != Verdict::Unexplained
}

/// Figures, tables and the corrected files; without a name they are those that were given.
pub(crate) fn diagnosed_report(rotor: &RotorOnSupports, found: &RotorDiagnosis) -> Result<Report, Failure> {
    let mut report = Report::of_rotor("diagnose", rotor);
    report.summary.set("diagnosis", diagnosis_topic(found));
    let effect = found.named().map(|change| change_name(change.parameter.as_ref()));
    let words = diagnosis_verdict(found.verdict.name(), &effect.into_iter().collect::<Vec<&str>>());
    report.verdict(is_explained(found), &words.map_or_else(String::new, |(_, words)| words));
    let best = found.found.changes.first().filter(|_| found.verdict != Verdict::Adequate);
    let changed = best.map(|change| ("with the change", change.errors.as_slice()));
    let models: Vec<_> =
        [("moduli alone", found.found.as_drawn.errors.as_slice())].into_iter().chain(changed).collect();
    report.figures([(Picture::RotorErrors, errors_figure(&models)), (Picture::Ranking, changes_figure(found))])?;
    let folder = &mut report.folder;
    folder.add_table("errors.csv", &error_table(&models))?;
    let corrected = found.named().map_or_else(|| rotor.clone(), |change| corrected(rotor, found, change));
    folder.add("spindle.yaml", rotor_yaml(&corrected))?;
    if let Some(tool) = &corrected.tool {
        folder.add("tool.yaml", tool_yaml(tool))?;
    }
    Ok(report)
}

/// What the best changes leave, beside the rotor as drawn.
fn changes_figure(found: &RotorDiagnosis) -> Figure {
    let shown = || found.found.changes.iter().take(CHANGES_SHOWN).chain([&found.found.as_drawn]);
    let names: Vec<String> = shown().map(|change| found.change_words(change)).collect();
    let left: Vec<f64> = shown().map(|change| (1.0 + change.statistic).log10()).collect();
    let limit = (1.0 + found.found.limit).log10();
    let label = format!("log10(1 + χ² left); explained below {limit:.2}");
    ranking("Single changes, best first, and the rotor as drawn", &names, &left, &label)
}

/// Bars of the picture: half a page.
const CHANGES_SHOWN: usize = 15;

/// `diagnosis` of the summary.
pub(crate) fn diagnosis_topic(found: &RotorDiagnosis) -> Value {
    let of = |change: &FittedChange| change_topic(found, change);
    let nearest = found.found.changes.first().filter(|_| found.verdict == Verdict::Unexplained);
    let topic = json!({
        "verdict": found.verdict.name(),
        "sentence": found.sentence(),
        "frequencies": found.found.fitted,
        "held_out": found.found.held_out,
        "chi_squared_limit": found.found.limit,
        "as_drawn": of(&found.found.as_drawn),
        "effects": found.named().map(of).into_iter().collect::<Vec<Value>>(),
        "tie": found.rivals.iter().filter(|_| found.verdict == Verdict::Tie).map(of).collect::<Vec<Value>>(),
        "nearest": nearest.map(of),
    });
    omit_absent(topic, &["nearest"])
}

/// The name of a change in files.
fn change_name(parameter: Option<&RotorParameter>) -> &'static str {
    match parameter {
        None => "as_drawn",
        Some(RotorParameter::Mass(_)) => "added_mass",
        Some(RotorParameter::Modulus(_)) => "region_stiffness",
        Some(RotorParameter::Density(_)) => "region_density",
        Some(RotorParameter::Diameter(_)) => "region_diameter",
        Some(RotorParameter::Discs) => "discs",
        Some(RotorParameter::Supports) => "supports",
        Some(RotorParameter::Magnets) => "negative_stiffness",
    }
}

fn change_topic(found: &RotorDiagnosis, change: &FittedChange) -> Value {
    let factor = json!({ "factor": change.factor });
    let (place, parameters) = match &change.parameter {
        None => (json!({}), json!({})),
        Some(RotorParameter::Mass(position_m)) => {
            (json!({ "position_m": position_m }), json!({ "mass_kg": found.mass_kg(change) }))
        }
        Some(RotorParameter::Modulus(region) | RotorParameter::Density(region) | RotorParameter::Diameter(region)) => {
            (json!({ "region": region }), factor)
        }
        Some(RotorParameter::Discs | RotorParameter::Supports | RotorParameter::Magnets) => (json!({}), factor),
    };
    json!({
        "effect": change_name(change.parameter.as_ref()),
        "where": place,
        "parameters": parameters,
        "chi_squared": change.statistic,
        "chi_squared_held_out": change.held_out,
        "words": found.change_words(change),
    })
}

/// The rotor with a change and the moduli beside it.
fn corrected(rotor: &RotorOnSupports, found: &RotorDiagnosis, change: &FittedChange) -> RotorOnSupports {
    let mut corrected = rotor.clone();
    let of_tool = corrected.tool.iter_mut().flat_map(|tool| &mut tool.sections);
    for section in corrected.sections.iter_mut().chain(of_tool) {
        correct_section(section, change);
    }
    match &change.parameter {
        Some(RotorParameter::Mass(position_m)) => add_mass(&mut corrected, *position_m, found.mass_kg(change)),
        Some(RotorParameter::Discs) => {
            for disc in &mut corrected.discs {
                disc.mass_kg *= change.factor;
                disc.polar_inertia_kg_m2 *= change.factor;
                disc.diametral_inertia_kg_m2 *= change.factor;
            }
        }
        Some(RotorParameter::Supports) => {
            let stiffness = corrected.supports.iter_mut().flat_map(|support| &mut support.stiffness_n_per_m);
            stiffness.flatten().for_each(|k| *k *= change.factor);
        }
        _ => {}
    }
    corrected
}

/// What a change and the moduli beside it do to a section.
fn correct_section(section: &mut Section, change: &FittedChange) {
    let Some(region) = section.region.clone() else {
        return;
    };
    let beside = change.modulus_factors.iter().find(|(name, _)| *name == region);
    section.modulus_scale *= beside.map_or(1.0, |(_, factor)| *factor);
    match &change.parameter {
        Some(RotorParameter::Modulus(name)) if *name == region => section.modulus_scale *= change.factor,
        Some(RotorParameter::Density(name)) if *name == region => section.material.density_kg_m3 *= change.factor,
        Some(RotorParameter::Diameter(name)) if *name == region => {
            section.outer_diameter_m = section.outer_diameter_m.map(|d| d * change.factor);
            section.mass_outer_diameter_m = section.mass_outer_diameter_m.map(|d| d * change.factor);
        }
        _ => {}
    }
}

/// Adds a mass as a disc; where no node stands an element is split.
fn add_mass(rotor: &mut RotorOnSupports, position_m: f64, mass_kg: f64) {
    let mut from_m = 0.0;
    for k in 0..rotor.sections.len() {
        let length_m = rotor.sections[k].length_m;
        let part_m = position_m - from_m;
        if part_m > SAME_NODE_M && part_m < length_m - SAME_NODE_M {
            let mut rest = rotor.sections[k].clone();
            rotor.sections[k].length_m = part_m;
            rest.length_m = length_m - part_m;
            rotor.sections.insert(k + 1, rest);
            break;
        }
        from_m += length_m;
    }
    rotor.discs.push(Disc { position_m, mass_kg, polar_inertia_kg_m2: 0.0, diametral_inertia_kg_m2: 0.0 });
}

/// Places closer than this are one node, as in a file of keys.
const SAME_NODE_M: f64 = 1e-6;
