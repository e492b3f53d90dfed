//! Diagonal state scaling that evens out the rows of [A B] and the columns of [A; C], or of A alone (powers of two, so
//! exact).

use super::state_space::{StateSpace, TimeBase};
use crate::linalg::Mat;
use crate::linalg::balance::balance_scales;

/// The norm of A may exceed what scaling by A alone leaves by this factor: three of sixteen digits. A companion form
/// of a fast system exceeds it by tens of decades, where the sizes of B and C say nothing of the states.
const LARGEST_EXCESS: f64 = 1e3;
/// Rounds of sweeps on A alone; companion forms of order 26 settle in the first.
const ROUNDS: usize = 10;

/// Diagonal T for x = T x̃ such that row i of [T⁻¹AT, T⁻¹B] and column i of [T⁻¹AT; CT] have like norms; those of A
/// alone where B and C would spoil it. States that nothing drives or nothing reads keep their scale.
pub(crate) fn balancing<T: TimeBase>(system: &StateSpace<T>) -> Vec<f64> {
    let all = evening_of_all(system);
    let own = evening_of_dynamics(&scale_dense(&system.a, &all));
    if is_excessive(&scale_dense(&system.a, &all), &own) { with_own(system, &all, &own) } else { all }
}

/// The same with A first and last: B and C decide only where A leaves the scale of a state open. For what needs the
/// poles of A to full precision.
pub(crate) fn balancing_of_dynamics<T: TimeBase>(system: &StateSpace<T>) -> Vec<f64> {
    let all = evening_of_all(system);
    with_own(system, &all, &evening_of_dynamics(&scale_dense(&system.a, &all)))
}

/// Diagonal T for x = T x̃ that evens out rows and columns of A, where A is much larger without it; else nothing.
pub(crate) fn dynamics_scale(a: &Mat<f64>) -> Option<Vec<f64>> {
    let own = evening_of_dynamics(a);
    is_excessive(a, &own).then_some(own)
}

fn is_excessive(a: &Mat<f64>, scale: &[f64]) -> bool {
    a.norm_l2() > LARGEST_EXCESS * scale_dense(a, scale).norm_l2()
}

/// Both scalings one after the other, and one factor for all states, which leaves A as it is and brings B and C to one
/// size.
fn with_own<T: TimeBase>(system: &StateSpace<T>, all: &[f64], own: &[f64]) -> Vec<f64> {
    let scale: Vec<f64> = all.iter().zip(own).map(|(all, own)| all * own).collect();
    let even = system.scale_states(&scale);
    let factor = (0.5 * (even.b.norm_l2().log2() - even.c.norm_l2().log2())).round().exp2();
    let factor = if factor.is_normal() { factor } else { 1.0 };
    scale.iter().map(|t| factor * t).collect()
}

/// The scaling by A alone.
fn evening_of_dynamics(a: &Mat<f64>) -> Vec<f64> {
    let n = a.nrows();
    let mut scale = vec![1.0; n];
    for _ in 0..ROUNDS {
        let current = scale_dense(a, &scale);
        let step = balance_scales(n, |t, i| {
            let others = (0..n).filter(|j| *j != i);
            others.fold((0.0, 0.0), |(row, column), j| {
                let (from, to) = (current[(i, j)] * t[j] / t[i], current[(j, i)] * t[i] / t[j]);
                (row + from * from, column + to * to)
            })
        });
        scale.iter_mut().zip(&step).for_each(|(t, step)| *t *= step);
        if step.iter().all(|step| *step == 1.0) {
            break;
        }
    }
    scale
}

fn scale_dense(a: &Mat<f64>, scale: &[f64]) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * scale[j] / scale[i])
}

/// The scaling by A, B and C together.
fn evening_of_all<T: TimeBase>(system: &StateSpace<T>) -> Vec<f64> {
    let n = system.order();
    let b: Vec<f64> = (0..n).map(|i| (0..system.inputs()).map(|j| system.b[(i, j)].powi(2)).sum()).collect();
    let c: Vec<f64> = (0..n).map(|j| (0..system.outputs()).map(|i| system.c[(i, j)].powi(2)).sum()).collect();
    balance_scales(n, |t, i| {
        let (mut row, mut col) = (b[i] / t[i].powi(2), c[i] * t[i].powi(2));
        for j in 0..n {
            if i != j {
                row += (system.a[(i, j)] * t[j] / t[i]).powi(2);
                col += (system.a[(j, i)] * t[i] / t[j]).powi(2);
            }
        }
        (row, col)
    })
}
