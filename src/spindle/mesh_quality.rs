//! Whether the elements are short enough for the modes that matter: those that the model keeps, or those measured.
//!
//! Every element is halved and the natural frequencies of the free-free shaft are compared; where they move, every
//! element is halved again and the difference to that mesh is the error. With consistent mass the error of a frequency
//! falls with the fourth power of the element length (Strang and Fix, section 6.3), so that the finest mesh has next to
//! none. The element to split is the one whose halving alone moves the frequency most.

use super::SpindleError;
use super::halved::{Meshed, halve_elements, refine_mesh};
use crate::rotor::Rotor;
use crate::rotor::modes::PlanarModes;

/// Change on halving over the error that is said from which on the mesh is halved again: the change understates the
/// error of very long elements.
const SUSPECT: f64 = 0.25;
/// Elements that are tried by halving alone, longest against the wavelength first.
const TRIED: usize = 40;
/// Shafts with more elements than this are not checked: their elements are short, and with every element halved
/// twice the eigenvalue problem would take longer than what follows.
const CHECKED: usize = crate::rotor::MOST_LISTED / 4;

/// A frequency that the mesh does not resolve.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarseMesh {
    /// Flexible mode, from 1.
    pub mode: usize,
    /// Relative error of its frequency.
    pub relative_error: f64,
    /// True when the element belongs to the tool.
    pub in_tool: bool,
    /// The element to split, its place in its list from 0.
    pub element: usize,
    /// Its length, m.
    pub length_m: f64,
}

/// The flexible mode among the first `modes` with the largest error, if its relative error is above `allowed`.
///
/// # Errors
/// [`SpindleError`] when the shaft or its modes cannot be computed.
pub fn coarse_mesh<M: Meshed>(machine: &M, modes: usize, allowed: f64) -> Result<Option<CoarseMesh>, SpindleError> {
    let [of_tool, of_shaft] = machine.elements();
    let tool = of_tool.len();
    let count = tool + of_shaft.len();
    if count > CHECKED {
        return Ok(None);
    }
    let own = frequencies(&machine.assembled()?)?;
    let kept = modes.min(own.len());
    let half = refine_mesh(machine);
    let moved = frequencies(&half.assembled()?)?;
    if (0..kept).all(|k| (own[k] / moved[k] - 1.0).abs() < SUSPECT * allowed) {
        return Ok(None);
    }
    let finer = frequencies(&refine_mesh(&half).assembled()?)?;
    let error = |k: usize| (own[k] / finer[k] - 1.0).abs();
    let worst = (0..kept).max_by(|a, b| error(*a).total_cmp(&error(*b)));
    let Some(mode) = worst.filter(|k| error(*k) > allowed) else {
        return Ok(None);
    };
    let section = |i: usize| match i.checked_sub(tool) {
        Some(k) => &of_shaft[k],
        None => &of_tool[i],
    };
    let mut order: Vec<usize> = (0..count).collect();
    // The wavelength of bending goes with the square root of the diameter.
    let against_wavelength = |i: &usize| {
        let s = section(*i);
        s.length_m / s.outer_diameter_m[0].sqrt()
    };
    order.sort_by(|a, b| against_wavelength(b).total_cmp(&against_wavelength(a)));
    let mut best = (0.0, order[0]);
    for i in order.into_iter().take(TRIED) {
        let split = frequencies(&halve_elements(machine, |k| k == i).assembled()?)?;
        let moved = (own[mode] - split[mode]).abs();
        if moved > best.0 {
            best = (moved, i);
        }
    }
    let element = best.1;
    Ok(Some(CoarseMesh {
        mode: mode + 1,
        relative_error: error(mode),
        in_tool: element < tool,
        element: element.checked_sub(tool).unwrap_or(element),
        length_m: section(element).length_m,
    }))
}

fn frequencies(rotor: &Rotor) -> Result<Vec<f64>, SpindleError> {
    Ok(PlanarModes::new(rotor)?.flexible_hz())
}
