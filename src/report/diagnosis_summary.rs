//! A diagnosis as the topic `diagnosis` of the summary.

use super::diagnosis_words::{fault_words, sentence, size, statement};
use super::summary::omit_absent;
use crate::diagnose::conclude::verdict::Rival;
use crate::diagnose::locate::localisation::PortScore;
use crate::diagnose::{Diagnosis, NamedEffect, Verdict};
use crate::pipeline::consequence::{Consequence, LoopOutcome};
use crate::spindle::effects::AXIS_NAMES as AXES;
use crate::spindle::{Effect, Location};
use serde::Serialize;
use serde_json::{Map, Value, json};

/// Half width of the interval that holds 90 % of a normal distribution, in standard deviations.
const HALF_WIDTH_90: f64 = 1.645;

/// `diagnosis`.
pub(crate) fn diagnosis_topic(d: &Diagnosis) -> Value {
    let strained = d.strained.iter();
    let strained = strained.map(|(name, sd)| json!({ "parameter": name, "prior_standard_deviations": sd }));
    let further_off = d.further_off.iter().map(|f| {
        let (usual, relative) = (f.usual_deviations, f.relative_change);
        json!({ "parameter": f.parameter, "usual_deviations": usual, "relative_change": relative })
    });
    let menu = d.menu.iter().map(|m| json!({ "measurement": m.text, "separation_chi2": m.separation }));
    let detectable = d.detectable.iter().map(|e| {
        json!({
            "effect": e.effect.kind.name(),
            "where": place_topic(&e.effect.location),
            "parameters": parameters(&e.effect),
            "words": size(&e.effect),
            "named_from": parameters(&e.named_from),
        })
    });
    let ranking = d.ranking.iter().map(
        |(e, score)| json!({ "effect": e.kind.name(), "where": place_topic(&e.location), "score_above_best": score }),
    );
    let (used, held) = (d.gaps(false), d.gaps(true));
    let topic = json!({
        "verdict": d.verdict.name(),
        "sentence": sentence(d),
        "effects": d.effects.iter().map(effect_topic).collect::<Vec<_>>(),
        // Shown by the records and too small for a name.
        "small_effects": d.small_effects.iter().map(effect_topic).collect::<Vec<_>>(),
        "tie": d.tie.iter().map(rival_topic).collect::<Vec<_>>(),
        "gap_before": d.gap_before,
        "gap_after": d.gap_after,
        "gap_nearest": d.gap_nearest,
        // What came nearest to records that nothing explains.
        "nearest": (d.verdict == Verdict::Unexplained).then(|| {
            let effects = d.nearest.iter().cloned().map(|e| effect_topic(&NamedEffect::from(e)));
            json!({ "effects": effects.collect::<Vec<_>>(), "gap": d.gap_nearest })
        }),
        "strained": strained.collect::<Vec<_>>(),
        "further_off": further_off.collect::<Vec<_>>(),
        "gap_before_used": used.0,
        "gap_after_used": used.1,
        "gap_before_held_out": d.gap_before_held_out,
        "gap_after_held_out": d.gap_after_held_out,
        "held_out": d.held_out,
        "next_measurement": d.next_measurement,
        "worst_block": {
            "chi2_per_residual": d.misfit.value,
            "output": d.misfit.output,
            "input": d.misfit.input,
            "from_hz": d.misfit.band_hz.0,
            "to_hz": d.misfit.band_hz.1,
        },
        "localisation": d.localisation.ports.iter().map(port_topic).collect::<Vec<_>>(),
        "menu": menu.collect::<Vec<_>>(),
        "detectable": detectable.collect::<Vec<_>>(),
        "ranking": ranking.collect::<Vec<_>>(),
        // What stands in for a name when the verdict is unexplained.
        "correction": d.correction.as_ref().map(|c| json!({
            "port": c.port,
            "shape": d.localisation.named_port().map(PortScore::shape),
            "gap_before_used": used.0,
            "gap_after_used": used.1,
            "gap_before_held_out": held.0,
            "gap_after_held_out": held.1,
            "law": "correction.csv",
            "corrected_response": "corrected-frf.csv",
        })),
    });
    omit_absent(topic, &["correction", "nearest"])
}

