//! Arguments that the commands of a design share: machine, weights, route, tightening, effort.

use super::Failure;
use super::controlled_machine::MachineArguments;
use crate::augment::plane::Route;
use crate::augment::weights::Weights;
use crate::input::load_weights;
use crate::pid::settings::TuneSettings;
use crate::pipeline::emulation::PADE_ORDER;
use crate::pipeline::tightening::Tightening;
use crate::spindle::Machine;

/// Machine and specification.
#[derive(clap::Args, Debug, Clone)]
pub(super) struct DesignArguments {
    #[command(flatten)]
    pub machine: MachineArguments,
    /// Weights file, or the name of a shipped one
    #[arg(long, default_value = "benchmark")]
    pub weights: String,
}

impl DesignArguments {
    /// Reads and validates all three files.
    pub(super) fn load(&self) -> Result<(Machine, Weights), Failure> {
        let machine = self.machine.alone()?;
        let weights = load_weights(&self.weights)?.on(&machine)?;
        Ok((machine, weights))
    }
}

#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub(super) enum RouteArgument {
    /// Synthesis on the sampled plant in the w plane
    #[default]
    Direct,
    /// Continuous synthesis with a Padé delay, then Tustin's rule
    Emulation,
}

impl From<RouteArgument> for Route {
    fn from(argument: RouteArgument) -> Self {
        match argument {
            RouteArgument::Direct => Self::Direct,
            RouteArgument::Emulation => Self::Emulation { pade_order: PADE_ORDER },
        }
    }
}

/// The value of `--tighten`.
pub(super) fn tightening(text: &str) -> Result<Tightening, String> {
    if text == "auto" {
        return Ok(Tightening::Auto);
    }
    match text.parse::<f64>() {
        Ok(factor) if factor.is_finite() && factor > 0.0 => Ok(Tightening::By(factor)),
        _ => Err("must be `auto` or a positive factor such as 1.5".to_owned()),
    }
}

/// Arguments of the commands that tune a PID.
#[derive(clap::Args, Debug, Clone, Copy)]
pub(super) struct PidArguments {
    /// Effort of the PID search: one search of a few seconds, or the best of four
    #[arg(long = "pid", value_enum, default_value = "quick")]
    effort: PidEffort,
    /// Seed of the PID search
    #[arg(long = "pid-seed", default_value_t = 1)]
    seed: u64,
}

impl PidArguments {
    pub(super) fn settings(&self) -> TuneSettings {
        let settings = match self.effort {
            PidEffort::Quick => TuneSettings::quick(),
            PidEffort::Thorough => TuneSettings::thorough(),
        };
        TuneSettings { seed: self.seed, ..settings }
    }
}

/// How long the PID is tuned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum PidEffort {
    /// One search.
    Quick,
    /// The best of four searches with different starts.
    Thorough,
}
