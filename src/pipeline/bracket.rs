//! Search of the factor at which γ crosses its target, between one that is too small and one that is large enough.

/// Logarithms of two factors between which γ crosses its target, with their γ.
///
/// γ falls about as a power of the factor. The next factor lies beside the crossing of the straight line in logarithms,
/// on the side that the last factor did not bound. A step that does not halve the bracket is followed by bisection.
pub struct Bracket {
    short: (f64, Option<f64>),
    factor: (f64, f64),
    target: f64,
    /// The next factor is the middle.
    halve: bool,
    /// The last factor was within the target.
    from_above: bool,
}

impl Bracket {
    /// Between a factor that is too small, with its γ if that is known, and one that brings γ to `target`, with its γ.
    pub fn new(short: f64, gamma: Option<f64>, factor: f64, reached: f64, target: f64) -> Self {
        Self {
            short: (short.ln(), gamma),
            factor: (factor.ln(), reached),
            target,
            halve: gamma.is_none(),
            from_above: false,
        }
    }

    /// The smallest factor found that brings γ to its target.
    pub fn factor(&self) -> f64 {
        self.factor.0.exp()
    }

    /// That factor over the largest found that is too small.
    pub fn ratio(&self) -> f64 {
        self.width().exp()
    }

    fn width(&self) -> f64 {
        self.factor.0 - self.short.0
    }

    /// The factor to try, for a bracket narrower than `asked`, as a share of the factor.
    pub fn next(&self, asked: f64) -> f64 {
        let (low, width) = (self.short.0, self.width());
        let middle = low + 0.5 * width;
        let (false, Some(gamma)) = (self.halve, self.short.1) else {
            return middle.exp();
        };
        let share = (gamma / self.target).ln() / (gamma / self.factor.1).ln();
        // Four tenths of the width asked for beside the crossing: one more on the other side ends the search.
        let beside = 0.4 * asked.ln_1p() * if self.from_above { -1.0 } else { 1.0 };
        let found = low + share * width + beside;
        let inside = if found.is_finite() {
            // Inside by a part of the width asked for, which the bracket is wider than.
            let margin = 0.25 * asked.ln_1p();
            found.clamp(low + margin, low + width - margin)
        } else {
            middle
        };
        inside.exp()
    }

    /// γ of a factor inside the bracket.
    pub fn add(&mut self, factor: f64, gamma: f64) {
        let at = factor.ln();
        let before = self.width();
        self.from_above = gamma <= self.target;
        if self.from_above {
            self.factor = (at, gamma);
        } else {
            self.short = (at, Some(gamma));
        }
        self.halve = self.short.1.is_none() || !self.halve && self.width() > 0.5 * before;
    }
}
