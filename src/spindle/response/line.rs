//! The response of a machine at one line, with its derivatives.

use super::assembled::{Assembled, PlanarLine, Receptance};
use super::channels::{IN, OUT, SIDE, Square, ZERO, planar};
use super::electronics::ElectronicsLine;
use super::line_in_planes::{Whirl, in_plane};
use super::parameters::MachineParameters;
use super::sensitivity::{Between, WhirlLine};
use super::term::Number;
use crate::linalg::c64;
use crate::spindle::Effective;
use rayon::prelude::*;
use std::cell::LazyCell;

/// F of a line and its derivatives to the logarithms of moduli, ks front, ks rear, ζ, and to the mesh, in that order.
#[derive(Clone, Debug)]
pub struct Line {
    /// What the shaft does to it.
    pub receptance: Receptance,
    /// F.
    pub response: Square,
    /// ∂F.
    pub derivatives: Vec<Square>,
}

/// F of a line, and its derivatives by what they do to the receptance: the electronics are the same for all of them.
pub(crate) struct LineSlopes {
    /// What the shaft does to it.
    pub receptance: Receptance,
    /// F.
    pub response: Square,
    /// What one unit in each entry of the receptance makes of F: of x to x, then, where x and y are coupled, of x to y.
    pub units: Vec<Square>,
    /// ∂ of these entries, as many as there are units for each derivative.
    pub entries: Vec<c64>,
    /// ∂F where it does not follow from the receptance, with the number of the derivative, increasing.
    pub others: Vec<(usize, Square)>,
}

impl LineSlopes {
    fn count(&self) -> usize {
        let entries = self.entries.len().checked_div(self.units.len());
        entries.unwrap_or(self.others.len())
    }

    /// ∂F of a derivative that does not follow from the receptance.
    pub(crate) fn other(&self, k: usize) -> Option<&Square> {
        let at = self.others.binary_search_by_key(&k, |other| other.0).ok()?;
        self.others.get(at).map(|other| &other.1)
    }

    /// ∂ of the entries of the receptance.
    pub(crate) fn entries(&self, k: usize) -> &[c64] {
        let width = self.units.len();
        self.entries.get(k * width..(k + 1) * width).unwrap_or_default()
    }

    /// ∂F.
    fn derivative(&self, k: usize) -> Square {
        if let Some(other) = self.other(k) {
            return *other;
        }
        let mut all = [ZERO; SIDE * SIDE];
        for (entry, unit) in self.entries(k).iter().zip(&self.units) {
            for (all, unit) in all.iter_mut().zip(unit) {
                *all += entry * unit;
            }
        }
        all
    }

    /// A line of electronics round a shaft that is known, with derivatives to `numbers` of the electronics; those to
    /// numbers of the shaft are zero.
    pub(crate) fn around_frequency(
        receptance: &Receptance,
        machine: &Effective,
        omega_rad_s: f64,
        numbers: &[Number],
    ) -> Self {
        let electronics = ElectronicsLine::new(machine, omega_rad_s);
        let response = receptance.behind(&electronics);
        let own = |number: &Number| match number {
            Number::Electronics(change) => change.slope(machine, &response, omega_rad_s),
            Number::Shaft(_) | Number::InPlane(..) => [ZERO; SIDE * SIDE],
        };
        Self {
            receptance: receptance.clone(),
            units: vec![],
            entries: vec![],
            others: numbers.iter().map(own).enumerate().collect(),
            response,
        }
    }
}

impl Assembled {
    /// F at `omega_rad_s`; with derivatives to moduli, ks, ln ζ and mesh when there are parameters.
    pub fn line(&self, omega_rad_s: f64, parameters: Option<&MachineParameters>) -> Line {
        self.line_with(omega_rad_s, parameters, 0, &[])
    }

    /// F at many frequencies.
    pub(crate) fn responses(&self, omega_rad_s: &[f64]) -> Vec<Square> {
        let lines = omega_rad_s.par_iter();
        lines.map(|w| self.line(*w, None).response).collect()
    }

    /// The same as [`Self::line`] with further derivatives, to numbers of effects, whose probes begin at port `first`.
    pub fn line_with(
        &self,
        omega_rad_s: f64,
        parameters: Option<&MachineParameters>,
        first: usize,
        numbers: &[Number],
    ) -> Line {
        let line = self.line_slopes(omega_rad_s, parameters, first, numbers);
        Line {
            derivatives: (0..line.count()).map(|k| line.derivative(k)).collect(),
            receptance: line.receptance,
            response: line.response,
        }
    }

