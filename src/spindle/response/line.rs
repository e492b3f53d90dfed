//! The response of a machine at one line, with its derivatives.

use super::assembled::{Assembled, Planar, Receptance};
use super::channels::{IN, OUT, SIDE, Square, ZERO};
use super::electronics::ElectronicsLine;
use super::line_in_planes::{Whirl, in_plane};
use super::parameters::MachineParameters;
use super::term::Number;
use crate::linalg::c64;
use crate::spindle::Effective;
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

impl Line {
    /// A line of electronics round a shaft that is known, with derivatives to `numbers` of the electronics; those to
    /// numbers of the shaft are zero.
    pub(crate) fn round(
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
            derivatives: numbers.iter().map(own).collect(),
            response,
        }
    }
}

impl Assembled {
    /// F at `omega_rad_s`; with derivatives to moduli, ks, ln ζ and mesh when there are parameters.
    pub fn line(&self, omega_rad_s: f64, parameters: Option<&MachineParameters>) -> Line {
        self.line_with(omega_rad_s, parameters, 0, &[])
    }

    /// The same with further derivatives, to numbers of effects, whose probes begin at port `first`.
    pub fn line_with(
        &self,
        omega_rad_s: f64,
        parameters: Option<&MachineParameters>,
        first: usize,
        numbers: &[Number],
    ) -> Line {
        let coupled = self.coupled || numbers.iter().any(Number::couples);
        let whirl = Whirl {
            forward: self.planar(omega_rad_s),
            backward: coupled.then(|| self.planar(-omega_rad_s)),
            omega_rad_s,
            first,
        };
        if !self.plane_springs.is_empty() {
            let (receptance, response, derivatives) =
                self.line_in_planes(&whirl, parameters, numbers);
            return Line {
                receptance,
                response,
                derivatives,
            };
        }
        let (forward, backward) = (&whirl.forward, whirl.backward.as_ref());
        let receptance = Receptance {
            plus: self.pick(forward),
            minus: backward.map(|b| self.pick(b)),
            planes: None,
        };
        let electronics = ElectronicsLine::new(&self.effective, omega_rad_s);
        let response = electronics.apply(&receptance.plus, receptance.minus.as_ref());
        let mut derivatives = vec![];
        if parameters.is_some() || !numbers.is_empty() {
            let plus = self.slopes(forward, omega_rad_s, parameters, first, numbers);
            let minus = backward.map(|b| self.slopes(b, -omega_rad_s, parameters, first, numbers));
            let small = plus.len() - numbers.len();
            derivatives.extend((0..plus.len()).map(|i| {
                match i.checked_sub(small).map(|k| &numbers[k]) {
                    Some(Number::Electronics(change)) => {
                        change.slope(&self.effective, &response, omega_rad_s)
                    }
                    Some(Number::InPlane(sum, plane)) => {
                        let x = |out, input| whirl.apart(out, input);
                        let mut own = in_plane(sum, *plane, first, omega_rad_s, x);
                        electronics.surround(&mut own, SIDE);
                        own
                    }
                    _ => electronics.apply(&plus[i], minus.as_ref().map(|m| &m[i])),
                }
            }));
        }
        Line {
            response,
            receptance,
            derivatives,
        }
    }

    /// Derivatives of the closed 3×3 receptance: to moduli, ks, ln ζ and mesh when there are parameters, then to
    /// numbers on the shaft.
    fn slopes(
        &self,
        at: &Planar,
        w: f64,
        parameters: Option<&MachineParameters>,
        first: usize,
        numbers: &[Number],
    ) -> Vec<[c64; 9]> {
        // What acts at ports needs neither.
        let behind = LazyCell::new(|| self.behind(at, w, &OUT, &IN));
        let strains = LazyCell::new(|| self.strains(&behind, w));
        let small = parameters.map(|l| self.small(at, w, (&OUT, &IN), &behind, &strains, l));
        let block = |of: &Vec<c64>| std::array::from_fn(|n| of[n]);
        let mut all: Vec<[c64; 9]> = small.iter().flatten().map(block).collect();
        all.extend(numbers.iter().map(|number| match number {
            Number::Shaft(sum) => {
                let mut own = [ZERO; 9];
                let whirl = (at, w, first);
                self.add_sensitivity(whirl, sum, (&OUT, &IN), &behind, &strains, &mut own);
                own
            }
            Number::Electronics(_) | Number::InPlane(..) => [ZERO; 9],
        }));
        all
    }
}
