//! Products that are added to a sum, in the fewest instructions that the processor has for them.

use super::c64;

/// a·b + c: rounded once where the program is built for a processor that does so in one instruction (the compiler may
/// not decide that), else with the product rounded as well.
#[inline(always)]
pub(crate) fn multiply_add(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { a.mul_add(b, c) } else { a * b + c }
}

/// a·b + c of complex numbers, as [`multiply_add`].
#[inline(always)]
pub(crate) fn fused_complex(a: c64, b: c64, c: c64) -> c64 {
    c64::new(
        multiply_add(a.re, b.re, multiply_add(-a.im, b.im, c.re)),
        multiply_add(a.re, b.im, multiply_add(a.im, b.re, c.im)),
    )
}

/// a·b of complex numbers, as [`multiply_add`].
#[inline(always)]
pub(crate) fn product(a: c64, b: c64) -> c64 {
    c64::new(multiply_add(a.re, b.re, -(a.im * b.im)), multiply_add(a.re, b.im, a.im * b.re))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fused_products_are_those_of_plain_arithmetic() {
        let z = |k: i32| c64::from_polar(1.5f64.powi(k), f64::from(3 * k + 1));
        for k in -4..5 {
            let (a, b, c) = (z(k), z(2 - k), z(k + 3));
            let size = (a * b).norm() + c.norm();
            assert!((fused_complex(a, b, c) - (a * b + c)).norm() < 1e-15 * size);
            assert!((product(a, b) - a * b).norm() < 1e-15 * size);
            assert!((multiply_add(a.re, b.re, c.re) - (a.re * b.re + c.re)).abs() < 1e-15 * size);
        }
    }
}
