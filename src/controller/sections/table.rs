//! The cascade of an axis as the table of a filter library: in single precision where that follows the axis, else in
//! double precision, else none. Every table is compared with the axis as it is held, and says what it changes.

use super::arrangement::{SMALLEST_PRODUCT, arrange};
use super::band::Band;
use super::roots::{AxisRoots, axis_system};
use super::rounding::round_cascade;
use super::section::SectionBiquad;
use crate::controller::ControllerError;
use crate::controller::fidelity::{LARGEST_CHANGE, ON_CIRCLE, TransferChange, count_growing};
use crate::linalg::c64;
use crate::lti::{Discrete, StateSpace};
use std::f64::consts::TAU;

/// A pair this near to a double real root, in the square and relative to the distance from ±1, changes the response by
/// as little when it is taken for one.
const DOUBLE_REAL: f64 = 1e-4;

/// The numbers that a table holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Precision {
    /// float32.
    Single,
    /// float64.
    Double,
}

#[derive(Clone, Debug)]
pub(crate) struct AxisTable {
    /// Sections in order of computation, in metres and amperes, every coefficient as it is held.
    pub sections: Vec<SectionBiquad>,
    pub precision: Precision,
    pub change: TransferChange,
    /// Why it is not in single precision.
    pub remark: Option<String>,
}

/// The table of every axis, or why there is none.
pub(crate) fn axis_tables(system: &StateSpace<Discrete>) -> Result<Vec<Result<AxisTable, String>>, ControllerError> {
    (0..system.inputs().min(system.outputs()))
        .map(|axis| {
            let own = axis_system(system, axis)?;
            Ok(AxisRoots::of(&own).map_or_else(|e| Err(e.to_string()), |roots| table(&own, &roots)))
        })
        .collect()
}

fn table(axis: &StateSpace<Discrete>, roots: &AxisRoots) -> Result<AxisTable, String> {
    let all: Vec<c64> = roots.poles.iter().chain(&roots.zeros).copied().collect();
    let band = Band::of(axis, &all);
    let growing = count_growing(&roots.poles);
    let judge = |sections: Vec<SectionBiquad>, precision: Precision| {
        let poles: Vec<c64> = sections.iter().flat_map(SectionBiquad::poles).collect();
        let change = band.change(&sections);
        let kept = change.is_accepted() && count_growing(&poles) == growing;
        (kept, AxisTable { sections, precision, change, remark: None })
    };
    let plain = arrange(roots, SMALLEST_PRODUCT);
    let (kept, single) = judge(round_cascade(&plain, roots.gain, &band), Precision::Single);
    if kept {
        return Ok(single);
    }
    let settled = roots.with_double_reals(DOUBLE_REAL);
    if settled != *roots {
        let (kept, table) =
            judge(round_cascade(&arrange(&settled, SMALLEST_PRODUCT), settled.gain, &band), Precision::Single);
        if kept {
            return Ok(table);
        }
    }
    let period_s = axis.time.period_s;
    let (kept, double) = judge(level(&plain, roots.gain), Precision::Double);
    if kept {
        let shift = moved_pole(&plain, &single.sections, period_s);
        let words = change_words(&single.change, period_s);
        return Ok(AxisTable { remark: Some(format!("single precision {words}{shift}")), ..double });
    }
    Err(format!("its sections {} even in double precision", change_words(&double.change, period_s)))
}

/// The cascade in double precision, every section but the last with a gain near one in the middle of the band.
fn level(sections: &[SectionBiquad], gain: f64) -> Vec<SectionBiquad> {
    let mut rest = gain;
    let mut levelled: Vec<SectionBiquad> = sections
        .iter()
        .map(|section| {
            let factor = section.levelling_factor();
            rest /= factor;
            section.with_numerator(section.b.map(|b| factor * b))
        })
        .collect();
    match levelled.last_mut() {
        Some(last) => *last = last.with_numerator(last.b.map(|b| rest * b)),
        None => levelled.push(SectionBiquad::of_gain(rest)),
    }
    levelled
}

fn change_words(change: &TransferChange, period_s: f64) -> String {
    if change.is_accepted() {
        return "would turn a pole that decays into one that does not".to_owned();
    }
    format!(
        "would change the response by {:.2} % at {:.4} Hz (at most {} % is accepted)",
        100.0 * change.relative,
        change.frequency_hz(period_s),
        100.0 * LARGEST_CHANGE
    )
}

/// The pole that rounding moves most, relative to its distance from z = 1; nothing where it moves none by much.
fn moved_pole(exact: &[SectionBiquad], held: &[SectionBiquad], period_s: f64) -> String {
    let shifts = exact.iter().zip(held).flat_map(|(exact, held)| {
        let (exact, held) = (exact.poles(), held.poles());
        let moved: Vec<(c64, c64)> = exact.into_iter().zip(held).collect();
        moved.into_iter()
    });
    let relative = |exact: c64, held: c64| (held - exact).norm() / (exact - 1.0).norm().max(ON_CIRCLE);
    let worst = shifts.max_by(|x, y| relative(x.0, x.1).total_cmp(&relative(y.0, y.1)));
    match worst {
        Some((exact, held)) if relative(exact, held) >= LARGEST_CHANGE => format!(
            ": the pole at {:.4} Hz, z = {}, would move to z = {}",
            exact.ln().norm() / (TAU * period_s),
            pole_words(exact),
            pole_words(held)
        ),
        _ => String::new(),
    }
}

fn pole_words(pole: c64) -> String {
    if pole.im == 0.0 { format!("{:.9}", pole.re) } else { format!("{:.9} ± {:.9}j", pole.re, pole.im.abs()) }
}
