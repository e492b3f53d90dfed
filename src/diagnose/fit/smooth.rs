//! The smooth model error of every channel: what calibration, drift and the model of the electronics leave on any rig.
//!
//! Channel G_ij is off by the relative error δ_ij(f), complex and smooth over frequency (Kennedy and O'Hagan, J. R.
//! Statist. Soc. B 63, 2001):  δ = a Σ_b √v_b z_b φ_b(x), φ_b = √2 cos πbx over x, the logarithm of frequency in the
//! band of the record, z complex and normal, Σ v_b = 1. Its amplitude a is estimated with every fit; the logarithm of a
//! is normal about that of 0.2 %. Whitened residuals then have the covariance I + a² B Bᵀ. With B = U S Vᵀ they are
//! multiplied by its inverse root I − U (I − (I + a²S²)^(−1/2)) Uᵀ, and so are their derivatives; the determinant of
//! the covariance belongs to χ².

use super::linearise::Record;
use super::problem::Problem;
use crate::diagnose::DiagnoseError;
use crate::diagnose::data::common_error::{Group, LARGEST, Smooth};
use crate::diagnose::data::covariance::whiten_vector;
use crate::linalg::gram::add_gram;
use crate::linalg::{Mat, c64, symmetric_eigen};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};

/// Functions of frequency.
const FUNCTIONS: usize = 8;
/// Index at which their variance has fallen to a quarter.
const BEND: f64 = 3.0;
/// Model errors above this hide a smooth error.
pub(crate) const HIDING: f64 = 3e-3;
/// Variance beside that of noise, at the largest amplitude, below which a direction is left out.
const NEGLIGIBLE: f64 = 0.1;

/// φ_b √v_b at a share x of the band.
fn functions(x: f64) -> [f64; FUNCTIONS] {
    let variance = |b: usize| (1.0 + (b as f64 / BEND).powi(2)).powi(-2);
    let all: f64 = (0..FUNCTIONS).map(variance).sum();
    std::array::from_fn(|b| {
        let shape = match b {
            0 => 1.0,
            _ => std::f64::consts::SQRT_2 * (std::f64::consts::PI * b as f64 * x).cos(),
        };
        shape * (variance(b) / all).sqrt()
    })
}

/// Shares of the band in the logarithm of frequency.
fn shares(omega_rad_s: &[f64]) -> Vec<f64> {
    let (Some(from), Some(to)) = (omega_rad_s.first(), omega_rad_s.last()) else {
        return vec![];
    };
    let width = (to / from).ln().max(f64::MIN_POSITIVE);
    let share = |w: &f64| (w / from).ln() / width;
    omega_rad_s.iter().map(share).collect()
}

