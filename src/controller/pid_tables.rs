//! Tables of a sampled plant's response for a PID search: in r = x + jy an isotropic plane has the responses a ± jb forwards
//! and backwards (a: x→x, b: x→y), each with two loops. The lines are packed round every open-loop mode (64 within ±8 %).

use crate::linalg::{Mat, c64};
use crate::lti::held::hold_magnitude;
use crate::lti::structure;
use crate::lti::{Discrete, FrequencyGrid, FrequencyResponder, Response, StateSpace, TimeBase};
use crate::spindle::Plant;
use rayon::prelude::*;
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

/// Tables of a sampled plant over the lines: the loops sampled, which is what stability is about. With `continuous`, the
/// same plant before sampling, also what performance needs: the tool's force and displacement are not held, a current
/// reaches the tool with the magnitude of the hold.
pub(super) fn scenario(
    plant: &StateSpace<Discrete>,
    omega: &[f64],
    rotating: bool,
    continuous: Option<&Plant>,
) -> Scenario {
    // Outputs x then y of front and rear sensor; inputs x of front and rear current.
    let responder = FrequencyResponder::new(&plant.select(&[0, 2, 1, 3], &[0, 2]));
    let responses: Vec<Mat<c64>> = omega
        .iter()
        .map(|w| responder.transfer(plant.time.point(*w)))
        .collect();
    let whole: Vec<Mat<c64>> =
        continuous.map_or_else(Vec::new, |p| omega.par_iter().map(|w| p.at(*w)).collect());
    let j = c64::new(0.0, 1.0);
    let table = |sign: f64| {
        // Forwards or backwards whirl of a pair of responses x→x, x→y.
        let whirl = |h: &Mat<c64>, x: usize, y: usize, column: usize| {
            h[(x, column)] + j * sign * h[(y, column)]
        };
        Table {
            loops: responses
                .iter()
                .map(|h| {
                    let at = |row: usize, column: usize| whirl(h, row, row + 2, column);
                    let cross = at(0, 1) * at(1, 0);
                    let (g11, g22) = (at(0, 0), at(1, 1));
                    [g11, g22, cross, g11 * g22 - cross]
                })
                .collect(),
            ports: responses
                .iter()
                .zip(&whole)
                .zip(omega)
                .map(|((h, full), w)| {
                    let hold = hold_magnitude(*w, plant.time.period_s);
                    let own = |row: usize, column: usize| whirl(h, row, row + 2, column);
                    let at = |row: usize, column: usize| whirl(full, row, row + 1, column);
                    // Channels of the plant: front 0, rear 2, tool 4, x each.
                    [
                        own(0, 1),
                        own(1, 0),
                        at(0, 4),
                        at(2, 4),
                        at(4, 0) * hold,
                        at(4, 2) * hold,
                        at(4, 4),
                    ]
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
