//! Hessenberg form, real or complex, and what an iteration on it takes as zero.

use super::dense::NEGLIGIBLE;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::hessenberg::{HessenbergParams, hessenberg_in_place, hessenberg_in_place_scratch};
use faer::linalg::householder::{
    apply_block_householder_sequence_on_the_right_in_place_scratch,
    apply_block_householder_sequence_on_the_right_in_place_with_conj,
};
use faer::traits::ComplexField;
use faer::{Auto, Conj, Mat, Par, Spec};

/// The Hessenberg form of a matrix, what is below its subdiagonal left over from the reflections, and their factors.
fn hessenberg_form<T: ComplexField>(mut a: Mat<T>) -> (Mat<T>, Mat<T>) {
    let n = a.nrows();
    // One reflection at a time.
    let mut reflections = Mat::<T>::zeros(1, n.saturating_sub(1));
    if n > 1 {
        let params: Spec<HessenbergParams, T> = Spec::new(<_ as Auto<T>>::auto());
        let scratch = hessenberg_in_place_scratch::<T>(n, 1, Par::Seq, params);
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        hessenberg_in_place(a.as_mut(), reflections.as_mut(), Par::Seq, stack, params);
    }
    (a, reflections)
}

/// A number as an iteration keeps it.
pub(super) trait Stored: Copy {
    const ZERO: Self;
    /// Modulus, or what is within √2 of it.
    fn size(self) -> f64;
    fn minus(self, other: Self) -> Self;
}

impl Stored for f64 {
    const ZERO: Self = 0.0;
    fn size(self) -> f64 {
        self.abs()
    }
    fn minus(self, other: Self) -> Self {
        self - other
    }
}

/// Real and imaginary part.
impl Stored for [f64; 2] {
    const ZERO: Self = [0.0; 2];
    fn size(self) -> f64 {
        self[0].abs() + self[1].abs()
    }
    fn minus(self, other: Self) -> Self {
        [self[0] - other[0], self[1] - other[1]]
    }
}

/// An upper Hessenberg matrix of norm one, column by column.
pub(super) struct Hessenberg<S> {
    pub order: usize,
    pub entries: Vec<S>,
}

impl<S: Stored> Hessenberg<S> {
    /// The Hessenberg form of a matrix whose entries are kept as `stored` says.
    pub(super) fn of<T: ComplexField>(a: Mat<T>, stored: impl Fn(&T) -> S) -> Self {
        Self::upper_part(&hessenberg_form(a).0, stored)
    }

    /// A Hessenberg matrix without what is below its subdiagonal.
    fn upper_part<T>(h: &Mat<T>, stored: impl Fn(&T) -> S) -> Self {
        let n = h.nrows();
        let entry = |k: usize| match (k % n, k / n) {
            (i, j) if i > j + 1 => S::ZERO,
            at => stored(&h[at]),
        };
        Self { order: n, entries: (0..n * n).map(entry).collect() }
    }

    pub(super) fn at(&self, i: usize, j: usize) -> S {
        self.entries[j * self.order + i]
    }

    pub(super) fn set(&mut self, i: usize, j: usize, value: S) {
        self.entries[j * self.order + i] = value;
    }

    /// Start of the last part before `end` that does not fall apart: the entry before it is negligible and set to zero.
    pub(super) fn deflate_end(&mut self, end: usize) -> usize {
        let Some(i) = (1..end).rev().find(|i| self.is_negligible(*i)) else {
            return 0;
        };
        self.set(i, i - 1, S::ZERO);
        i
    }

    /// True where the entry of row `i` below the diagonal is zero to rounding (Ahues and Tisseur 1997).
    fn is_negligible(&self, i: usize) -> bool {
        let (below, above) = (self.at(i, i - 1).size(), self.at(i - 1, i).size());
        if below < NEGLIGIBLE {
            return true;
        }
        let (before, after) = (self.at(i - 1, i - 1), self.at(i, i));
        below <= f64::EPSILON * (before.size() + after.size()) && {
            let apart = after.minus(before).size();
            let (larger, smaller) = (after.size().max(apart), after.size().min(apart));
            let (most, least) = (below.max(above), below.min(above));
            let scale = larger + most;
            least * (most / scale) <= f64::EPSILON * (smaller * (larger / scale))
        }
    }
}

impl Hessenberg<f64> {
    /// The Hessenberg form H of a real matrix, and Q with A = Q H Qᵀ, column by column.
    pub(super) fn with_basis(a: Mat<f64>) -> (Self, Vec<f64>) {
        let n = a.nrows();
        let (h, factors) = hessenberg_form(a);
        let mut q = Mat::<f64>::identity(n, n);
        if n > 1 {
            let scratch = apply_block_householder_sequence_on_the_right_in_place_scratch::<f64>(n - 1, 1, n - 1);
            let mut memory = MemBuffer::new(scratch);
            apply_block_householder_sequence_on_the_right_in_place_with_conj(
                h.submatrix(1, 0, n - 1, n - 1),
                factors.as_ref(),
                Conj::No,
                q.submatrix_mut(1, 1, n - 1, n - 1),
                Par::Seq,
                MemStack::new(&mut memory),
            );
        }
        let basis = (0..n * n).map(|k| q[(k % n, k / n)]).collect();
        (Self::upper_part(&h, |x| *x), basis)
    }
}

/// Steps for one eigenvalue at most; two or three are usual.
pub(super) const MOST_STEPS: usize = 300;
/// After so many steps without deflation one takes a shift from outside, which breaks cycles.
pub(super) const EXCEPTION: usize = 10;
