//! Which states inputs drive and outputs see, from the pattern of zeros.

use super::{StateSpace, TimeBase};
use crate::linalg::equal_planes::EqualPlanes;

/// States that the listed inputs drive, directly or through others.
pub(crate) fn driven_states<T: TimeBase>(system: &StateSpace<T>, inputs: &[usize]) -> Vec<bool> {
    let start = |i: usize| inputs.iter().any(|j| system.b[(i, *j)] != 0.0);
    spread(system.order(), start, |to, from| system.a[(to, from)] != 0.0)
}

/// States that the listed outputs see, directly or through others.
pub(crate) fn observed_states<T: TimeBase>(system: &StateSpace<T>, outputs: &[usize]) -> Vec<bool> {
    let start = |j: usize| outputs.iter().any(|i| system.c[(*i, j)] != 0.0);
    spread(system.order(), start, |to, from| system.a[(from, to)] != 0.0)
}

/// The planes of the states of a law whose channels alternate between x and y; none when it joins the planes.
pub(crate) fn planes_apart<T: TimeBase>(law: &StateSpace<T>) -> Option<EqualPlanes> {
    let of_plane = |plane: usize| driven_states(law, &(plane..law.inputs()).step_by(2).collect::<Vec<_>>());
    let [x, y] = [0, 1].map(of_plane);
    let apart = x.iter().zip(&y).all(|(x, y)| x != y);
    apart.then(|| EqualPlanes::of(&y)).flatten()
}

fn spread(n: usize, start: impl Fn(usize) -> bool, edge: impl Fn(usize, usize) -> bool) -> Vec<bool> {
    let mut reached: Vec<bool> = (0..n).map(start).collect();
    let mut front: Vec<usize> = (0..n).filter(|i| reached[*i]).collect();
    while let Some(from) = front.pop() {
        for to in 0..n {
            if !reached[to] && edge(to, from) {
                reached[to] = true;
                front.push(to);
            }
        }
    }
    reached
}
