//! μ of the whole machine on its exact frequency responses, at rest and over speed.
//!
//! The plant is the full finite-element model with the true gyroscopics; currents reach it through the hold, sinc(ωT/2) and
//! half a sample, and the rest of the delay; loads and modal forces act between the samples and are not held; the weights are
//! those written, at true frequency; the controller is the one that runs. Two equal planes that gyroscopics couple are one
//! plane in r = x + jy, with responses H(ω) at positive (forward) and negative (backward) frequencies: with a the x→x and
//! b the x→y response, H(ω) = a + jb and conj H(−ω) = a − jb. In these coordinates the 4×4 loop is block diagonal, so its
//! μ, with the same δ for both planes and any load in both, is the larger of the two. Both are isotropic.
//! The values are upper bounds on a grid that is dense round the closed-loop poles, not certified between its lines. An
//! unstable loop has no μ.

use super::PipelineError;
use crate::augment::Block;
use crate::augment::assembly::{SIGNAL_SCALE_M, UncertainMode, input_weights, output_weights};
use crate::augment::plane::{LOADS, LOOPS, isotropic};
use crate::augment::weight_plane::WeightPlane;
use crate::augment::weights::Weights;
use crate::linalg::{Mat, c64, solve_complex};
use crate::lti::responder::FrequencyResponder;
use crate::lti::{Continuous, Discrete, FrequencyGrid, Response, StateSpace};
use crate::predict::closed_loop::{close, equivalent_poles};
use crate::robust::mu::upper_bound;
use crate::robust::structure::Scaling;
use crate::spindle::plant::CHANNELS;
use crate::spindle::{Machine, ModelDetail, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// μ at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedMu {
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Largest upper bound on the grid; infinite for an unstable loop.
    pub mu: f64,
    /// Its frequency, Hz; negative: backward whirl.
    pub frequency_hz: f64,
}

/// Speeds over the top speed.
const SPEEDS: [f64; 6] = [0.0, 0.25, 0.5, 0.75, 1.0, 1.2];
/// Every so many lines the bound is optimised for its scaling, whatever its value.
const STRIDE: usize = 6;
/// Rounds of so many lines round the largest value.
const ROUNDS: usize = 4;
const FINER: usize = 8;
/// Lines of the plain grid and on each side of a pole: three to each half-power width.
const LINES: usize = 160;
const LINES_A_SIDE: usize = 3;

/// μ of the specification with a four-axis law, from rest to 20 % above the top speed.
///
/// # Errors
/// [`PipelineError`] when a plant, a weight or a bound fails.
pub fn mu_over_speed(
    machine: &Machine,
    weights: &Weights,
    modes: &[UncertainMode],
    law: &StateSpace<Discrete>,
) -> Result<Vec<SpeedMu>, PipelineError> {
    SPEEDS
        .iter()
        .map(|share| {
            mu_at_speed(
                machine,
                weights,
                modes,
                law,
                share * machine.spindle.max_rpm,
            )
        })
        .collect()
}

