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
            let slopes =
                |at: &Planar, w: f64| self.slopes((at, w, first), parameters, numbers, (&OUT, &IN));
            let plus = slopes(forward, omega_rad_s);
            let minus = backward.map(|b| slopes(b, -omega_rad_s));
            let block = |all: &[c64], i: usize| std::array::from_fn(|n| all[9 * i + n]);
            let count = plus.len() / 9;
            let small = count - numbers.len();
            derivatives.extend((0..count).map(
                |i| match i.checked_sub(small).map(|k| &numbers[k]) {
                    Some(Number::Electronics(change)) => {
                        change.slope(&self.effective, &response, omega_rad_s)
                    }
                    Some(Number::InPlane(sum, plane)) => {
                        let x = |out, input| whirl.apart(out, input);
                        let mut own = in_plane(sum, *plane, first, omega_rad_s, x);
                        electronics.surround(&mut own, SIDE);
                        own
                    }
                    _ => {
                        let minus = minus.as_ref().map(|m| block(m, i));
                        electronics.apply(&block(&plus, i), minus.as_ref())
                    }
                },
            ));
        }
        Line {
            response,
            receptance,
            derivatives,
        }
    }

    /// Derivatives of the receptance between ports, springs in one plane open, outputs × inputs, one behind the other: to
    /// moduli, ks, ln ζ and mesh when there are parameters, then to numbers; zero for those that are not on the shaft.
    pub(super) fn slopes(
        &self,
        (at, w, first): (&Planar, f64, usize),
        parameters: Option<&MachineParameters>,
        numbers: &[Number],
        (outs, ins): (&[usize], &[usize]),
    ) -> Vec<c64> {
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
                let (whirl, ports) = ((at, w, first), (outs, ins));
                self.add_sensitivity(whirl, sum, ports, &behind, &strains, &mut all[from..]);
            }
        }
        all
    }
}
