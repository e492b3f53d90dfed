//! The response of an axis over frequency, and how much a cascade changes it.

use super::section::{SectionBiquad, value};
use crate::controller::fidelity::{TransferChange, compared_angles, smallest_reference};
use crate::linalg::c64;
use crate::lti::{Discrete, StateSpace};
use rayon::prelude::*;

pub(super) struct Band {
    points: Vec<BandPoint>,
}

struct BandPoint {
    angle: f64,
    /// z⁻¹.
    q: c64,
    response: c64,
    /// What a change is relative to.
    reference: f64,
}

impl Band {
    /// The response of `axis`, which has the poles and zeros `roots`.
    pub(super) fn of(axis: &StateSpace<Discrete>, roots: &[c64]) -> Self {
        let angles = compared_angles(roots);
        let at = |angle: &f64| axis.transfer(c64::from_polar(1.0, *angle))[(0, 0)];
        let responses: Vec<c64> = angles.par_iter().map(at).collect();
        let floor = smallest_reference(&angles, &responses.iter().map(|r| r.norm()).collect::<Vec<_>>());
        let points = angles.iter().zip(responses).map(|(angle, response)| BandPoint {
            angle: *angle,
            q: c64::from_polar(1.0, -angle),
            response,
            reference: response.norm().max(floor),
        });
        Self { points: points.collect() }
    }

    /// Largest change of the response by a cascade.
    pub(super) fn change(&self, sections: &[SectionBiquad]) -> TransferChange {
        self.points.iter().fold(TransferChange::NONE, |change, point| {
            let product = sections.iter().fold(c64::new(1.0, 0.0), |p, s| p * s.response(point.q));
            change.or_larger((product - point.response).norm() / point.reference, point.angle)
        })
    }

    /// Largest change of the response when one polynomial in z⁻¹ takes the place of another.
    pub(super) fn polynomial_change(&self, exact: [f64; 3], held: [f64; 3]) -> f64 {
        let difference = [0, 1, 2].map(|k| held[k] - exact[k]);
        let changes = self.points.iter().map(|point| {
            let weight = point.response.norm() / point.reference;
            weight * value(difference, point.q).norm() / value(exact, point.q).norm()
        });
        // An exact zero on the circle at a frequency of comparison has no change.
        changes.filter(|c| !c.is_nan()).fold(0.0, f64::max)
    }
}
