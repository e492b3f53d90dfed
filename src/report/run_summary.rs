//! Figures of a run as JSON: design with its certificates, stiffness, sensitivity. Keys as the format contract names
//! them.

use super::design_summary::{
    alternatives_json, emulation_json, mu_model_json, polish_json, route_word, scale_json,
    speed_intervals_json, speed_mu_json, speed_proof_json,
};
use super::summary::{number, numbers};
use crate::controller::verification::Verification;
use crate::pipeline::certificates::{PeakFigures, Stage};
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::Design;
use crate::spindle::Machine;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// The `design` object of a summary.
pub fn design_json(design: &Design) -> Value {
    let stable: Vec<f64> = design
        .delivery
        .verification
        .speeds
        .iter()
        .filter(|s| s.growth_rate_per_s < 0.0)
        .map(|s| s.speed_rpm)
        .collect();
    let covered = design.problems.covered_modes.iter();
    let modes: Vec<Value> = covered
        .filter_map(|mode| Some((design.problems.split.get(mode.number)?, mode)))
        .map(|(split, mode)| {
            json!({
                "natural_frequency_hz": number(split.omega_rad_s / TAU),
                "backward_at_max_speed_hz": number(split.backward_rad_s / TAU),
                "forward_at_max_speed_hz": number(split.forward_rad_s / TAU),
                "uncertainty_covered": number(mode.relative),
            })
        })
        .collect();
    let steps: Vec<Value> = design.steps.iter().map(step_json).collect();
    let figures = json!({
        "mu_peak": number(design.full.covered.upper),
        "mu_lower_peak": number(design.full.covered.lower),
        "gamma": number(design.gamma),
        "iterations": design.steps.len(),
        "d_order": design.d_order,
        "controller_order_full": 2 * design.full.order,
        "controller_order": 2 * design.delivery.rounded.order,
        "mu_peak_reduced": number(design.reduced.covered.upper),
        "mu_peak_discrete": number(design.delivery.rounded.covered.upper),
        "mu_peak_discrete_lower": number(design.delivery.rounded.covered.lower),
        "mu_model": mu_model_json(design),
        "weights_fit_error": number(design.problems.fit_errors.analysis),
        "stable": design.is_stable(),
        "route": route_word(design.problems.route),
        "emulation": design.emulated.as_ref().map(emulation_json),
        "speed_proof": speed_proof_json(&design.delivery.speed_proof),
        "mu_over_speed": speed_mu_json(design),
        "controller_stable": design.controller_is_stable(),
        "controller_stability": design.own_stability_sentence(),
        "stable_alternatives": alternatives_json(&design.own_stability),
        "static_stiffness_tool_n_per_m": number(design.delivery.static_stiffness_n_per_m[0]),
        "static_stiffness_front_n_per_m": number(design.delivery.static_stiffness_n_per_m[1]),
        "static_stiffness_rear_n_per_m": number(design.delivery.static_stiffness_n_per_m[2]),
        "stable_speeds_rpm": numbers(&stable),
        "stable_at_20_percent_overspeed": design.delivery.overspeed.is_stable(),
        "controller_growth_rate_per_s": number(design.delivery.controller_growth_rate_per_s),
        "complementary_sensitivity_limit": design.problems.sensitivity_limit.map(number),
        "table_as_written": {
            "mu_peak": number(design.full.specification.upper),
            "mu_peak_reduced": number(design.reduced.specification.upper),
            "mu_peak_discrete": number(design.delivery.rounded.specification.upper),
            "mu_lower_peak_discrete": number(design.delivery.rounded.specification.lower),
            "frequency_hz": number(design.delivery.rounded.specification.frequency_hz),
        },
        "gyroscopic_cover": modes,
        "order_per_plane": [design.full.order, design.reduced.order, design.delivery.rounded.order],
        "steps": steps,
        "certificates": {
            "full": stage_json(&design.full),
            "reduced": stage_json(&design.reduced),
            "rounded": stage_json(&design.delivery.rounded),
            "verification": verification_json(&design.delivery.verification),
            "overspeed": verification_json(&design.delivery.overspeed),
            "speed_proof": speed_intervals_json(&design.delivery.speed_proof),
        },
    });
    let Value::Object(mut all) = figures else {
        return figures;
    };
    all.insert("largest_mu".to_owned(), number(design.largest_mu()));
    all.insert(
        "specification_scale".to_owned(),
        design
            .specification_scale
            .as_ref()
            .map_or(Value::Null, scale_json),
    );
    all.insert("aim".to_owned(), aim_json(design));
    all.insert(
        "polish".to_owned(),
        design.polish.as_ref().map_or(Value::Null, polish_json),
    );
    Value::Object(all)
}

/// What the synthesis aimed at: cover of the gyroscopic split, factors on the limits of the specification.
fn aim_json(design: &Design) -> Value {
    let (cover, widening) = (design.problems.cover, design.problems.widening);
    json!({
        "as_written": widening.is_none(),
        "displacement_factor": number(widening.tool),
        "current_factor": number(widening.current),
        "modes_covered": cover.modes,
        "guard_share_covered": number(cover.guard_share),
    })
}

fn step_json(step: &crate::robust::dk::DkStep) -> Value {
    json!({
        "gamma": number(step.gamma),
        "mu_peak": number(step.mu_peak),
        "controller_order": step.controller_order,
        "d_orders": step.d_orders,
        "failure": step.failure,
    })
}

fn stage_json(stage: &Stage) -> Value {
    let peak = |p: &PeakFigures| {
        json!({
            "upper": number(p.upper),
            "lower": number(p.lower),
            "frequency_hz": number(p.frequency_hz),
        })
    };
    json!({
        "order_per_plane": stage.order,
        "table_as_written": peak(&stage.specification),
        "with_gyroscopic_cover": peak(&stage.covered),
    })
}

/// Stability over speed.
pub fn verification_json(verification: &Verification) -> Value {
    let speeds: Vec<Value> = verification
        .speeds
        .iter()
        .map(|s| json!({ "speed_rpm": number(s.speed_rpm), "growth_rate_per_s": number(s.growth_rate_per_s) }))
        .collect();
    json!({ "conditions": verification.conditions, "speeds": speeds })
}

/// Closed-loop damping ratio of each flexible mode: of the least damped pole among those that show in the mode.
pub fn modal_damping_json(prediction: &Prediction, flexible_rad_s: &[f64]) -> Value {
    let modes = prediction.modes.flexible.iter().take(flexible_rad_s.len());
    Value::Array(
        modes
            .map(|m| m.map_or(Value::Null, |m| number(m.damping_ratio)))
            .collect(),
    )
}

/// Name and masses of the machine, and its natural frequencies at rest.
pub fn machine_json(machine: &Machine, flexible_hz: &[f64]) -> Value {
    json!({
        "spindle": machine.spindle.name,
        "tool": machine.tool.name,
        "flexible_frequencies_hz": numbers(flexible_hz),
    })
}
