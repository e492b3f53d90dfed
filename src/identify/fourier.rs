//! Discrete Fourier transform of any length: Σ x_n exp(−2πj nk/N), split along the prime factors of N (Cooley and
//! Tukey, Math. Comp. 19, 1965).

use crate::linalg::c64;
use std::f64::consts::TAU;

/// The transform, one value for k from 0 to N − 1. Its time grows with the sum of the prime factors of N.
pub(super) fn fourier(x: &[c64]) -> Vec<c64> {
    let n = x.len();
    let roots: Vec<c64> = (0..n).map(|k| c64::from_polar(1.0, -TAU * k as f64 / n as f64)).collect();
    part(x, 0, 1, &roots)
}

/// Transform of every `stride`-th value from `start` on.
fn part(x: &[c64], start: usize, stride: usize, roots: &[c64]) -> Vec<c64> {
    let n = x.len() / stride;
    if n <= 1 {
        return x.get(start).copied().into_iter().collect();
    }
    let factor = smallest_factor(n);
    let parts: Vec<Vec<c64>> = (0..factor).map(|r| part(x, start + r * stride, stride * factor, roots)).collect();
    let value = |k: usize| {
        let each = parts.iter().enumerate();
        each.map(|(r, own)| own[k % own.len()] * roots[r * k % n * stride]).sum::<c64>()
    };
    (0..n).map(value).collect()
}

fn smallest_factor(n: usize) -> usize {
    (2..).take_while(|p| p * p <= n).find(|p| n.is_multiple_of(*p)).unwrap_or(n)
}

/// The largest length up to `most` without prime factors above seven.
pub(super) fn smooth_length(most: usize) -> usize {
    (1..=most).rev().find(|n| largest_factor(*n) <= 7).unwrap_or(0)
}

/// Largest prime factor, 1 of 1.
pub(super) fn largest_factor(mut n: usize) -> usize {
    let mut largest = 1;
    while n > 1 {
        largest = largest.max(smallest_factor(n));
        n /= smallest_factor(n);
    }
    largest
}
