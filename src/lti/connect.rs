//! Connections of systems on one time base. Feedback is positive: u = K y closes as the lower LFT.
//! Symbols: P = [[P11, P12], [P21, P22]] with inputs (w, u) and outputs (z, y).

use super::state_space::{Discrete, StateSpace, TimeBase};
use crate::linalg::{Mat, NumericError, solve};

/// Block matrix [[a, b], [c, d]]; shapes must fit.
pub fn block2(a: &Mat<f64>, b: &Mat<f64>, c: &Mat<f64>, d: &Mat<f64>) -> Mat<f64> {
    let (r, s) = (a.nrows(), a.ncols());
    Mat::from_fn(r + c.nrows(), s + b.ncols(), |i, j| match (i < r, j < s) {
        (true, true) => a[(i, j)],
        (true, false) => b[(i, j - s)],
        (false, true) => c[(i - r, j)],
        (false, false) => d[(i - r, j - s)],
    })
}

/// Series connection: `second` after `first`, transfer second·first.
///
/// # Errors
/// [`NumericError::Dimension`] when the channel counts differ.
pub fn series<T: TimeBase>(first: &StateSpace<T>, second: &StateSpace<T>) -> Result<StateSpace<T>, NumericError> {
    check(first.outputs(), second.inputs(), "series connection")?;
    let zero = Mat::zeros(first.order(), second.order());
    let a = block2(&first.a, &zero, &(&second.b * &first.c), &second.a);
    let b2 = &second.b * &first.d;
    let b = stack_rows(&first.b, &b2);
    let c = stack_cols(&(&second.d * &first.c), &second.c);
    StateSpace::new(a, b, c, &second.d * &first.d, first.time)
}

/// Block-diagonal connection of independent systems: inputs and outputs are concatenated.
pub fn append<T: TimeBase>(first: &StateSpace<T>, second: &StateSpace<T>) -> StateSpace<T> {
    let diag =
        |x: &Mat<f64>, y: &Mat<f64>| block2(x, &Mat::zeros(x.nrows(), y.ncols()), &Mat::zeros(y.nrows(), x.ncols()), y);
    StateSpace {
        a: diag(&first.a, &second.a),
        b: diag(&first.b, &second.b),
        c: diag(&first.c, &second.c),
        d: diag(&first.d, &second.d),
        time: first.time,
    }
}

/// Two equal systems of one plane (channels front, rear) as one with the channels front_x, front_y, rear_x, rear_y.
pub fn both_planes<T: TimeBase>(plane: &StateSpace<T>) -> StateSpace<T> {
    // Of front_x, rear_x, front_y, rear_y.
    let order = [0, 2, 1, 3];
    append(plane, plane).select(&order, &order)
}

/// Sum of two systems with equal channel counts.
///
/// # Errors
/// [`NumericError::Dimension`] when the channel counts differ.
pub fn add<T: TimeBase>(first: &StateSpace<T>, second: &StateSpace<T>) -> Result<StateSpace<T>, NumericError> {
    check(first.outputs(), second.outputs(), "parallel connection")?;
    check(first.inputs(), second.inputs(), "parallel connection")?;
    let both = append(first, second);
    StateSpace::new(
        both.a,
        stack_rows(&first.b, &second.b),
        stack_cols(&first.c, &second.c),
        &first.d + &second.d,
        first.time,
    )
}

/// Lower linear fractional transformation F_l(P, K): closes the last channels of P with u = K y.
/// Handles D22 ≠ 0; state order is that of P followed by that of K.
///
/// # Errors
/// [`NumericError::Dimension`] when P has too few channels, [`NumericError::IllPosed`] when I − D22·D_K is singular.
pub fn lower_lft<T: TimeBase>(
    plant: &StateSpace<T>,
    controller: &StateSpace<T>,
) -> Result<StateSpace<T>, NumericError> {
    let (nu, ny) = (controller.outputs(), controller.inputs());
    if plant.inputs() < nu || plant.outputs() < ny {
        return Err(NumericError::Dimension {
            what: "lower linear fractional transformation",
            expected: format!("a plant with at least {nu} inputs and {ny} outputs"),
            found: format!("{} inputs and {} outputs", plant.inputs(), plant.outputs()),
        });
    }
    let (nw, nz) = (plant.inputs() - nu, plant.outputs() - ny);
    let (n, k) = (plant.order(), controller.order());
    let part = |m: &Mat<f64>, r0, c0, r, c| m.submatrix(r0, c0, r, c).to_owned();
    let (b1, b2) = (part(&plant.b, 0, 0, n, nw), part(&plant.b, 0, nw, n, nu));
    let (c1, c2) = (part(&plant.c, 0, 0, nz, n), part(&plant.c, nz, 0, ny, n));
    let d11 = part(&plant.d, 0, 0, nz, nw);
    let d12 = part(&plant.d, 0, nw, nz, nu);
    let d21 = part(&plant.d, nz, 0, ny, nw);
    let d22 = part(&plant.d, nz, nw, ny, nu);
    // y = (I − D22 DK)⁻¹ (C2 x + D22 CK xk + D21 w)
    let loop_matrix = Mat::<f64>::identity(ny, ny) - &d22 * &controller.d;
    let right = stack_cols(&stack_cols(&c2, &(&d22 * &controller.c)), &d21);
    let y = solve(&loop_matrix, &right)
        .map_err(|_| NumericError::IllPosed { what: "I − D22·D_K of the feedback loop" })?;
    let (yx, yk, yw) = (part(&y, 0, 0, ny, n), part(&y, 0, n, ny, k), part(&y, 0, n + k, ny, nw));
    let (ux, uk, uw) = (&controller.d * &yx, &controller.c + &controller.d * &yk, &controller.d * &yw);
    let a =
        block2(&(&plant.a + &b2 * &ux), &(&b2 * &uk), &(&controller.b * &yx), &(&controller.a + &controller.b * &yk));
    let b = stack_rows(&(&b1 + &b2 * &uw), &(&controller.b * &yw));
    let c = stack_cols(&(&c1 + &d12 * &ux), &(&d12 * &uk));
    StateSpace::new(a, b, c, &d11 + &d12 * &uw, plant.time)
}

/// Refuses a controller that is not sampled as the plant is.
pub(crate) fn check_sample_times(
    plant: &StateSpace<Discrete>,
    controller: &StateSpace<Discrete>,
) -> Result<(), NumericError> {
    let (ts, tk) = (plant.time.period_s, controller.time.period_s);
    // Sample times are the same number read from the same file; only rounding of a decimal is forgiven.
    if (ts - tk).abs() > 1e-12 * ts {
        return Err(NumericError::Dimension {
            what: "sampled closed loop",
            expected: format!("a controller with the plant's sample time {ts:e} s"),
            found: format!("{tk:e} s"),
        });
    }
    Ok(())
}

/// [a; b].
pub(crate) fn stack_rows(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let r = a.nrows();
    Mat::from_fn(r + b.nrows(), a.ncols(), |i, j| if i < r { a[(i, j)] } else { b[(i - r, j)] })
}

/// [a, b].
pub(crate) fn stack_cols(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let s = a.ncols();
    Mat::from_fn(a.nrows(), s + b.ncols(), |i, j| if j < s { a[(i, j)] } else { b[(i, j - s)] })
}

fn check(expected: usize, found: usize, what: &'static str) -> Result<(), NumericError> {
    if expected == found {
        return Ok(());
    }
    Err(NumericError::Dimension { what, expected: format!("{expected} channels"), found: format!("{found} channels") })
}
