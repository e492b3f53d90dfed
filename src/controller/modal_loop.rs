//! A sampled loop of two equal planes, or of one, in the coordinates of its modes.
//!
//! On r = x + jy the loop is z → C(zI − A)⁻¹B + D with A = P + jQ, a mode a term. From x to x it is the mean of that
//! and of the same with conjugate coefficients; noise of both axes, white and alike, is white in r.

use crate::linalg::equal_planes::EqualPlanes;
use crate::linalg::{Mat, c64, eigen_vectors_complex, solve_complex};
use crate::lti::pole_residues::PoleResidues;
use crate::lti::{Discrete, StateSpace};

#[derive(Clone, Debug)]
pub(super) struct ModalLoop {
    poles: Vec<c64>,
    /// Outputs × modes.
    read: Mat<c64>,
    /// Modes × inputs.
    drive: Mat<c64>,
    direct: Mat<c64>,
    /// The coordinates are r = x + jy; else they are those of one plane.
    is_turning: bool,
}

/// Largest relative residual of the eigenvectors at which the modes are used; rounding leaves 1e-13.
const TRUSTED: f64 = 1e-10;
/// Share of the terms of a noise that is left by rounding: of a sum of n² terms up to n² units in the last place, 1e-12
/// for a hundred poles.
const ROUNDING: f64 = 1e-12;
/// Largest relative error of a noise.
const ACCURACY: f64 = 1e-7;

impl ModalLoop {
    /// The modes of a loop of one plane, or on r = x + jy of two equal ones; none where the planes are not equal, or
    /// the eigenvectors not accurate.
    pub(super) fn new(loops: &StateSpace<Discrete>, planes: Option<&EqualPlanes>) -> Option<Self> {
        let complex = |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| c64::from(m[(i, j)]));
        let [a, b, c, d] = match planes {
            Some(planes) => {
                let axes = |count: usize| EqualPlanes::of(&(0..count).map(|k| k % 2 == 1).collect::<Vec<_>>());
                let (inputs, outputs) = (axes(loops.inputs())?, axes(loops.outputs())?);
                let (a, scale) = planes.turning(&loops.a)?;
                let ones = |axes: usize| vec![1.0; axes / 2];
                let (of_inputs, of_outputs) = (ones(loops.inputs()), ones(loops.outputs()));
                [
                    a,
                    planes.turning_between(&inputs, &loops.b, (&scale, &of_inputs))?,
                    outputs.turning_between(planes, &loops.c, (&of_outputs, &scale))?,
                    outputs.turning_between(&inputs, &loops.d, (&of_outputs, &of_inputs))?,
                ]
            }
            None => [&loops.a, &loops.b, &loops.c, &loops.d].map(complex),
        };
        let eigen = eigen_vectors_complex(&a).ok()?;
        if eigen.residual.is_nan() || eigen.residual > TRUSTED {
            return None;
        }
        let drive = solve_complex(&eigen.vectors, &b);
        let error = &eigen.vectors * &drive - &b;
        if error.norm_max().is_nan() || error.norm_max() > TRUSTED * b.norm_max() {
            return None;
        }
        Some(Self { poles: eigen.values, read: &c * &eigen.vectors, drive, direct: d, is_turning: planes.is_some() })
    }

    /// Poles of the loop, of both planes if it has two.
    pub(super) fn poles(&self) -> Vec<c64> {
        if self.is_turning { self.poles.iter().flat_map(|p| [*p, p.conj()]).collect() } else { self.poles.clone() }
    }

    /// From input to output of one plane, x to x.
    pub(super) fn entry(&self, output: usize, input: usize) -> PoleResidues {
        let residue = |k: usize| self.read[(output, k)] * self.drive[(k, input)];
        let own = (0..self.poles.len()).map(|k| (self.poles[k], residue(k)));
        let direct = self.direct[(output, input)];
        if !self.is_turning {
            return PoleResidues::new(&own.collect::<Vec<_>>(), direct);
        }
        let both = own.flat_map(|(p, r)| [(p, 0.5 * r), (p.conj(), 0.5 * r.conj())]);
        PoleResidues::new(&both.collect::<Vec<_>>(), c64::from(direct.re))
    }

    /// Variance of an output of one plane by white noise of unit variance at all inputs: Σ|D|² and, of two modes with
    /// residues r and s, r s̄/(1 − p p̄′); none where these cancel to less than [`ACCURACY`].
    pub(super) fn variance(&self, output: usize) -> Option<f64> {
        let (mut sum, mut size) = (0.0, 0.0);
        for input in 0..self.drive.ncols() {
            sum += self.direct[(output, input)].norm_sqr();
            let residue = |k: usize| self.read[(output, k)] * self.drive[(k, input)];
            let residues: Vec<c64> = (0..self.poles.len()).map(residue).collect();
            for (p, r) in self.poles.iter().zip(&residues) {
                for (q, s) in self.poles.iter().zip(&residues) {
                    let term = r * s.conj() / (1.0 - p * q.conj());
                    sum += term.re;
                    size += term.norm();
                }
            }
        }
        // NaN is not accurate.
        (ROUNDING * size < ACCURACY * sum).then_some(sum)
    }
}
