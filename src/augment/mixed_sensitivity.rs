//! The generalized plant of mixed sensitivity, as `augw` of MATLAB and of python-control build it: w is the command,
//! e = w − G u the measurement, z = (W1 e, W2 u, W3 G u); u = K e.

use super::generalized::GeneralizedPlant;
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::{append, series, stack_rows};
use crate::lti::{Continuous, StateSpace};

/// The weights; one that is absent has no error.
#[derive(Clone, Debug, Default)]
pub struct SensitivityWeights {
    /// W1 of e: S = (I + GK)⁻¹.
    pub error: Option<StateSpace<Continuous>>,
    /// W2 of u: K S.
    pub control: Option<StateSpace<Continuous>>,
    /// W3 of G u: T = G K S.
    pub output: Option<StateSpace<Continuous>>,
}

/// The plant of G with its weights; a weight of one input and one output stands for one in each channel.
///
/// # Errors
/// [`NumericError::Dimension`] for a weight that does not fit its channels, and where there is no weight.
pub fn augment_with_weights(
    plant: &StateSpace<Continuous>,
    weights: &SensitivityWeights,
) -> Result<GeneralizedPlant, NumericError> {
    let (n, m, p) = (plant.order(), plant.inputs(), plant.outputs());
    // Of (w, u): the signals that are weighted, then e.
    let mut c = Mat::zeros(0, n);
    let mut d = Mat::zeros(0, p + m);
    let mut all = StateSpace::gain(Mat::zeros(0, 0), plant.time);
    let one = |i: usize, j: usize| f64::from(u8::from(i == j));
    let minus = |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| -m[(i, j)]);
    let of_error =
        (minus(&plant.c), Mat::from_fn(p, p + m, |i, j| if j < p { one(i, j) } else { -plant.d[(i, j - p)] }));
    let of_control = (Mat::zeros(m, n), Mat::from_fn(m, p + m, |i, j| one(i + p, j)));
    let of_output = (plant.c.clone(), Mat::from_fn(p, p + m, |i, j| if j < p { 0.0 } else { plant.d[(i, j - p)] }));
    let weighted = [(&weights.error, &of_error), (&weights.control, &of_control), (&weights.output, &of_output)];
    for (weight, (state, direct)) in weighted {
        let Some(weight) = weight else { continue };
        all = append(&all, &spread(weight, direct.nrows())?);
        (c, d) = (stack_rows(&c, state), stack_rows(&d, direct));
    }
    if all.outputs() == 0 {
        return Err(NumericError::Dimension {
            what: "mixed sensitivity",
            expected: "at least one of W1, W2, W3".to_owned(),
            found: "none".to_owned(),
        });
    }
    let measured = StateSpace::gain(Mat::identity(p, p), plant.time);
    let b = Mat::from_fn(n, p + m, |i, j| if j < p { 0.0 } else { plant.b[(i, j - p)] });
    let (state, direct) = of_error;
    let signals = StateSpace::new(plant.a.clone(), b, stack_rows(&c, &state), stack_rows(&d, &direct), plant.time)?;
    let system = series(&signals, &append(&all, &measured))?;
    Ok(GeneralizedPlant { system, controls: m, measurements: p, blocks: vec![] })
}

/// A single weight once for each channel.
fn spread(weight: &StateSpace<Continuous>, channels: usize) -> Result<StateSpace<Continuous>, NumericError> {
    match (weight.inputs(), weight.outputs()) {
        (inputs, _) if inputs == channels => Ok(weight.clone()),
        (1, 1) => Ok((1..channels).fold(weight.clone(), |all, _| append(&all, weight))),
        (inputs, outputs) => Err(NumericError::Dimension {
            what: "weight",
            expected: format!("{channels} inputs, or one input and one output"),
            found: format!("{inputs} inputs and {outputs} outputs"),
        }),
    }
}
