//! A design with its certificates as the topic `design` of the summary.

use super::polish_summary::PolishSummary;
use super::speed_summary::{
    ProofCentre, SpeedMuSummary, SpeedProofSummary, VerificationSummary, speed_intervals, speed_mu,
};
use super::summary::{finite, finite_all};
use super::variant_summary::route_word;
use crate::pipeline::certificates::{PeakFigures, Stage};
use crate::pipeline::design::Design;
use crate::pipeline::emulation::Emulated;
use crate::pipeline::specification_scale::SpecificationScale;
use crate::pipeline::stable::OwnStability;
use crate::robust::dk::DkStep;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// `design`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct DesignSummary {
    pub(crate) mu_peak: Option<f64>,
    mu_lower_peak: Option<f64>,
    gamma: Option<f64>,
    constant_scales: Vec<Option<f64>>,
    iterations: usize,
    d_order: Option<usize>,
    controller_order_full: Option<usize>,
    pub(crate) controller_order: Option<usize>,
    pub(crate) mu_peak_reduced: Option<f64>,
    pub(crate) mu_peak_discrete: Option<f64>,
    mu_peak_discrete_lower: Option<f64>,
    mu_model: MuModelSummary,
    weights_fit_error: Option<f64>,
    pub(crate) stable: Option<bool>,
    route: String,
    emulation: Option<EmulationSummary>,
    pub(crate) speed_proof: SpeedProofSummary,
    mu_over_speed: Vec<SpeedMuSummary>,
    controller_stable: bool,
    pub(crate) controller_stability: Option<String>,
    stable_alternatives: Vec<AlternativeSummary>,
    static_stiffness_tool_n_per_m: Option<f64>,
    static_stiffness_front_n_per_m: Option<f64>,
    static_stiffness_rear_n_per_m: Option<f64>,
    stable_speeds_rpm: Vec<Option<f64>>,
    stable_at_20_percent_overspeed: bool,
    controller_growth_rate_per_s: Option<f64>,
    complementary_sensitivity_limit: Option<f64>,
    pub(crate) table_as_written: WrittenSummary,
    gyroscopic_cover: Vec<CoveredMode>,
    order_per_plane: [Option<usize>; 3],
    steps: Vec<StepSummary>,
    certificates: Certificates,
    pub(crate) largest_mu: Option<f64>,
    specification_scale: Option<ScaleSummary>,
    /// Largest at rest, specification as written, over the corners of ki and ks; only where they are uncertain.
    #[serde(skip_serializing_if = "Option::is_none")]
    mu_at_real_corners: Option<f64>,
    aim: AimSummary,
    polish: Option<PolishSummary>,
}

/// The specification as written, at rest.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct WrittenSummary {
    mu_peak: Option<f64>,
    mu_peak_reduced: Option<f64>,
    pub(crate) mu_peak_discrete: Option<f64>,
    mu_lower_peak_discrete: Option<f64>,
    frequency_hz: Option<f64>,
}

/// Gyroscopic split of a mode, and how much of it is covered.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct CoveredMode {
    natural_frequency_hz: Option<f64>,
    backward_at_max_speed_hz: Option<f64>,
    forward_at_max_speed_hz: Option<f64>,
    uncertainty_covered: Option<f64>,
}

/// A step of the D-K iteration.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct StepSummary {
    gamma: Option<f64>,
    mu_peak: Option<f64>,
    controller_order: usize,
    d_orders: Vec<usize>,
    failure: Option<String>,
}

/// What is proven of the controller at each stage.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct Certificates {
    full: Option<StageSummary>,
    reduced: Option<StageSummary>,
    rounded: StageSummary,
    verification: VerificationSummary,
    overspeed: VerificationSummary,
    speed_proof: Vec<ProofCentre>,
}

/// Bounds on µ of a stage.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct StageSummary {
    order_per_plane: usize,
    table_as_written: PeakSummary,
    with_gyroscopic_cover: PeakSummary,
}

