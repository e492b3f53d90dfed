//! A free law at a place together with the nuisance parameters: variable projection.
//!
//! At every line the whitened residual r loses what the directions of the place explain (orthogonal projection P), and
//! the nuisance parameters follow from  min Σ 2‖P(r − J dp)‖² + Σ((p + dp)/sd)²  by Gauss–Newton, the law held in J,
//! relinearised while the model error falls.

use super::super::DiagnoseError;
use super::super::data::covariance::whiten_vector;
use super::super::data::evidence::{Subset, SweepEvidence};
use super::super::fit::case::Case;
use super::super::fit::nuisance::Layout;
use super::basis::{LineBasis, power};
use super::place::Place;
use super::place_response::{OpenedPlace, PlaceResponse};
use crate::linalg::dense::solve_normal;
use crate::linalg::gram::{add_gram, mirror_lower};
use crate::linalg::{Mat, c64};
use crate::spindle::response::{SIDE, Square, ZERO};

/// Standard deviation of a nuisance parameter that is under test: free.
const FREE_SD: f64 = 1.0;
/// Numbers below this many standard deviations may as well be zero.
const INSIGNIFICANT: f64 = 3.0;
/// Longest step of a nuisance parameter: a factor stays one.
const LONGEST_STEP: f64 = 0.3;
/// Real residuals of a line.
const HEIGHT: usize = 32;
/// Lines whose derivatives are multiplied in one piece.
const PIECE: usize = 16;

/// Nuisance parameters with a free law at a place.
#[derive(Clone, Debug)]
pub(crate) struct Settled {
    pub p: Vec<f64>,
    /// χ² of the lines that were seen, the law taken out, with priors.
    pub chi2: f64,
    /// Free complex numbers, lines times numbers a line.
    pub numbers: usize,
}

/// One line of a sweep with the law that fits it.
pub(crate) struct Fitted<'v> {
    pub sweep: usize,
    pub omega_rad_s: f64,
    /// χ² without the law and with it.
    pub chi2: (f64, f64),
    /// X and its standard deviations.
    pub x: Vec<c64>,
    /// Standard deviations of X.
    pub sd: Vec<f64>,
    pub view: &'v PlaceResponse<'v>,
    basis: LineBasis,
    residual: [c64; 16],
    rows: [[c64; 16]; 4],
}

/// Real and imaginary parts, one after the other.
fn parts(v: &[c64; 16]) -> [f64; HEIGHT] {
    std::array::from_fn(|k| if k % 2 == 0 { v[k / 2].re } else { v[k / 2].im })
}

/// What a law is fitted with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawFit<'a> {
    pub place: &'a Place,
    /// Nuisance parameters, held.
    pub p: &'a [f64],
    pub model_error: f64,
    /// Data that it sees.
    pub usage: Subset,
    /// Whether derivatives to the nuisance parameters are wanted.
    pub derivatives: bool,
}

/// Fits the law at the lines of all sweeps, nuisance parameters held at `p`.
pub(crate) fn lines(case: &Case, fit: &LawFit, mut visit: impl FnMut(Fitted)) -> Result<(), DiagnoseError> {
    let LawFit { place, p, model_error, usage, derivatives } = *fit;
    let layout = &case.model.layout;
    for (s, sweep) in case.evidence.sweeps.iter().enumerate() {
        let scene: OpenedPlace = place.scene(case.model, p, &[], sweep.speed_rad_s, derivatives)?;
        for line in (0..sweep.omega_rad_s.len()).step_by(usage.stride) {
            let omega = sweep.omega_rad_s[line];
            let view = scene.view(omega);
            let rows = sweep.whitening(line, model_error, usage.off_diagonal);
            let gain: [f64; 4] = std::array::from_fn(|i| 1.0 + p[layout.axis(s, i)]);
            let residual = residual(sweep, line, &view.response, &gain, &rows);
            let white: Vec<[c64; 16]> = view.directions.iter().map(|d| whiten_rows(d, &gain, &rows)).collect();
            let basis = LineBasis::new(&white);
            let (x, sd) = basis.solve(&residual, white.len());
            let left = basis.beyond(&residual);
            visit(Fitted {
                sweep: s,
                omega_rad_s: omega,
                chi2: (2.0 * power(&residual), 2.0 * power(&left)),
                x,
                sd,
                view: &view,
                basis,
                residual: left,
                rows,
            });
        }
    }
    Ok(())
}

