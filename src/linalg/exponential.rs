//! Matrix exponential on balanced data. Parts that do not act on each other, the planes of a machine at rest for
//! instance, are taken one by one, and two equal planes of a machine that turns as one complex matrix.

use super::dense::balance;
use super::equal_planes::EqualPlanes;
use super::error::NumericError;
use super::pade::exponentials_of_balanced;
use faer::Mat;

/// exp(A) of a square matrix.
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data or a result that overflows.
pub fn exponential(a: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let [e] = exponentials(a, [1.0], None)?;
    Ok(e)
}

/// exp(tA) of a square matrix at some times t ≥ 0; `planes` are those of its coordinates, where two planes may be
/// equal.
pub(crate) fn exponentials<const K: usize>(
    a: &Mat<f64>,
    times: [f64; K],
    planes: Option<&EqualPlanes>,
) -> Result<[Mat<f64>; K], NumericError> {
    let not_finite = Err(NumericError::NotFinite { what: "matrix exponential" });
    if !a.is_all_finite() {
        return not_finite;
    }
    let turning = planes.and_then(|planes| planes.exponentials(a, times));
    let result = turning.unwrap_or_else(|| by_parts(a, times));
    if result.iter().all(Mat::is_all_finite) { Ok(result) } else { not_finite }
}

fn by_parts<const K: usize>(a: &Mat<f64>, times: [f64; K]) -> [Mat<f64>; K] {
    let n = a.nrows();
    let mut result = times.map(|_| Mat::zeros(n, n));
    let mut last: Option<(Mat<f64>, [Mat<f64>; K])> = None;
    for part in separate_parts(a) {
        let size = part.len();
        let own = Mat::from_fn(size, size, |i, j| a[(part[i], part[j])]);
        // Two planes that do the same at rest have the same exponential.
        let list = match last.take() {
            Some((same, list)) if same == own => list,
            _ => of_one_part(&own, times),
        };
        for (result, e) in result.iter_mut().zip(&list) {
            for i in 0..size {
                for j in 0..size {
                    result[(part[i], part[j])] = e[(i, j)];
                }
            }
        }
        last = Some((own, list));
    }
    result
}

fn of_one_part<const K: usize>(a: &Mat<f64>, times: [f64; K]) -> [Mat<f64>; K] {
    let n = a.nrows();
    let (balanced, scale) = balance(a);
    let list = exponentials_of_balanced(&balanced, times);
    list.map(|e| Mat::from_fn(n, n, |i, j| e[(i, j)] * scale[i] / scale[j]))
}

/// Coordinates that act on each other, directly or through others, in ascending order.
fn separate_parts(a: &Mat<f64>) -> Vec<Vec<usize>> {
    let n = a.nrows();
    let joined = |i: usize, j: usize| a[(i, j)] != 0.0 || a[(j, i)] != 0.0;
    let mut parts: Vec<Vec<usize>> = vec![];
    let mut free: Vec<usize> = (0..n).collect();
    while let Some(first) = free.first().copied() {
        free.remove(0);
        let mut part = vec![first];
        let mut seen = 0;
        while let Some(own) = part.get(seen).copied() {
            let (with, without) = free.into_iter().partition(|other| joined(own, *other));
            part.extend::<Vec<usize>>(with);
            free = without;
            seen += 1;
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_that_do_not_act_on_each_other_are_apart() {
        // 0 acts on 3, 3 on 4; 1 and 2 are alone with themselves.
        let mut a = Mat::<f64>::zeros(5, 5);
        (a[(3, 0)], a[(4, 3)], a[(1, 1)]) = (2.0, 3.0, 0.5);
        assert_eq!(separate_parts(&a), [vec![0, 3, 4], vec![1], vec![2]]);
        let e = exponential(&a).expect("finite");
        // exp of the nilpotent part is its series.
        let expected = [((3, 0), 2.0), ((4, 3), 3.0), ((4, 0), 3.0), ((1, 1), 0.5f64.exp())];
        for (at, value) in expected {
            assert!((e[at] - value).abs() < 1e-14, "{at:?} {}", e[at]);
        }
        assert_eq!((e[(0, 3)], e[(2, 1)], e[(1, 4)]), (0.0, 0.0, 0.0));
    }
}
