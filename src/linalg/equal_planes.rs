//! Eigenvalues and exponentials of real matrices that do the same in two planes and couple them as a turning frame
//! does.
//!
//! On coordinates (x, y) such a matrix is [[P, −Q], [Q, P]], which is P + jQ on r = x + jy: its eigenvalues are those
//! of P + jQ and their conjugates, at a quarter of the cost or less.

use super::complex_eigenvalues::eigenvalues_complex;
use super::dense::balance;
use super::error::NumericError;
use super::hermitian::hermitian_eigen;
use super::pade::{exponentials_of_balanced, size_of};
use super::real_eigenvalues::{eigenvalues, eigenvalues_of_balanced};
use faer::{Mat, c64};

/// Which coordinates belong to the x plane and which to the y plane: the k-th of each are partners.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct EqualPlanes {
    x: Vec<usize>,
    y: Vec<usize>,
}

/// Largest difference of the planes that counts as rounding, relative to the largest entry of the balanced matrix.
/// Exponentials and factors of gramians that are computed for both planes at once differ by less; what makes two planes
/// of a machine differ, a gain of an axis for instance, is above a millionth.
const ROUNDING: f64 = 1e-12;

impl EqualPlanes {
    /// From the plane of every coordinate, true for y; none when one plane has more than the other.
    pub(crate) fn of(in_y: &[bool]) -> Option<Self> {
        let members = |plane: bool| (0..in_y.len()).filter(|k| in_y[*k] == plane).collect();
        let (x, y): (Vec<usize>, Vec<usize>) = (members(false), members(true));
        (x.len() == y.len()).then_some(Self { x, y })
    }

    /// The coordinates of two systems one after the other.
    pub(crate) fn followed_by(&self, next: &Self) -> Self {
        let first = self.x.len() + self.y.len();
        let joined = |own: &[usize], next: &[usize]| {
            let next = next.iter().map(|k| first + k);
            own.iter().copied().chain(next).collect()
        };
        Self { x: joined(&self.x, &next.x), y: joined(&self.y, &next.y) }
    }

    /// The same scale for partners, that of x.
    pub(crate) fn with_equal_partners(&self, scale: &[f64]) -> Vec<f64> {
        let mut equal = scale.to_vec();
        for (x, y) in self.x.iter().zip(&self.y) {
            equal[*y] = scale[*x];
        }
        equal
    }

    /// P + jQ, the mean of what the planes say of a matrix with these coordinates as rows and those of `columns`; none
    /// for another size.
    fn mean_between(&self, columns: &Self, a: &Mat<f64>) -> Option<Mat<c64>> {
        let (x, y) = (&self.x, &self.y);
        let fits = a.nrows() == 2 * x.len() && a.ncols() == 2 * columns.x.len();
        fits.then(|| {
            Mat::from_fn(x.len(), columns.x.len(), |i, j| {
                let (right, left) = (columns.x[j], columns.y[j]);
                c64::new(0.5 * (a[(x[i], right)] + a[(y[i], left)]), 0.5 * (a[(y[i], right)] - a[(x[i], left)]))
            })
        })
    }

    /// P + jQ of a matrix with these coordinates as rows and those of `columns`, each entry divided by the scale of its
    /// row and multiplied by that of its column; none for another size, or when the planes differ by more than rounding
    /// relative to the largest entry.
    pub(crate) fn turning_between(&self, columns: &Self, a: &Mat<f64>, scales: (&[f64], &[f64])) -> Option<Mat<c64>> {
        let mean = self.mean_between(columns, a)?;
        self.scale_planes(columns, a, &mean, scales.0, scales.1)
    }

    /// [`Self::turning_between`] of a matrix with its mean.
    fn scale_planes(
        &self,
        columns: &Self,
        a: &Mat<f64>,
        mean: &Mat<c64>,
        of_rows: &[f64],
        of_columns: &[f64],
    ) -> Option<Mat<c64>> {
        let (mut largest, mut apart) = (0.0f64, 0.0f64);
        for (i, (x, y)) in self.x.iter().zip(&self.y).enumerate() {
            for (j, (right, left)) in columns.x.iter().zip(&columns.y).enumerate() {
                let alike = a[(*x, *right)] - a[(*y, *left)];
                let turned = a[(*y, *right)] + a[(*x, *left)];
                let scale = of_columns[j] / of_rows[i];
                apart = apart.max(scale * alike.abs().max(turned.abs()));
                let own = mean[(i, j)];
                largest = largest.max(scale * own.re.abs().max(own.im.abs()));
            }
        }
        (apart <= ROUNDING * largest)
            .then(|| Mat::from_fn(mean.nrows(), mean.ncols(), |i, j| mean[(i, j)] * (of_columns[j] / of_rows[i])))
    }