fn residual(sweep: &SweepEvidence, line: usize, f: &Square, gain: &[f64; 4], rows: &[[c64; 16]; 4]) -> [c64; 16] {
    let mut all = [ZERO; 16];
    for i in 0..4 {
        let mut d: [c64; 4] = std::array::from_fn(|j| sweep.response[line][4 * i + j] - f[SIDE * i + j] * gain[i]);
        whiten_vector(&rows[i], &mut d);
        all[4 * i..4 * i + 4].copy_from_slice(&d);
    }
    all
}

fn whiten_rows(f: &Square, gain: &[f64; 4], rows: &[[c64; 16]; 4]) -> [c64; 16] {
    let mut all = [ZERO; 16];
    for i in 0..4 {
        let mut d: [c64; 4] = std::array::from_fn(|j| f[SIDE * i + j] * gain[i]);
        whiten_vector(&rows[i], &mut d);
        all[4 * i..4 * i + 4].copy_from_slice(&d);
    }
    all
}

/// Nuisance parameters with a free law at a place, through stages of model error and number of steps.
pub(crate) fn settle(
    case: &Case,
    place: &Place,
    from: &[f64],
    stages: &[(f64, usize)],
    usage: Subset,
) -> Result<Settled, DiagnoseError> {
    let layout = &case.model.layout;
    let n = layout.len();
    let mut priors = layout.clone();
    if let Place::Freed(parameter) = place {
        priors.sd[*parameter] = FREE_SD;
    }
    let mut p = from.to_vec();
    let mut best: Option<Settled> = None;
    // Derivatives of some lines, and what they leave of the residuals in the last column.
    let mut block = Mat::zeros(HEIGHT * PIECE, n + 1);
    for (model_error, steps) in stages {
        best = None;
        for step in 0..=*steps {
            let last = step == *steps;
            let mut gram = Mat::zeros(n + 1, n + 1);
            let (mut chi2, mut numbers, mut filled) = (0.0, 0, 0);
            let fit = LawFit { place, p: &p, model_error: *model_error, usage, derivatives: !last };
            lines(case, &fit, |line| {
                chi2 += line.chi2.1;
                numbers += line.basis.q.len();
                if last {
                    return;
                }
                line.write(layout, &p, &mut block, filled);
                filled += HEIGHT;
                if filled == block.nrows() {
                    add_gram(&mut gram, block.as_ref());
                    filled = 0;
                }
            })?;
            add_gram(&mut gram, block.subrows(0, filled));
            let here = Settled { chi2: chi2 + priors.prior(&p), numbers, p: p.clone() };
            match &best {
                // A step that went too far is halved.
                Some(b) if here.chi2 > b.chi2 && !last => {
                    for (p, b) in p.iter_mut().zip(&b.p) {
                        *p = 0.5 * (*p + b);
                    }
                    continue;
                }
                Some(b) if here.chi2 > b.chi2 => {}
                _ => best = Some(here),
            }
            if last {
                break;
            }
            let pulls: Vec<(f64, f64)> = priors.pull(&p).collect();
            let gram = mirror_lower(gram);
            let matrix = Mat::from_fn(n, n, |i, j| 2.0 * gram[(i, j)] + if i == j { pulls[i].0 } else { 0.0 });
            let right = Mat::from_fn(n, 1, |i, _| 2.0 * gram[(n, i)] + pulls[i].1);
            let step = solve_normal(&matrix, &right)?;
            for (i, p) in p.iter_mut().enumerate() {
                *p += step[(i, 0)].clamp(-LONGEST_STEP, LONGEST_STEP);
                *p = p.clamp(-0.7, 3.0);
            }
        }
        if let Some(b) = &best {
            p.clone_from(&b.p);
        }
    }
    best.ok_or(DiagnoseError::NoSweep)
}

