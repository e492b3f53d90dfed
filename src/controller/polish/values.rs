//! Values of a loss: logarithms of quantities over their limits, in groups of which the first is the objective.

/// Groups of values; the first is the objective, the others are limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Group {
    Compliance,
    Sensitivity,
    HighGain,
    NoiseCurrent,
    Specification,
    /// |S| with weak magnets.
    Margin,
}

/// Number of limits.
pub(crate) const LIMITS: usize = 5;

/// The objective and the limits in their order.
pub(super) const GROUPS: [Group; LIMITS + 1] = [
    Group::Compliance,
    Group::Sensitivity,
    Group::HighGain,
    Group::NoiseCurrent,
    Group::Specification,
    Group::Margin,
];

/// The limits in their order.
pub(super) const LIMIT_GROUPS: [Group; LIMITS] = {
    let [_, limits @ ..] = GROUPS;
    limits
};

impl Group {
    /// Number of the limit; `None` for the objective.
    pub(crate) fn limit(self) -> Option<usize> {
        LIMIT_GROUPS.iter().position(|group| *group == self)
    }
}

/// One value: the logarithm of a quantity over its limit (compliance: over 1 µm/N).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Value {
    pub group: Group,
    pub value: f64,
    pub rotor: usize,
    pub line: usize,
    /// Entry of S, current of the noise, loop of the specification.
    pub entry: (usize, usize),
}

impl Value {
    /// True for the same quantity of another controller.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let of = |v: &Self| (v.line, v.rotor, v.entry, v.group);
        of(self) == of(other)
    }
}

/// The larger; NaN counts as infinite.
pub(super) fn nan_max(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// Values of a rotor or of the controller.
pub(super) struct Gathered {
    rotor: usize,
    /// Squares above this share of the largest of their group, of limits of one if that is larger, are kept.
    share: Option<f64>,
    pub values: Vec<Value>,
    /// Square of the largest of each group.
    pub largest: [f64; LIMITS + 1],
}

impl Gathered {
    /// Values less than a reach (logarithms) below their group's largest, of limits below zero if that is larger, are
    /// kept; without one, none.
    pub(super) fn new(rotor: usize, reach: Option<f64>) -> Self {
        Self {
            rotor,
            share: reach.map(|reach| (-2.0 * reach).exp()),
            values: vec![],
            largest: [0.0; LIMITS + 1],
        }
    }

    /// A value by the square of its ratio to its limit.
    pub(super) fn push(&mut self, group: Group, square: f64, line: usize, entry: (usize, usize)) {
        let largest = &mut self.largest[group as usize];
        *largest = nan_max(*largest, square);
        let Some(share) = self.share else { return };
        let reference = match group {
            Group::Compliance => *largest,
            _ => largest.max(1.0),
        };
        // What is not a number is kept.
        if square < reference * share {
            return;
        }
        self.values.push(Value {
            group,
            value: 0.5 * square.ln(),
            rotor: self.rotor,
            line,
            entry,
        });
    }
}
