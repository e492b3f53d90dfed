//! What closed loops come to: the largest value of each group, and the values near it.

use super::limits::{AT_TOP_SPEED, SHIFTED, WEAKEST};
use super::line_state::{ClosedLines, LinePart, PackedSquares};
use super::loss::{Evaluation, Loss, largest_singular};
use super::responses::Role;
use super::values::{Gathered, Group, LIMITS, Value, nan_max};
use crate::linalg::lanes::WIDTH;
use std::f64::consts::TAU;

/// Factors that turn the squares of a rotor into those of its ratios to limits.
#[derive(Clone, Copy, Debug)]
struct Ratios {
    rotor: usize,
    /// Zero where the compliance does not count.
    compliance: f64,
    sensitivity: f64,
    /// Group of the sensitivity.
    group: Group,
    /// Zero where the noise does not count.
    noise: f64,
}

impl Loss {
    /// What closed loops come to over the rotors that count; of the values those less than a reach (logarithms) below
    /// their group's largest, of limits below zero if that is larger. Without a reach there are none.
    pub(super) fn gathered(
        &self,
        lines: ClosedLines,
        turns: Vec<i64>,
        reach: Option<f64>,
    ) -> Evaluation {
        let ratios: Vec<[Option<Ratios>; WIDTH]> = (0..self.groups.list.len())
            .map(|group| std::array::from_fn(|l| self.ratios(group, l)))
            .collect();
        let noise = noise(&lines, &ratios);
        let mut squares = [0.0; LIMITS + 1];
        let mut add = |group: Group, square: f64| {
            let all = &mut squares[group as usize];
            *all = nan_max(*all, square);
        };
        for part in lines.parts() {
            for (own, l, rule) in counted(part, &ratios) {
                let largest = &part.largest[own];
                add(rule.group, largest.sensitivity[l] * rule.sensitivity);
                if rule.compliance > 0.0 {
                    add(Group::Compliance, largest.compliance[l] * rule.compliance);
                }
            }
        }
        for (_, _, square) in &noise {
            add(Group::NoiseCurrent, *square);
        }
        let mut values = vec![];
        if let Some(reach) = reach {
            let share = (-2.0 * reach).exp();
            let floor = |group: Group| {
                let largest = squares[group as usize];
                share
                    * match group {
                        Group::Compliance => largest,
                        _ => largest.max(1.0),
                    }
            };
            for part in lines.parts() {
                for (own, l, rule) in counted(part, &ratios) {
                    let floors = [floor(Group::Compliance), floor(rule.group)];
                    self.add_near(&mut values, (part, own, l), (&rule, floors));
                }
            }
            for (rotor, i, square) in &noise {
                if is_kept(*square, floor(Group::NoiseCurrent)) {
                    let at = (*rotor, 0, (*i, *i));
                    values.push(value(Group::NoiseCurrent, *square, at));
                }
            }
        }
        let own = self.controller_values(&lines, reach);
        let mut largest = squares;
        for (all, square) in largest.iter_mut().zip(own.largest) {
            *all = 0.5 * nan_max(*all, square).ln();
        }
        values.extend(own.values);
        Evaluation {
            values,
            lines,
            largest,
            turns,
        }
    }

    /// Of a rotor of a group, if it counts.
    fn ratios(&self, group: usize, l: usize) -> Option<Ratios> {
        let rotor = *self.groups.list[group].rotors.get(l)?;
        if !self.active[rotor] {
            return None;
        }
        let (role, limits) = (self.rotors[rotor].role, &self.limits);
        let weight = match role {
            Role::Rest => 1.0,
            Role::TopSpeed => AT_TOP_SPEED,
            Role::Shifted => SHIFTED,
            Role::Overspeed | Role::Weak | Role::Weakest => 0.0,
        };
        let (group, limit) = match role {
            Role::Rest | Role::TopSpeed => (Group::Sensitivity, limits.sensitivity),
            Role::Shifted | Role::Overspeed => {
                let limit = limits.sensitivity * limits.shifted_sensitivity;
                (Group::Sensitivity, limit)
            }
            Role::Weak => (Group::Margin, limits.weak_sensitivity),
            Role::Weakest => (Group::Margin, WEAKEST * limits.weak_sensitivity),
        };
        let noise = match role.is_nominal() {
            true => limits.sensor_noise_m / limits.noise_current_a,
            false => 0.0,
        };
        Some(Ratios {
            rotor,
            // Per µm/N.
            compliance: (weight * 1e6).powi(2),
            sensitivity: (limit * limit).recip(),
            group,
            noise: noise * noise,
        })
    }