    /// The same with derivatives of the receptance.
    pub(crate) fn line_slopes(
        &self,
        omega_rad_s: f64,
        parameters: Option<&MachineParameters>,
        first: usize,
        numbers: &[Number],
    ) -> LineSlopes {
        let coupled = self.coupled || numbers.iter().any(Number::couples);
        let whirl = Whirl {
            forward: self.planar(omega_rad_s),
            backward: coupled.then(|| self.planar(-omega_rad_s)),
            omega_rad_s,
            first,
        };
        if !self.plane_laws.is_empty() {
            let (receptance, response, derivatives) = self.line_in_planes(&whirl, parameters, numbers);
            return LineSlopes {
                receptance,
                response,
                units: vec![],
                entries: vec![],
                others: derivatives.into_iter().enumerate().collect(),
            };
        }
        let (forward, backward) = (&whirl.forward, whirl.backward.as_ref());
        let receptance = Receptance { plus: self.pick(forward), minus: backward.map(|b| self.pick(b)), planes: None };
        let electronics = ElectronicsLine::new(&self.effective, omega_rad_s);
        let response = electronics.apply(&receptance.plus, receptance.minus.as_ref());
        let mut line = LineSlopes { receptance, response, units: vec![], entries: vec![], others: vec![] };
        if parameters.is_none() && numbers.is_empty() {
            return line;
        }
        let between = Between { outs: &OUT, ins: &IN };
        let slopes = |at: &PlanarLine, omega_rad_s: f64| {
            self.slopes(&WhirlLine { at, omega_rad_s, first }, between, parameters, numbers)
        };
        line.units.extend((0..9).map(|n| electronics.unit(n, false)));
        let plus = slopes(forward, omega_rad_s);
        line.entries = match backward.map(|b| slopes(b, -omega_rad_s)) {
            None => plus,
            Some(minus) => {
                line.units.extend((0..9).map(|n| electronics.unit(n, true)));
                let both = plus.chunks_exact(9).zip(minus.chunks_exact(9));
                let each = both.flat_map(|(plus, minus)| {
                    let parts = |n: usize| planar(plus[n], Some(minus[n]));
                    let alike = (0..9).map(move |n| parts(n).0);
                    alike.chain((0..9).map(move |n| parts(n).1))
                });
                each.collect()
            }
        };
        let small = line.count() - numbers.len();
        for (k, number) in numbers.iter().enumerate() {
            let own = match number {
                Number::Shaft(_) => continue,
                Number::Electronics(change) => change.slope(&self.effective, &response, omega_rad_s),
                Number::InPlane(sum, plane) => {
                    let x = |out, input| whirl.apart(out, input);
                    let mut own = in_plane(sum, *plane, first, omega_rad_s, x);
                    electronics.apply_to(&mut own, SIDE);
                    own
                }
            };
            line.others.push((small + k, own));
        }
        line
    }

    /// Derivatives of the receptance between ports, springs in one plane open, outputs × inputs, one behind the other:
    /// to moduli, ks, ln ζ and mesh when there are parameters, then to numbers; zero for those that are not on the
    /// shaft.
    pub(super) fn slopes(
        &self,
        line: &WhirlLine,
        between: Between,
        parameters: Option<&MachineParameters>,
        numbers: &[Number],
    ) -> Vec<c64> {
        let (WhirlLine { at, omega_rad_s: w, .. }, Between { outs, ins }) = (*line, between);
        // What acts at ports needs neither.
        let behind = LazyCell::new(|| self.behind(at, w, outs, ins));
        let strains = LazyCell::new(|| self.strains(&behind, w));
        let mut all = parameters.map_or(vec![], |parameters| {
            let through = self.through_magnets(at, outs, ins);
            self.small(w, &behind, &strains, &through, parameters)
        });
        let size = outs.len() * ins.len();
        for number in numbers {
            let from = all.len();
            all.resize(from + size, ZERO);
            if let Number::Shaft(sum) = number {
                self.add_sensitivity(line, between, sum, &behind, &strains, &mut all[from..]);
            }
        }
        all
    }
}