/// Bounds on a peak of µ.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct PeakSummary {
    upper: Option<f64>,
    lower: Option<f64>,
    frequency_hz: Option<f64>,
}

/// What the synthesis aimed at: cover of the gyroscopic split, factors on the limits of the specification.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct AimSummary {
    as_written: bool,
    displacement_factor: Option<f64>,
    current_factor: Option<f64>,
    modes_covered: usize,
    guard_share_covered: Option<f64>,
}

/// The model that every µ of a design is of, what is proven of it, and the syntheses that it asked for.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct MuModelSummary {
    sentence: String,
    covered: String,
    machine_modes: usize,
    synthesis_modes: usize,
    synthesis_weights_excess: Option<f64>,
    /// Largest excess of a weight over the points it was given by; only where there are points.
    #[serde(skip_serializing_if = "Option::is_none")]
    points_excess: Option<f64>,
    inverse_hold_fit_error: Option<f64>,
    rounds: Vec<RoundSummary>,
}

/// One synthesis, and µ of the whole machine with its controller.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct RoundSummary {
    synthesis_modes: usize,
    gamma_target: Option<f64>,
    mu_synthesis_model: Option<f64>,
    mu_whole_machine: Option<f64>,
    frequency_hz: Option<f64>,
}

/// What was tried for the sake of a stable controller.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct AlternativeSummary {
    lever: String,
    growth_rate_per_s: Option<f64>,
    mu: Option<f64>,
    delivered: bool,
}

/// What sampling did to an emulated design.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct EmulationSummary {
    prewarp_hz: Option<f64>,
    mu_continuous: Option<f64>,
    mu_sampled: Option<f64>,
}

/// At how many times its limits a missed specification is met.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct ScaleSummary {
    sentence: String,
    factor: Option<f64>,
    binds: String,
    key: String,
    speed_rpm: Option<f64>,
    frequency_hz: Option<f64>,
    /// Below this no controller brings µ.
    least_mu: Option<f64>,
}

impl From<&Design> for DesignSummary {
    fn from(design: &Design) -> Self {
        let (delivery, problems) = (&design.delivery, &design.problems);
        let dk = design.dk.as_ref();
        let [full, reduced] = [dk.map(|dk| &dk.full), dk.map(|dk| &dk.reduced)];
        let rounded = &delivery.rounded;
        let [tool, front, rear] = delivery.static_stiffness_n_per_m.map(finite);
        let speeds = delivery.verification.speeds.iter();
        let stable = speeds.filter(|s| s.growth_rate_per_s < 0.0);
        let stable: Vec<f64> = stable.map(|s| s.speed_rpm).collect();
        let found = Self {
            mu_peak: full.and_then(|full| finite(full.covered.upper)),
            mu_lower_peak: full.and_then(|full| finite(full.covered.lower)),
            gamma: dk.and_then(|dk| finite(dk.gamma)),
            constant_scales: design.constant_scales.iter().map(|s| finite(*s)).collect(),
            iterations: dk.map_or(0, |dk| dk.steps.len()),
            d_order: dk.map(|dk| dk.d_order),
            controller_order_full: full.map(|full| 2 * full.order),
            controller_order: Some(2 * rounded.order),
            mu_peak_reduced: reduced.and_then(|reduced| finite(reduced.covered.upper)),
            mu_peak_discrete: finite(rounded.covered.upper),
            mu_peak_discrete_lower: finite(rounded.covered.lower),
            mu_model: MuModelSummary::from(design),
            weights_fit_error: finite(problems.fit_errors.analysis),
            stable: Some(design.is_stable()),
            route: route_word(problems.route).to_owned(),
            emulation: dk.and_then(|dk| dk.emulated.as_ref().map(EmulationSummary::from)),
            speed_proof: SpeedProofSummary::from(&delivery.speed_proof),
            mu_over_speed: speed_mu(design),
            controller_stable: design.controller_is_stable(),
            controller_stability: Some(design.own_stability_sentence()),
            stable_alternatives: dk.map_or_else(Vec::new, |dk| AlternativeSummary::all(&dk.own_stability)),
            static_stiffness_tool_n_per_m: tool,
            static_stiffness_front_n_per_m: front,
            static_stiffness_rear_n_per_m: rear,
            stable_speeds_rpm: finite_all(&stable),
            stable_at_20_percent_overspeed: delivery.overspeed.is_stable(),
            controller_growth_rate_per_s: finite(delivery.controller_growth_rate_per_s),
            complementary_sensitivity_limit: problems.sensitivity_limit.and_then(finite),
            table_as_written: WrittenSummary::from(design),
            gyroscopic_cover: CoveredMode::all(design),
            order_per_plane: [full, reduced, Some(rounded)].map(|stage| Some(stage?.order)),
            steps: dk.map_or_else(Vec::new, |dk| dk.steps.iter().map(StepSummary::from).collect()),
            certificates: Certificates::from(design),
            largest_mu: finite(design.largest_mu()),
            specification_scale: design.specification_scale.as_ref().map(ScaleSummary::from),
            mu_at_real_corners: design.real_corner_mu.and_then(finite),
            aim: AimSummary::from(design),
            polish: design.polish.as_ref().map(PolishSummary::from),
        };
        if design.instability.is_some() { found.without_stable_loop() } else { found }
    }
}

