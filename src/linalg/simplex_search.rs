//! Descent of a simplex (Nelder and Mead 1965, The Computer Journal 7, 308): the worst vertex is reflected at the
//! centre of the others, expanded or contracted, or all of them shrink to the best.

/// Steps of the worst vertex from the centre of the others, in its own distances from there.
const REFLECTED: f64 = -1.0;
const EXPANDED: f64 = 2.0;
const CONTRACTED: f64 = 0.5;
/// Distances from the best vertex after a shrink, in those before.
const SHRUNK: f64 = 0.5;

/// Where a simplex has come to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SimplexEnd {
    /// The best vertex.
    pub point: Vec<f64>,
    pub value: f64,
    pub steps: usize,
}

/// A vertex with its value.
type Vertex = (Vec<f64>, f64);

/// Moves a simplex until its values agree to rounding, `most_steps` times at most; none for a simplex of fewer than
/// two vertices. A value that is no number counts as infinite.
pub(crate) fn descend_simplex(
    vertices: Vec<Vec<f64>>,
    most_steps: usize,
    value: impl Fn(&[f64]) -> f64,
) -> Option<SimplexEnd> {
    let judge = |x: Vec<f64>| -> Vertex {
        let found = value(&x);
        (x, if found.is_nan() { f64::INFINITY } else { found })
    };
    let mut simplex: Vec<Vertex> = vertices.into_iter().map(judge).collect();
    let order = |simplex: &mut Vec<Vertex>| simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    order(&mut simplex);
    let last = simplex.len().checked_sub(1).filter(|last| *last > 0)?;
    let mut steps = 0;
    // Values that differ by less than this are equal to rounding.
    let agree = |simplex: &[Vertex]| spread(simplex) < f64::EPSILON;
    while steps < most_steps && !agree(&simplex) {
        let centre = centre(&simplex[..last]);
        let worst = simplex[last].1;
        let reflected = judge(move_from(&centre, &simplex[last].0, REFLECTED));
        let better = if reflected.1 < simplex[0].1 {
            let expanded = judge(move_from(&centre, &reflected.0, EXPANDED));
            Some(if expanded.1 < reflected.1 { expanded } else { reflected })
        } else if reflected.1 < simplex[last - 1].1 {
            Some(reflected)
        } else if reflected.1 < worst {
            let contracted = judge(move_from(&centre, &reflected.0, CONTRACTED));
            (contracted.1 <= reflected.1).then_some(contracted)
        } else {
            let contracted = judge(move_from(&centre, &simplex[last].0, CONTRACTED));
            (contracted.1 < worst).then_some(contracted)
        };
        match better {
            Some(vertex) => simplex[last] = vertex,
            None => {
                let best = simplex[0].0.clone();
                for vertex in &mut simplex[1..] {
                    *vertex = judge(move_from(&best, &vertex.0, SHRUNK));
                }
            }
        }
        order(&mut simplex);
        steps += 1;
    }
    let (point, value) = simplex.swap_remove(0);
    Some(SimplexEnd { point, value, steps })
}

/// from + (to − from)·by.
fn move_from(from: &[f64], to: &[f64], by: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + (b - a) * by).collect()
}

fn centre(vertices: &[Vertex]) -> Vec<f64> {
    let share = 1.0 / vertices.len() as f64;
    (0..vertices[0].0.len()).map(|i| vertices.iter().map(|v| v.0[i]).sum::<f64>() * share).collect()
}

/// Standard deviation of the values.
fn spread(simplex: &[Vertex]) -> f64 {
    let n = simplex.len() as f64;
    let mean = simplex.iter().map(|v| v.1).sum::<f64>() / n;
    (1.0 / (n - 1.0) * simplex.iter().map(|v| (v.1 - mean).powi(2)).sum::<f64>()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::descend_simplex;

    #[test]
    fn the_minima_of_published_functions_are_found() {
        // Rosenbrock's valley from (-1.2, 1), minimum 0 at (1, 1); Himmelblau's from the origin, minimum 0 at (3, 2).
        let valley = |x: &[f64]| 100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2);
        let himmelblau = |x: &[f64]| (x[0] * x[0] + x[1] - 11.0).powi(2) + (x[0] + x[1] * x[1] - 7.0).powi(2);
        let from = |x: f64, y: f64| vec![vec![x, y], vec![x + 0.5, y], vec![x, y + 0.5]];
        let found = descend_simplex(from(-1.2, 1.0), 500, valley).expect("three vertices");
        assert!(found.value < 1e-14 && (found.point[0] - 1.0).abs() < 1e-6, "{found:?}");
        let found = descend_simplex(from(0.0, 0.0), 500, himmelblau).expect("three vertices");
        assert!(found.value < 1e-14 && (found.point[0] - 3.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn what_is_no_number_is_never_the_end() {
        let undefined_left = |x: &[f64]| if x[0] < 0.0 { f64::NAN } else { (x[0] - 0.1).powi(2) };
        let found = descend_simplex(vec![vec![-1.0], vec![2.0]], 200, undefined_left).expect("three vertices");
        assert!((found.point[0] - 0.1).abs() < 1e-6 && found.steps < 200, "{found:?}");
        assert_eq!(descend_simplex(vec![vec![1.0]], 9, |x| x[0]), None);
    }
}