    /// P + jQ of a matrix on these coordinates with balanced moduli, and the scale that balances them; none as in
    /// [`Self::turning_between`].
    pub(crate) fn turning(&self, a: &Mat<f64>) -> Option<(Mat<c64>, Vec<f64>)> {
        let mean = self.mean_between(self, a)?;
        let scale = scale_of_moduli(&mean);
        let turning = self.scale_planes(self, a, &mean, &scale, &scale)?;
        Some((turning, scale))
    }

    /// The matrix on these coordinates that P + jQ stands for.
    fn of_both(&self, turning: impl Fn(usize, usize) -> c64) -> Mat<f64> {
        let n = self.x.len();
        let mut a = Mat::zeros(2 * n, 2 * n);
        for (i, (xi, yi)) in self.x.iter().zip(&self.y).enumerate() {
            for (j, (xj, yj)) in self.x.iter().zip(&self.y).enumerate() {
                let entry = turning(i, j);
                (a[(*xi, *xj)], a[(*yi, *yj)]) = (entry.re, entry.re);
                (a[(*yi, *xj)], a[(*xi, *yj)]) = (entry.im, -entry.im);
            }
        }
        a
    }

    /// exp(tA) of a real matrix on these coordinates at some times t ≥ 0; none when its planes are not equal. Entries
    /// that overflow are not finite.
    pub(crate) fn exponentials<const K: usize>(&self, a: &Mat<f64>, times: [f64; K]) -> Option<[Mat<f64>; K]> {
        let (turning, scale) = self.turning(a)?;
        Some(match one_plane(&turning) {
            Some(plane) => self.unscale_planes(exponentials_of_balanced(&plane, times), &scale),
            None => self.unscale_planes(exponentials_of_balanced(&turning, times), &scale),
        })
    }

    /// What scaled matrices of one plane stand for on these coordinates.
    fn unscale_planes<T: Copy + Into<c64>, const K: usize>(&self, list: [Mat<T>; K], scale: &[f64]) -> [Mat<f64>; K] {
        list.map(|e| {
            self.of_both(|i, j| {
                let entry: c64 = e[(i, j)].into();
                entry * (scale[i] / scale[j])
            })
        })
    }

    /// Rows S with SᵀS = W for a symmetric W ≥ 0 on these coordinates, without those whose share of W is at most
    /// `rounding`; none when the planes of W are not equal.
    pub(crate) fn root(&self, w: &Mat<f64>, rounding: f64) -> Result<Option<Mat<f64>>, NumericError> {
        let scale = vec![1.0; self.x.len()];
        let Some(turning) = self.turning_between(self, w, (&scale, &scale)) else {
            return Ok(None);
        };
        let (values, vectors) = hermitian_eigen(&turning)?;
        let kept = above_rounding(&values, rounding);
        let mut rows = Mat::zeros(2 * kept.len(), w.ncols());
        // A row p + jq takes x + jy to p x − q y + j(q x + p y).
        for (row, k) in kept.into_iter().enumerate() {
            for (j, (x, y)) in self.x.iter().zip(&self.y).enumerate() {
                let entry = vectors[(j, k)].conj() * values[k].sqrt();
                (rows[(2 * row, *x)], rows[(2 * row, *y)]) = (entry.re, -entry.im);
                (rows[(2 * row + 1, *x)], rows[(2 * row + 1, *y)]) = (entry.im, entry.re);
            }
        }
        Ok(Some(rows))
    }

    /// [`Self::eigenvalues`] where the planes of the coordinates are known, else those of the matrix as it is.
    pub(crate) fn eigenvalues_on(planes: Option<&Self>, a: &Mat<f64>) -> Result<Vec<c64>, NumericError> {
        planes.map_or_else(|| eigenvalues(a), |planes| planes.eigenvalues(a))
    }

    /// Eigenvalues of a real matrix on these coordinates, each of P + jQ beside its conjugate; those of the matrix as
    /// it is when its planes are not equal.
    pub(crate) fn eigenvalues(&self, a: &Mat<f64>) -> Result<Vec<c64>, NumericError> {
        let Some((turning, _)) = self.turning(a) else {
            return eigenvalues(a);
        };
        let own = match one_plane(&turning) {
            Some(plane) => eigenvalues_of_balanced(&plane)?,
            None => eigenvalues_complex(&turning)?,
        };
        Ok(own.into_iter().flat_map(|v| [v, v.conj()]).collect())
    }
}

/// P of P + jQ where Q is zero: the planes do not act on each other.
fn one_plane(turning: &Mat<c64>) -> Option<Mat<f64>> {
    let n = turning.nrows();
    let apart = (0..n).all(|j| (0..n).all(|i| turning[(i, j)].im == 0.0));
    apart.then(|| Mat::from_fn(n, n, |i, j| turning[(i, j)].re))
}

