//! Regularisation of an H∞ problem whose D12 or D21 lacks rank: every control gets an error z = ε u of its own, every
//! measurement a disturbance ε w of its own. ε is a share of the largest gain over frequency that this control
//! (measurement) reaches in the plant, so that it does not depend on units. The loop of the given plant is a part of
//! the enlarged loop: a norm or a μ of the enlarged one bounds that of the given one.

use super::channel_units::ChannelUnits;
use super::feedthrough::{direct_share, parts, smallest_share};
use crate::augment::{Block, GeneralizedPlant};
use crate::linalg::Mat;
use crate::lti::{Continuous, StateSpace};

/// Share of the gain that is added by default: below it the Riccati solutions span more than half the digits of a
/// double.
pub const DEFAULT_SHARE: f64 = 1e-4;

/// Gains are read on s = ω(0.1 + j): a pole on the imaginary axis (an integrator, a free mode) has no finite gain on
/// the axis itself.
const DAMPING: f64 = 0.1;

/// What was added; empty where D12 (D21) was left as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Regularisation {
    /// ε of each control: extra rows of D12.
    pub d12: Vec<f64>,
    /// ε of each measurement: extra columns of D21.
    pub d21: Vec<f64>,
    /// δ of each state: extra rows of C1.
    pub c1: Vec<f64>,
    /// δ of each state: extra columns of B1.
    pub b1: Vec<f64>,
}

/// Channels of states that zeros on the imaginary axis ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Needs {
    /// Errors δ x, for zeros of P12.
    pub state_errors: bool,
    /// Disturbances δ on the states, for zeros of P21.
    pub state_disturbances: bool,
}

/// The plant with an error for each control where D12 falls below `share` of the units, a disturbance for each
/// measurement where D21 does, and the channels of states that are needed.
pub(super) fn enlarged_by(
    plant: &GeneralizedPlant,
    units: &ChannelUnits,
    share: f64,
    needs: Needs,
) -> (GeneralizedPlant, Regularisation) {
    let (control, sensing) = parts(plant);
    let missing = |part: &StateSpace<Continuous>, sizes: &[f64]| -> Vec<f64> {
        match smallest_share(&part.d, sizes) {
            Some(found) if found >= share => vec![],
            _ => sizes.iter().map(|size| share * size).collect(),
        }
    };
    let of_states = |sizes: &[f64]| sizes.iter().map(|size| share * units.errors / size).collect();
    let added = Regularisation {
        d12: missing(&control, &units.controls),
        d21: missing(&sensing, &units.measurements),
        c1: if needs.state_errors { of_states(&units.reached) } else { vec![] },
        b1: if needs.state_disturbances { of_states(&units.seen) } else { vec![] },
    };
    (enlarge(plant, &added), added)
}

/// The plant with an error for each control where D12 falls below `share` of the gains, and a disturbance for each
/// measurement where D21 does. A performance block that is full and complex, the last one, grows with the channels; a
/// plant whose last block is another kind gets a further full block. `None` when a gain cannot be computed or is zero:
/// then the control or the measurement does nothing, and no regularisation of this kind helps.
pub fn regularise_plant(plant: &GeneralizedPlant, share: f64) -> Option<(GeneralizedPlant, Regularisation)> {
    let (control, sensing) = parts(plant);
    let missing = |part: &StateSpace<Continuous>| -> Option<Vec<f64>> {
        let found = direct_share(part, DAMPING)?;
        if found.relative >= share {
            return Some(vec![]);
        }
        let sizes: Vec<f64> = found.gains.iter().map(|gain| share * gain).collect();
        sizes.iter().all(|e| e.is_finite() && *e > 0.0).then_some(sizes)
    };
    let added = Regularisation { d12: missing(&control)?, d21: missing(&sensing)?, ..Regularisation::default() };
    let enlarged = enlarge(plant, &added);
    Some((enlarged, added))
}

/// The plant with these channels.
pub(in crate::robust) fn enlarge(plant: &GeneralizedPlant, added: &Regularisation) -> GeneralizedPlant {
    let s = &plant.system;
    let (m1, p1, n) = (plant.disturbances(), plant.errors(), s.order());
    let (noises, costs) = (added.d21.len(), added.d12.len());
    let (more_w, more_z) = (noises + added.b1.len(), costs + added.c1.len());
    // Where an old channel stands in the enlarged plant: the new ones come after the old w and z, before u and y.
    let input = |j: usize| if j < m1 { j } else { j + more_w };
    let output = |i: usize| if i < p1 { i } else { i + more_z };
    let mut b = Mat::zeros(n, s.inputs() + more_w);
    let mut c = Mat::zeros(s.outputs() + more_z, n);
    let mut d = Mat::zeros(s.outputs() + more_z, s.inputs() + more_w);
    for j in 0..s.inputs() {
        for i in 0..n {
            b[(i, input(j))] = s.b[(i, j)];
        }
        for i in 0..s.outputs() {
            d[(output(i), input(j))] = s.d[(i, j)];
        }
    }
    for i in 0..s.outputs() {
        for j in 0..n {
            c[(output(i), j)] = s.c[(i, j)];
        }
    }
    for (k, size) in added.d12.iter().enumerate() {
        d[(p1 + k, input(m1 + k))] = *size;
    }
    for (k, size) in added.d21.iter().enumerate() {
        d[(output(p1 + k), m1 + k)] = *size;
    }
    for (k, size) in added.c1.iter().enumerate() {
        c[(p1 + costs + k, k)] = *size;
    }
    for (k, size) in added.b1.iter().enumerate() {
        b[(k, m1 + noises + k)] = *size;
    }
    GeneralizedPlant {
        system: StateSpace { a: s.a.clone(), b, c, d, time: Continuous },
        controls: plant.controls,
        measurements: plant.measurements,
        blocks: grow_blocks(&plant.blocks, more_w, more_z),
    }
}

/// The blocks with room for the new channels.
fn grow_blocks(blocks: &[Block], more_w: usize, more_z: usize) -> Vec<Block> {
    let mut blocks = blocks.to_vec();
    if more_w + more_z == 0 {
        return blocks;
    }
    match blocks.last_mut() {
        // No blocks: one full block is meant, whatever its size.
        None => {}
        Some(Block::ComplexFull { rows, cols }) => {
            *rows += more_w;
            *cols += more_z;
        }
        // A block needs both sides: the smallest structure that contains Δ for the given plant closes the new channels
        // over the last block.
        Some(last) => {
            *last = Block::ComplexFull { rows: last.rows() + more_w, cols: last.cols() + more_z };
        }
    }
    blocks
}
