//! Bounds of the structured singular value of a constant matrix, 1/μ = min { σ_max(Δ) : det(I − ΔM) = 0 }.
//!
//! Upper: reduce to irreducible parts, then the optimal D of each (`dscale`), or D and G where a scalar is repeated or
//! real (`mixed`). Lower: a perturbation (`lower`). Both are evaluated from what they return: the upper bound is
//! the value of the inequality for the scaling in the answer, the lower bound belongs to a Δ with a checked singular I
//! − ΔM.

pub(crate) mod certificate;
pub mod dscale;
pub(crate) mod dscale_centre;
mod level_form;
pub mod lower;
pub mod mixed;
pub mod peak;
mod real_crossing;
pub(crate) mod reduction;
mod search;
pub mod system;
mod vertex_crossing;

use crate::augment::Block;
use crate::linalg::{Mat, c64, max_singular_value_complex};
use crate::robust::structure::{MuError, Scaling, Span, Structure};
use lower::SingularDelta;
use reduction::Component;

/// Both bounds with what proves them.
#[derive(Clone, Debug)]
pub struct MuBounds {
    /// Upper bound, evaluated with `scaling`.
    pub upper: f64,
    /// Lower bound 1/σ_max(delta); 0 when no perturbation was found.
    pub lower: f64,
    /// The perturbation that attains the lower bound, w×z.
    pub delta: Mat<c64>,
    /// The scaling that proves the upper bound.
    pub scaling: Scaling,
}

/// What is left of the coupling between irreducible parts, relative to the bound.
const COUPLING: f64 = 1e-10;
/// The same for scalings that are used over an interval of frequency, where moderate scales matter more.
const SYSTEM_COUPLING: f64 = 1e-6;

/// Upper bound with a scaling of moderate spread, for one frequency of a system; `m` must fit and be finite.
pub(super) fn upper_bound_for_system(m: &Mat<c64>, structure: &Structure) -> Result<(f64, Scaling), MuError> {
    let (upper, scaling, _) = upper_by_parts(m, structure, SYSTEM_COUPLING)?;
    Ok((upper, scaling))
}

/// Upper bound of μ(M) with its scaling.
///
/// # Errors
/// [`MuError`] when the blocks do not fit, the data are not finite, or a decomposition fails.
pub fn upper_bound(m: &Mat<c64>, blocks: &[Block]) -> Result<(f64, Scaling), MuError> {
    let structure = Structure::new(blocks)?;
    let (upper, scaling, _) = upper_by_parts(m, &structure, COUPLING)?;
    Ok((upper, scaling))
}

/// Lower bound of μ(M) with the perturbation that attains it.
///
/// # Errors
/// As [`upper_bound`].
pub fn lower_bound(m: &Mat<c64>, blocks: &[Block]) -> Result<SingularDelta, MuError> {
    let found = bounds(m, blocks)?;
    Ok(SingularDelta { value: found.lower, delta: found.delta, singularity: f64::NAN })
}

/// Both bounds of μ(M).
///
/// # Errors
/// As [`upper_bound`].
pub fn bounds(m: &Mat<c64>, blocks: &[Block]) -> Result<MuBounds, MuError> {
    let structure = Structure::new(blocks)?;
    let (upper, scaling, parts) = upper_by_parts(m, &structure, COUPLING)?;
    let mut best = SingularDelta::none(&structure);
    for part in &parts {
        if part.upper <= best.value {
            continue;
        }
        let found = lower::search(&part.component.part_of(m), &part.component.structure, &part.scaling, part.upper);
        if found.value > best.value {
            best.value = found.value;
            best.delta = embed_block(&found.delta, &part.component, &structure);
        }
    }
    Ok(MuBounds { upper, lower: best.value, delta: best.delta, scaling })
}

struct Part {
    component: Component,
    scaling: Scaling,
    upper: f64,
}

fn upper_by_parts(m: &Mat<c64>, structure: &Structure, coupling: f64) -> Result<(f64, Scaling, Vec<Part>), MuError> {
    structure.check(m)?;
    let mut parts = vec![];
    for component in reduction::components(m, structure) {
        let own = component.part_of(m);
        let (scaling, upper) = irreducible(&own, &component.structure)?;
        parts.push(Part { component, scaling, upper });
    }
    if let [only] = parts.as_slice() {
        let same_order = only.component.w.is_sorted();
        if same_order && only.upper.is_finite() {
            return Ok((only.upper, only.scaling.clone(), parts));
        }
    }
    let largest = parts.iter().map(|p| p.upper).fold(0.0, f64::max);
    let pairs: Vec<(Component, Scaling)> = parts.iter().map(|p| (p.component.clone(), p.scaling.clone())).collect();
    let whole = reduction::assemble(m, structure, &pairs, largest, coupling);
    let upper = whole.bound_at(m);
    let plain = max_singular_value_complex(m);
    // An overflow of the assembled scales leaves the plain bound, which always holds.
    if upper.is_nan() || upper > plain {
        return Ok((plain, Scaling::identity(structure), parts));
    }
    Ok((upper, whole, parts))
}

/// Scaling of a part that cannot be reduced further, and the bound that it proves.
fn irreducible(m: &Mat<c64>, structure: &Structure) -> Result<(Scaling, f64), MuError> {
    if m.norm_max() == 0.0 {
        return Ok((Scaling::identity(structure), 0.0));
    }
    if structure.spans.iter().all(Span::has_scalar_scaling) {
        let end = dscale::settle_scaling(m, structure);
        return Ok((Scaling::diagonal(structure, &end.d), end.bound));
    }
    // A diagonal D that ignores repetition and realness is the start.
    let split = reduction::split_scalars(structure);
    let end = dscale::settle_scaling(m, &split);
    let start = Scaling::diagonal(&split, &end.d);
    let best = mixed::optimal(m, structure, start)?;
    let bound = best.bound_at(m);
    Ok((best, bound))
}

/// Δ of a part as Δ of the whole: a scalar that the part holds in part is repeated over its whole block.
fn embed_block(delta: &Mat<c64>, component: &Component, structure: &Structure) -> Mat<c64> {
    let mut whole = Mat::zeros(structure.inputs(), structure.outputs());
    for (own, origin) in component.structure.spans.iter().zip(&component.origin) {
        let span = &structure.spans[*origin];
        if span.is_scalar() {
            for (i, j) in span.w.clone().zip(span.z.clone()) {
                whole[(i, j)] = delta[(own.w.start, own.z.start)];
            }
        } else {
            for (i, a) in own.w.clone().enumerate() {
                for (j, b) in own.z.clone().enumerate() {
                    whole[(span.w.start + i, span.z.start + j)] = delta[(a, b)];
                }
            }
        }
    }
    whole
}
