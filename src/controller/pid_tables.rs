//! Tables of a sampled plant's response for a PID search: in r = x + jy an isotropic plane has the responses a ± jb forwards
//! and backwards (a: x→x, b: x→y), each with two loops. The lines are packed round every open-loop mode (64 within ±8 %).

use crate::linalg::{Mat, c64};
use crate::lti::structure;
use crate::lti::{Discrete, FrequencyGrid, FrequencyResponder, StateSpace, TimeBase};
use std::f64::consts::TAU;

/// The two loops at one line: g₁₁, g₂₂, g₁₂·g₂₁ and det G = g₁₁g₂₂ − g₁₂g₂₁ (front 1, rear 2).
pub(super) type Loops = [c64; 4];
/// What performance needs besides: g₁₂, g₂₁, g₁ₜ, g₂ₜ, gₜ₁, gₜ₂, gₜₜ (t: force and displacement at the tool).
pub(super) type Ports = [c64; 7];

/// One direction of whirl of one plant over the lines; `ports` is empty where only stability counts.
pub(super) struct Table {
    pub(super) loops: Vec<Loops>,
    pub(super) ports: Vec<Ports>,
}

/// One plant: one table at standstill, two (forwards, backwards) at speed.
pub(super) struct Scenario {
    pub(super) tables: Vec<Table>,
}

/// Lines: 4 % steps from 1 Hz to 30 Hz, 1.2 % steps to Nyquist, and f/400 within ±8 % of every mode.
pub(super) fn lines(modes_rad_s: &[f64], nyquist: f64) -> Vec<f64> {
    let last = nyquist * 0.9999;
    let steps = |from: f64, to: f64, ratio: f64| {
        let count = ((to / from).ln() / ratio).ceil().max(2.0) as usize;
        (0..=count).map(move |k| from * ((to / from).ln() * k as f64 / count as f64).exp())
    };
    let knee = (TAU * 30.0).min(0.5 * last);
    let base = steps(TAU.min(0.5 * knee), knee, 0.04).chain(steps(knee, last, 0.012));
    let packed = modes_rad_s
        .iter()
        .flat_map(|mode| (-32..=32).map(move |k| mode * (1.0 + f64::from(k) / 400.0)))
        .filter(|w| *w < last);
    FrequencyGrid::from_rad_s(base.chain(packed))
        .omega_rad_s()
        .to_vec()
}

/// Tables of a sampled plant over the lines.
pub(super) fn scenario(
    plant: &StateSpace<Discrete>,
    omega: &[f64],
    rotating: bool,
    nominal: bool,
) -> Scenario {
    // Outputs x then y of front, rear sensor and tool; inputs x of front, rear current and tool force.
    let responder = FrequencyResponder::new(&plant.select(&[0, 2, 4, 1, 3, 5], &[0, 2, 4]));
    let responses: Vec<Mat<c64>> = omega
        .iter()
        .map(|w| responder.transfer(plant.time.point(*w)))
        .collect();
    let j = c64::new(0.0, 1.0);
    let table = |sign: f64| {
        let at = |h: &Mat<c64>, row: usize, column: usize| {
            h[(row, column)] + j * sign * h[(row + 3, column)]
        };
        Table {
            loops: responses
                .iter()
                .map(|h| {
                    let cross = at(h, 0, 1) * at(h, 1, 0);
                    let (g11, g22) = (at(h, 0, 0), at(h, 1, 1));
                    [g11, g22, cross, g11 * g22 - cross]
                })
                .collect(),
            ports: responses
                .iter()
                .filter(|_| nominal)
                .map(|h| {
                    [(0, 1), (1, 0), (0, 2), (1, 2), (2, 0), (2, 1), (2, 2)]
                        .map(|(row, column)| at(h, row, column))
                })
                .collect(),
        }
    };
    Scenario {
        tables: if rotating {
            vec![table(1.0), table(-1.0)]
        } else {
            vec![table(0.0)]
        },
    }
}

/// Currents front_x, rear_x to signals front_x, rear_x, without the states of the other plane.
pub(super) fn x_plane(plant: &StateSpace<Discrete>) -> StateSpace<Discrete> {
    reachable(&plant.select(&[0, 2], &[0, 2]))
}

/// The system without states that the pattern of A and B never reaches.
pub(super) fn reachable(system: &StateSpace<Discrete>) -> StateSpace<Discrete> {
    let inputs: Vec<usize> = (0..system.inputs()).collect();
    let driven = structure::driven(system, &inputs);
    system.keep_states(|i| driven[i])
}
