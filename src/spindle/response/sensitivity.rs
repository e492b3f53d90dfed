//! Derivatives of F to the numbers of an effect, magnets closed.
//!
//! With H the closed receptance between all ports, a force law dκ at a port q gives  dH_oi = H_oq dκ H_qi; a law κ
//! whose place moves, q' its slope port,  dH_oi = κ (H_oq' H_qi + H_oq H_q'i); a sensor that moves reads H_q'i instead
//! of H_oi; what stands between ports a and b before the magnets are closed gives  Σ (1 + Hκ)_oa dh (1 + κH)_bi.

use super::adjoint::Adjoint;
use super::assembled::{Assembled, PlanarLine};
use super::channels::{MAGNETS, ON_HOUSING, ZERO};
use super::term::{Sum, Term};
use crate::linalg::c64;
use crate::rotor::modes::RIGID;
use std::f64::consts::TAU;
use std::ops::Deref;

/// The plane at a signed frequency; `first` is the port of the first probe.
#[derive(Clone, Copy)]
pub(super) struct WhirlLine<'a> {
    pub(super) at: &'a PlanarLine,
    pub(super) omega_rad_s: f64,
    pub(super) first: usize,
}

/// Ports whose receptance is asked for, row-major.
#[derive(Clone, Copy)]
pub(super) struct Between<'a> {
    pub(super) outs: &'a [usize],
    pub(super) ins: &'a [usize],
}

impl Assembled {
    /// Adds a derivative of the receptance between ports to `all`; `behind` and `strains` stand for the same ports.
    pub(super) fn add_sensitivity(
        &self,
        line: &WhirlLine,
        Between { outs, ins }: Between,
        sum: &Sum,
        behind: &impl Deref<Target = Adjoint>,
        strains: &impl Deref<Target = Vec<c64>>,
        all: &mut [c64],
    ) {
        for (factor, term) in sum {
            let whole = self.of_coordinates(*term, line.omega_rad_s, behind, strains);
            for (n, entry) in all.iter_mut().enumerate() {
                let own = match &whole {
                    Some(whole) => whole.get(n).copied().unwrap_or(ZERO),
                    None => {
                        let (out, input) = (outs[n / ins.len()], ins[n % ins.len()]);
                        self.at_ports(line, *term, out, input)
                    }
                };
                *entry += own * *factor;
            }
        }
    }

    /// Derivatives to what the coordinates of the shaft have.
    fn of_coordinates(
        &self,
        term: Term,
        w: f64,
        behind: &impl Deref<Target = Adjoint>,
        strains: &impl Deref<Target = Vec<c64>>,
    ) -> Option<Vec<c64>> {
        let modes = RIGID..self.dynamic;
        Some(match term {
            Term::Modulus(group) => {
                let size = behind.n * behind.n;
                let own = strains.get(group * size..(group + 1) * size);
                own.map_or(vec![], <[c64]>::to_vec)
            }
            Term::Damping(mode) => {
                let own = (RIGID + mode).min(self.dynamic)..(RIGID + mode + 1).min(self.dynamic);
                self.through(behind, own, |k| c64::new(0.0, w * self.damping.modal[k]))
            }
            Term::Loss => {
                let seen = w - self.speed_rad_s;
                self.through(behind, modes, |k| c64::new(0.0, seen * self.omega[k] * self.omega[k]))
            }
            Term::Gyroscopic => {
                let own = self.gyroscopic.as_ref();
                own.map_or(vec![], |g| g.slope(behind, w))
            }
            _ => return None,
        })
    }

    /// Derivative of the entry between ports o and i to what acts at ports.
    fn at_ports(&self, line: &WhirlLine, term: Term, o: usize, i: usize) -> c64 {
        let WhirlLine { at, omega_rad_s: w, first } = *line;
        let h = |a: usize, b: usize| at.entry(a, b);
        // A law at a place whose slope port moves it.
        let moved = |q: usize, slope: usize| h(o, slope) * h(q, i) + h(o, q) * h(slope, i);
        match term {
            Term::NegativeStiffness(b) => {
                let magnet = MAGNETS[b];
                h(o, magnet) * h(magnet, i) * self.negative_stiffness()[b]
            }
            Term::Bond(q, law) => h(o, first + q) * law.gain(w, self.turning_rad_s()) * h(first + q, i),
            Term::Shift(q, slope, law) => moved(first + q, first + slope) * law.gain(w, self.turning_rad_s()),
            Term::Signal(b, slope) if o == 3 + b => h(first + slope, i),
            Term::Signal(..) => ZERO,
            Term::Magnet(b, slope) => {
                let magnet = MAGNETS[b];
                let through = moved(magnet, first + slope) * self.negative_stiffness()[b];
                if i == magnet { through + h(o, first + slope) } else { through }
            }
            Term::Housing(index, number) => {
                let Some(housing) = self.effective.housings.get(index) else {
                    return ZERO;
                };
                let own = housing.omega_rad_s;
                let spring = c64::new(own * own - w * w, 2.0 * housing.damping_ratio * own * w);
                let compliance = (spring * housing.mass_kg).inv();
                let slope = match number {
                    0 => c64::new(housing.mass_kg.recip(), 0.0),
                    1 => c64::new(2.0 * own, 2.0 * housing.damping_ratio * w) * TAU / spring,
                    _ => c64::new(0.0, 2.0 * own * w) / spring,
                };
                // Bearings and sensors stand on the housing, the tool does not.
                let on = |port: usize| c64::new(f64::from(u8::from(ON_HOUSING.contains(&port))), 0.0);
                let ks = self.negative_stiffness();
                let (mut left, mut right) = (on(o), on(i));
                for (magnet, ks) in MAGNETS.into_iter().zip(ks) {
                    left += h(o, magnet) * ks;
                    right += h(magnet, i) * ks;
                }
                -(left * compliance * slope * right)
            }
            _ => ZERO,
        }
    }
}
