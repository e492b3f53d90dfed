//! Hessenberg form, real or complex, and what an iteration on it takes as zero.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::hessenberg::{
    HessenbergParams, hessenberg_in_place, hessenberg_in_place_scratch,
};
use faer::traits::ComplexField;
use faer::{Auto, Mat, Par, Spec};

/// The Hessenberg form of a matrix; what is below its subdiagonal is left over from the reflections.
pub(super) fn hessenberg_form<T: ComplexField>(mut a: Mat<T>) -> Mat<T> {
    let n = a.nrows();
    if n > 1 {
        let params: Spec<HessenbergParams, T> = Spec::new(<_ as Auto<T>>::auto());
        // One reflection at a time.
        let mut reflections = Mat::<T>::zeros(1, n - 1);
        let scratch = hessenberg_in_place_scratch::<T>(n, 1, Par::Seq, params);
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        hessenberg_in_place(a.as_mut(), reflections.as_mut(), Par::Seq, stack, params);
    }
    a
}

/// Sizes of the entries round a place of the subdiagonal.
pub(super) struct Corner {
    /// Of the entry of the subdiagonal, and of its mirror above the diagonal.
    pub below: f64,
    pub above: f64,
    /// Of the diagonal entries before and after it, and of their difference.
    pub before: f64,
    pub after: f64,
    pub apart: f64,
}

impl Corner {
    /// True where the entry of the subdiagonal is zero to rounding (Ahues and Tisseur 1997), in a matrix of norm one.
    pub(super) fn is_negligible(&self) -> bool {
        let Self {
            below,
            above,
            before,
            after,
            apart,
        } = *self;
        if below < f64::MIN_POSITIVE / f64::EPSILON {
            return true;
        }
        below <= f64::EPSILON * (before + after) && {
            let (larger, smaller) = (after.max(apart), after.min(apart));
            let (most, least) = (below.max(above), below.min(above));
            let scale = larger + most;
            least * (most / scale) <= f64::EPSILON * (smaller * (larger / scale))
        }
    }
}

/// Power of two near a norm, by which a matrix is divided so that products of its entries stay in range.
pub(super) fn unit_of(norm: f64) -> f64 {
    match norm > 0.0 {
        true => norm.log2().round().exp2(),
        false => 1.0,
    }
}

/// Steps for one eigenvalue at most; two or three are usual.
pub(super) const MOST_STEPS: usize = 300;
/// After so many steps without deflation one takes a shift from outside, which breaks cycles.
pub(super) const EXCEPTION: usize = 10;
