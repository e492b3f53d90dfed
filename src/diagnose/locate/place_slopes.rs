//! Derivatives of a response with a law at a place to the nuisance parameters, the law held.
//!
//! With the law Δ held, H_new = H + B X C moves by  dH + dB X C + B X dC + B X dG X C = L dV R,  V the receptance
//! between all ports, L = [1, B X], R = [1; X C]: derivatives of V are needed behind L and R only. A stator that hangs
//! in a law reads and acts with the magnets' negative stiffness; a plane elsewhere reads, or acts on, the slope too.
//! What electronics and mixtures make of the receptance is linear: a response is a sum over its entries, the same for
//! every parameter.

use super::place::Place;
use super::place_response::{ONE, PlaceResponse, axis_of, matrix};
use crate::linalg::c64;
use crate::spindle::response::channels::planar;
use crate::spindle::response::parameters::MachineParameters;
use crate::spindle::response::ported::{Ported, factor, product};
use crate::spindle::response::{Square, ZERO};

/// The response of a line with a law, and what its derivatives are made of.
pub(super) struct PlaceSlopes {
    /// F with X.
    pub response: Square,
    /// What one unit in each entry of the receptance makes of F.
    pub units: Vec<Square>,
    /// Entries of the receptance's derivative to every modulus, ks, ln ζ and mesh, `units` of them for each.
    pub entries: Vec<c64>,
    /// ∂F to ln ki, front and rear, and to the logarithms of the sensor gains.
    pub gains: [Square; 4],
}

/// L, 2 × side, and R, side × 2.
type Sides = (Vec<c64>, Vec<c64>);

