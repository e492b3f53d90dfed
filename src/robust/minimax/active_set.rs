//! The weights of a prox-linear step by a primal active-set method (Nocedal and Wright 2006, section 16.5).
//!
//! With y_k the weight of slope g_k in the step p = −Σ y_k g_k/λ:
//!   minimise |Σ y_k g_k|²/2λ − Σ v_k y_k,   y ≥ 0,   Σ y = 1 over the objective,   Σ y ≤ ρ over each limit.
//! A slack with v = 0, g = 0 in each limit makes its sum ρ as well. Of hundreds of weights ten or twenty are positive:
//! a system of their number is solved exactly, in the place of an interior-point programme over all of them.

use crate::linalg::small::eliminate_real;

/// A value with its linearisation.
#[derive(Clone, Debug)]
pub struct LinearValue {
    /// `None`: part of the objective. Some(g): limit of group g, asked to be at most zero.
    pub limit: Option<usize>,
    /// v.
    pub value: f64,
    /// g, one entry per coordinate of p.
    pub gradient: Vec<f64>,
}

/// Penalties of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepRule {
    /// Number of limits.
    pub limits: usize,
    /// ρ.
    pub penalty: f64,
    /// λ.
    pub proximal: f64,
}

/// Weight added to the diagonal of the matrix of the programme, relative to its largest entry: slopes of neighbouring
/// lines are nearly dependent.
const RIDGE: f64 = 1e-12;
/// A value joins if it exceeds its level by more, relative to the largest value plus one.
const VIOLATION: f64 = 1e-9;
/// Changes of the active set at most, for each value and slack.
const CHANGES: usize = 4;

/// Weights of the values, of which `likely` are expected to bind; `None` where the method does not come to its end.
pub(super) fn weights(values: &[LinearValue], likely: &[usize], rule: &StepRule) -> Option<Vec<f64>> {
    let mut programme = Programme::new(values, likely, rule);
    let all = values.len() + programme.groups.len();
    for _ in 0..CHANGES * all {
        let target = programme.minimiser()?;
        if !programme.moved_to(&target) {
            continue;
        }
        match programme.most_violated() {
            Some(next) => programme.active.push(next),
            None => {
                programme.y.truncate(values.len());
                return Some(programme.y);
            }
        }
    }
    None
}

struct Programme<'a> {
    values: &'a [LinearValue],
    proximal: f64,
    /// Groups that have values, 0 for the objective, with the sum of their weights.
    groups: Vec<(usize, f64)>,
    /// Weights of the values, then of the slack of each group (zero for the objective).
    y: Vec<f64>,
    /// Positions of the weights that may be positive.
    active: Vec<usize>,
    /// Levels of the groups, in their order.
    levels: Vec<f64>,
    /// Values that were active, in the order in which they first were; the place of each value among them.
    met: Vec<usize>,
    place: Vec<Option<usize>>,
    /// Lower triangle of the matrix of the programme among the values that were active, row after row.
    quadratic: Vec<Vec<f64>>,
    ridge: f64,
    tolerance: f64,
}

impl<'a> Programme<'a> {
    fn new(values: &'a [LinearValue], likely: &[usize], rule: &StepRule) -> Self {
        let m = values.len();
        let mut groups: Vec<(usize, f64)> = vec![];
        for group in 0..=rule.limits {
            if values.iter().any(|v| group_of(v) == group) {
                groups.push((group, if group == 0 { 1.0 } else { rule.penalty }));
            }
        }
        let mut y = vec![0.0; m + groups.len()];
        let mut active = vec![];
        for (slot, (group, sum)) in groups.iter().enumerate() {
            let mut members: Vec<usize> = likely.to_vec();
            members.retain(|k| group_of(&values[*k]) == *group);
            if *group > 0 {
                members.push(m + slot);
            } else if members.is_empty() {
                let own = (0..m).filter(|k| group_of(&values[*k]) == 0);
                members.extend(own.max_by(|a, b| values[*a].value.total_cmp(&values[*b].value)));
            }
            for k in &members {
                y[*k] = sum / members.len() as f64;
            }
            active.extend(members);
        }
        let square = |v: &LinearValue| product(&v.gradient, &v.gradient) / rule.proximal;
        let largest = values.iter().map(square).fold(0.0, f64::max);
        let size = values.iter().map(|v| v.value.abs()).fold(1.0, f64::max);
        Self {
            levels: vec![0.0; groups.len()],
            met: vec![],
            place: vec![None; m],
            quadratic: vec![],
            ridge: RIDGE * largest,
            tolerance: VIOLATION * size,
            proximal: rule.proximal,
            values,
            groups,
            y,
            active,
        }
    }

