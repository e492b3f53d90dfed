//! The columns of a Jacobian: what each parameter changes of the residuals of a line.
//!
//! Most parameters act on the shaft and change its receptance, of which a line has a few entries; what electronics,
//! whitening and a closed loop make of a unit in each entry is the same for all of them.

use super::nuisance::Layout;
use crate::linalg::{Mat, c64};
use crate::spindle::response::ported::factor;
use crate::spindle::response::{LineSlopes, Square};

/// A line of the model that records are compared with.
pub(super) struct PredictedLine<'a> {
    pub(super) line: &'a LineSlopes,
    pub(super) order: &'a [JacobianColumn],
    pub(super) p: &'a [f64],
    pub(super) model_error: f64,
}

/// Where the derivative to a parameter comes from.
pub(super) enum JacobianColumn {
    /// None: the parameter changes nothing.
    Nothing,
    Line(usize),
    /// Logarithm of the force constant of a bearing.
    Current(usize),
    /// Logarithm of the sensor gain of a bearing.
    Signal(usize),
    /// Gain of an axis in a sweep.
    Axis(usize, usize),
}

/// Columns in the order of the parameters: the small ones where there is a layout, then the `coordinates` of effects.
/// `readings` stand behind those in a line.
pub(super) fn order(layout: Option<&Layout>, coordinates: usize, readings: &[Option<usize>; 4]) -> Vec<JacobianColumn> {
    let mut all = vec![];
    if let Some(layout) = layout {
        all.extend((0..layout.machine.groups).map(JacobianColumn::Line));
        all.extend([0, 1].map(JacobianColumn::Current));
        all.extend([0, 1].map(|b| JacobianColumn::Line(layout.machine.groups + b)));
        all.extend([0, 1].map(JacobianColumn::Signal));
        all.extend((layout.machine.groups + 2..layout.machine.analytic()).map(JacobianColumn::Line));
        let reading = |r: &Option<usize>| match r {
            Some(k) => JacobianColumn::Line(layout.machine.analytic() + k),
            None => JacobianColumn::Nothing,
        };
        all.extend(readings.iter().map(reading));
        for s in 0..layout.sweeps {
            all.extend((0..4).map(|i| JacobianColumn::Axis(s, i)));
        }
    }
    let small = layout.map_or(0, |l| l.machine.analytic());
    all.extend((small..small + coordinates).map(JacobianColumn::Line));
    all
}

impl PredictedLine<'_> {
    /// Writes the derivatives of the residuals of a line into the rows of `block` from `first` on, of a sweep whose
    /// axes have gains, or of a hammer test. `seen` is what a change of F, with such gains, does to these residuals; it
    /// is linear, so that a few entries of the receptance say it for every parameter that acts on the shaft.
    pub(super) fn write<const N: usize>(
        &self,
        sweep: Option<usize>,
        gain: &[f64; 4],
        seen: impl Fn(&Square, &[f64; 4]) -> [c64; N],
        block: &mut Mat<f64>,
        first: usize,
    ) {
        let f = &self.line.response;
        // No sweep looks at the tool.
        let looked_at = |n: usize| sweep.is_none() || (n % 9 / 3 < 2 && n % 3 < 2);
        let units: Vec<(usize, ComplexParts<N>)> = (self.line.units.iter().enumerate())
            .filter(|(n, _)| !self.order.is_empty() && looked_at(*n))
            .map(|(n, unit)| (n, ComplexParts::of(&seen(unit, gain))))
            .collect();
        for (c, column) in self.order.iter().enumerate() {
            let parts = match *column {
                JacobianColumn::Line(k) => match self.line.other(k) {
                    Some(other) => ComplexParts::of(&seen(other, gain)),
                    None => ComplexParts::sum(self.line.entries(k), &units),
                },
                JacobianColumn::Current(b) => ComplexParts::of(&seen(&factor(f, false, b), gain)),
                JacobianColumn::Signal(b) => ComplexParts::of(&seen(&factor(f, true, b), gain)),
                JacobianColumn::Axis(s, axis) if sweep == Some(s) => {
                    let mut own = [0.0; 4];
                    own[axis] = 1.0;
                    ComplexParts::of(&seen(f, &own))
                }
                // The block is zero from the start.
                JacobianColumn::Axis(..) | JacobianColumn::Nothing => continue,
            };
            let rows = &mut block.col_as_slice_mut(c)[first..first + 2 * N];
            for (pair, (re, im)) in rows.chunks_exact_mut(2).zip(parts.re.iter().zip(&parts.im)) {
                pair[0] = std::f64::consts::SQRT_2 * re;
                pair[1] = std::f64::consts::SQRT_2 * im;
            }
        }
    }
}

/// Complex numbers, real and imaginary parts apart.
struct ComplexParts<const N: usize> {
    re: [f64; N],
    im: [f64; N],
}

impl<const N: usize> ComplexParts<N> {
    fn of(values: &[c64; N]) -> Self {
        Self { re: values.map(|v| v.re), im: values.map(|v| v.im) }
    }

    /// Σ entry × unit, the units given with the number of their entry.
    fn sum(entries: &[c64], units: &[(usize, Self)]) -> Self {
        let (mut re, mut im) = ([0.0; N], [0.0; N]);
        for (n, unit) in units {
            let Some(by) = entries.get(*n) else {
                continue;
            };
            for k in 0..N {
                re[k] += by.re * unit.re[k] - by.im * unit.im[k];
                im[k] += by.re * unit.im[k] + by.im * unit.re[k];
            }
        }
        Self { re, im }
    }
}
