//! The slope of the shaft that a moment acts on, and the flexibility of the place against it.
//!
//! In a beam that shears, a point moment on the slope w′ of the deflection turns the place without limit as the mesh
//! gets finer: the shear angle under the two forces of the moment grows as their distance shrinks. A disc sits on a
//! length of shaft. The slope is therefore read with the cubic functions on a third of the element of the file in which
//! the place lies, as a mesh three times as fine reads it. The nodes between are left out by static condensation, which
//! gives the row on the ends of the element and the flexibility that the ends do not show.

use super::RotorError;
use super::assembly::Rotor;
use super::element::{self, Matrix};
use super::section::Section;
use crate::linalg::NumericError;
use nalgebra::{Matrix4, SMatrix, Vector4};

/// Parts of an element.
pub(crate) const PARTS: usize = 3;
/// Freedoms of its ends and of the two nodes between.
const FREEDOMS: usize = 2 * (PARTS + 1);

/// What a moment at a place acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tilt {
    pub element: usize,
    /// Slope over (w₁, ψ₁, w₂, ψ₂) of its ends.
    pub row: [f64; 4],
    /// Derivative of the row to the place, 1/m.
    pub along: [f64; 4],
    /// Slope under a unit moment with the ends held, rad/(N m).
    pub flexibility: f64,
    /// Its derivative to the place.
    pub flexibility_along: f64,
}

impl Tilt {
    /// With more flexibility, and its derivative to the place.
    #[must_use]
    pub(crate) fn softer(self, more: f64, along: f64) -> Self {
        Self { flexibility: self.flexibility + more, flexibility_along: self.flexibility_along + along, ..self }
    }

    /// Stiffness, N m/rad, that a stiffness at the place is for the slope of the row.
    pub(crate) fn seen_stiffness(&self, stiffness: f64) -> f64 {
        stiffness / (1.0 + stiffness * self.flexibility)
    }

    /// Derivatives of [`Self::seen_stiffness`] to the stiffness and to the place.
    pub(crate) fn seen_derivatives(&self, stiffness: f64) -> (f64, f64) {
        let share = (1.0 + stiffness * self.flexibility).recip();
        let square = share * share;
        (square, -stiffness * stiffness * square * self.flexibility_along)
    }
}

impl Rotor {
    /// What a moment at a position acts on.
    pub(crate) fn tilt_at(&self, what: &str, position_m: f64) -> Result<Tilt, RotorError> {
        let (element, s) = self.element_at(what, position_m)?;
        tilt_of_element(element, &self.sections()[element], s)
    }
}

fn tilt_of_element(element: usize, section: &Section, s: f64) -> Result<Tilt, RotorError> {
    let parts = PARTS as f64;
    let part = ((s * parts).floor() as usize).min(PARTS - 1);
    let length_m = section.length_m / parts;
    let mut stiffness = SMatrix::<f64, FREEDOMS, FREEDOMS>::zeros();
    for k in 0..PARTS {
        let own: Matrix = element::matrices(&slice(section, k)).stiffness;
        let mut view = stiffness.fixed_view_mut::<4, 4>(2 * k, 2 * k);
        view += own;
    }
    let at = s * parts - part as f64;
    let mut reading = SMatrix::<f64, FREEDOMS, 2>::zeros();
    let columns = [element::hermite_slope(at, length_m), element::hermite_curvature(at, length_m)];
    for (j, column) in columns.iter().enumerate() {
        for (i, value) in column.iter().enumerate() {
            reading[(2 * part + i, j)] = *value;
        }
    }
    // The nodes between are 2..6, the ends the first and the last two.
    let inner: Matrix4<f64> = stiffness.fixed_view::<4, 4>(2, 2).into_owned();
    let ends = [0, 1, FREEDOMS - 2, FREEDOMS - 1];
    let held = inner
        .cholesky()
        .ok_or(NumericError::Singular { what: "stiffness of an element with its ends held", rcond: 0.0 })?;
    let answer = held.solve(&reading.fixed_view::<4, 2>(2, 0).into_owned());
    let onto_ends = |j: usize| {
        ends.map(|e| {
            let coupling = Vector4::from_fn(|i, _| stiffness[(2 + i, e)]);
            reading[(e, j)] - coupling.dot(&answer.column(j))
        })
    };
    let between = |j: usize, k: usize| {
        let own = Vector4::from_fn(|i, _| reading[(2 + i, j)]);
        own.dot(&answer.column(k))
    };
    Ok(Tilt {
        element,
        row: onto_ends(0),
        along: onto_ends(1),
        flexibility: between(0, 0),
        flexibility_along: 2.0 * between(1, 0),
    })
}

/// Part `k` of a section.
fn slice(section: &Section, k: usize) -> Section {
    let share = |k: usize| k as f64 / PARTS as f64;
    let cut = |d: [f64; 2]| [k, k + 1].map(|k| d[0] + share(k) * (d[1] - d[0]));
    Section {
        length_m: section.length_m / PARTS as f64,
        outer_diameter_m: cut(section.outer_diameter_m),
        inner_diameter_m: cut(section.inner_diameter_m),
        mass_outer_diameter_m: cut(section.mass_outer_diameter_m),
        mass_inner_diameter_m: cut(section.mass_inner_diameter_m),
        ..section.clone()
    }
}