/// `diagnosis.consequence`: what the corrected machine changes for the controller of a record.
pub(crate) fn consequence_topic(c: &Consequence) -> Value {
    let state = |s: &LoopOutcome| {
        json!({
            "growth_rate_per_s": s.growth_rate_per_s,
            "least_stiffness_n_per_m": s.least_stiffness_n_per_m,
        })
    };
    json!({
        "record": c.record,
        "speed_rpm": c.speed_rpm,
        "given": state(&c.given),
        "corrected": state(&c.corrected),
        "sentence": c.words(),
    })
}

/// Where an effect sits.
fn place_topic(location: &Location) -> Value {
    match location {
        Location::None => json!({}),
        Location::Bearing(b) => json!({ "bearing": b.name() }),
        Location::Axis(axis) => json!({ "axis": AXES[*axis % 4] }),
        Location::Across { from, to } => json!({ "from": AXES[*from % 4], "to": AXES[*to % 4] }),
        Location::Position(z) => json!({ "position_m": z }),
        Location::InPlane(z, plane) => json!({ "axis": plane.name(), "position_m": z }),
        Location::Mode(mode) => json!({ "mode": mode }),
        Location::Region(region) => json!({ "region": region }),
    }
}

fn parameters(effect: &Effect) -> Map<String, Value> {
    key_values(effect, &effect.values)
}

/// Values under the names of an effect's parameters.
fn key_values<T: Serialize>(effect: &Effect, values: &[T]) -> Map<String, Value> {
    let parameters = effect.kind.parameters().iter();
    parameters.zip(values).map(|(p, value)| (p.name.to_owned(), json!(value))).collect()
}

/// An effect with its parameters and their intervals.
fn effect_topic(e: &NamedEffect) -> Value {
    let mut deviations = key_values(&e.effect, &e.standard_deviations);
    let mut intervals = key_values(&e.effect, &e.intervals);
    if let Some(sd) = e.position_sd_m {
        deviations.insert("position_m".to_owned(), json!(sd));
    }
    if let (Some(sd), Some(z)) = (e.position_sd_m, e.effect.location.position_m()) {
        intervals.insert("position_m".to_owned(), json!([z - HALF_WIDTH_90 * sd, z + HALF_WIDTH_90 * sd]));
    }
    json!({
        "effect": e.effect.kind.name(),
        "where": place_topic(&e.effect.location),
        "parameters": parameters(&e.effect),
        "standard_deviations": deviations,
        "intervals_90": intervals,
        "words": statement(e),
    })
}

/// A member of a tie with what it says is wrong with the records. One effect stands for itself; several are a list.
fn rival_topic(rival: &Rival) -> Value {
    let mut topic = match &rival.effects[..] {
        [one] => effect_topic(one),
        several => json!({ "effects": several.iter().map(effect_topic).collect::<Vec<_>>() }),
    };
    if !rival.record_faults.is_empty() {
        topic["record_faults"] = json!(rival.record_faults.iter().map(fault_words).collect::<Vec<_>>());
    }
    topic["score_above_best"] = json!(rival.score_above_best);
    topic
}

/// What a free law at a place explains.
fn port_topic(p: &PortScore) -> Value {
    let law = p.law();
    json!({
        "port": p.port,
        "chi2_before": p.chi2_before,
        "chi2_after": p.chi2_after,
        "score_above_best": p.score_above_best,
        "shape": law.map_or("nothing", |l| l.name_of_shape()),
        "words": p.shape(),
        "size": law.map_or(0.0, |l| l.size()),
        "size_unit": law.map_or("", |l| l.unit.key()),
    })
}