impl PlaceResponse<'_> {
    /// F with X, and its derivatives to the nuisance parameters (without axis gains), the law held.
    pub(super) fn slopes(&self, x: &[c64], parameters: &MachineParameters) -> PlaceSlopes {
        let mut response = self.response;
        for (d, x) in self.directions.iter().zip(x) {
            for (f, d) in response.iter_mut().zip(d) {
                *f += d * x;
            }
        }
        let first = x.first().copied().unwrap_or(ZERO);
        let with_mixture = |d: Square| match self.mix_axes(&d) {
            Some(m) => std::array::from_fn(|n| d[n] + first * m[n]),
            None => d,
        };
        let mixes = self.mix_axes(&self.response).is_some();
        let gain = |rows: bool, b: usize| {
            if mixes { with_mixture(factor(&self.response, rows, b)) } else { factor(&response, rows, b) }
        };
        let gains = [gain(false, 0), gain(false, 1), gain(true, 0), gain(true, 1)];
        let mut units: Vec<Square> = self.units().into_iter().map(with_mixture).collect();
        let scene = self.scene;
        let half = x.len() / 2;
        let at = |ported: &Ported, x: &[c64]| self.slope_of_move(ported, x, parameters);
        let entries = match (&self.minus, scene.place) {
            (Some(minus), _) => {
                let own = if scene.split { &x[..half] } else { x };
                let back = if scene.split { &x[half..] } else { x };
                let back: Vec<c64> = back.iter().map(|z| z.conj()).collect();
                let (plus, minus) = (at(&self.plus, own), at(minus, &back));
                let both = plus.iter().zip(&minus);
                both.flat_map(|(plus, minus)| {
                    let parts = [0, 1, 2, 3].map(|n| planar(plus[n], Some(minus[n])));
                    parts.map(|p| p.0).into_iter().chain(parts.map(|p| p.1))
                })
                .collect()
            }
            (None, Place::Apart(_)) => {
                let of = |axis: usize| units.iter().map(move |u| axis_of(u, axis));
                units = of(0).chain(of(1)).collect();
                let (a, b) = (at(&self.plus, &x[..1]), at(&self.plus, &x[1..]));
                let both = a.into_iter().zip(b);
                both.flat_map(|(a, b)| a.into_iter().chain(b)).collect()
            }
            _ => at(&self.plus, x).into_iter().flatten().collect(),
        };
        PlaceSlopes { response, units, entries, gains }
    }

    /// What one unit in each entry between sensors and magnets makes of F: of x to x, then, where x and y are coupled,
    /// of x to y.
    fn units(&self) -> Vec<Square> {
        let unit = |n: usize, value: c64| {
            let mut h = [ZERO; 9];
            h[3 * (n / 2) + n % 2] = value;
            h
        };
        let alike = (0..4).map(|n| self.electronics.apply(&unit(n, ONE), None));
        let across = (0..4).map(|n| {
            let turned = unit(n, c64::new(0.0, 1.0));
            self.electronics.apply(&turned, Some(&turned))
        });
        match self.minus {
            Some(_) => alike.chain(across).collect(),
            None => alike.collect(),
        }
    }

    /// Derivatives between sensors and magnets at one sign of frequency, with the law X of that sign.
    fn slope_of_move(&self, at: &Ported, x: &[c64], parameters: &MachineParameters) -> Vec<[c64; 4]> {
        let (left, right) = self.sides(at, x);
        let assembled = &self.scene.assembled;
        let mut all = assembled.ported_slopes(at, &left, &right, parameters);
        if *self.scene.place == Place::Housing {
            for f in 0..2 {
                let more = self.carry_through(at, x, f);
                let own = &mut all[parameters.groups + f];
                own.iter_mut().zip(more).for_each(|(own, more)| *own += more);
            }
        }
        all
    }

    fn sides(&self, at: &Ported, x: &[c64]) -> Sides {
        let side = at.side;
        let (mut left, mut right) = (vec![ZERO; 2 * side], vec![ZERO; 2 * side]);
        for b in 0..2 {
            left[b * side + b] = ONE;
            right[2 * b + b] = ONE;
        }
        let first = x.first().copied().unwrap_or(ZERO);
        match self.scene.place {
            Place::SensorPlane(b) => left[b * side + 3] = first,
            Place::ActuatorPlane(b) => right[2 * 3 + b] = first,
            Place::Housing => {
                let bond = self.scene.bond(at);
                let ks = self.scene.assembled.negative_stiffness();
                for (e, ks) in ks.into_iter().enumerate() {
                    for b in 0..2 {
                        left[b * side + 3 + e] = bond.b[b] * first * ks;
                        right[2 * (3 + e) + b] = first * bond.c[b] * ks;
                    }
                }
            }
            place if place.mechanical() => {
                let bond = self.scene.bond(at);
                let m = bond.m;
                let x = matrix(m, x);
                let on_left = product(&bond.b, &x, 3, m, m);
                let on_right = product(&x, &bond.c, m, m, 3);
                for b in 0..2 {
                    for a in 0..m {
                        left[b * side + 3 + a] = on_left[b * m + a];
                        right[2 * (3 + a) + b] = on_right[a * 3 + b];
                    }
                }
            }
            _ => {}
        }
        (left, right)
    }

    /// What the negative stiffness of bearing `f` itself does to what a hanging stator carries.
    fn carry_through(&self, at: &Ported, x: &[c64], f: usize) -> [c64; 4] {
        let bond = self.scene.bond(at);
        let ks = self.scene.assembled.negative_stiffness();
        let x = x.first().copied().unwrap_or(ZERO);
        let row = (0..2).fold(ONE, |s, e| s + at.at(3 + f, 3 + e) * ks[e]);
        let column = (0..2).fold(ZERO, |s, e| s + at.at(3 + e, 3 + f) * ks[e]);
        let inner = (row + column) * ks[f];
        std::array::from_fn(|n| {
            let (o, i) = (n / 2, n % 2);
            let (left, right) = (bond.b[o] * x, x * bond.c[i]);
            at.at(o, 3 + f) * ks[f] * right + left * at.at(3 + f, i) * ks[f] + left * inner * right
        })
    }
}
