//! What closed loops come to: the largest value of each group, and the values near it.

use super::limits::{AT_TOP_SPEED, SHIFTED, WEAKEST};
use super::line_state::{ClosedLines, LinePart};
use super::loss::{Evaluation, Loss, largest_singular};
use super::responses::RotorRole;
use super::values::{Gathered, LIMITS, Value, ValueGroup, is_kept, nan_max, share_of};
use std::f64::consts::TAU;

/// A rotor that counts, with the factors that turn its squares into those of its ratios to limits.
#[derive(Clone, Copy, Debug)]
struct Counted {
    rotor: usize,
    /// Number of its group of rotors, and its place there.
    place: (usize, usize),
    /// Zero where the compliance does not count.
    compliance: f64,
    sensitivity: f64,
    group: ValueGroup,
    /// Zero where the noise does not count.
    noise: f64,
}

impl Loss {
    /// What closed loops come to over the rotors that count; of the values those less than a reach (logarithms) below
    /// their group's largest, of limits below zero if that is larger. Without a reach there are none.
    pub(super) fn gather_lines(&self, lines: ClosedLines, turns: Vec<i64>, reach: Option<f64>) -> Evaluation {
        let counted = self.list_counted();
        let noise = noise(&lines, &counted);
        let soft = self.squares_over_floors(&lines, &counted);
        let mut squares = [0.0; LIMITS + 1];
        let mut add = |group: ValueGroup, square: f64| {
            let all = &mut squares[group as usize];
            *all = nan_max(*all, square);
        };
        for part in lines.parts() {
            for own in &counted {
                let (group, l) = own.place;
                let largest = &part.largest[group];
                add(own.group, largest.sensitivity.as_array()[l] * own.sensitivity);
                if own.compliance > 0.0 {
                    let square = largest.compliance.as_array()[l] * own.compliance;
                    add(ValueGroup::Compliance, square);
                }
            }
        }
        for (_, _, square) in &noise {
            add(ValueGroup::NoiseCurrent, *square);
        }
        for (_, _, square) in &soft {
            add(ValueGroup::ToolStiffness, *square);
        }
        let mut values = vec![];
        if let Some(reach) = reach {
            let share = share_of(reach);
            let floor = |group: ValueGroup| share * group.reference(squares[group as usize], 1.0);
            for part in lines.parts() {
                for own in &counted {
                    let floors = [floor(ValueGroup::Compliance), floor(own.group)];
                    self.add_near(&mut values, part, own, floors);
                }
            }
            for (rotor, i, square) in &noise {
                if is_kept(*square, floor(ValueGroup::NoiseCurrent)) {
                    let at = (*rotor, 0, (*i, *i));
                    values.push(Value::of_square(ValueGroup::NoiseCurrent, *square, at));
                }
            }
            for (rotor, line, square) in &soft {
                if is_kept(*square, floor(ValueGroup::ToolStiffness)) {
                    let at = (*rotor, *line, (0, 0));
                    values.push(Value::of_square(ValueGroup::ToolStiffness, *square, at));
                }
            }
        }
        let own = self.controller_values(&lines, reach);
        let mut largest = squares;
        for (all, square) in largest.iter_mut().zip(own.largest) {
            *all = 0.5 * nan_max(*all, square).ln();
        }
        values.extend(own.values);
        Evaluation { values, lines, largest, turns }
    }

    /// The rotors that count.
    fn list_counted(&self) -> Vec<Counted> {
        let groups = self.groups.list.iter().enumerate();
        let places = groups.flat_map(|(group, own)| {
            let rotors = own.rotors.iter().enumerate();
            rotors.map(move |(l, rotor)| (*rotor, (group, l)))
        });
        let counts = places.filter(|(rotor, _)| self.active[*rotor]);
        counts.map(|(rotor, place)| self.count(rotor, place)).collect()
    }

