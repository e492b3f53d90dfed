//! A controller file as the law of one whirl coordinate: u_r = K y_r with r = x + jy.

use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use muspin::lti::{Discrete, StateSpace};
use serde_json::Value;
use std::f64::consts::TAU;
use std::path::Path;

/// A matrix, row by row.
pub type Table = Vec<Vec<f64>>;

/// A law with two inputs and two outputs; sample time 0 means continuous time.
pub struct Law {
    pub a: Mat<c64>,
    pub b: Mat<c64>,
    pub c: Mat<c64>,
    pub d: Mat<c64>,
    pub sample_time_s: f64,
}

impl Law {
    /// A controller JSON.
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path);
        let text = text.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let file: Value = serde_json::from_str(&text).expect("controller JSON");
        let table = |key: &str| -> Table { serde_json::from_value(file[key].clone()).expect(key) };
        let sample_time_s = file["sample_time_s"].as_f64().expect("sample_time_s");
        Self::new(["A", "B", "C", "D"].map(table), sample_time_s)
    }

    /// A sampled law of four axes.
    pub fn of(law: &StateSpace<Discrete>) -> Self {
        let row = |m: &Mat<f64>, i: usize| (0..m.ncols()).map(|j| m[(i, j)]).collect();
        let table = |m: &Mat<f64>| -> Table { (0..m.nrows()).map(|i| row(m, i)).collect() };
        Self::new([&law.a, &law.b, &law.c, &law.d].map(table), law.time.period_s)
    }

    /// A law of the axes front_x, front_y, rear_x, rear_y by its matrices A, B, C, D. Its axes x and y must be alike,
    /// and turning the pair must not change it.
    pub fn new([a, b, c, d]: [Table; 4], sample_time_s: f64) -> Self {
        let from = |axes: [usize; 2]| {
            // States that these inputs reach; the others never move.
            let mut reached: Vec<bool> = b.iter().map(|row| axes.iter().any(|k| row[*k] != 0.0)).collect();
            for _ in 0..a.len() {
                for i in 0..a.len() {
                    reached[i] |= (0..a.len()).any(|j| reached[j] && a[i][j] != 0.0);
                }
            }
            let states: Vec<usize> = (0..a.len()).filter(|i| reached[*i]).collect();
            let n = states.len();
            // What x commands in x, plus j times what it commands in y (for the y axes: in y, minus j times in x).
            let (own, other) = if axes[0] == 0 { ([0, 2], 1.0) } else { ([1, 3], -1.0) };
            let across = if axes[0] == 0 { [1, 3] } else { [0, 2] };
            Self {
                a: Mat::from_fn(n, n, |i, j| c64::new(a[states[i]][states[j]], 0.0)),
                b: Mat::from_fn(n, 2, |i, j| c64::new(b[states[i]][axes[j]], 0.0)),
                c: Mat::from_fn(2, n, |i, j| c64::new(c[own[i]][states[j]], other * c[across[i]][states[j]])),
                d: Mat::from_fn(2, 2, |i, j| c64::new(d[own[i]][axes[j]], other * d[across[i]][axes[j]])),
                sample_time_s,
            }
        };
        let (x, y) = (from([0, 2]), from([1, 3]));
        for hz in [3.0, 300.0, 3000.0] {
            let (kx, ky) = (x.at(hz), y.at(hz));
            let difference = (&kx - &ky).norm_max();
            assert!(difference <= 1e-6 * kx.norm_max(), "the axes differ");
        }
        x
    }

    /// Response at a signed frequency, A/m.
    pub fn at(&self, hz: f64) -> Mat<c64> {
        let point = if self.sample_time_s > 0.0 {
            c64::from_polar(1.0, TAU * hz * self.sample_time_s)
        } else {
            c64::new(0.0, TAU * hz)
        };
        let n = self.a.nrows();
        if n == 0 {
            return self.d.clone();
        }
        let shifted = Mat::from_fn(n, n, |i, j| if i == j { point } else { c64::new(0.0, 0.0) } - self.a[(i, j)]);
        &self.c * shifted.partial_piv_lu().solve(&self.b) + &self.d
    }
}
