//! The largest value of a function of one variable between two ends, asked value by value: the vertex of the parabola
//! through the three best points where that is inside, golden section where it is not (Brent 1973, chapter 5).

/// Smaller part of the golden section.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Smallest step relative to the place: a few times the distance of two numbers there.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A search in progress; points are (place, value).
#[derive(Clone, Debug)]
pub(crate) struct LineMaximum {
    ends: (f64, f64),
    best: (f64, f64),
    second: (f64, f64),
    third: (f64, f64),
    /// The last step and the one before it.
    steps: [f64; 2],
    /// Smallest step.
    tolerance: f64,
}

impl LineMaximum {
    /// A search between `below` and `above`, on either side of `best`, with their values; it ends when the largest is
    /// known to twice `tolerance` of its place, or to the rounding of that place.
    pub(crate) fn new([below, best, above]: [(f64, f64); 3], tolerance: f64) -> Self {
        let (second, third) = if below.1 > above.1 { (below, above) } else { (above, below) };
        let width = above.0 - below.0;
        // A step that rounding takes away would be asked for ever.
        let tolerance = tolerance.max(ROUNDING * below.0.abs().max(above.0.abs()));
        Self { ends: (below.0, above.0), best, second, third, steps: [width, width], tolerance }
    }

    /// Where the next value is asked; none when the place of the largest is known.
    pub(crate) fn next(&mut self) -> Option<f64> {
        let (lo, hi) = self.ends;
        let x = self.best.0;
        let middle = 0.5 * (lo + hi);
        if (x - middle).abs() <= 2.0 * self.tolerance - 0.5 * (hi - lo) {
            return None;
        }
        let [last, before] = self.steps;
        let vertex = self.vertex().filter(|step| {
            let inside = x + step > lo && x + step < hi;
            // Steps that do not shrink do not converge.
            before.abs() > self.tolerance && inside && step.abs() < 0.5 * before.abs()
        });
        let step = match vertex {
            Some(step) => {
                self.steps = [step, last];
                let near = |end: f64| (x + step - end).abs() < 2.0 * self.tolerance;
                if near(lo) || near(hi) { self.tolerance.copysign(middle - x) } else { step }
            }
            None => {
                let larger = if x >= middle { lo - x } else { hi - x };
                self.steps = [GOLDEN * larger, larger];
                GOLDEN * larger
            }
        };
        self.steps[0] = step;
        Some(x + step.abs().max(self.tolerance).copysign(step))
    }

    /// Step from the best point to the vertex of the parabola; none where the three points show none.
    fn vertex(&self) -> Option<f64> {
        let [to_second, to_third] = [self.second, self.third].map(|p| self.best.0 - p.0);
        let [by_second, by_third] = [self.second, self.third].map(|p| self.best.1 - p.1);
        let below = 2.0 * (to_third * by_second - to_second * by_third);
        let above = to_second * to_second * by_third - to_third * to_third * by_second;
        let step = above / below;
        step.is_finite().then_some(step)
    }

    /// Takes a value in; one that is not a number counts as none at all.
    pub(crate) fn add(&mut self, place: f64, value: f64) {
        let value = if value.is_nan() { f64::NEG_INFINITY } else { value };
        let point = (place, value);
        let right = place >= self.best.0;
        if value >= self.best.1 {
            if right {
                self.ends.0 = self.best.0
            } else {
                self.ends.1 = self.best.0
            }
            (self.third, self.second, self.best) = (self.second, self.best, point);
            return;
        }
        if right {
            self.ends.1 = place
        } else {
            self.ends.0 = place
        }
        if value >= self.second.1 {
            (self.third, self.second) = (self.second, point);
        } else if value >= self.third.1 {
            self.third = point;
        }
    }

    /// The largest value so far, with its place.
    pub(crate) fn best(&self) -> (f64, f64) {
        self.best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Place and value of the largest, and how many values were asked.
    fn largest(of: impl Fn(f64) -> f64, lo: f64, hi: f64, tolerance: f64) -> (f64, f64, usize) {
        let at = |x: f64| (x, of(x));
        let mut search = LineMaximum::new([at(lo), at(0.6 * lo + 0.4 * hi), at(hi)], tolerance);
        let mut asked = 0;
        while let Some(x) = search.next() {
            assert!(x > lo && x < hi, "{x} is not between {lo} and {hi}");
            search.add(x, of(x));
            asked += 1;
        }
        (search.best().0, search.best().1, asked)
    }

    #[test]
    fn a_resonance_is_found_within_the_tolerance_by_few_values() {
        for zeta in [0.5f64, 0.1, 0.01] {
            let top = (1.0 - 2.0 * zeta * zeta).sqrt();
            let gain = |w: f64| 1.0 / ((1.0 - w * w).powi(2) + (2.0 * zeta * w).powi(2)).sqrt();
            let (place, value, asked) = largest(gain, 0.5, 1.7, 1e-6);
            let exact = 1.0 / (2.0 * zeta * (1.0 - zeta * zeta).sqrt());
            assert!((place - top).abs() < 3e-6, "{place} and {top}");
            assert!((value / exact - 1.0).abs() < 1e-8, "{value} and {exact}");
            // Golden section alone asks 29.
            assert!(asked <= 20, "{asked} values for a damping ratio of {zeta}");
        }
    }

    #[test]
    fn a_search_between_numbers_that_rounding_hardly_tells_apart_ends() {
        for apart in [1e-10, 1e-13, 1e-15] {
            let (lo, hi) = (3e4, 3e4 * (1.0 + apart));
            let mut search = LineMaximum::new([(lo, 1.0), (0.5 * (lo + hi), 2.0), (hi, 1.0)], 2.5e-5 * (hi - lo));
            let mut asked = 0;
            while let Some(x) = search.next() {
                search.add(x, 2.0);
                asked += 1;
                assert!(asked < 60, "{apart}: still asks for {x}");
            }
        }
    }

    #[test]
    fn a_kink_and_an_end_are_found_too() {
        let (place, _, asked) = largest(|x| -(x - 0.3f64).abs(), 0.0, 1.0, 1e-6);
        assert!((place - 0.3).abs() < 3e-6 && asked <= 45, "{place} after {asked}");
        let (place, ..) = largest(|x| if x < 0.9 { x } else { f64::NAN }, 0.0, 1.0, 1e-6);
        assert!((place - 0.9).abs() < 3e-6, "{place}");
        let (place, ..) = largest(|x| x, 0.0, 1.0, 1e-6);
        assert!((place - 1.0).abs() < 3e-6, "{place}");
    }
}