impl DesignSummary {
    /// Without what only a loop that is stable from rest to the overspeed has.
    fn without_stable_loop(self) -> Self {
        let rounded = StageSummary { order_per_plane: self.certificates.rounded.order_per_plane, ..Default::default() };
        Self {
            mu_peak_discrete: None,
            mu_peak_discrete_lower: None,
            static_stiffness_tool_n_per_m: None,
            static_stiffness_front_n_per_m: None,
            static_stiffness_rear_n_per_m: None,
            table_as_written: WrittenSummary::default(),
            largest_mu: None,
            specification_scale: None,
            mu_at_real_corners: None,
            certificates: Certificates { rounded, ..self.certificates },
            ..self
        }
    }

    /// µ of what is delivered: of the sampled controller if there is one.
    pub(crate) fn final_mu(&self) -> Option<f64> {
        self.largest_mu.or(self.mu_peak_discrete).or(self.mu_peak_reduced).or(self.mu_peak)
    }
}

impl From<&Design> for WrittenSummary {
    fn from(design: &Design) -> Self {
        let rounded = &design.delivery.rounded.specification;
        let dk = design.dk.as_ref();
        Self {
            mu_peak: dk.and_then(|dk| finite(dk.full.specification.upper)),
            mu_peak_reduced: dk.and_then(|dk| finite(dk.reduced.specification.upper)),
            mu_peak_discrete: finite(rounded.upper),
            mu_lower_peak_discrete: finite(rounded.lower),
            frequency_hz: finite(rounded.frequency_hz),
        }
    }
}

impl CoveredMode {
    fn all(design: &Design) -> Vec<Self> {
        let covered = design.problems.covered_modes.iter();
        covered
            .filter_map(|mode| Some((design.problems.split.get(mode.number)?, mode)))
            .map(|(split, mode)| Self {
                natural_frequency_hz: finite(split.omega_rad_s / TAU),
                backward_at_max_speed_hz: finite(split.backward_rad_s / TAU),
                forward_at_max_speed_hz: finite(split.forward_rad_s / TAU),
                uncertainty_covered: finite(mode.relative),
            })
            .collect()
    }
}

impl From<&DkStep> for StepSummary {
    fn from(step: &DkStep) -> Self {
        Self {
            gamma: finite(step.gamma),
            mu_peak: finite(step.mu_peak),
            controller_order: step.controller_order,
            d_orders: step.d_orders.clone(),
            failure: step.failure.clone(),
        }
    }
}

impl From<&Design> for Certificates {
    fn from(design: &Design) -> Self {
        let (delivery, dk) = (&design.delivery, design.dk.as_ref());
        Self {
            full: dk.map(|dk| StageSummary::from(&dk.full)),
            reduced: dk.map(|dk| StageSummary::from(&dk.reduced)),
            rounded: StageSummary::from(&delivery.rounded),
            verification: VerificationSummary::from(&delivery.verification),
            overspeed: VerificationSummary::from(&delivery.overspeed),
            speed_proof: speed_intervals(&delivery.speed_proof),
        }
    }
}