    /// Adds the values of a rotor, with these places among the groups, on the lines of a part that are not below the
    /// floors of compliance and sensitivity.
    fn add_near(
        &self,
        values: &mut Vec<Value>,
        (part, own, l): (&LinePart, usize, usize),
        (rule, [softest, highest]): (&Ratios, [f64; 2]),
    ) {
        let largest = &part.largest[own];
        let is_soft =
            rule.compliance > 0.0 && is_kept(largest.compliance[l] * rule.compliance, softest);
        let is_high = is_kept(largest.sensitivity[l] * rule.sensitivity, highest);
        if !is_soft && !is_high {
            return;
        }
        let band = self.stiffness_band_rad_s();
        let each = self.groups.list.len();
        let squares = part.squares.iter().skip(own).step_by(each);
        for (
            k,
            PackedSquares {
                compliance,
                sensitivity,
            },
        ) in squares.enumerate()
        {
            let line = part.first + k;
            let square = compliance[l] * rule.compliance;
            if is_soft && is_kept(square, softest) && band.contains(&self.lines[line].omega_rad_s) {
                values.push(value(Group::Compliance, square, (rule.rotor, line, (0, 0))));
            }
            for (j, four) in sensitivity.iter().enumerate() {
                let square = four[l] * rule.sensitivity;
                if is_high && is_kept(square, highest) {
                    values.push(value(rule.group, square, (rule.rotor, line, (j, j))));
                }
            }
        }
    }

    /// Values of the controller itself and of the specification.
    fn controller_values(&self, lines: &ClosedLines, reach: Option<f64>) -> Gathered {
        let mut all = Gathered::new(0, reach);
        let from = self.limits.high_frequency_hz * TAU;
        for (line, state) in lines.all().enumerate() {
            if self.lines[line].omega_rad_s >= from {
                let gain = largest_singular(state.gain).0;
                if gain != 0.0 {
                    let ratio = gain / self.limits.high_frequency_gain_a_per_m;
                    all.push(Group::HighGain, ratio * ratio, line, (0, 0));
                }
            }
            for (part, bound) in state.specification.iter().enumerate() {
                let ratio = (bound.sigma / self.limits.mu).powi(2);
                // Zero has no logarithm; what is not a number stays.
                let ratio = if ratio < f64::MIN_POSITIVE {
                    f64::MIN_POSITIVE
                } else {
                    ratio
                };
                all.push(Group::Specification, ratio, line, (part, part));
            }
        }
        all
    }
}

/// The rotors that count with their places among the groups of a part.
fn counted(
    part: &LinePart,
    ratios: &[[Option<Ratios>; WIDTH]],
) -> impl Iterator<Item = (usize, usize, Ratios)> {
    let places = (0..part.largest.len()).flat_map(|own| (0..WIDTH).map(move |l| (own, l)));
    places.filter_map(|(own, l)| Some((own, l, ratios[own][l]?)))
}

/// Squares of the noise currents: rotor, bearing and ratio to the limit.
fn noise(lines: &ClosedLines, ratios: &[[Option<Ratios>; WIDTH]]) -> Vec<(usize, usize, f64)> {
    let mut noise = vec![];
    for (own, rules) in ratios.iter().enumerate() {
        for (l, rule) in rules.iter().enumerate() {
            if let Some(rule) = rule.filter(|rule| rule.noise > 0.0) {
                noise.extend([0, 1].map(|i| {
                    let parts = lines.parts().iter();
                    let sum: f64 = parts.map(|part| part.largest[own].noise[i][l]).sum();
                    (rule.rotor, i, sum * rule.noise)
                }));
            }
        }
    }
    noise
}

/// True for what is not below a floor; what is not a number is kept.
fn is_kept(square: f64, floor: f64) -> bool {
    square >= floor || square.is_nan()
}

/// A value by the square of its ratio to its limit; at a rotor, a line and an entry.
fn value(group: Group, square: f64, (rotor, line, entry): (usize, usize, (usize, usize))) -> Value {
    Value {
        group,
        value: 0.5 * square.ln(),
        rotor,
        line,
        entry,
    }
}
