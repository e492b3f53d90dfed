//! Values of a loss: logarithms of quantities over their limits, in groups of which the first is the objective.

/// Groups of values; the first is the objective, the others are limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ValueGroup {
    Compliance,
    Sensitivity,
    HighGain,
    NoiseCurrent,
    Specification,
    /// |S| with weak magnets.
    Margin,
    /// Compliance of the tool where its stiffness has a floor.
    ToolStiffness,
}

pub(crate) const LIMITS: usize = 6;

/// The objective and the limits in their order.
pub(super) const GROUPS: [ValueGroup; LIMITS + 1] = [
    ValueGroup::Compliance,
    ValueGroup::Sensitivity,
    ValueGroup::HighGain,
    ValueGroup::NoiseCurrent,
    ValueGroup::Specification,
    ValueGroup::Margin,
    ValueGroup::ToolStiffness,
];

/// The limits in their order.
pub(super) const LIMIT_GROUPS: [ValueGroup; LIMITS] = {
    let [_, limits @ ..] = GROUPS;
    limits
};

impl ValueGroup {
    /// Number of the limit; `None` for the objective.
    pub(crate) fn limit(self) -> Option<usize> {
        LIMIT_GROUPS.iter().position(|group| *group == self)
    }

    /// What its values are compared with: the largest of them and, for limits, `limit` if that is larger.
    pub(super) fn reference(self, largest: f64, limit: f64) -> f64 {
        match self {
            Self::Compliance => largest,
            _ => largest.max(limit),
        }
    }
}

/// One value: the logarithm of a quantity over its limit (compliance: over 1 µm/N).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Value {
    pub group: ValueGroup,
    pub value: f64,
    pub rotor: usize,
    pub line: usize,
    /// Entry of S, current of the noise, loop of the specification.
    pub entry: (usize, usize),
}

impl Value {
    /// By the square of its ratio to its limit; at a rotor, a line and an entry.
    pub(super) fn of_square(
        group: ValueGroup,
        square: f64,
        (rotor, line, entry): (usize, usize, (usize, usize)),
    ) -> Self {
        Self { group, value: 0.5 * square.ln(), rotor, line, entry }
    }

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

/// True for what is not below a floor; what is not a number is kept.
pub(super) fn is_kept(square: f64, floor: f64) -> bool {
    square >= floor || square.is_nan()
}

/// Values of the controller, and of the specification.
pub(super) struct Gathered {
    /// Squares above this share of the largest of their group, of limits of one if that is larger, are kept.
    share: Option<f64>,
    pub values: Vec<Value>,
    /// Square of the largest of each group.
    pub largest: [f64; LIMITS + 1],
}

impl Gathered {
    /// Values less than a reach (logarithms) below their group's largest, of limits below zero if that is larger, are
    /// kept; without one, none.
    pub(super) fn new(reach: Option<f64>) -> Self {
        Self { share: reach.map(share_of), values: vec![], largest: [0.0; LIMITS + 1] }
    }

    /// A value by the square of its ratio to its limit.
    pub(super) fn push(&mut self, group: ValueGroup, square: f64, line: usize, entry: (usize, usize)) {
        let largest = &mut self.largest[group as usize];
        *largest = nan_max(*largest, square);
        let Some(share) = self.share else { return };
        if is_kept(square, share * group.reference(*largest, 1.0)) {
            self.values.push(Value::of_square(group, square, (0, line, entry)));
        }
    }
}

/// Share of a square that is a reach (logarithms) below another one's root.
pub(super) fn share_of(reach: f64) -> f64 {
    (-2.0 * reach).exp()
}
