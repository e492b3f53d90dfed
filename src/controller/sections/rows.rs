//! Cascades as the rows that firmware computes. The gain of the axis is a factor of its output, so that coefficients
//! near ±1 and ±2 can be written as the whole number and the distance from it: single precision then holds slow poles
//! and zeros to full precision.

use super::arrangement::{SMALLEST_PRODUCT, arrange};
use super::roots::{AxisRoots, axis_system};
use super::section::SectionBiquad;
use crate::controller::ControllerError;
use crate::controller::modal::transfer_change;
use crate::controller::realise::{Form, ProductTerm, Realisation, Row};
use crate::lti::{Discrete, StateSpace};

/// Accepted change of the transfer matrix, relative to its peak: below single precision (6e-8). Zeros of multiple
/// order cost half the digits of double precision.
const LARGEST_CHANGE: f64 = 2e-8;
/// Farther from a whole number the split gains less than two bits and costs a product all the same.
const NEAR_WHOLE: f64 = 0.25;

/// Cascades of second-order sections of a decentralised controller (output i depends on input i alone).
///
/// # Errors
/// [`ControllerError::NotDecentralised`] for a controller that mixes axes, [`ControllerError::Inaccurate`] when the
/// cascade does not reproduce the controller, [`ControllerError::Numeric`] from the eigenvalue iterations.
pub fn second_order_sections(system: &StateSpace<Discrete>) -> Result<Realisation, ControllerError> {
    let axes = 0..system.inputs().min(system.outputs());
    let cascades: Result<Vec<Cascade>, ControllerError> =
        axes.map(|axis| Ok(Cascade::of(&AxisRoots::of(&axis_system(system, axis)?)?))).collect();
    let cascades = cascades?;
    let n: usize = cascades.iter().flat_map(|c| &c.sections).map(|s| s.order).sum();
    let mut rows = CascadeRows { states: n, inputs: system.inputs(), ..CascadeRows::default() };
    for (axis, cascade) in cascades.iter().enumerate() {
        rows.add(axis, cascade);
    }
    let realisation = Realisation {
        form: Form::SecondOrderSections,
        inputs: rows.inputs,
        signals: rows.signals,
        outputs: rows.outputs,
        states: rows.next_states,
        sample_time_s: system.time.period_s,
        blocks: rows.blocks,
        condition: 1.0,
        notes: Vec::new(),
    };
    let error = transfer_change(system, &realisation.to_state_space()?);
    if error.is_nan() || error > LARGEST_CHANGE {
        return Err(ControllerError::Inaccurate { step: "second-order sections", error, allowed: LARGEST_CHANGE });
    }
    Ok(realisation)
}

/// Sections of one axis, and the factor of its output.
struct Cascade {
    sections: Vec<SectionBiquad>,
    gain: f64,
}

impl Cascade {
    fn of(roots: &AxisRoots) -> Self {
        let mut gain = roots.gain;
        // Slow poles stand apart where that costs no state.
        let states = |sections: &[SectionBiquad]| sections.iter().map(|s| s.order).sum::<usize>();
        let [apart, coupled] = [SMALLEST_PRODUCT, 0.0].map(|product| arrange(roots, product));
        let mut sections = if states(&apart) <= states(&coupled) { apart } else { coupled };
        for section in &mut sections {
            let factor = section.levelling_factor();
            *section = section.with_numerator(section.b.map(|b| factor * b));
            gain /= factor;
        }
        Self { sections, gain }
    }
}

#[derive(Default)]
struct CascadeRows {
    states: usize,
    inputs: usize,
    signals: Vec<Row>,
    outputs: Vec<Row>,
    next_states: Vec<Row>,
    blocks: Vec<usize>,
}

impl CascadeRows {
    fn add(&mut self, axis: usize, cascade: &Cascade) {
        let mut source = self.states + axis;
        for section in &cascade.sections {
            let first = self.next_states.len();
            let out = self.states + self.inputs + self.signals.len();
            let mut row = vec![ProductTerm { source, coefficient: section.b[0] }];
            if section.order > 0 {
                row.push(ProductTerm { source: first, coefficient: 1.0 });
            }
            self.signals.push(row);
            // Numerators begin with a power of two; those of a double zero at one go on with −2 and 1 times it.
            let unit = section.b.into_iter().find(|b| *b != 0.0).unwrap_or(1.0);
            for (k, whole) in [(1, -2.0), (2, 1.0)].into_iter().take(section.order) {
                let mut row = split_term(source, section.b[k], [whole * unit, -unit]);
                row.extend(split_term(out, -section.a[k - 1], [-whole, 1.0]));
                if k < section.order {
                    row.push(ProductTerm { source: first + k, coefficient: 1.0 });
                }
                self.next_states.push(row);
            }
            self.blocks.push(section.order);
            source = out;
        }
        self.outputs.push(vec![ProductTerm { source, coefficient: cascade.gain }]);
    }
}

/// A product as it stands, or as the distance from the nearest of `wholes` and that.
fn split_term(source: usize, coefficient: f64, wholes: [f64; 2]) -> Row {
    let near = |whole: &&f64| (coefficient - **whole).abs() < NEAR_WHOLE * whole.abs();
    let parts = match wholes.iter().find(near) {
        Some(whole) => vec![coefficient - whole, *whole],
        None => vec![coefficient],
    };
    parts.into_iter().filter(|c| *c != 0.0).map(|coefficient| ProductTerm { source, coefficient }).collect()
}
