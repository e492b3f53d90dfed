//! Exponential of a balanced matrix, real or complex: Padé approximation with scaling and squaring (Higham, The scaling
//! and squaring method for the matrix exponential revisited, SIAM J. Matrix Anal. Appl. 26, 2005).

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::traits::ComplexField;
use faer::{Accum, Mat, Par, c64};
use std::ops::{Add, Mul};

/// Entries of a matrix whose exponential is asked for.
pub(super) trait PadeEntry:
    ComplexField + Copy + Into<c64> + Add<Output = Self> + Mul<f64, Output = Self> + From<f64>
{
}
impl PadeEntry for f64 {}
impl PadeEntry for c64 {}

/// Coefficients of the Padé approximant of degree 13, b₀ … b₁₃ (Higham 2005, section 2).
const PADE: [f64; 14] = [
    64_764_752_532_480_000.0,
    32_382_376_266_240_000.0,
    7_771_770_303_897_600.0,
    1_187_353_796_428_800.0,
    129_060_195_264_000.0,
    10_559_470_521_600.0,
    670_442_572_800.0,
    33_522_128_640.0,
    1_323_241_920.0,
    40_840_800.0,
    960_960.0,
    16_380.0,
    182.0,
    1.0,
];
/// Largest size at which that approximant is exact to rounding (Higham 2005, table 2.3).
const LARGEST: f64 = 5.371_920_351_148_152;
/// Inverse of the first coefficient of its backward error, C(26, 13) · 27! (Al-Mohy and Higham 2009).
const BACKWARD_ERROR: f64 = 10_400_600.0 * 1.088_886_945_041_835_2e28;
/// Largest number of squarings: what needs more overflows.
const MOST_SQUARINGS: i32 = 1100;
/// By how much, in powers of two, the powers of a matrix may show it smaller than its norm does: their entries do not
/// underflow then.
const MOST_SPARED: i32 = 40;

/// exp(tA) of a balanced square matrix at some times t ≥ 0, which share the powers of A. Entries that overflow are not
/// finite.
pub(super) fn exponentials_of_balanced<T: PadeEntry, const K: usize>(a: &Mat<T>, times: [f64; K]) -> [Mat<T>; K] {
    let n = a.nrows();
    let longest = times.into_iter().fold(0.0, f64::max);
    // Powers of what the longest time needs by the norm, so that none overflows where its exponential does not.
    let halvings = squarings(longest * norm(a));
    let unit = longest * 0.5f64.powi(halvings);
    let first = Mat::from_fn(n, n, |i, j| a[(i, j)] * unit);
    let second = product(&first, &first);
    let fourth = product(&second, &second);
    let sixth = product(&fourth, &second);
    let size = match halvings {
        0 => norm(&first),
        _ => size_by_powers(&fourth, &sixth).max(LARGEST * 0.5f64.powi(MOST_SPARED)),
    };
    let backward = norm_of_power(&first);
    times.map(|time| {
        // Where the unit underflows the result is not finite.
        let whole = if time > 0.0 { time / unit } else { 0.0 };
        let by_size = squarings(whole * size);
        let further = beyond_rounding(whole * 0.5f64.powi(by_size), backward);
        let squarings = by_size + further;
        let share = whole * 0.5f64.powi(squarings);
        let mut e = approximant(&first, [&second, &fourth, &sixth], share);
        for _ in 0..squarings {
            e = product(&e, &e);
        }
        e
    })
}

/// Halvings that bring a matrix of this size within reach of the approximant, and squarings that undo them.
fn squarings(size: f64) -> i32 {
    // Zero has no logarithm; of a size that is not finite the exponential is not either.
    let needed = (size / LARGEST).log2().ceil();
    (needed.max(0.0) as i32).min(MOST_SQUARINGS)
}

/// |Re z| + |Im z|, which no finite entry makes overflow; up to √2 above the modulus.
pub(super) fn size_of<T: PadeEntry>(entry: T) -> f64 {
    let z: c64 = entry.into();
    z.re.abs() + z.im.abs()
}