impl From<&Stage> for StageSummary {
    fn from(stage: &Stage) -> Self {
        Self {
            order_per_plane: stage.order,
            table_as_written: PeakSummary::from(&stage.specification),
            with_gyroscopic_cover: PeakSummary::from(&stage.covered),
        }
    }
}

impl From<&PeakFigures> for PeakSummary {
    fn from(peak: &PeakFigures) -> Self {
        Self { upper: finite(peak.upper), lower: finite(peak.lower), frequency_hz: finite(peak.frequency_hz) }
    }
}

impl From<&Design> for AimSummary {
    fn from(design: &Design) -> Self {
        let (cover, widening) = (design.problems.cover, design.problems.widening);
        Self {
            as_written: widening.is_none(),
            displacement_factor: finite(widening.tool),
            current_factor: finite(widening.current),
            modes_covered: cover.modes,
            guard_share_covered: finite(cover.guard_share),
        }
    }
}

impl From<&Design> for MuModelSummary {
    fn from(design: &Design) -> Self {
        let problems = &design.problems;
        let rounds = design.dk.iter().flat_map(|dk| &dk.rounds);
        let rounds = rounds.map(|r| RoundSummary {
            synthesis_modes: r.synthesis_modes,
            gamma_target: finite(r.gamma_target),
            mu_synthesis_model: finite(r.synthesis),
            mu_whole_machine: finite(r.whole_machine),
            frequency_hz: finite(r.frequency_hz),
        });
        Self {
            sentence: format!(
                "µ is of the whole machine: {} flexible modes below half the sample rate and the static flexibility \
                 of the others, sampled with hold and exact delay, weights of true frequency, loads and modal forces \
                 not held. The upper bound is certified over all frequencies for the rational realisation of this \
                 model, and is not below any line of the exact frequency responses at rest; over speed it is the \
                 largest of the exact responses on a grid.",
                problems.machine_modes
            ),
            covered: format!(
                "mu_peak, mu_peak_reduced and mu_peak_discrete are of {} with the gyroscopic split of {} modes \
                 covered; table_as_written, mu_over_speed and largest_mu are of the specification as written.",
                problems.widening.words(),
                problems.cover.modes
            ),
            machine_modes: problems.machine_modes,
            synthesis_modes: problems.synthesis_modes,
            synthesis_weights_excess: finite(problems.fit_errors.synthesis),
            points_excess: Some(problems.fit_errors.points).filter(|excess| *excess > 0.0),
            inverse_hold_fit_error: finite(problems.fit_errors.hold),
            rounds: rounds.collect(),
        }
    }
}

impl AlternativeSummary {
    fn all(own: &OwnStability) -> Vec<Self> {
        let each = own.alternatives.iter().enumerate().map(|(k, a)| Self {
            lever: a.lever.clone(),
            growth_rate_per_s: finite(a.growth_rate_per_s),
            mu: finite(a.mu),
            delivered: own.chosen == Some(k),
        });
        each.collect()
    }
}

impl From<&Emulated> for EmulationSummary {
    fn from(emulated: &Emulated) -> Self {
        Self {
            prewarp_hz: finite(emulated.prewarp_hz),
            mu_continuous: finite(emulated.mu_continuous),
            mu_sampled: finite(emulated.mu_sampled),
        }
    }
}

impl From<&SpecificationScale> for ScaleSummary {
    fn from(scale: &SpecificationScale) -> Self {
        Self {
            sentence: scale.sentence(),
            factor: finite(scale.factor),
            binds: scale.binds.to_owned(),
            key: scale.key.to_owned(),
            speed_rpm: finite(scale.speed_rpm),
            frequency_hz: finite(scale.frequency_hz),
            least_mu: scale.least_mu,
        }
    }
}
