//! Derivatives of the loss compared with central differences, a check that every new limit has to pass.

use super::limits::WEAK_MAGNETS;
use super::lines::lines;
use super::modal_law::ModalLaw;
use super::problem::{PolishTask, loss_on};
use super::responses::Plants;
use super::structure::LawStructure;
use super::values::{GROUPS, LIMITS};
use crate::controller::verification_error::VerificationError;
use crate::lti::{Discrete, StateSpace};
use crate::spindle::Machine;

/// Largest difference between derivative and central difference of the largest value of each group (compliance,
/// sensitivity, high-frequency gain, noise current, specification, weak magnets, tool stiffness), relative to the
/// norm of that derivative, for a sampled controller of one plane (m to A).
///
/// # Errors
/// [`VerificationError`] as [`super::Polisher::new`].
pub fn derivative_errors(
    machine: &Machine,
    task: &PolishTask<'_>,
    plane: &StateSpace<Discrete>,
) -> Result<[f64; LIMITS + 1], VerificationError> {
    let plants = Plants::new(machine, 1.2, &[])?.with_weak_magnets(&WEAK_MAGNETS);
    let (law, x) = ModalLaw::within(plane, task.largest_radius(plane.time.period_s))?;
    let lines = lines(&plants, 1.0, &[], 2e-3);
    let loss = loss_on(&plants, task, lines, None)?;
    let all = |x: &[f64]| loss.evaluate_near(&law, x, f64::INFINITY);
    let found = all(&x);
    let natural = law.natural_steps(&x);
    // The largest value of each group, its derivatives, and the largest difference and derivative found so far.
    let mut checked: Vec<_> = GROUPS
        .iter()
        .enumerate()
        .filter_map(|(place, group)| {
            let of_group = (0..found.values.len()).filter(|k| found.values[*k].group == *group);
            let k = of_group.max_by(|a, b| found.values[*a].value.total_cmp(&found.values[*b].value))?;
            let slopes = loss.gradients(&*law.with(&x), &found, &[found.values[k]]).swap_remove(0);
            Some((place, k, slopes, [0.0f64; 2]))
        })
        .collect();
    for (p, natural) in natural.iter().enumerate() {
        // Balances truncation against rounding of values of order one.
        let at = |step: f64| {
            let mut moved = x.clone();
            moved[p] += step * natural;
            all(&moved)
        };
        let (above, below) = (at(1e-5), at(-1e-5));
        for (_, k, slopes, [difference, size]) in &mut checked {
            let central = (above.values[*k].value - below.values[*k].value) / 2e-5;
            *difference = difference.max((central - slopes[p] * natural).abs());
            *size = size.max((slopes[p] * natural).abs());
        }
    }
    let mut errors = [f64::NAN; LIMITS + 1];
    for (place, _, _, [difference, size]) in checked {
        errors[place] = difference / size;
    }
    Ok(errors)
}
