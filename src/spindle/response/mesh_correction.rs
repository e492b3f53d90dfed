//! What a mesh twice as fine would change.
//!
//! Elements are exact in statics; under inertia the nodes that a finer mesh has in the middle of its elements move by
//! K_ii⁻¹ω²f on top of the static shape, f = M_i· x. Condensed, Z = K − ω²M − ω⁴C with C = Σ fᵀK_ii⁻¹f over the
//! elements. The error of the mesh falls with the square of its length, so 4/3 C is that of a continuum, and any finer
//! mesh is some multiple between.

use crate::linalg::{Mat, solve};
use crate::rotor::Rotor;
use crate::spindle::SpindleError;

/// C in the coordinates `shapes` (dofs of `coarse` × coordinates); every element of `coarse` is two of `fine`.
pub(super) fn flexibility(coarse: &Rotor, fine: &Rotor, shapes: &Mat<f64>) -> Result<Mat<f64>, SpindleError> {
    let size = shapes.ncols();
    let mass = fine.plane_matrices().mass;
    let mut all = Mat::zeros(size, size);
    for element in 0..coarse.sections().len() {
        let (_, ends) = coarse.element_stiffness(element);
        let (left, dofs) = fine.element_stiffness(2 * element);
        let (right, further) = fine.element_stiffness(2 * element + 1);
        let middle = [dofs[2], dofs[3]];
        let outer = [dofs[0], dofs[1], further[2], further[3]];
        let own = Mat::from_fn(2, 2, |r, c| left[(r + 2, c + 2)] + right[(r, c)]);
        let bond = Mat::from_fn(2, 4, |r, c| if c < 2 { left[(r + 2, c)] } else { right[(r, c)] });
        let at_ends = Mat::from_fn(4, size, |r, c| shapes[(ends[r], c)]);
        let follows = solve(&own, &(&bond * &at_ends))?;
        let inertia = Mat::from_fn(2, size, |r, c| {
            let ends: f64 = (0..4).map(|k| mass[(middle[r], outer[k])] * at_ends[(k, c)]).sum();
            let still: f64 = (0..2).map(|k| mass[(middle[r], middle[k])] * follows[(k, c)]).sum();
            ends - still
        });
        all += inertia.transpose() * solve(&own, &inertia)?;
    }
    Ok(all)
}
