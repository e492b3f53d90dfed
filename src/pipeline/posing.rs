//! The problem that a synthesis solves: how much of the gyroscopic split it covers, how far T is bounded, and, where
//! the specification is out of reach, by how much its limits are widened.
//!
//! γ with constant scales decides; it is an upper bound of the μ that the D-K iteration reaches. While γ exceeds the
//! target, the cover is reduced: first that of the guard modes, then that of the flexible modes from the highest to the
//! lowest. If γ exceeds the target even with the uncertainty as written, the allowed displacements are multiplied by
//! the smallest factor that brings γ to the target; then the cover is extended as far as a quarter more of that factor
//! allows. Last, the tightest bound on T within the target is chosen.

use super::PipelineError;
use super::bracket::Bracket;
use super::problems::{Cover, Problems, build_generalized, whole_machine};
use super::settings::DesignSettings;
use super::widening::Widening;
use crate::augment::GeneralizedPlant;
use crate::augment::assembly::UncertainMode;
use crate::augment::plane::{Route, modes_below_nyquist};
use crate::augment::split::{ModeSplit, gyroscopic_split};
use crate::augment::weight_plane::fit_errors;
use crate::augment::weights::Weights;
use crate::robust::prescale::{ScaleStart, constant_scales, scales_to};
use crate::spindle::Machine;
use std::f64::consts::TAU;

/// Where the search for constant scales of modal channels starts: q is of the order 1e-6 m√kg, √(2r)ω₀ of 1e3 rad/s.
const STARTING_SCALE: f64 = 100.0;
/// Smallest growth of the widening in one step of its search.
const STEP: f64 = 1.05;
/// Steps at most: γ falls about as the limits widen, so that two or three are enough where it falls at all.
const STEPS: usize = 12;
/// A step that lowers γ by less than this share shows that displacements do not bind.
const PROGRESS: f64 = 0.02;
/// Width of the widening, relative: far below what it costs the loop.
const WIDTH: f64 = 0.05;
/// Factor by which covering the split may increase the widening.
const COVER_PRICE: f64 = 1.25;

/// Where the constant scales of a problem are searched from.
#[derive(Clone, Copy)]
enum Beside<'a> {
    /// No other problem is solved yet.
    Nothing,
    /// The scales of a problem with another cover, another bound on T, or fewer modes.
    Near(&'a [f64]),
    /// Those of a problem whose limits are some times as wide, or that covers much more.
    Far(&'a [f64]),
}

/// A problem with its constant scales.
struct Posed {
    plant: GeneralizedPlant,
    limit: Option<f64>,
    scales: Vec<f64>,
    gamma: f64,
}

/// What stays the same while cover, widening and bound on T are chosen.
struct Posing<'a> {
    machine: &'a Machine,
    weights: &'a Weights,
    settings: &'a DesignSettings,
    split: Vec<ModeSplit>,
    /// Flexible modes of the specification's model.
    kept: usize,
    synthesis_modes: usize,
}

/// A choice of cover and widening with what constant scales make of it.
struct Choice {
    cover: Cover,
    widening: Widening,
    posed: Posed,
}

/// Builds the problems and the constant scales of the synthesis problem, one per block, with their γ.
///
/// # Errors
/// [`PipelineError`] when a plant, a weight or the first synthesis fails.
pub fn pose(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
) -> Result<(Problems, Vec<f64>, f64), PipelineError> {
    pose_again(machine, weights, settings, None)
}

