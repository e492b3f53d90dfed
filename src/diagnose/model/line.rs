//! A hypothesis at one line: the receptance between all ports, its loop through magnets and added parts, F, and the derivatives.

use super::super::chain::eliminate;
use super::super::nuisance::Layout;
use super::sensitivity::Number;
use super::{Assembled, IN, Line, OUT, Receptance, ZERO};
use crate::linalg::c64;
use std::cell::LazyCell;

/// One signed frequency in the complex plane.
pub(super) struct Planar {
    /// X = Z⁻¹Φᵀ, dynamic coordinates × ports.
    pub x: Vec<c64>,
    /// Receptance with all loops closed, ports × ports.
    pub closed: Vec<c64>,
}

impl Assembled {
    /// F at `omega_rad_s`; with derivatives to moduli, ks, ln ζ and mesh when there is a layout.
    pub fn line(&self, omega_rad_s: f64, layout: Option<&Layout>) -> Line {
        self.line_with(omega_rad_s, layout, 0, &[])
    }

    /// The same with further derivatives, to numbers of effects, whose probes begin at port `first`.
    pub fn line_with(
        &self,
        omega_rad_s: f64,
        layout: Option<&Layout>,
        first: usize,
        numbers: &[Number],
    ) -> Line {
        let forward = self.planar(omega_rad_s);
        let coupled = self.coupled || numbers.iter().any(Number::couples);
        let backward = coupled.then(|| self.planar(-omega_rad_s));
        let receptance = Receptance {
            plus: self.pick(&forward),
            minus: backward.as_ref().map(|b| self.pick(b)),
        };
        let chain = self.electronics.chain(omega_rad_s);
        let response = chain.apply(&receptance.plus, receptance.minus.as_ref());
        let mut derivatives = vec![];
        if layout.is_some() || !numbers.is_empty() {
            let plus = self.slopes(&forward, omega_rad_s, layout, first, numbers);
            let minus = backward.map(|b| self.slopes(&b, -omega_rad_s, layout, first, numbers));
            let small = plus.len() - numbers.len();
            derivatives.extend((0..plus.len()).map(|i| {
                match i.checked_sub(small).map(|k| &numbers[k]) {
                    Some(Number::Electronics(change)) => {
                        self.electronics.slope(change, &response, omega_rad_s)
                    }
                    _ => chain.apply(&plus[i], minus.as_ref().map(|m| &m[i])),
                }
            }));
        }
        Line {
            response,
            receptance,
            derivatives,
        }
    }

    /// Force per displacement of every feedback, N/m.
    pub(super) fn gains(&self, w: f64) -> Vec<c64> {
        let each = self.feedback.iter();
        each.map(|(_, law, value)| law.gain(w) * *value).collect()
    }

    fn pick(&self, at: &Planar) -> [c64; 9] {
        let n = self.ports.len();
        std::array::from_fn(|k| at.closed[OUT[k / 3] * n + IN[k % 3]])
    }

    pub(super) fn planar(&self, w: f64) -> Planar {
        let (p, n) = (self.ports.len(), self.omega.len());
        let diagonal = |k: usize| {
            c64::new(
                self.omega[k] * self.omega[k] - w * w,
                w * self.damping[k] - self.turning[k],
            )
        };
        let d = self.dynamic;
        let mut x = vec![ZERO; d * p];
        match &self.gyroscopic {
            None => {
                for k in 0..d {
                    let inverse = diagonal(k).inv();
                    for j in 0..p {
                        x[k * p + j] = inverse * self.ports[j][k];
                    }
                }
            }
            Some(g) => x = g.solve(w, d, &self.ports, &diagonal),
        }
        let mut h = vec![ZERO; p * p];
        for (h, c) in h.iter_mut().zip(&self.constant) {
            *h += c;
        }
        for k in 0..d {
            for i in 0..p {
                let a = self.ports[i][k];
                for j in 0..=i {
                    h[i * p + j] += x[k * p + j] * a;
                }
            }
        }
        if let Some(g) = &self.gyroscopic {
            for k in 0..d {
                for i in 0..p {
                    let a = w * g.factor * g.ports[k * p + i];
                    for j in 0..=i {
                        h[i * p + j] -= x[k * p + j] * a;
                    }
                }
            }
        }
        for k in d..n {
            let inverse = diagonal(k).inv();
            for i in 0..p {
                let a = inverse * self.ports[i][k];
                for j in 0..=i {
                    h[i * p + j] += a * self.ports[j][k];
                }
            }
        }
        for housing in &self.housings {
            let own = housing.omega_rad_s;
            let z = c64::new(own * own - w * w, 2.0 * housing.damping_ratio * own * w)
                * housing.mass_kg;
            for i in 1..5 {
                for j in 1..=i {
                    h[i * p + j] += z.inv();
                }
            }
        }
        for i in 0..p {
            for j in i + 1..p {
                h[i * p + j] = h[j * p + i];
            }
        }
        // X_c = (I − H_ff κ)⁻¹ H_f·
        let f = &self.feedback;
        let gains = self.gains(w);
        let m = f.len();
        let mut unit = vec![ZERO; m * m];
        let mut rows = vec![ZERO; m * p];
        for a in 0..m {
            for b in 0..m {
                unit[a * m + b] =
                    c64::new(f64::from(u8::from(a == b)), 0.0) - h[f[a].0 * p + f[b].0] * gains[b];
            }
            rows[a * p..(a + 1) * p].copy_from_slice(&h[f[a].0 * p..(f[a].0 + 1) * p]);
        }
        eliminate(&mut unit, &mut rows, m, p);
        let mut closed = h.clone();
        for i in 0..p {
            for a in 0..m {
                let through = h[i * p + f[a].0] * gains[a];
                for j in 0..p {
                    closed[i * p + j] += through * rows[a * p + j];
                }
            }
        }
        Planar { x, closed }
    }

    /// Derivatives of the closed 3×3 receptance: to moduli, ks, ln ζ and mesh when there is a layout, then to numbers on the shaft.
    fn slopes(
        &self,
        at: &Planar,
        w: f64,
        layout: Option<&Layout>,
        first: usize,
        numbers: &[Number],
    ) -> Vec<[c64; 9]> {
        // What acts at ports needs neither.
        let behind = LazyCell::new(|| self.behind(at, w, &OUT, &IN));
        let strains = LazyCell::new(|| self.strains(&behind, w));
        let small = layout.map(|l| self.small(at, w, (&OUT, &IN), &behind, &strains, l));
        let block = |of: &Vec<c64>| std::array::from_fn(|n| of[n]);
        let mut all: Vec<[c64; 9]> = small.iter().flatten().map(block).collect();
        all.extend(numbers.iter().map(|number| match number {
            Number::Shaft(sum) => self.sensitive(at, w, first, sum, &behind, &strains),
            Number::Electronics(_) => [ZERO; 9],
        }));
        all
    }
}
