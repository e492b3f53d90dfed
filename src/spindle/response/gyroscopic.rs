//! Gyroscopic coupling of the modes of a shaft at one line.
//!
//! In r = x + jy the term is ωΩG. Modes far above the band follow as springs; those between couple with the lowest
//! only.

use super::adjoint::Adjoint;
use super::channels::ZERO;
use super::shaft_modes::Modes;
use crate::linalg::small::eliminate;
use crate::linalg::{Mat, c64};

/// ΩG between the dynamic coordinates d, and what it does through the higher ones h, which follow as springs Ω_h².
#[derive(Clone, Debug)]
pub(super) struct Gyroscopic {
    /// Factor on all of it; 1 is the coupling of the shaft.
    pub factor: f64,
    /// ΩG_dd, d×d.
    own: Vec<f64>,
    /// ΩG_dh Ω_h⁻² ΩG_hd, d×d.
    through: Vec<f64>,
    /// ΩG_dh Ω_h⁻² B_h, d×ports.
    pub ports: Vec<f64>,
    /// The first coordinates, which act on each other without limit; the others act on those and on themselves.
    near: usize,
}

impl Gyroscopic {
    /// Of the shaft's G, n×n, in its modes, of which the first `dynamic` are dynamic, and the first `near` act on each
    /// other without limit; `ports` are ports × modes, `speed` is Ω, rad/s.
    pub(super) fn new(
        speed: f64,
        matrix: &Mat<f64>,
        modes: &Modes,
        ports: &[Vec<f64>],
        dynamic: usize,
        near: usize,
    ) -> Self {
        let (turned, omega) = (&modes.shapes, &modes.omega);
        let n = omega.len();
        let low = turned.submatrix(0, 0, n, dynamic);
        let high = Mat::from_fn(n, n - dynamic, |i, k| turned[(i, dynamic + k)] / omega[dynamic + k]);
        let on_low = matrix * low;
        let across = on_low.transpose() * high;
        let still = Mat::from_fn(n - dynamic, ports.len(), |k, p| ports[p][dynamic + k] / omega[dynamic + k]);
        let flat = |m: Mat<f64>, scale: f64| -> Vec<f64> {
            (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| (i, j))).map(|(i, j)| scale * m[(i, j)]).collect()
        };
        Self {
            factor: 1.0,
            own: flat(low.transpose() * &on_low, speed),
            through: flat(&across * across.transpose(), speed * speed),
            ports: flat(&across * still, speed),
            near,
        }
    }

    /// Derivative to the factor of the receptance behind a loop, n × n.
    pub(super) fn slope(&self, behind: &Adjoint, w: f64) -> Vec<c64> {
        let n = behind.n;
        let d = behind.right.len() / n.max(1);
        let p = behind.right_ports.len() / n.max(1);
        let stride = self.ports.len() / d.max(1);
        let mut slope = vec![ZERO; n * n];
        let mut on_left = vec![ZERO; n];
        let mut on_right = vec![ZERO; n];
        for k in 0..d {
            on_left.fill(ZERO);
            on_right.fill(ZERO);
            for q in 0..p {
                let port = w * self.ports[k * stride + q];
                for o in 0..n {
                    on_left[o] -= behind.left_ports[o * p + q] * port;
                    on_right[o] -= behind.right_ports[q * n + o] * port;
                }
            }
            // Coordinates that are both far do not act on each other.
            for l in (0..d).filter(|l| k.min(*l) < self.near || k == *l) {
                let own = w * self.own[k * d + l];
                let term = own - 2.0 * w * w * self.factor * self.through[k * d + l];
                for i in 0..n {
                    on_right[i] -= behind.right[l * n + i] * term;
                }
            }
            for o in 0..n {
                for i in 0..n {
                    slope[o * n + i] += on_left[o] * behind.right[k * n + i] + behind.left[o * d + k] * on_right[i];
                }
            }
        }
        slope
    }

    /// Z⁻¹B of the first `ports`, coordinates × ports, at a signed frequency; `diagonal` is what Z is without
    /// gyroscopic terms.
    pub(super) fn solve(
        &self,
        w: f64,
        dynamic: usize,
        ports: &[Vec<f64>],
        diagonal: &impl Fn(usize) -> c64,
    ) -> Vec<c64> {
        let (l, d, p) = (self.near, dynamic, ports.len());
        let stride = self.ports.len() / d.max(1);
        let w = w * self.factor;
        let both = self.own.iter().zip(&self.through);
        let term: Vec<f64> = both.map(|(own, t)| w * own - w * w * t).collect();
        // Of every coordinate: its row of near terms, then its inputs.
        let width = l + p;
        let mut rows = vec![0.0; d * width];
        for (k, row) in rows.chunks_mut(width).enumerate() {
            row[..l].copy_from_slice(&term[k * d..k * d + l]);
            for j in 0..p {
                row[l + j] = ports[j][k] - w * self.ports[k * stride + j];
            }
        }
        let far: Vec<c64> = (l..d).map(|k| (diagonal(k) + term[k * d + k]).inv()).collect();
        let mut z = vec![ZERO; l * l];
        let mut x = vec![ZERO; d * p];
        let (mut re, mut im) = (vec![0.0; width], vec![0.0; width]);
        for i in 0..l {
            re.copy_from_slice(&rows[i * width..(i + 1) * width]);
            im.fill(0.0);
            for (row, inverse) in rows[l * width..].chunks(width).zip(&far) {
                let (a, b) = (row[i] * inverse.re, row[i] * inverse.im);
                for ((re, im), t) in re.iter_mut().zip(&mut im).zip(row) {
                    *re -= a * t;
                    *im -= b * t;
                }
            }
            for j in 0..l {
                z[i * l + j] = c64::new(re[j], im[j]);
            }
            z[i * l + i] += diagonal(i);
            for j in 0..p {
                x[i * p + j] = c64::new(re[l + j], im[l + j]);
            }
        }
        let (low, high) = x.split_at_mut(l * p);
        eliminate(&mut z, low, l, p);
        for ((row, inverse), x) in rows[l * width..].chunks(width).zip(&far).zip(high.chunks_mut(p)) {
            for (x, input) in x.iter_mut().zip(&row[l..]) {
                *x = c64::new(*input, 0.0);
            }
            for (low, t) in low.chunks(p).zip(row) {
                for (x, low) in x.iter_mut().zip(low) {
                    *x -= low * *t;
                }
            }
            for x in x {
                *x *= inverse;
            }
        }
        x
    }
}
