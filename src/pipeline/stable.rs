//! A stable controller instead of an unstable one, where it costs little.
//!
//! The optimal controller of an unstable plant may have poles of its own in the right half plane: the loop is stable,
//! but it does not survive a saturated actuator or a lost sensor, and it may not lift off. The set of
//! controllers of a level grows with the level, and its central member changes, so a few syntheses with the scales
//! found are tried: a higher γ, more noise in the assumed sensors, a bound on T. The first stable one whose μ is at
//! most 5 % above the one found is delivered.

use super::PipelineError;
use super::certificates::attained_gain;
use crate::augment::{Block, GeneralizedPlant};
use crate::controller::verification::rate_words;
use crate::lti::{Continuous, StateSpace};
use crate::robust::dk::DkOutcome;
use crate::robust::hinf::{HinfSettings, synthesise};
use crate::robust::prescale::scale_signals;
use crate::robust::structure::Structure;

/// Growth of μ that a stable controller may cost.
pub(crate) const PRICE: f64 = 0.05;
/// Levels above the optimum at which the central controller is formed.
const RELAXED: [f64; 5] = [0.003, 0.01, 0.02, 0.035, 0.05];
/// Factors on the sensor noise.
const NOISIER: [f64; 3] = [1.5, 2.0, 3.0];

/// A synthesis tried for the sake of a stable controller.
#[derive(Clone, Debug)]
pub struct Alternative {
    /// What was changed.
    pub lever: String,
    /// Largest growth rate of the controller's poles in the w plane, rad/s.
    pub growth_rate_per_s: f64,
    /// μ of the problem as posed; infinite when the loop is unstable.
    pub mu: f64,
}

/// What the iteration found, and what was done about it.
#[derive(Clone, Debug)]
pub struct OwnStability {
    /// Largest growth rate of the poles of the best controller by μ, in the plane of the synthesis, rad/s.
    pub found_growth_rate_per_s: f64,
    /// Its μ.
    pub found_mu: f64,
    /// Syntheses tried; empty when that controller was stable.
    pub alternatives: Vec<Alternative>,
    /// Number of the alternative that is delivered.
    pub chosen: Option<usize>,
}

impl OwnStability {
    /// True when the controller delivered is stable itself.
    pub fn is_stable(&self) -> bool {
        self.found_growth_rate_per_s < 0.0 || self.chosen.is_some()
    }

    /// The stable alternative with the lowest μ.
    pub(crate) fn cheapest(&self) -> Option<&Alternative> {
        self.alternatives
            .iter()
            .filter(|a| a.growth_rate_per_s < 0.0 && a.mu.is_finite())
            .min_by(|a, b| a.mu.total_cmp(&b.mu))
    }

    /// The finding in a sentence; the poles of the delivered controller grow at `delivered_per_s`.
    pub fn sentence(&self, delivered_per_s: f64) -> String {
        let percent = |mu: f64| 100.0 * (mu / self.found_mu - 1.0);
        if self.found_growth_rate_per_s < 0.0 {
            return "The controller itself is stable.".to_owned();
        }
        let price = 100.0 * PRICE;
        let lifts = "`muspin simulate --case lift-off` shows whether it lifts off.";
        let rate = if self.chosen.is_some() { self.found_growth_rate_per_s } else { delivered_per_s };
        let rate = rate_words(rate, 1);
        match (self.chosen.and_then(|k| self.alternatives.get(k)), self.cheapest()) {
            (Some(a), _) => format!(
                "The controller with the lowest µ is unstable itself ({rate} 1/s); the stable one delivered ({}) \
                 costs {:.1} % in µ.",
                a.lever,
                percent(a.mu)
            ),
            (None, Some(a)) => format!(
                "The controller is unstable itself ({rate} 1/s): the cheapest stable one found ({}) costs {:.1} % \
                 in µ, more than {price:.0} %. {lifts}",
                a.lever,
                percent(a.mu)
            ),
            (None, None) => format!(
                "The controller is unstable itself ({rate} 1/s), and none of {} syntheses for a stable one gave \
                 one. {lifts}",
                self.alternatives.len()
            ),
        }
    }
}

/// The controller to deliver: that of the iteration when it is stable, else a stable one within the price, else it all
/// the same.
///
/// `posed` is the problem of the synthesis, `constant` its constant scales, `noise` the channels of w that carry sensor
/// noise, `bounded` gives the problem with a bound on T, for the bounds to try.
pub(super) fn prefer_stable(
    posed: &GeneralizedPlant,
    constant: &[f64],
    outcome: &DkOutcome,
    noise: std::ops::Range<usize>,
    limits: &[f64],
    bounded: &dyn Fn(f64) -> Result<GeneralizedPlant, PipelineError>,
) -> Result<(StateSpace<Continuous>, OwnStability), PipelineError> {
    let growth = |k: &StateSpace<Continuous>| k.growth_rate().map_err(PipelineError::numeric("controller poles"));
    let mut report = OwnStability {
        found_growth_rate_per_s: growth(&outcome.controller)?,
        found_mu: f64::NAN,
        alternatives: vec![],
        chosen: None,
    };
    if report.found_growth_rate_per_s < 0.0 {
        return Ok((outcome.controller.clone(), report));
    }
    report.found_mu = attained_gain(posed, &outcome.controller)?.unwrap_or(f64::INFINITY);
    let mut levers: Vec<(String, GeneralizedPlant, f64)> = vec![];
    for relaxed in RELAXED {
        let words = format!("γ {:.1} % above the optimum", 100.0 * relaxed);
        levers.push((words, posed.clone(), relaxed));
    }
    for factor in NOISIER {
        let mut plant = posed.clone();
        for j in noise.clone() {
            for m in [&mut plant.system.b, &mut plant.system.d] {
                for i in 0..m.nrows() {
                    m[(i, j)] *= factor;
                }
            }
        }
        levers.push((format!("{factor} times the sensor noise"), plant, RELAXED[0]));
    }
    for limit in limits {
        // A bound that cannot be posed is no lever.
        if let Ok(plant) = bounded(*limit) {
            levers.push((format!("T bounded by {limit}"), plant, RELAXED[0]));
        }
    }
    for (lever, plant, relaxed) in levers {
        let Some(k) = central(&scale_signals(&plant, constant), outcome, relaxed) else {
            continue;
        };
        let growth_rate_per_s = growth(&k)?;
        let mu =
            if growth_rate_per_s < 0.0 { attained_gain(posed, &k)?.unwrap_or(f64::INFINITY) } else { f64::INFINITY };
        report.alternatives.push(Alternative { lever, growth_rate_per_s, mu });
        if mu <= report.found_mu * (1.0 + PRICE) {
            report.chosen = Some(report.alternatives.len() - 1);
            return Ok((k, report));
        }
    }
    Ok((outcome.controller.clone(), report))
}

/// The central controller of a plant with the scales of the iteration, this far above its optimal level.
fn central(plant: &GeneralizedPlant, outcome: &DkOutcome, relaxed: f64) -> Option<StateSpace<Continuous>> {
    let blocks: Vec<Block> =
        plant.blocks.iter().map(|b| Block::ComplexFull { rows: b.rows(), cols: b.cols() }).collect();
    let structure = Structure::new(&blocks).ok()?;
    let plant = outcome.scales.scaled_plant(plant, &structure).ok()?;
    let settings = HinfSettings { rel_tol: 1e-5, slack: relaxed, ..HinfSettings::default() };
    synthesise(&plant, &settings).ok().map(|s| s.controller)
}