/// Largest sum of sizes of a column.
fn norm<T: PadeEntry>(a: &Mat<T>) -> f64 {
    let column = |j: usize| a.col(j).iter().map(|z| size_of(*z)).sum::<f64>();
    (0..a.ncols()).map(column).fold(0.0, f64::max)
}

/// Bound on a matrix in an even power series, from the norms of its sixth, eighth and tenth power: the norm of the
/// matrix itself may be far larger, and each squaring that it would ask for costs digits (Al-Mohy and Higham, A new
/// scaling and squaring algorithm for the matrix exponential, SIAM J. Matrix Anal. Appl. 31, 2009).
fn size_by_powers<T: PadeEntry>(fourth: &Mat<T>, sixth: &Mat<T>) -> f64 {
    let by_power = |power: &Mat<T>, degree: f64| norm(power).powf(degree.recip());
    let eighth = by_power(&product(fourth, fourth), 8.0);
    let tenth = by_power(&product(fourth, sixth), 10.0);
    by_power(sixth, 6.0).max(eighth).min(eighth.max(tenth))
}

/// ‖|A|²⁷‖/‖A‖, the size of the first term of the backward error.
fn norm_of_power<T: PadeEntry>(a: &Mat<T>) -> f64 {
    let n = a.nrows();
    let sizes = Mat::from_fn(n, n, |i, j| size_of(a[(i, j)]));
    let norm = norm(&sizes);
    let mut sums = vec![1.0; n];
    for _ in 0..27 {
        let column = |j: usize| sizes.col(j).iter().zip(&sums).map(|(a, b)| a * b).sum();
        sums = (0..n).map(column).collect();
    }
    if norm > 0.0 { sums.into_iter().fold(0.0, f64::max) / norm } else { 0.0 }
}

/// Squarings that bring the first term of the backward error of exp(cA) below rounding.
fn beyond_rounding(c: f64, norm_of_power: f64) -> i32 {
    let term = norm_of_power * c.powi(26) / BACKWARD_ERROR;
    let needed = ((term / (0.5 * f64::EPSILON)).log2() / 26.0).ceil();
    (needed.max(0.0) as i32).min(MOST_SQUARINGS)
}

/// The approximant of exp(cA) from A and A², A⁴, A⁶: (V − U)⁻¹(V + U) with the odd part U and the even part V.
fn approximant<T: PadeEntry>(a: &Mat<T>, [second, fourth, sixth]: [&Mat<T>; 3], c: f64) -> Mat<T> {
    let n = a.nrows();
    let [c2, c4, c6] = [c.powi(2), c.powi(4), c.powi(6)];
    // b₀ I + b₁ c²A² + b₂ c⁴A⁴ + b₃ c⁶A⁶.
    let sum = |[b0, b1, b2, b3]: [f64; 4]| {
        Mat::from_fn(n, n, |i, j| {
            let own = second[(i, j)] * (b1 * c2) + fourth[(i, j)] * (b2 * c4);
            let own = own + sixth[(i, j)] * (b3 * c6);
            if i == j { own + T::from(b0) } else { own }
        })
    };
    let half = |first: usize| {
        let [b0, b2, b4, b6, b8, b10, b12] = [0, 2, 4, 6, 8, 10, 12].map(|k| PADE[first + k]);
        let upper = product(sixth, &sum([0.0, b8, b10, b12]));
        let lower = sum([b0, b2, b4, b6]);
        Mat::from_fn(n, n, |i, j| upper[(i, j)] * c6 + lower[(i, j)])
    };
    let (odd, even) = (product(a, &half(1)), half(0));
    let side = |sign: f64| Mat::from_fn(n, n, |i, j| even[(i, j)] + odd[(i, j)] * (sign * c));
    side(-1.0).partial_piv_lu().solve(side(1.0))
}

fn product<T: PadeEntry>(a: &Mat<T>, b: &Mat<T>) -> Mat<T> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    matmul(&mut c, Accum::Replace, a, b, T::from(1.0), Par::Seq);
    c
}