/// What balances the moduli of a matrix, taken to within √2.
fn scale_of_moduli(a: &Mat<c64>) -> Vec<f64> {
    balance(&Mat::from_fn(a.nrows(), a.ncols(), |i, j| size_of(a[(i, j)]))).1
}

/// Numbers of the eigenvalues of a matrix W ≥ 0 above a share of the largest.
pub(crate) fn above_rounding(values: &[f64], rounding: f64) -> Vec<usize> {
    let largest = values.iter().copied().fold(0.0, f64::max);
    let above = |k: &usize| values[*k] > rounding * largest;
    (0..values.len()).filter(above).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coordinates in the order x, y, y, x, x, y with partners (0, 1), (3, 2), (4, 5).
    fn planes() -> EqualPlanes {
        EqualPlanes::of(&[false, true, true, false, false, true]).expect("three of each")
    }

    /// A matrix of two equal planes on these coordinates, and the same with another entry in the y plane.
    fn matrix(other: f64) -> Mat<f64> {
        let (x, y) = ([0, 3, 4], [1, 2, 5]);
        let p = |i: usize, j: usize| ((3 * i + 5 * j) as f64).sin() - 2.0 * f64::from(i == j);
        let q = |i: usize, j: usize| 0.3 * ((i + 7 * j) as f64).cos();
        let mut a = Mat::zeros(6, 6);
        for i in 0..3 {
            for j in 0..3 {
                let scale = 1e3f64.powi(i as i32 - j as i32);
                a[(x[i], x[j])] = scale * p(i, j);
                a[(y[i], y[j])] = scale * p(i, j);
                a[(y[i], x[j])] = scale * q(i, j);
                a[(x[i], y[j])] = -scale * q(i, j);
            }
        }
        a[(1, 1)] += other;
        a
    }

    fn largest_gap(found: &[c64], expected: &[c64]) -> f64 {
        assert_eq!(found.len(), expected.len());
        let nearest = |v: &c64| {
            let gaps = expected.iter().map(|e| (v - e).norm());
            gaps.fold(f64::INFINITY, f64::min)
        };
        found.iter().map(nearest).fold(0.0, f64::max)
    }

    #[test]
    fn eigenvalues_of_equal_planes_are_those_of_the_whole_matrix() {
        let a = matrix(0.0);
        assert!(planes().turning(&a).is_some());
        let whole = eigenvalues(&a).expect("finite");
        let found = planes().eigenvalues(&a).expect("finite");
        assert!(largest_gap(&found, &whole) < 1e-12 && largest_gap(&whole, &found) < 1e-12);
    }

    #[test]
    fn exponentials_of_equal_planes_are_those_of_the_whole_matrix() {
        // One that turns, and one that stands still: without it the planes are apart.
        let whole = matrix(0.0);
        let still = Mat::from_fn(6, 6, |i, j| {
            let one_plane = planes().x.contains(&i) == planes().x.contains(&j);
            if one_plane { whole[(i, j)] } else { 0.0 }
        });
        for a in [whole, still] {
            let times = [0.0, 0.3, 2.0];
            let found = planes().exponentials(&a, times).expect("equal planes");
            for (e, t) in found.iter().zip(times) {
                let scaled = Mat::from_fn(6, 6, |i, j| t * a[(i, j)]);
                let exact = super::super::exponential(&scaled).expect("finite");
                let apart = (0..36).map(|k| (k % 6, k / 6)).map(|(i, j)| {
                    // Entries of very different scales.
                    let scale = exact[(i, j)].abs() + exact[(j, i)].abs();
                    (e[(i, j)] - exact[(i, j)]).abs() / scale.max(1e-300)
                });
                assert!(apart.fold(0.0, f64::max) < 1e-10);
            }
        }
        assert!(planes().exponentials(&matrix(1e-3), [1.0]).is_none());
    }

    #[test]
    fn rows_of_a_root_give_the_matrix_again() {
        let a = matrix(0.0);
        let w = a.transpose() * &a;
        let rows = planes().root(&w, 1e-15).expect("finite").expect("equal planes");
        let gap = (rows.transpose() * &rows - &w).norm_max();
        assert!(gap < 1e-13 * w.norm_max(), "{gap:.1e}");
        assert!(planes().root(&matrix(1e-3), 0.0).expect("finite").is_none());
    }

    #[test]
    fn planes_that_differ_are_taken_as_they_are() {
        let a = matrix(1e-6);
        assert!(planes().turning(&a).is_none());
        let whole = eigenvalues(&a).expect("finite");
        assert_eq!(planes().eigenvalues(&a).expect("finite"), whole);
    }
}
