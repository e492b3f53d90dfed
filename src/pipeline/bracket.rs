//! A factor at which γ crosses its target, between one that is too small and one that is large enough.

/// Logarithms of two factors between which γ crosses its target, with their γ.
///
/// γ falls about as a power of the factor: the next one lies beside the crossing of the straight line in logarithms, on
/// the side that the last one did not bound. Where that does not halve the bracket, bisection does.
pub(super) struct Bracket {
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
    pub(super) fn new(
        (short, gamma): (f64, Option<f64>),
        (factor, reached): (f64, f64),
        target: f64,
    ) -> Self {
        Self {
            short: (short.ln(), gamma),
            factor: (factor.ln(), reached),
            target,
            halve: gamma.is_none(),
            from_above: false,
        }
    }

    /// The smallest factor found that brings γ to its target.
    pub(super) fn factor(&self) -> f64 {
        self.factor.0.exp()
    }

    /// That factor over the largest found that is too small.
    pub(super) fn ratio(&self) -> f64 {
        self.width().exp()
    }

    fn width(&self) -> f64 {
        self.factor.0 - self.short.0
    }

    /// The factor to try, for a bracket narrower than `asked`, as a share of the factor.
    pub(super) fn next(&self, asked: f64) -> f64 {
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
    pub(super) fn add(&mut self, factor: f64, gamma: f64) {
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

#[cfg(test)]
mod tests {
    use super::Bracket;

    /// Evaluations until the bracket is narrower than 5 %, and its factor.
    fn narrowed(gamma: impl Fn(f64) -> f64, start: (f64, Option<f64>)) -> (usize, f64) {
        let mut bracket = Bracket::new(start, (4000.0, gamma(4000.0)), 1.0);
        let mut evaluations = 0;
        while bracket.ratio() > 1.05 && evaluations < 100 {
            let factor = bracket.next(0.05);
            bracket.add(factor, gamma(factor));
            evaluations += 1;
        }
        (evaluations, bracket.factor())
    }

    #[test]
    fn the_crossing_of_a_power_is_found_in_two_evaluations() {
        let gamma = |factor: f64| (factor / 37.0).powf(-0.7);
        let (evaluations, factor) = narrowed(gamma, (1.0, Some(gamma(1.0))));
        assert!((37.0..37.0 * 1.05).contains(&factor), "{factor}");
        assert_eq!(evaluations, 2);
    }

    #[test]
    fn a_step_and_a_floor_are_found_about_as_fast_as_by_bisection() {
        // ln 4000 / ln 1.05 = 170 widths: bisection takes eight.
        let step = |factor: f64| if factor < 37.0 { 1000.0 } else { 0.99 };
        let floor = |factor: f64| 0.98 + 100.0 / factor.powi(2);
        for gamma in [&step as &dyn Fn(f64) -> f64, &floor] {
            for known in [None, Some(gamma(1.0))] {
                let (evaluations, factor) = narrowed(gamma, (1.0, known));
                assert!(evaluations <= 2 * 8 + 2, "{evaluations}");
                assert!(
                    gamma(factor) <= 1.0 && gamma(factor / 1.05) > 1.0,
                    "{factor}"
                );
            }
        }
    }
}
