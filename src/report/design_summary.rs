//! A design with its certificates as the topic `design` of the summary.

use super::polish_summary::polish_topic;
use super::speed_summary::{speed_intervals, speed_mu, speed_proof_topic, verification_topic};
use super::summary::omit_absent;
use super::variant_summary::route_word;
use crate::pipeline::certificates::{PeakFigures, Stage};
use crate::pipeline::design::Design;
use crate::pipeline::specification_scale::SpecificationScale;
use crate::pipeline::stable::OwnStability;
use crate::robust::dk::DkStep;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// `design`; without figures that only a loop has which is stable from rest to the overspeed, where it is not.
pub(crate) fn design_topic(design: &Design) -> Value {
    let (delivery, problems) = (&design.delivery, &design.problems);
    let dk = design.dk.as_ref();
    let [full, reduced] = [dk.map(|dk| &dk.full), dk.map(|dk| &dk.reduced)];
    let rounded = &delivery.rounded;
    let loop_is_stable = design.instability.is_none();
    let of_stable = |figure: f64| loop_is_stable.then_some(figure);
    let [tool, front, rear] = delivery.static_stiffness_n_per_m.map(of_stable);
    let speeds = delivery.verification.speeds.iter();
    let stable = speeds.filter(|s| s.growth_rate_per_s < 0.0);
    let order_per_plane = [full, reduced, Some(rounded)].map(|stage| Some(stage?.order));
    let topic = json!({
        "mu_peak": full.map(|full| full.covered.upper),
        "mu_lower_peak": full.map(|full| full.covered.lower),
        "gamma": dk.map(|dk| dk.gamma),
        "constant_scales": design.constant_scales,
        "iterations": dk.map_or(0, |dk| dk.steps.len()),
        "d_order": dk.map(|dk| dk.d_order),
        "controller_order_full": full.map(|full| 2 * full.order),
        "controller_order": 2 * rounded.order,
        "mu_peak_reduced": reduced.map(|reduced| reduced.covered.upper),
        "mu_peak_discrete": of_stable(rounded.covered.upper),
        "mu_peak_discrete_lower": of_stable(rounded.covered.lower),
        "mu_model": mu_model_topic(design),
        "weights_fit_error": problems.fit_errors.analysis,
        "stable": design.is_stable(),
        "route": route_word(problems.route),
        "emulation": dk.and_then(|dk| dk.emulated.as_ref()).map(|emulated| json!({
            "prewarp_hz": emulated.prewarp_hz,
            "mu_continuous": emulated.mu_continuous,
            "mu_sampled": emulated.mu_sampled,
        })),
        "speed_proof": speed_proof_topic(&delivery.speed_proof),
        "mu_over_speed": speed_mu(design),
        "controller_stable": design.controller_is_stable(),
        "controller_stability": design.own_stability_sentence(),
        "stable_alternatives": dk.map_or_else(Vec::new, |dk| alternatives_topic(&dk.own_stability)),
        "static_stiffness_tool_n_per_m": tool,
        "static_stiffness_front_n_per_m": front,
        "static_stiffness_rear_n_per_m": rear,
        "stable_speeds_rpm": stable.map(|s| s.speed_rpm).collect::<Vec<_>>(),
        "stable_at_20_percent_overspeed": delivery.overspeed.is_stable(),
        "controller_growth_rate_per_s": delivery.controller_growth_rate_per_s,
        "complementary_sensitivity_limit": problems.sensitivity_limit,
        "table_as_written": written_topic(design, loop_is_stable),
        "gyroscopic_cover": covered_modes(design),
        "order_per_plane": order_per_plane,
        "steps": dk.map_or_else(Vec::new, |dk| dk.steps.iter().map(step_topic).collect()),
        "certificates": {
            "full": full.map(|full| stage_topic(full, true)),
            "reduced": reduced.map(|reduced| stage_topic(reduced, true)),
            "rounded": stage_topic(rounded, loop_is_stable),
            "verification": verification_topic(&delivery.verification),
            "overspeed": verification_topic(&delivery.overspeed),
            "speed_proof": speed_intervals(&delivery.speed_proof),
        },
        "largest_mu": of_stable(design.largest_mu()),
        "specification_scale": design.specification_scale.as_ref().filter(|_| loop_is_stable).map(scale_topic),
        // Largest at rest, specification as written, over the corners of ki and ks; only where they are uncertain.
        "mu_at_real_corners": design.real_corner_mu.and_then(of_stable),
        "least_decay": design.least_decay().map(|[slowest, asked]| json!({
            "slowest_pole_per_s": slowest,
            "asked_per_s": asked,
        })),
        "tool_stiffness": design.share_of_floors.map(|share| json!({ "least_share_of_asked": share })),
        "aim": aim_topic(design),
        "polish": design.polish.as_ref().map(polish_topic),
    });
    omit_absent(topic, &["mu_at_real_corners", "least_decay", "tool_stiffness"])
}

