//! The weighted specification closed with a four-axis law on the exact frequency responses of the rotating machine.
//!
//! The plant is the full finite-element model with the true gyroscopics; currents reach it through the hold, sinc(ωT/2)
//! and half a sample, and the rest of the delay; loads and modal forces act between the samples and are not held; the
//! weights are those written, at true frequency; the controller is the one that runs. Two equal planes that gyroscopics
//! couple are one plane in r = x + jy, with responses H(ω) at positive (forward) and negative (backward) frequencies:
//! with a the x→x and b the x→y response, H(ω) = a + jb and conj H(−ω) = a − jb. In these coordinates the 4×4 loop is
//! block diagonal, so its μ, with the same δ for both planes and any load in both, is the larger of the two. Both are
//! isotropic.

use super::PipelineError;
use crate::augment::Block;
use crate::augment::assembly::{ProblemWeights, SIGNAL_SCALE_M, UncertainMode};
use crate::augment::channels::{Channel, problem_blocks};
use crate::augment::exposure::Exposure;
use crate::augment::plane::LOOPS;
use crate::augment::weights::Weights;
use crate::linalg::{Mat, c64, solve_complex};
use crate::lti::held::hold_magnitude;
use crate::lti::responder::FrequencyResponder;
use crate::lti::{Continuous, Discrete, Response, StateSpace};
use crate::spindle::Plant;
use crate::spindle::plant::CHANNELS;

/// Signs of the frequency of forward and backward whirl.
pub(super) const SIGNS: [f64; 2] = [1.0, -1.0];

/// The weighted loop of a specification at one speed.
pub(super) struct RotatingLoop {
    plant: Plant,
    /// Channels of the plant: modal ports, loads, magnets; x axis, and the same of the y axis.
    channels: [Vec<usize>; 2],
    /// What the delay of the plant lacks of half a sample, s: a shorter one counts as that, as in the sampled plant.
    late_s: f64,
    /// The controller x → (x, y).
    law: FrequencyResponder<Discrete>,
    /// Weights at the outputs and at the inputs.
    weights: [FrequencyResponder<Continuous>; 2],
    frame: Frame,
}

impl RotatingLoop {
    /// The loop of a plant whose planes are equal, with the law; `modes` are the uncertain ones.
    pub(super) fn new(
        plant: &Plant,
        weights: &Weights,
        modes: &[UncertainMode],
        law: &StateSpace<Discrete>,
    ) -> Result<Self, PipelineError> {
        let round = ProblemWeights::of_specification(modes, weights);
        let round = round.map_err(PipelineError::numeric("weights of μ over speed"))?;
        let ports = modes.iter().map(|m| m.number + 1).max().unwrap_or(0);
        let x: Vec<usize> = modes.iter().map(|m| CHANNELS + 2 * m.number).chain([4, 6, 8, 0, 2]).collect();
        let y = x.iter().map(|k| k + 1).collect();
        Ok(Self {
            late_s: (0.5 * plant.sample_period_s() - plant.delay_s()).max(0.0),
            plant: plant.with_modal_ports(ports),
            channels: [x, y],
            law: FrequencyResponder::new(&law.select(&[0, 2, 1, 3], &[0, 2])),
            weights: [&round.output, &round.input].map(FrequencyResponder::new),
            frame: Frame {
                modes: modes.len(),
                exposure: Exposure::new(modes.len(), &round.channels, weights.integral_corner_hz.is_some()),
                channels: round.channels,
            },
        })
    }

    /// M and its blocks for forward and backward whirl at a frequency, rad/s.
    pub(super) fn at(&self, omega: f64) -> [(Mat<c64>, Vec<Block>); 2] {
        let [a, b] = self.planes(omega);
        let law = self.law.at(omega);
        let [ka, kb] = [0, LOOPS].map(|first| law.submatrix(first, 0, LOOPS, LOOPS).to_owned());
        let weights = self.weights.each_ref().map(|w| w.at(omega));
        SIGNS.map(|sign| {
            let turn = c64::new(0.0, sign);
            let whirl =
                |p: &Mat<c64>, q: &Mat<c64>| Mat::from_fn(p.nrows(), p.ncols(), |i, j| p[(i, j)] + turn * q[(i, j)]);
            self.frame.close_frame(&weights, &whirl(&a, &b), &whirl(&ka, &kb))
        })
    }

    /// Responses x → x and x → y at a frequency; the currents are held.
    fn planes(&self, omega: f64) -> [Mat<c64>; 2] {
        let held = hold_magnitude(omega, self.plant.sample_period_s());
        let hold = c64::new(0.0, -omega * self.late_s).exp() * held;
        let response = self.plant.at(omega);
        let columns = &self.channels[0];
        let commands = columns.len() - LOOPS;
        [0, 1].map(|axis| {
            let rows = &self.channels[axis];
            Mat::from_fn(rows.len(), columns.len(), |i, j| {
                let value = response[(rows[i], columns[j])];
                if j < commands { value } else { hold * value }
            })
        })
    }
}

/// What is round a plane's response at one frequency.
struct Frame {
    modes: usize,
    channels: Vec<Channel>,
    exposure: Exposure,
}

impl Frame {
    /// The weighted loop z ← w at a frequency, with the weights there, for a plane (v, loads, u) → (q, x, y) and a
    /// controller y → u.
    fn close_frame(
        &self,
        [output, input]: &[Mat<c64>; 2],
        plane: &Mat<c64>,
        controller: &Mat<c64>,
    ) -> (Mat<c64>, Vec<Block>) {
        let exposed = self.exposure.matrix(|i, j| plane[(i, j)]);
        let weighted = output * exposed * input;
        let uncertain = self.modes + self.channels.len();
        let exposure = &self.exposure;
        let (nz, nw) = (exposure.error_rows(), exposure.disturbance_columns());
        let part = |r, c, h, w| weighted.submatrix(r, c, h, w).to_owned();
        let k = Mat::from_fn(LOOPS, LOOPS, |i, j| controller[(i, j)] * SIGNAL_SCALE_M);
        let loop_gain = part(nz, nw, LOOPS, LOOPS) * &k;
        let difference = Mat::<c64>::identity(LOOPS, LOOPS) - loop_gain;
        let inner = solve_complex(&difference, &part(nz, 0, LOOPS, nw));
        let closed = part(0, 0, nz, nw) + part(0, nw, nz, LOOPS) * (&k * inner);
        let performance = (nw - uncertain, nz - uncertain);
        let blocks = problem_blocks(self.modes, &self.channels, performance.0, performance.1);
        (closed, blocks)
    }
}
