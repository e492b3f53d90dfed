//! Laws at a place, and what they change of its directions.
//!
//! X = (Δ⁻¹ − G)⁻¹ of a law Δ: unlike X, Δ does not contain the shaft and is smooth over frequency.

use super::joint::collet;
use super::place::Place;
use super::place_response::{ONE, PlaceResponse, matrix, pairs};
use crate::linalg::c64;
use crate::linalg::small::eliminate;
use crate::spindle::response::ZERO;
use crate::spindle::response::ported::{Ported, product};

impl PlaceResponse<'_> {
    /// Δ of a sign from X, or X from Δ: X (1 + G X)⁻¹ and Δ (1 − G Δ)⁻¹.
    fn exchange_signals(&self, at: &Ported, from: &[c64], sign: f64) -> Vec<c64> {
        let bond = self.scene.bond(at);
        let m = bond.m;
        let mut to = matrix(m, from);
        let mut unit = product(&to, &bond.g, m, m, m);
        for (i, u) in unit.iter_mut().enumerate() {
            *u = *u * sign + if i % (m + 1) == 0 { ONE } else { ZERO };
        }
        eliminate(&mut unit, &mut to, m, m);
        pairs(m).map(|(a, b)| to[a * m + b]).collect()
    }

    fn signs(&self, from: &[c64], sign: f64) -> Vec<c64> {
        let place = self.scene.place;
        if !place.mechanical() {
            return from.to_vec();
        }
        let half = from.len() / 2;
        match (&self.minus, place) {
            (Some(minus), _) if self.scene.split => {
                let back: Vec<c64> = from[half..].iter().map(|z| z.conj()).collect();
                let mut all = self.exchange_signals(&self.plus, &from[..half], sign);
                let back = self.exchange_signals(minus, &back, sign);
                all.extend(back.iter().map(|z| z.conj()));
                all
            }
            (_, Place::Apart(_)) => from.iter().flat_map(|x| self.exchange_signals(&self.plus, &[*x], sign)).collect(),
            _ => self.exchange_signals(&self.plus, from, sign),
        }
    }

    /// Δ from X, entry by entry; unlike X it does not contain the shaft, and is smooth over frequency.
    pub(crate) fn free(&self, x: &[c64]) -> Vec<c64> {
        self.signs(x, 1.0)
    }

    /// X from Δ.
    pub(crate) fn bind_law(&self, free: &[c64]) -> Vec<c64> {
        self.signs(free, -1.0)
    }

    /// Flexibility of a collet, m/N and rad/(N m).
    pub(super) fn collet(&self) -> [f64; 2] {
        collet(self.scene.rigid)
    }

    /// X of a joint with flexibility across (m/N) and in turning (rad/(N m)) and none between the two.
    pub(crate) fn add_joint(&self, flexibility: [c64; 2]) -> Vec<c64> {
        let law = |i: usize| {
            let rigid = self.scene.rigid[i];
            c64::new(rigid, 0.0) - (flexibility[i] + 1.0 / rigid).inv()
        };
        self.bind_law(&[law(0), ZERO, law(1)])
    }

    /// The laws that X means, in the order of [`Place::laws`]; stiffness positive for a spring.
    pub(crate) fn laws(&self, x: &[c64]) -> Vec<c64> {
        let (place, rigid) = (self.scene.place, self.scene.rigid);
        let free = self.free(x);
        let half = free.len() / 2;
        match place {
            Place::Joint => {
                let one = if self.scene.split { &free[..half] } else { &free[..] };
                let mut total = matrix(2, one).iter().map(|d| -d).collect::<Vec<_>>();
                total[0] += rigid[0];
                total[3] += rigid[1];
                let mut flexible = vec![ONE, ZERO, ZERO, ONE];
                eliminate(&mut total, &mut flexible, 2, 2);
                vec![flexible[3] - 1.0 / rigid[1], flexible[0] - 1.0 / rigid[0]]
            }
            Place::Housing => free[..1].to_vec(),
            _ if self.scene.split => {
                let (a, b) = (-free[0], -free[half]);
                let (alike, across) = ((a + b) * 0.5, (a - b) * c64::new(0.0, 0.5));
                match place {
                    Place::Circulating(_) => vec![across, alike],
                    _ => vec![alike, across],
                }
            }
            _ if place.mechanical() => free.iter().map(|d| -d).collect(),
            _ => free,
        }
    }
}