/// μ of a specification with a four-axis law at one speed; `modes` are the uncertain ones.
///
/// # Errors
/// As [`mu_over_speed`].
pub fn mu_at_speed(
    machine: &Machine,
    weights: &Weights,
    modes: &[UncertainMode],
    law: &StateSpace<Discrete>,
    speed_rpm: f64,
) -> Result<SpeedMu, PipelineError> {
    const STAGE: &str = "μ over speed";
    let numeric = || PipelineError::numeric(STAGE);
    let machine = isotropic(machine);
    // The bound on T is a means of the design, not part of the specification.
    let weights = &Weights {
        complementary_sensitivity_limit: None,
        ..weights.clone()
    };
    let plant = Plant::new(&machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
    let period = plant.sample_period_s();
    let closed = close(&plant.sampled()?, law).map_err(numeric())?;
    if closed.growth_rate().map_err(numeric())? >= 0.0 {
        return Ok(SpeedMu {
            speed_rpm,
            mu: f64::INFINITY,
            frequency_hz: f64::NAN,
        });
    }
    let ports = modes.iter().map(|m| m.number + 1).max().unwrap_or(0);
    let opened = plant.with_modal_ports(ports);
    let x: Vec<usize> = modes
        .iter()
        .map(|m| CHANNELS + 2 * m.number)
        .chain([4, 6, 8, 0, 2])
        .collect();
    let y: Vec<usize> = x.iter().map(|k| k + 1).collect();
    // A delay below half a sample counts as half a sample, as in the sampled plant.
    let late_s = (0.5 * period - plant.delay_s()).max(0.0);
    let commands = x.len() - LOOPS;
    let plane = |omega: f64| {
        let theta = 0.5 * omega * period;
        let hold = c64::new(0.0, -omega * late_s).exp() * (theta.sin() / theta);
        let response = opened.at(omega);
        [&x, &y].map(|rows| {
            Mat::from_fn(rows.len(), x.len(), |i, j| {
                let held = if j < commands {
                    c64::new(1.0, 0.0)
                } else {
                    hold
                };
                held * response[(rows[i], x[j])]
            })
        })
    };
    let (own, other) = (law.select(&[0, 2], &[0, 2]), law.select(&[1, 3], &[0, 2]));
    let (own, other) = (
        FrequencyResponder::new(&own),
        FrequencyResponder::new(&other),
    );
    let frame = Frame {
        modes: modes.len(),
        integral: weights.integral_corner_hz.is_some(),
        input: input_weights(modes, weights, WeightPlane::Laplace).map_err(numeric())?,
        output: output_weights(modes, weights, WeightPlane::Laplace).map_err(numeric())?,
    };
    let poles = equivalent_poles(&closed).map_err(numeric())?;
    let nyquist_hz = 0.5 / period;
    let grid = FrequencyGrid::log_hz(1.0, 0.98 * nyquist_hz, LINES)
        .refine_round_poles(&poles, LINES_A_SIDE);
    let loops = |omega: f64| {
        let [a, b] = plane(omega);
        let (ka, kb) = (own.at(omega), other.at(omega));
        [1.0, -1.0].map(|sign| {
            let turn = c64::new(0.0, sign);
            let whirl = |p: &Mat<c64>, q: &Mat<c64>| {
                Mat::from_fn(p.nrows(), p.ncols(), |i, j| p[(i, j)] + turn * q[(i, j)])
            };
            let (m, blocks) = frame.closed(omega, &whirl(&a, &b), &whirl(&ka, &kb));
            (sign * omega, m, blocks)
        })
    };
    let bound =
        |m: &Mat<c64>, blocks: &[Block]| upper_bound(m, blocks).map_err(PipelineError::mu(STAGE));
    let lines = grid.omega_rad_s();
    let guides: Vec<usize> = (0..lines.len()).step_by(STRIDE).collect();
    let guided: Result<Vec<[(f64, f64, Scaling); 2]>, PipelineError> = guides
        .par_iter()
        .map(|k| {
            let [forward, backward] = loops(lines[*k]);
            let both = |(omega, m, blocks): (f64, Mat<c64>, Vec<Block>)| {
                bound(&m, &blocks).map(|(upper, scaling)| (upper, omega, scaling))
            };
            Ok([both(forward)?, both(backward)?])
        })
        .collect();
    let guided = guided?;
    let mut peak = (0.0, f64::NAN);
    let take = |peak: &mut (f64, f64), value: (f64, f64)| {
        if value.0 > peak.0 {
            *peak = value;
        }
    };
    for (upper, omega, _) in guided.iter().flatten() {
        take(&mut peak, (*upper, *omega));
    }
    // Any scaling gives a bound: where that of the nearest guide is below the peak already, the optimum is, too.
    let search = |lines: &[f64], least: f64| -> Result<Vec<(f64, f64)>, PipelineError> {
        let found: Result<Vec<Option<(f64, f64)>>, PipelineError> = lines
            .par_iter()
            .map(|omega| {
                let after = guides.partition_point(|k| grid.omega_rad_s()[*k] < *omega);
                let guide = guided.get(after).or(guided.last());
                let mut largest: Option<(f64, f64)> = None;
                for (side, (signed, m, blocks)) in loops(*omega).into_iter().enumerate() {
                    if guide.is_some_and(|g| g[side].2.bound(&m) <= least) {
                        continue;
                    }
                    let (upper, _) = bound(&m, &blocks)?;
                    if largest.is_none_or(|l| upper > l.0) {
                        largest = Some((upper, signed));
                    }
                }
                Ok(largest)
            })
            .collect();
        Ok(found?.into_iter().flatten().collect())
    };
    for value in search(lines, peak.0)? {
        take(&mut peak, value);
    }
    let mut lines = lines.to_vec();
    for _ in 0..ROUNDS {
        // Once more between the neighbours of the largest.
        let top = peak.1.abs();
        let near = |from: f64, pick: fn(f64, f64) -> f64, side: &dyn Fn(&f64) -> bool| {
            lines.iter().copied().filter(|w| side(w)).fold(from, pick)
        };
        let below = near(0.9 * top, f64::max, &|w| *w < top);
        let above = near(1.1 * top, f64::min, &|w| *w > top);
        lines = (0..FINER)
            .map(|k| below + (above - below) * (k as f64 + 0.5) / FINER as f64)
            .collect();
        for value in search(&lines, peak.0)? {
            take(&mut peak, value);
        }
    }
    Ok(SpeedMu {
        speed_rpm,
        mu: peak.0,
        frequency_hz: peak.1 / TAU,
    })
}

/// Weights round a plane's response at one frequency.
struct Frame {
    modes: usize,
    integral: bool,
    input: StateSpace<Continuous>,
    output: StateSpace<Continuous>,
}

impl Frame {
    /// The weighted loop z ← w at a frequency for a plane (v, loads, u) → (q, x, y) and a controller y → u.
    fn closed(
        &self,
        omega: f64,
        plane: &Mat<c64>,
        controller: &Mat<c64>,
    ) -> (Mat<c64>, Vec<Block>) {
        let nv = self.modes;
        let (errors, wide) = (nv + LOADS, nv + LOADS + 2 * LOOPS);
        let (zero, one) = (c64::new(0.0, 0.0), c64::new(1.0, 0.0));
        // Column of `plane` that an input (v, loads, noise, u) of the frame is.
        let column = |j: usize| match j {
            j if j < errors => Some(j),
            j if j < errors + LOOPS => None,
            j => Some(j - LOOPS),
        };
        let unit = |here: bool| if here { one } else { zero };
        let signal = |k: usize, j: usize| match column(j) {
            Some(c) => plane[(errors + k, c)],
            None => unit(j == errors + k),
        };
        let regulated = if self.integral { LOOPS } else { 0 };
        let rows = errors + LOOPS + regulated + LOOPS;
        let exposed = Mat::from_fn(rows, wide, |i, j| {
            if i < errors {
                column(j).map_or(zero, |c| plane[(i, c)])
            } else if i < errors + LOOPS {
                unit(j == errors + LOOPS + (i - errors))
            } else {
                signal((i - errors) % LOOPS, j)
            }
        });
        let weighted = self.output.at(omega) * exposed * self.input.at(omega);
        let (nz, nw) = (rows - LOOPS, wide - LOOPS);
        let part = |r, c, h, w| weighted.submatrix(r, c, h, w).to_owned();
        let k = Mat::from_fn(LOOPS, LOOPS, |i, j| controller[(i, j)] * SIGNAL_SCALE_M);
        let loop_gain = part(nz, nw, LOOPS, LOOPS) * &k;
        let difference = Mat::from_fn(LOOPS, LOOPS, |i, j| unit(i == j) - loop_gain[(i, j)]);
        let inner = solve_complex(&difference, &part(nz, 0, LOOPS, nw));
        let closed = part(0, 0, nz, nw) + part(0, nw, nz, LOOPS) * (&k * inner);
        let mut blocks = vec![Block::ComplexScalar { n: 1 }; nv];
        blocks.push(Block::ComplexFull {
            rows: nw - nv,
            cols: nz - nv,
        });
        (closed, blocks)
    }
}