/// [`pose`]; what was chosen for the same specification with `fewer_modes` in the synthesis is kept where it is still
/// within the target.
pub(super) fn pose_again(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    fewer_modes: Option<(&Problems, &[f64])>,
) -> Result<(Problems, Vec<f64>, f64), PipelineError> {
    let top_speed = machine.spindle.max_rpm * TAU / 60.0;
    let flexible_rad_s = modes_below_nyquist(machine)?;
    let machine_modes = flexible_rad_s.len();
    let kept = machine.spindle.flexible_modes.min(machine_modes);
    let covered = (kept + settings.guard_modes).min(machine_modes);
    let synthesis_modes = covered.saturating_add(settings.extra_modes).min(machine_modes);
    let posing = Posing {
        split: gyroscopic_split(machine, top_speed, covered)?,
        machine,
        weights,
        settings,
        kept,
        synthesis_modes,
    };
    let Choice { cover, widening, posed } = match fewer_modes {
        Some((problems, scales)) => posing.kept_or_chosen(problems, scales)?,
        None => posing.bound_choice(posing.choose_cover()?)?,
    };
    let posed = posing.search_cover(posed)?;
    let aim = widening.apply(weights);
    let covered_modes = posing.modes(Some(cover));
    let written = posing.modes(None);
    let period_s = machine.spindle.electronics.sample_period_s();
    let whole = |weights: &Weights, modes: &[UncertainMode]| whole_machine(machine, weights, machine_modes, modes);
    let specification = whole(weights, &written)?;
    let problems = Problems {
        aimed: if widening.is_none() { specification.clone() } else { whole(&aim, &written)? },
        specification,
        covered: whole(&aim, &covered_modes)?,
        synthesis: match settings.route {
            Route::Direct => posed.plant.clone(),
            Route::Emulation { .. } => {
                build_generalized(machine, &aim, synthesis_modes, &covered_modes, posed.limit, Route::Direct)?
            }
        },
        posed: posed.plant,
        route: settings.route,
        sensitivity_limit: posed.limit,
        period_s,
        written_modes: written,
        synthesis_modes,
        machine_modes,
        flexible_rad_s,
        fit_errors: fit_errors(weights, period_s).map_err(PipelineError::numeric("weights in the w plane"))?,
        covered_modes,
        cover,
        aim,
        widening,
        split: posing.split,
    };
    Ok((problems, posed.scales, posed.gamma))
}