/// The specification as written, at rest.
fn written_topic(design: &Design, loop_is_stable: bool) -> Value {
    let stage = |stage: &Stage| loop_is_stable.then_some(stage.specification);
    let dk = design.dk.as_ref();
    let rounded = stage(&design.delivery.rounded);
    json!({
        "mu_peak": dk.and_then(|dk| stage(&dk.full)).map(|peak| peak.upper),
        "mu_peak_reduced": dk.and_then(|dk| stage(&dk.reduced)).map(|peak| peak.upper),
        "mu_peak_discrete": rounded.map(|peak| peak.upper),
        "mu_lower_peak_discrete": rounded.map(|peak| peak.lower),
        "frequency_hz": rounded.map(|peak| peak.frequency_hz),
    })
}

/// Gyroscopic split of the modes, and how much of it is covered.
fn covered_modes(design: &Design) -> Vec<Value> {
    let covered = design.problems.covered_modes.iter();
    covered
        .filter_map(|mode| Some((design.problems.split.get(mode.number)?, mode)))
        .map(|(split, mode)| {
            json!({
                "natural_frequency_hz": split.omega_rad_s / TAU,
                "backward_at_max_speed_hz": split.backward_rad_s / TAU,
                "forward_at_max_speed_hz": split.forward_rad_s / TAU,
                "uncertainty_covered": mode.relative,
            })
        })
        .collect()
}

/// A step of the D-K iteration.
fn step_topic(step: &DkStep) -> Value {
    json!({
        "gamma": step.gamma,
        "mu_peak": step.mu_peak,
        "controller_order": step.controller_order,
        "d_orders": step.d_orders,
        "failure": step.failure,
    })
}

/// Bounds on µ of a stage, where they are known.
fn stage_topic(stage: &Stage, known: bool) -> Value {
    let peak = |p: &PeakFigures| {
        let [upper, lower, frequency_hz] = [p.upper, p.lower, p.frequency_hz].map(|x| known.then_some(x));
        json!({ "upper": upper, "lower": lower, "frequency_hz": frequency_hz })
    };
    json!({
        "order_per_plane": stage.order,
        "table_as_written": peak(&stage.specification),
        "with_gyroscopic_cover": peak(&stage.covered),
    })
}

/// What the synthesis aimed at: cover of the gyroscopic split, factors on the limits of the specification.
fn aim_topic(design: &Design) -> Value {
    let (cover, widening) = (design.problems.cover, design.problems.widening);
    json!({
        "as_written": widening.is_none(),
        "displacement_factor": widening.tool,
        "current_factor": widening.current,
        "modes_covered": cover.modes,
        "guard_share_covered": cover.guard_share,
    })
}

/// The model that every µ of a design is of, what is proven of it, and the syntheses that it asked for: each with µ of
/// the whole machine with its controller.
fn mu_model_topic(design: &Design) -> Value {
    let problems = &design.problems;
    let rounds = design.dk.iter().flat_map(|dk| &dk.rounds);
    let rounds = rounds.map(|r| {
        json!({
            "synthesis_modes": r.synthesis_modes,
            "gamma_target": r.gamma_target,
            "mu_synthesis_model": r.synthesis,
            "mu_whole_machine": r.whole_machine,
            "frequency_hz": r.frequency_hz,
        })
    });
    let topic = json!({
        "sentence": format!(
            "µ is of the whole machine: {} flexible modes below half the sample rate and the static flexibility \
             of the others, sampled with hold and exact delay, weights of true frequency, loads and modal forces \
             not held. The upper bound is certified over all frequencies for the rational realisation of this \
             model, and is not below any line of the exact frequency responses at rest; over speed it is the \
             largest of the exact responses on a grid.",
            problems.machine_modes
        ),
        "covered": format!(
            "mu_peak, mu_peak_reduced and mu_peak_discrete are of {} with the gyroscopic split of {} modes \
             covered; table_as_written, mu_over_speed and largest_mu are of the specification as written.",
            problems.widening.words(),
            problems.cover.modes
        ),
        "machine_modes": problems.machine_modes,
        "synthesis_modes": problems.synthesis_modes,
        "synthesis_weights_excess": problems.fit_errors.synthesis,
        // Largest excess of a weight over the points it was given by; only where there are points.
        "points_excess": Some(problems.fit_errors.points).filter(|excess| *excess > 0.0),
        "inverse_hold_fit_error": problems.fit_errors.hold,
        "rounds": rounds.collect::<Vec<_>>(),
    });
    omit_absent(topic, &["points_excess"])
}

/// What was tried for the sake of a stable controller.
fn alternatives_topic(own: &OwnStability) -> Vec<Value> {
    let each = own.alternatives.iter().enumerate().map(|(k, a)| {
        let delivered = own.chosen == Some(k);
        json!({ "lever": a.lever, "growth_rate_per_s": a.growth_rate_per_s, "mu": a.mu, "delivered": delivered })
    });
    each.collect()
}

/// At how many times its limits a missed specification is met.
fn scale_topic(scale: &SpecificationScale) -> Value {
    json!({
        "sentence": scale.sentence(),
        "factor": scale.factor,
        "binds": scale.binds,
        "key": scale.key,
        "speed_rpm": scale.speed_rpm,
        "frequency_hz": scale.frequency_hz,
        // Below this no controller brings µ.
        "least_mu": scale.least_mu,
    })
}
