//! Whether the elements are short enough for the modes that the model keeps.
//!
//! Every element is halved and the natural frequencies of the free-free shaft are compared; where they move, every
//! element is halved again and the difference to that mesh is the error. With consistent mass the error of a frequency
//! falls with the fourth power of the element length (Strang and Fix, section 6.3), so that the finest mesh has next to
//! none. The element to split is the one whose halving alone moves the frequency most.

use super::{Machine, SpindleError};
use crate::rotor::modes::PlanarModes;
use crate::rotor::{Rotor, Section};

/// Relative error of a kept frequency that is said: half the smallest uncertainty that frequencies are usually
/// specified with.
const SAID: f64 = 0.005;
/// Change on halving from which on the mesh is halved again: the change understates the error of very long elements.
const SUSPECT: f64 = SAID / 4.0;
/// Elements that are tried by halving alone, longest against the wavelength first.
const TRIED: usize = 40;
/// Shafts with more elements than this are not checked: halving them twice would pass the limit of the dense eigenvalue
/// problem.
const CHECKED: usize = crate::rotor::MOST_ELEMENTS / 4;

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

/// The kept mode with the largest error, if it is worth a word.
///
/// # Errors
/// [`SpindleError`] when the shaft or its modes cannot be computed.
pub fn coarse_mesh(machine: &Machine) -> Result<Option<CoarseMesh>, SpindleError> {
    let tool = machine.tool.sections.len();
    let count = tool + machine.spindle.sections.len();
    if count > CHECKED {
        return Ok(None);
    }
    let own = frequencies(&machine.rotor()?)?;
    let kept = machine.spindle.flexible_modes.min(own.len());
    let half = halved(machine, |_| true);
    let moved = frequencies(&half.rotor()?)?;
    if (0..kept).all(|k| (own[k] / moved[k] - 1.0).abs() < SUSPECT) {
        return Ok(None);
    }
    let finer = frequencies(&halved(&half, |_| true).rotor()?)?;
    let error = |k: usize| (own[k] / finer[k] - 1.0).abs();
    let worst = (0..kept).max_by(|a, b| error(*a).total_cmp(&error(*b)));
    let Some(mode) = worst.filter(|k| error(*k) > SAID) else {
        return Ok(None);
    };
    let section = |i: usize| match i.checked_sub(tool) {
        Some(k) => &machine.spindle.sections[k],
        None => &machine.tool.sections[i],
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
        let split = frequencies(&halved(machine, |k| k == i).rotor()?)?;
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

/// The machine with the chosen elements in two halves; elements count from the tool's first to the spindle's last.
fn halved(machine: &Machine, chosen: impl Fn(usize) -> bool) -> Machine {
    let tool = machine.tool.sections.len();
    let split = |sections: &[Section], first: usize| -> Vec<Section> {
        let parts = sections
            .iter()
            .enumerate()
            .map(|(k, s)| match chosen(first + k) {
                true => halves(s).to_vec(),
                false => vec![s.clone()],
            });
        parts.flatten().collect()
    };
    let mut machine = machine.clone();
    machine.tool.sections = split(&machine.tool.sections, 0);
    machine.spindle.sections = split(&machine.spindle.sections, tool);
    machine
}

fn halves(section: &Section) -> [Section; 2] {
    [0, 1].map(|half| {
        let part = |d: [f64; 2]| {
            let middle = 0.5 * (d[0] + d[1]);
            if half == 0 {
                [d[0], middle]
            } else {
                [middle, d[1]]
            }
        };
        Section {
            length_m: 0.5 * section.length_m,
            outer_diameter_m: part(section.outer_diameter_m),
            inner_diameter_m: part(section.inner_diameter_m),
            mass_outer_diameter_m: part(section.mass_outer_diameter_m),
            mass_inner_diameter_m: part(section.mass_inner_diameter_m),
            ..section.clone()
        }
    })
}