impl Posing<'_> {
    /// Uncertainty as written, or widened by the split that is covered.
    fn modes(&self, cover: Option<Cover>) -> Vec<UncertainMode> {
        let table = |k: usize| {
            let given = self.weights.mode_uncertainty.get(k);
            given.copied().unwrap_or(0.0)
        };
        let covered = |number: usize| match cover {
            Some(cover) if number < cover.modes => 1.0,
            Some(cover) if number >= self.kept => cover.guard_share,
            _ => 0.0,
        };
        let modes = self.split.iter().enumerate();
        modes
            .map(|(number, s)| UncertainMode {
                number,
                omega_rad_s: s.omega_rad_s,
                relative: table(number) + covered(number) * s.relative(),
            })
            .filter(|m| m.relative > 0.0)
            .collect()
    }

    /// Covers from the full one to none of the split, in the order in which they are tried.
    fn covers(&self) -> Vec<Cover> {
        let mut shares = self.settings.guard_cover.clone();
        shares.retain(|share| *share > 0.0 && self.split.len() > self.kept);
        shares.push(0.0);
        let mut covers: Vec<Cover> =
            shares.into_iter().map(|guard_share| Cover { modes: self.kept, guard_share }).collect();
        if self.settings.give_way {
            covers.extend((0..self.kept).rev().map(|modes| Cover { modes, guard_share: 0.0 }));
        }
        // A cover that changes no mode is none.
        covers.dedup_by(|b, a| self.modes(Some(*a)) == self.modes(Some(*b)));
        covers
    }

    /// Constant scales of a problem, from the scales of another if there are any, to the level that is enough.
    fn attempt(
        &self,
        cover: Cover,
        widening: Widening,
        limit: Option<f64>,
        from: Beside<'_>,
        enough: f64,
    ) -> Result<Posed, PipelineError> {
        let modes = self.modes(Some(cover));
        let plant = build_generalized(
            self.machine,
            &widening.apply(self.weights),
            self.synthesis_modes,
            &modes,
            limit,
            self.settings.route,
        )?;
        let further = plant.blocks.len().saturating_sub(1 + modes.len());
        let mut start = vec![STARTING_SCALE; modes.len()];
        start.extend(vec![1.0; further]);
        let earlier = self.settings.earlier.as_ref();
        let (known, near) = match from {
            Beside::Near(scales) => (Some(scales), true),
            Beside::Far(scales) => (Some(scales), false),
            Beside::Nothing => (earlier.map(|e| e.scales.as_slice()), true),
        };
        let known = known.filter(|scales| !scales.is_empty());
        for (own, scale) in start.iter_mut().zip(known.into_iter().flatten()) {
            *own = *scale;
        }
        let start = if known.is_some() && near { ScaleStart::Neighbour(&start) } else { ScaleStart::Guess(&start) };
        let found = scales_to(&plant, start, enough)?;
        Ok(Posed { plant, limit, scales: found.scale, gamma: found.gamma })
    }

    /// The problem with its best constant scales, where the search for them ended at the target.
    fn search_cover(&self, posed: Posed) -> Result<Posed, PipelineError> {
        if !self.reaches(&posed) {
            return Ok(posed);
        }
        let scales = &posed.scales[..posed.scales.len().saturating_sub(1)];
        let found = constant_scales(&posed.plant, ScaleStart::Neighbour(scales))?;
        Ok(Posed { scales: found.scale, gamma: found.gamma, ..posed })
    }

    fn reaches(&self, posed: &Posed) -> bool {
        posed.gamma <= self.settings.gamma_target
    }

    /// The choice made with fewer modes in the synthesis if it is within the target with these, else a new one.
    fn kept_or_chosen(&self, problems: &Problems, scales: &[f64]) -> Result<Choice, PipelineError> {
        let kept =
            self.covering(problems.cover, problems.widening, problems.sensitivity_limit, Beside::Near(scales))?;
        if self.reaches(&kept.posed) {
            return Ok(kept);
        }
        self.bound_choice(self.choose_cover()?)
    }

    /// Cover and widening without a bound on T but the one given.
    fn choose_cover(&self) -> Result<Choice, PipelineError> {
        let given = self.weights.complementary_sensitivity_limit;
        let covers = self.covers();
        let first = self.covering(covers[0], Widening::NONE, given, Beside::Nothing)?;
        if self.reaches(&first.posed) || covers.len() == 1 {
            return self.widened_if_allowed(first, &covers);
        }
        let least = covers[covers.len() - 1];
        let last = self.covering(least, Widening::NONE, given, Beside::Far(&first.posed.scales))?;
        if self.reaches(&last.posed) {
            return self.most_covered(&covers[1..], Widening::NONE, last);
        }
        self.widened_if_allowed(last, &covers)
    }

    /// A cover and a widening with their constant scales.
    fn covering(
        &self,
        cover: Cover,
        widening: Widening,
        limit: Option<f64>,
        from: Beside<'_>,
    ) -> Result<Choice, PipelineError> {
        // Whether the target is reached decides; the choice that is made is searched to its end.
        let ends = (from, self.settings.gamma_target);
        let posed = self.attempt(cover, widening, limit, ends.0, ends.1)?;
        Ok(Choice { cover, widening, posed })
    }

    /// The first cover of the list that is within the target with `widening`; where none is, `reached`, a choice with
    /// the last cover. γ falls as the cover is reduced, so bisection finds it.
    fn most_covered(&self, covers: &[Cover], widening: Widening, reached: Choice) -> Result<Choice, PipelineError> {
        let limit = reached.posed.limit;
        let (mut low, mut high, mut best) = (0, covers.len() - 1, reached);
        while low < high {
            let middle = low.midpoint(high);
            let found = self.covering(covers[middle], widening, limit, Beside::Near(&best.posed.scales))?;
            if self.reaches(&found.posed) {
                (high, best) = (middle, found);
            } else {
                low = middle + 1;
            }
        }
        Ok(best)
    }

    /// The choice, or the one with wider limits where it misses the target and the settings allow it.
    fn widened_if_allowed(&self, choice: Choice, covers: &[Cover]) -> Result<Choice, PipelineError> {
        if self.reaches(&choice.posed) || !self.settings.give_way {
            return Ok(choice);
        }
        let widened = self.widen_choice(choice)?;
        if !self.reaches(&widened.posed) {
            return Ok(widened);
        }
        let priced = Widening {
            current: widened.widening.current,
            ..Widening::displacements(COVER_PRICE * widened.widening.tool)
        };
        self.most_covered(covers, priced, widened)
    }

    /// The choice with the displacements widened until γ reaches the target, the current as well where they do not
    /// help; the lowest γ found where neither does.
    fn widen_choice(&self, choice: Choice) -> Result<Choice, PipelineError> {
        let displacements = Widening::displacements;
        let (wide, choice) = self.widened_by(choice, &displacements)?;
        if self.reaches(&choice.posed) {
            return Ok(choice);
        }
        // Displacements do not bind beyond this; the current may.
        let with_current = |current: f64| Widening { current, ..displacements(wide) };
        let (current, choice) = self.widened_by(choice, &with_current)?;
        let at_this_current = |factor: f64| Widening { current, ..displacements(factor) };
        let (_, choice) = self.narrow_widening(1.0, None, wide, choice, &at_this_current)?;
        Ok(choice)
    }

    /// Constant scales of a choice's problem at another widening.
    fn rewiden_choice(&self, choice: &Choice, widening: Widening) -> Result<Choice, PipelineError> {
        let cover = choice.cover;
        let limit = choice.posed.limit;
        let from = Beside::Far(&choice.posed.scales);
        // Where γ crosses the target is interpolated: it is searched to its end.
        let posed = self.attempt(cover, widening, limit, from, 0.0)?;
        Ok(Choice { cover, widening, posed })
    }

    /// The least factor of a family of widenings, from 1 on, that brings γ to the target; the last that lowered γ where
    /// none does. With the choice that belongs to it.
    fn widened_by(&self, choice: Choice, family: &dyn Fn(f64) -> Widening) -> Result<(f64, Choice), PipelineError> {
        let mut short = (1.0f64, Some(choice.posed.gamma));
        let (mut factor, mut best) = (1.0f64, choice);
        for _ in 0..STEPS {
            let gamma = best.posed.gamma;
            let next = factor * (gamma / self.settings.gamma_target).max(STEP);
            let found = self.rewiden_choice(&best, family(next))?;
            if found.posed.gamma > (1.0 - PROGRESS) * gamma {
                break;
            }
            short = (factor, Some(gamma));
            (factor, best) = (next, found);
            if self.reaches(&best.posed) {
                break;
            }
        }
        self.narrow_widening(short.0, short.1, factor, best, family)
    }

    /// Narrows the factor of a family between one that is too small, with its γ if that is known, and that of a choice,
    /// if the choice reaches the target.
    fn narrow_widening(
        &self,
        short: f64,
        gamma: Option<f64>,
        factor: f64,
        choice: Choice,
        family: &dyn Fn(f64) -> Widening,
    ) -> Result<(f64, Choice), PipelineError> {
        let mut best = choice;
        let mut bracket = Bracket::new(short, gamma, factor, best.posed.gamma, self.settings.gamma_target);
        while self.reaches(&best.posed) && bracket.ratio() > 1.0 + WIDTH {
            let middle = bracket.next(WIDTH);
            let found = self.rewiden_choice(&best, family(middle))?;
            bracket.add(middle, found.posed.gamma);
            if self.reaches(&found.posed) {
                best = found;
            }
        }
        Ok((bracket.factor(), best))
    }

    /// The choice with the tightest bound on T within the target.
    fn bound_choice(&self, choice: Choice) -> Result<Choice, PipelineError> {
        if self.weights.complementary_sensitivity_limit.is_some() || !self.reaches(&choice.posed) {
            return Ok(choice);
        }
        let tighter = &self.settings.sensitivity_limits;
        let Choice { cover, widening, mut posed } = choice;
        // γ falls as the bound on T is loosened: bisection finds the tightest bound of the list that is within the
        // target.
        let (mut low, mut high) = (0, tighter.len());
        while low < high {
            let middle = low.midpoint(high);
            let tight = self.attempt(
                cover,
                widening,
                Some(tighter[middle]),
                Beside::Near(&posed.scales),
                self.settings.gamma_target,
            )?;
            if self.reaches(&tight) {
                posed = tight;
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        Ok(Choice { cover, widening, posed })
    }
}