    /// Position of the group of a weight.
    fn slot(&self, k: usize) -> usize {
        match self.values.get(k) {
            Some(value) => {
                let group = group_of(value);
                let own = self.groups.iter().position(|(g, _)| *g == group);
                own.unwrap_or(0)
            }
            None => k - self.values.len(),
        }
    }

    /// Place of a value among those that were active; the first time its row of the matrix is computed. None for a
    /// slack, which has no slope.
    fn met(&mut self, k: usize) -> Option<usize> {
        let place = self.place.get_mut(k)?;
        let known = place.get_or_insert_with(|| {
            self.met.push(k);
            let own = &self.values[k].gradient;
            let earlier = self.met.iter().map(|j| &self.values[*j].gradient);
            let row = earlier.map(|other| product(own, other) / self.proximal);
            self.quadratic.push(row.collect());
            self.quadratic.len() - 1
        });
        Some(*known)
    }

    /// The weights that minimise over the active ones whatever their sign, and the levels, which it keeps.
    fn minimiser(&mut self) -> Option<Vec<f64>> {
        let (count, groups) = (self.active.len(), self.groups.len());
        let n = count + groups;
        let mut matrix = vec![0.0; n * n];
        let mut rhs = vec![0.0; n];
        let active = self.active.clone();
        let met: Vec<Option<usize>> = active.iter().map(|k| self.met(*k)).collect();
        for i in 0..count {
            let k = self.active[i];
            for j in 0..=i {
                if let (Some(a), Some(b)) = (met[i], met[j]) {
                    let entry = self.quadratic[a.max(b)][a.min(b)];
                    matrix[i * n + j] = entry;
                    matrix[j * n + i] = entry;
                }
            }
            if let Some(value) = self.values.get(k) {
                matrix[i * n + i] += self.ridge;
                rhs[i] = value.value;
            }
            let slot = count + self.slot(k);
            matrix[i * n + slot] = 1.0;
            matrix[slot * n + i] = 1.0;
        }
        for (slot, (_, sum)) in self.groups.iter().enumerate() {
            rhs[count + slot] = *sum;
        }
        eliminate_real(&mut matrix, &mut rhs, n);
        if rhs.iter().any(|v| !v.is_finite()) {
            return None;
        }
        self.levels.copy_from_slice(&rhs[count..]);
        rhs.truncate(count);
        Some(rhs)
    }

    /// Moves the active weights to a target, or as far as they stay positive; the one that does not is no longer
    /// active, and the answer is false.
    fn moved_to(&mut self, target: &[f64]) -> bool {
        let mut share = 1.0;
        let mut blocking = None;
        for (i, k) in self.active.iter().enumerate() {
            let (y, fall) = (self.y[*k], self.y[*k] - target[i]);
            if target[i] < 0.0 && y < share * fall {
                (share, blocking) = (y / fall, Some(i));
            }
        }
        for (k, target) in self.active.iter().zip(target) {
            self.y[*k] = (self.y[*k] + share * (target - self.y[*k])).max(0.0);
        }
        if let Some(i) = blocking {
            self.y[self.active[i]] = 0.0;
            self.active.remove(i);
        }
        blocking.is_none()
    }

    /// The weight whose value exceeds the level of its group most, if one does.
    fn most_violated(&self) -> Option<usize> {
        let n = self.values.first().map_or(0, |v| v.gradient.len());
        let mut step = vec![0.0; n];
        for k in &self.active {
            if let Some(value) = self.values.get(*k) {
                for (p, g) in step.iter_mut().zip(&value.gradient) {
                    *p -= self.y[*k] * g / self.proximal;
                }
            }
        }
        let mut active = vec![false; self.y.len()];
        for k in &self.active {
            active[*k] = true;
        }
        let mut worst = (self.tolerance, None);
        for k in (0..self.y.len()).filter(|k| !active[*k]) {
            let slot = self.slot(k);
            let after = match self.values.get(k) {
                Some(value) => value.value + product(&value.gradient, &step),
                None if self.groups[slot].0 == 0 => continue,
                None => 0.0,
            };
            let above = after - self.levels[slot];
            if above > worst.0 {
                worst = (above, Some(k));
            }
        }
        worst.1
    }
}

/// 0 for the objective, 1 + g for limit g.
fn group_of(value: &LinearValue) -> usize {
    value.limit.map_or(0, |g| 1 + g)
}

/// aᵀb in four sums side by side.
fn product(a: &[f64], b: &[f64]) -> f64 {
    let (mut sums, whole) = ([0.0; 4], a.len() / 4 * 4);
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a[whole..].iter().zip(&b[whole..]).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
