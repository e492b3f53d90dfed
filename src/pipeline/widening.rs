//! A specification with wider limits.

use crate::augment::weights::{GivenCurves, Limits, Weights};

/// Factors on the limits of a specification; loads, noise and natural-frequency uncertainty stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widening {
    /// On the displacement of the tool.
    pub tool: f64,
    /// On the displacement at the front bearing.
    pub front: f64,
    /// On the displacement at the rear bearing.
    pub rear: f64,
    /// On the control current.
    pub current: f64,
}

impl Widening {
    /// The limits as written.
    pub const NONE: Self = Self::all(1.0);

    /// One factor on every limit.
    #[must_use]
    pub(crate) const fn all(factor: f64) -> Self {
        Self { tool: factor, front: factor, rear: factor, current: factor }
    }

    /// One factor on every displacement, the control current as written.
    #[must_use]
    pub const fn displacements(factor: f64) -> Self {
        Self { current: 1.0, ..Self::all(factor) }
    }

    /// True when no limit is wider than written.
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// The specification with these factors, in words.
    pub(crate) fn words(&self) -> String {
        if self.is_none() {
            return "the specification as written".to_owned();
        }
        format!(
            "the specification with wider limits (tool × {:.3}, front × {:.3}, rear × {:.3}, current × {:.3})",
            self.tool, self.front, self.rear, self.current
        )
    }

    fn wider(&self, curves: &GivenCurves) -> GivenCurves {
        let places = [self.tool, self.front, self.rear];
        let divided = |place: usize| {
            let weight = curves.displacement[place].as_ref();
            weight.map(|w| w.times(places[place].recip()))
        };
        GivenCurves {
            load: curves.load.clone(),
            noise: curves.noise.clone(),
            displacement: [0, 1, 2].map(divided),
            current: curves.current.as_ref().map(|w| w.times(self.current.recip())),
        }
    }

    /// The specification with these factors.
    #[must_use]
    pub fn apply(&self, weights: &Weights) -> Weights {
        let wider = |limits: &Limits, factor: f64| Limits {
            max_dc_displacement_m: factor * limits.max_dc_displacement_m,
            max_hf_displacement_m: factor * limits.max_hf_displacement_m,
            ..*limits
        };
        Weights {
            tool: wider(&weights.tool, self.tool),
            front: wider(&weights.front, self.front),
            rear: wider(&weights.rear, self.rear),
            current_limit_a: self.current * weights.current_limit_a,
            curves: self.wider(&weights.curves),
            ..weights.clone()
        }
    }
}