impl Problem<'_> {
    /// The smooth errors at a model error; none where that hides them.
    ///
    /// # Errors
    /// [`DiagnoseError::Numeric`] when an eigenvalue iteration fails.
    pub fn smooth(&self, model_error: f64) -> Result<Option<Arc<Smooth>>, DiagnoseError> {
        if model_error > HIDING {
            return Ok(None);
        }
        let usage = self.usage;
        let key = (usage.stride, usage.taps, usage.off_diagonal, model_error.to_bits());
        let known = || {
            let lock = self.evidence.smooth.lock();
            lock.unwrap_or_else(PoisonError::into_inner)
        };
        if let Some(found) = known().get(&key) {
            return Ok(Some(found.clone()));
        }
        let made = Arc::new(self.build_basis(model_error)?);
        known().insert(key, made.clone());
        Ok(Some(made))
    }

    fn build_basis(&self, model_error: f64) -> Result<Smooth, DiagnoseError> {
        let mut lines: BTreeMap<Record, Vec<(usize, usize)>> = BTreeMap::new();
        for (record, line, first) in self.rows() {
            lines.entry(record).or_default().push((line, first));
        }
        let mut wanted = vec![];
        for (record, lines) in &lines {
            match record {
                Record::Sweep(_) => wanted.extend((0..4).map(|i| (*record, i, lines))),
                Record::HammerTest(_) => wanted.push((*record, 0, lines)),
            }
        }
        let groups: Result<Vec<Option<Group>>, DiagnoseError> = wanted
            .into_par_iter()
            .map(|(record, row, lines)| {
                let (rows, b) = match record {
                    Record::Sweep(s) => self.of_row(s, row, lines, model_error),
                    Record::HammerTest(t) => self.of_tap(t, lines, model_error),
                };
                group(rows, &b)
            })
            .collect();
        Ok(Smooth { groups: groups?.into_iter().flatten().collect() })
    }

    /// Rows and B of row `i` of a sweep.
    fn of_row(&self, s: usize, i: usize, lines: &[(usize, usize)], model_error: f64) -> (Vec<usize>, Mat<f64>) {
        let sweep = &self.evidence.sweeps[s];
        let share = shares(&sweep.omega_rad_s);
        let mut b = Mat::zeros(8 * lines.len(), 8 * FUNCTIONS);
        let mut rows = Vec::with_capacity(8 * lines.len());
        for (l, (line, first)) in lines.iter().enumerate() {
            rows.extend((0..8).map(|k| first + 8 * i + k));
            let lower = &sweep.whitening(*line, model_error, self.usage.off_diagonal)[i];
            let shape = functions(share[*line]);
            for j in 0..4 {
                let mut d = [c64::new(0.0, 0.0); 4];
                d[j] = sweep.response[*line][4 * i + j];
                whiten_vector(lower, &mut d);
                for (k, v) in d.iter().enumerate() {
                    write_entries(&mut b, [8 * l + 2 * k, 2 * FUNCTIONS * j], *v, &shape);
                }
            }
        }
        (rows, b)
    }

    /// Rows and B of a hammer test.
    fn of_tap(&self, t: usize, lines: &[(usize, usize)], model_error: f64) -> (Vec<usize>, Mat<f64>) {
        let tap = &self.evidence.taps[t];
        let share = shares(&tap.omega_rad_s);
        let mut b = Mat::zeros(2 * lines.len(), 2 * FUNCTIONS);
        let mut rows = Vec::with_capacity(2 * lines.len());
        for (l, (line, first)) in lines.iter().enumerate() {
            rows.extend([*first, first + 1]);
            let v = tap.compliance[*line] / tap.sd(*line, model_error);
            let shape = functions(share[*line]);
            write_entries(&mut b, [2 * l, 0], v, &shape);
        }
        (rows, b)
    }
}

/// Writes the two real rows of a complex residual of size `v`, from the row and the column `corner` on: δ has a real
/// and an imaginary part, of half the variance each, and residuals are counted √2 times.
fn write_entries(b: &mut Mat<f64>, corner: [usize; 2], v: c64, shape: &[f64; FUNCTIONS]) {
    let [row, first] = corner;
    for (f, size) in shape.iter().enumerate() {
        let at = first + 2 * f;
        b[(row, at)] = v.re * size;
        b[(row + 1, at)] = v.im * size;
        b[(row, at + 1)] = -v.im * size;
        b[(row + 1, at + 1)] = v.re * size;
    }
}

/// The directions of B that matter.
fn group(rows: Vec<usize>, b: &Mat<f64>) -> Result<Option<Group>, DiagnoseError> {
    let mut gram = Mat::zeros(b.ncols(), b.ncols());
    add_gram(&mut gram, b.as_ref());
    // The lower triangle is read.
    let (values, vectors) = symmetric_eigen(&gram)?;
    let kept: Vec<usize> = (0..values.len()).filter(|k| LARGEST * LARGEST * values[*k] > NEGLIGIBLE).collect();
    if kept.is_empty() {
        return Ok(None);
    }
    let v = Mat::from_fn(vectors.nrows(), kept.len(), |i, k| vectors[(i, kept[k])] / values[kept[k]].sqrt());
    Ok(Some(Group { rows, u: b * v, s2: kept.iter().map(|k| values[*k]).collect() }))
}
