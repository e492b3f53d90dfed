//! The shaft without magnets between its ports, made once for all frequencies.

use super::response::damping::ModalDamping;
use super::response::pairs::{over_coordinates, pairs, products};
use super::whirl_form::{WhirlForm, WhirlModes};
use crate::linalg::{Mat, c64, solve_complex};
use std::sync::OnceLock;

/// How the open receptance is computed; all of them give the pairs of [`pairs`].
#[derive(Clone, Debug)]
pub(crate) enum OpenReceptance {
    /// No coordinate acts on another one: amplitudes at both ports multiplied, of every coordinate.
    Modes(Vec<f64>),
    /// Whirl modes of the rotating shaft.
    Whirl(WhirlForm),
    /// Whirl modes are not to be trusted: the equations of the coordinates, which are solved at each frequency.
    Equations,
}

/// Coordinates of a shaft at a speed.
pub(crate) struct Coordinates<'a> {
    pub omega_rad_s: &'a [f64],
    pub damping: &'a ModalDamping,
    /// Ω × factor × G; `None` when zero.
    pub gyroscopic: Option<&'a Mat<f64>>,
    /// Amplitudes, ports × coordinates.
    pub ports: &'a Mat<f64>,
    /// Of the rotating shaft, made when first asked for; empty where they are not to be trusted.
    pub whirl: &'a OnceLock<Option<WhirlModes>>,
}

impl Coordinates<'_> {
    /// ω_k² − ω² + jω c_k − circ_k at a signed frequency.
    fn stiffness(&self, k: usize, w: f64) -> c64 {
        c64::new(
            self.omega_rad_s[k] * self.omega_rad_s[k] - w * w,
            w * self.damping.total[k] - self.damping.circulatory[k],
        )
    }

    /// What their receptance is computed from.
    pub(crate) fn open_receptance(&self) -> OpenReceptance {
        let (p, n) = (self.ports.nrows(), self.ports.ncols());
        let Some(gyroscopic) = self.gyroscopic else {
            let row = |i: usize| (0..n).map(|k| self.ports[(i, k)]).collect();
            let rows: Vec<Vec<f64>> = (0..p).map(row).collect();
            return OpenReceptance::Modes(products(&rows, p));
        };
        let ModalDamping { total, circulatory, .. } = self.damping;
        let modes = || WhirlModes::new(self.omega_rad_s, total, circulatory, gyroscopic);
        match self.whirl.get_or_init(modes) {
            Some(modes) => OpenReceptance::Whirl(modes.between_ports(self.ports)),
            None => OpenReceptance::Equations,
        }
    }

    /// The receptance of every pair at a signed frequency, without that of what the coordinates leave out, real and
    /// imaginary parts apart.
    pub(crate) fn receptance(&self, form: &OpenReceptance, w: f64) -> (Vec<f64>, Vec<f64>) {
        let (p, n) = (self.ports.nrows(), self.ports.ncols());
        match form {
            OpenReceptance::Modes(products) => {
                let inverses = (0..n).map(|k| {
                    let inverse = self.stiffness(k, w).inv();
                    (inverse.re, inverse.im)
                });
                over_coordinates(products, inverses, pairs(p, p).count())
            }
            OpenReceptance::Whirl(form) => form.receptance(w),
            OpenReceptance::Equations => {
                let z = Mat::from_fn(n, n, |i, j| {
                    let turn = self.gyroscopic.map_or(0.0, |g| w * g[(i, j)]);
                    if i == j { self.stiffness(i, w) + turn } else { c64::new(turn, 0.0) }
                });
                let force = Mat::from_fn(n, p, |k, j| c64::new(self.ports[(j, k)], 0.0));
                let moved = solve_complex(&z, &force);
                let sum = |(i, j): (usize, usize)| {
                    let parts = (0..n).map(|k| moved[(k, j)] * self.ports[(i, k)]);
                    let sum: c64 = parts.sum();
                    (sum.re, sum.im)
                };
                pairs(p, p).map(sum).unzip()
            }
        }
    }
}