impl Fitted<'_> {
    /// Writes PJ and Pr of this line, real and imaginary parts apart, into the rows of `block` from `first` on; columns
    /// that do not depend on the line stay as they are.
    fn write(&self, layout: &Layout, p: &[f64], block: &mut Mat<f64>, first: usize) {
        let n = layout.len();
        let machine = &layout.machine;
        let slopes = self.view.slopes(&self.x, machine);
        let gain: [f64; 4] = std::array::from_fn(|i| 1.0 + p[layout.axis(self.sweep, i)]);
        let left = |d: &Square, gain: &[f64; 4]| parts(&self.basis.beyond(&whiten_rows(d, gain, &self.rows)));
        let mut column = |k: usize, values: &[f64; HEIGHT]| {
            block.col_as_slice_mut(k)[first..first + HEIGHT].copy_from_slice(values);
        };
        let units: Vec<[[f64; HEIGHT]; 2]> = slopes
            .units
            .iter()
            .map(|unit| {
                let real = left(unit, &gain);
                let turned = |k: usize| match k % 2 {
                    0 => -real[k + 1],
                    _ => real[k - 1],
                };
                [real, std::array::from_fn(turned)]
            })
            .collect();
        let groups = machine.groups;
        for (k, entries) in slopes.entries.chunks_exact(units.len()).enumerate() {
            let mut values = [0.0; HEIGHT];
            for (entry, [real, turned]) in entries.iter().zip(&units) {
                for (value, (a, b)) in values.iter_mut().zip(real.iter().zip(turned)) {
                    *value += entry.re * a + entry.im * b;
                }
            }
            // Moduli, ks, damping and mesh, among which ki and sensor gains stand.
            let at = match k.checked_sub(groups) {
                None => k,
                Some(b @ 0..2) => machine.ks(b),
                Some(further) => machine.damping(0) + further - 2,
            };
            column(at, &values);
        }
        for b in 0..2 {
            column(machine.ki(b), &left(&slopes.gains[b], &gain));
            column(machine.gain(b), &left(&slopes.gains[2 + b], &gain));
        }
        for (sweep, i) in (0..layout.sweeps).flat_map(|s| (0..4).map(move |i| (s, i))) {
            let mut values = [0.0; HEIGHT];
            if sweep == self.sweep {
                let mut own = [0.0; 4];
                own[i] = 1.0;
                values = left(&slopes.response, &own);
            }
            column(layout.axis(sweep, i), &values);
        }
        column(n, &parts(&self.residual));
    }

    /// R x of the triangle that whitens X.
    fn triangle(&self, x: &[c64]) -> Vec<c64> {
        let n = self.basis.kept.len();
        (0..n).map(|k| (k..n).fold(ZERO, |sum, l| sum + self.basis.r[l][k] * x[self.basis.kept[l]])).collect()
    }

    /// Flexibility of a joint in turning and across, nothing between the two: the flexibilities whose X comes nearest
    /// to what was found, by Gauss–Newton from two starts.
    fn joint(&self) -> Vec<(c64, f64)> {
        let collet = self.view.collet();
        let at = |z: &[c64; 2]| -> Vec<c64> {
            let s: [c64; 2] = std::array::from_fn(|i| z[i] * collet[i]);
            self.triangle(&self.view.add_joint(s))
        };
        let wanted = self.triangle(&self.x);
        let cost = |there: &[c64]| -> f64 {
            let both = wanted.iter().zip(there);
            both.map(|(a, b)| (a - b).norm_sqr()).sum()
        };
        let unit = c64::new(1.0, 0.0);
        let found = self.view.laws(&self.x);
        let raw = [1, 0].map(|i| found[i] / collet[1 - i]);
        let mut best: Option<(f64, [c64; 2], [f64; 2])> = None;
        for start in [[unit; 2], raw] {
            let mut z = start;
            let mut deviations = [0.0; 2];
            for _ in 0..12 {
                let here = at(&z);
                let step = 1e-4;
                let columns: Vec<Vec<c64>> = (0..2)
                    .map(|i| {
                        let mut there = z;
                        there[i] += step;
                        let moved = at(&there);
                        moved.iter().zip(&here).map(|(a, b)| (a - b) / step).collect()
                    })
                    .collect();
                let product = |a: &[c64], b: &[c64]| a.iter().zip(b).fold(ZERO, |s, (a, b)| s + a.conj() * b);
                let left: Vec<c64> = wanted.iter().zip(&here).map(|(a, b)| a - b).collect();
                let (a, b, c) = (
                    product(&columns[0], &columns[0]).re,
                    product(&columns[0], &columns[1]),
                    product(&columns[1], &columns[1]).re,
                );
                let determinant = a * c - b.norm_sqr();
                if determinant <= 1e-14 * a * c {
                    break;
                }
                let (p, q) = (product(&columns[0], &left), product(&columns[1], &left));
                let mut change = [(p * c - b * q) / determinant, (q * a - b.conj() * p) / determinant];
                deviations = [(c / determinant).sqrt(), (a / determinant).sqrt()];
                // Half a step until it is an improvement; six halvings make it small against the deviations.
                let now = cost(&here);
                for _ in 0..6 {
                    if cost(&at(&[z[0] + change[0], z[1] + change[1]])) < now {
                        break;
                    }
                    change = change.map(|c| c * 0.5);
                }
                z = [z[0] + change[0], z[1] + change[1]];
            }
            let value = cost(&at(&z));
            if value.is_finite() && best.as_ref().is_none_or(|b| value < b.0) {
                best = Some((value, z, deviations));
            }
        }
        let Some((_, z, deviations)) = best else {
            return found.into_iter().map(|v| (v, f64::INFINITY)).collect();
        };
        // Turning first, as in the list of laws.
        [1, 0].map(|i| (z[i] * collet[i], deviations[i] * collet[i])).to_vec()
    }

    /// The law and its standard deviation, in the order of [`Place::laws`].
    pub(crate) fn laws(&self) -> Vec<(c64, f64)> {
        if *self.view.place() == Place::Joint && !self.view.split() && self.basis.kept.len() > 1 {
            return self.joint();
        }
        let here = self.view.laws(&self.x);
        let mut variance = vec![0.0; here.len()];
        for (a, sd) in self.sd.iter().enumerate() {
            // A hundredth of the deviation is within the linear range of the law.
            let step = 1e-2 * sd;
            if step == 0.0 {
                continue;
            }
            let mut there = self.x.clone();
            there[a] += step;
            for (v, (a, b)) in variance.iter_mut().zip(self.view.laws(&there).iter().zip(&here)) {
                *v += (a - b).norm_sqr() * 1e4;
            }
        }
        // Where X is noise, 1 + G X is noise too and Δ tends to −1/G, however exact it looks: what a law would be
        // without the numbers that are not significant is within its uncertainty.
        let sure: Vec<c64> =
            self.x.iter().zip(&self.sd).map(|(x, sd)| if x.norm() < INSIGNIFICANT * sd { ZERO } else { *x }).collect();
        let sure = self.view.laws(&sure);
        let deviations =
            variance.iter().zip(here.iter().zip(&sure)).map(|(v, (law, sure))| v.sqrt().max((law - sure).norm()));
        here.iter().copied().zip(deviations).collect()
    }
}
