//! The loop from sample to sample: exponentials of the first-order form over the sample period and over the part of
//! it that the delay leaves, stored commands for the whole samples of delay.

use super::controller::Law;
use super::rotor::{BEARINGS, Rotor};
use faer::{Mat, c64};

/// Matrix of the closed loop from one sample to the next.
pub fn closed_loop(rotor: &Rotor, law: &Law, rpm: f64) -> Mat<c64> {
    // The number is written twice, as a rate and as a period.
    assert!((law.sample_time_s / rotor.period_s - 1.0).abs() < 1e-9, "sample times differ");
    let (a, b, c) = rotor.first_order(rpm);
    let (n, m, period) = (a.nrows(), BEARINGS, rotor.period_s);
    let lag = rotor.pure_delay_s() / period;
    let whole = (lag + 1e-9).floor();
    let part = (lag - whole).max(0.0);
    let part = if part < 1e-9 { 0.0 } else { part };
    // x after a span during which the command u is constant: Φ x + Γ u.
    let span = |t: f64| -> (Mat<c64>, Mat<c64>) {
        let mut wide = Mat::<c64>::zeros(n + m, n + m);
        wide.submatrix_mut(0, 0, n, n).copy_from(&a * faer::Scale(c64::new(t, 0.0)));
        wide.submatrix_mut(0, n, n, m).copy_from(&b * faer::Scale(c64::new(t, 0.0)));
        let e = exponential(&wide);
        (e.submatrix(0, 0, n, n).to_owned(), e.submatrix(0, n, n, m).to_owned())
    };
    let (early, gain_early) = span(part * period);
    let (late, gain_late) = span((1.0 - part) * period);
    let whole = whole as usize;
    let stored = whole + usize::from(part > 0.0);
    let order = law.a.nrows();
    let size = n + stored * m + order;
    let k0 = n + stored * m;
    let mut loop_matrix = Mat::<c64>::zeros(size, size);
    loop_matrix.submatrix_mut(0, 0, n, n).copy_from(&late * &early);
    // The command of `age` samples ago acts with this gain: the older one before the step, the younger one after it.
    let gains = [(whole, gain_late), (whole + 1, &late * &gain_early)];
    let command_of_state = &law.d * &c;
    for (age, gain) in gains {
        if age == 0 {
            add(&mut loop_matrix, (0, 0), &(&gain * &command_of_state));
            add(&mut loop_matrix, (0, k0), &(&gain * &law.c));
        } else if age <= stored {
            add(&mut loop_matrix, (0, n + (age - 1) * m), &gain);
        }
    }
    if stored > 0 {
        add(&mut loop_matrix, (n, 0), &command_of_state);
        add(&mut loop_matrix, (n, k0), &law.c);
    }
    let identity = Mat::<c64>::identity(m, m);
    for k in 1..stored {
        add(&mut loop_matrix, (n + k * m, n + (k - 1) * m), &identity);
    }
    add(&mut loop_matrix, (k0, 0), &(&law.b * &c));
    add(&mut loop_matrix, (k0, k0), &law.a);
    loop_matrix
}

fn add(to: &mut Mat<c64>, (row, column): (usize, usize), block: &Mat<c64>) {
    for i in 0..block.nrows() {
        for j in 0..block.ncols() {
            to[(row + i, column + j)] += block[(i, j)];
        }
    }
}

/// Eigenvalues of the loop, z plane.
pub fn poles(rotor: &Rotor, law: &Law, rpm: f64) -> Vec<c64> {
    closed_loop(rotor, law, rpm).eigenvalues().expect("eigenvalues of the loop")
}

/// Largest ln|z|/Ts of the poles, 1/s; negative when stable.
pub fn growth_rate_per_s(rotor: &Rotor, poles: &[c64]) -> f64 {
    let radius = poles.iter().map(|z| z.norm()).fold(0.0, f64::max);
    radius.ln() / rotor.period_s
}

/// e^A by scaling and squaring of its Taylor series.
pub fn exponential(a: &Mat<c64>) -> Mat<c64> {
    let n = a.nrows();
    let largest = (0..n).map(|i| (0..n).map(|j| a[(i, j)].norm()).sum::<f64>()).fold(0.0, f64::max);
    // Norm at most a half: the term after the last is below 0.5²⁰/20! = 4e-25.
    let squarings = (largest.max(0.5) / 0.5).log2().ceil() as i32;
    let scaled = a * faer::Scale(c64::new(0.5f64.powi(squarings), 0.0));
    let mut sum = Mat::<c64>::identity(n, n);
    for k in (1..20).rev() {
        sum = Mat::<c64>::identity(n, n) + &scaled * &sum * faer::Scale(c64::new(1.0 / f64::from(k), 0.0));
    }
    for _ in 0..squarings {
        sum = &sum * &sum;
    }
    sum
}
