//! The problems that a design solved, with their answers, for other programs: everything of one plane, in the w plane
//! of the sampled loop, with the scaled signals of the synthesis.

use super::PipelineError;
use super::delivery::scaled_plane;
use super::design::Design;
use crate::augment::GeneralizedPlant;
use crate::augment::assembly::ProblemWeights;
use crate::augment::plane::x_plane;
use crate::augment::weights::Weights;
use crate::controller::ControlLaw;
use crate::lti::connect::lower_lft;
use crate::lti::{Continuous, StateSpace};
use crate::robust::structure::Structure;

/// Problems and answers of a design.
#[derive(Clone, Debug)]
pub(crate) struct ProblemSet {
    pub synthesis: GeneralizedPlant,
    /// What μ is judged on: the specification as written, of the whole machine at rest.
    pub specification: GeneralizedPlant,
    /// The delivered controller of one plane, u = K y in the scaled signals.
    pub controller: StateSpace<Continuous>,
    /// The specification closed with it.
    pub closed_loop: StateSpace<Continuous>,
    /// Weights at the inputs of the specification, as written, over s.
    pub input_weights: StateSpace<Continuous>,
    pub output_weights: StateSpace<Continuous>,
    /// D-scales of the D-K iteration over the outputs z of `synthesis`, constant scales included; these alone where the
    /// iteration was not run.
    pub d_left: StateSpace<Continuous>,
    /// Their inverses over its inputs w: the scaled plant is D_left P D_right_inverse.
    pub d_right_inverse: StateSpace<Continuous>,
}

impl ProblemSet {
    /// The problems of a design; `weights` are the specification as written.
    pub(crate) fn of(design: &Design, weights: &Weights) -> Result<Self, PipelineError> {
        const STAGE: &str = "problem files";
        let numeric = PipelineError::numeric(STAGE);
        let problems = &design.problems;
        let ControlLaw::Discrete(law) = &design.delivery.controller.law else {
            return Err(PipelineError::Controller(crate::controller::ControllerError::Infeasible {
                step: STAGE,
                reason: "the delivered controller is not sampled".to_owned(),
                advice: "design by the direct route",
            }));
        };
        let plane = x_plane(law);
        let controller = scaled_plane(&plane)?;
        let closed_loop = lower_lft(&problems.specification.system, &controller).map_err(&numeric)?;
        let structure = Structure::new(&problems.synthesis.blocks).map_err(PipelineError::mu(STAGE))?;
        let (d_left, d_right_inverse) = design.scales().systems(&structure).map_err(&numeric)?;
        let round = ProblemWeights::of_specification(&problems.written_modes, weights);
        let round = round.map_err(&numeric)?;
        Ok(Self {
            synthesis: problems.posed.clone(),
            specification: problems.specification.clone(),
            input_weights: round.input,
            output_weights: round.output,
            controller,
            closed_loop,
            d_left,
            d_right_inverse,
        })
    }
}