    /// A rotor at a place among the groups.
    fn count(&self, rotor: usize, place: (usize, usize)) -> Counted {
        let (role, limits) = (self.rotors[rotor].role, &self.limits);
        let weight = match role {
            RotorRole::Rest => 1.0,
            RotorRole::TopSpeed => AT_TOP_SPEED,
            RotorRole::Shifted | RotorRole::Between => SHIFTED,
            RotorRole::Overspeed | RotorRole::Weak | RotorRole::Weakest => 0.0,
        };
        let (group, limit) = match role {
            RotorRole::Rest | RotorRole::TopSpeed => (ValueGroup::Sensitivity, limits.sensitivity),
            RotorRole::Shifted | RotorRole::Between | RotorRole::Overspeed => {
                let limit = limits.sensitivity * limits.shifted_sensitivity;
                (ValueGroup::Sensitivity, limit)
            }
            RotorRole::Weak => (ValueGroup::Margin, limits.weak_sensitivity),
            RotorRole::Weakest => (ValueGroup::Margin, WEAKEST * limits.weak_sensitivity),
        };
        let noise = if role.is_nominal() { limits.sensor_noise_m / limits.noise_current_a } else { 0.0 };
        Counted {
            rotor,
            place,
            // Per µm/N.
            compliance: (weight * 1e6).powi(2),
            sensitivity: (limit * limit).recip(),
            group,
            noise: noise * noise,
        }
    }

    /// Squares of the compliance of nominal rotors over what the floors of the tool's stiffness allow: rotor, line and
    /// ratio.
    fn squares_over_floors(&self, lines: &ClosedLines, counted: &[Counted]) -> Vec<(usize, usize, f64)> {
        let groups = self.groups.list.len();
        let nominal = counted.iter().filter(|own| own.noise > 0.0);
        let at_floors = nominal.flat_map(|own| self.floors.iter().map(move |floor| (own, floor)));
        at_floors
            .map(|(own, (line, floor_n_per_m))| {
                let (group, l) = own.place;
                let square = lines.squares(*line, group, groups).compliance.as_array()[l];
                (own.rotor, *line, square * (floor_n_per_m / self.limits.tool_softness).powi(2))
            })
            .collect()
    }

    /// Adds the values of a rotor on the lines of a part that are not below the floors of compliance and sensitivity.
    fn add_near(&self, values: &mut Vec<Value>, part: &LinePart, own: &Counted, [softest, highest]: [f64; 2]) {
        let (group, l) = own.place;
        let largest = &part.largest[group];
        let (soft, high) = (largest.compliance.as_array(), largest.sensitivity.as_array());
        let is_soft = own.compliance > 0.0 && is_kept(soft[l] * own.compliance, softest);
        let is_high = is_kept(high[l] * own.sensitivity, highest);
        if !is_soft && !is_high {
            return;
        }
        let band = self.stiffness_band_rad_s();
        let squares = part.squares.iter().skip(group);
        let squares = squares.step_by(self.groups.list.len());
        for (line, squares) in (part.first..).zip(squares) {
            let square = squares.compliance.as_array()[l] * own.compliance;
            if is_soft && is_kept(square, softest) && band.contains(&self.lines[line].omega_rad_s) {
                let at = (own.rotor, line, (0, 0));
                values.push(Value::of_square(ValueGroup::Compliance, square, at));
            }
            for (j, four) in squares.sensitivity.iter().enumerate() {
                let square = four.as_array()[l] * own.sensitivity;
                if is_high && is_kept(square, highest) {
                    let at = (own.rotor, line, (j, j));
                    values.push(Value::of_square(own.group, square, at));
                }
            }
        }
    }

    /// Values of the controller itself and of the specification.
    fn controller_values(&self, lines: &ClosedLines, reach: Option<f64>) -> Gathered {
        let mut all = Gathered::new(reach);
        let from = self.limits.high_frequency_hz * TAU;
        for (line, state) in lines.all().enumerate() {
            if self.lines[line].omega_rad_s >= from {
                let gain = largest_singular(state.gain).0;
                if gain != 0.0 {
                    let ratio = gain / self.limits.high_frequency_gain_a_per_m;
                    all.push(ValueGroup::HighGain, ratio * ratio, line, (0, 0));
                }
            }
            for (part, bound) in state.specification.iter().enumerate() {
                let ratio = (bound.sigma / self.limits.mu).powi(2);
                // Zero has no logarithm; what is not a number stays.
                let ratio = if ratio < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { ratio };
                all.push(ValueGroup::Specification, ratio, line, (part, part));
            }
        }
        all
    }
}

/// Squares of the noise currents: rotor, bearing and ratio to the limit.
fn noise(lines: &ClosedLines, counted: &[Counted]) -> Vec<(usize, usize, f64)> {
    let nominal = counted.iter().filter(|own| own.noise > 0.0);
    let both = nominal.flat_map(|own| [0, 1].map(|i| (own, i)));
    both.map(|(own, i)| {
        let (group, l) = own.place;
        let parts = lines.parts().iter();
        let sum: f64 = parts.map(|part| part.largest[group].noise[i].as_array()[l]).sum();
        (own.rotor, i, sum * own.noise)
    })
    .collect()
}
