//! A measurement folder as a rig would give it, computed from a model.

use super::records::{Listed, hammer_csv, rehearsed_list, sweep_csv};
use super::results::{ResultsError, ResultsFolder};
use crate::controller::Controller;
use crate::export::json::controller_json;
use crate::identify::Rehearsal;
use crate::input::machine_files;
use crate::pipeline::PipelineError;
use crate::pipeline::loop_stability::{growth_rate_at, unstable_words};
use crate::spindle::halved::refined_around_tilting;
use crate::spindle::{Machine, SpindleError};
use thiserror::Error;

/// Why nothing can be rehearsed.
#[derive(Debug, Error)]
pub(crate) enum RehearsalError {
    /// The loop is unstable, in words: no such measurement can be taken.
    #[error("{0}")]
    Unstable(String),
    /// A loop that cannot be computed.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A record that cannot be computed.
    #[error(transparent)]
    Record(#[from] SpindleError),
    /// Two files of the same name.
    #[error(transparent)]
    Results(#[from] ResultsError),
}

/// What is measured of a machine that floats.
pub(crate) struct RehearsedRig<'a> {
    /// The machine that the records come from.
    pub truth: &'a Machine,
    /// What floats it.
    pub controller: &'a Controller,
    /// Lines, repeats, noise.
    pub rehearsal: &'a Rehearsal,
    pub speeds_rpm: &'a [f64],
    /// Called before each record.
    pub watch: &'a dyn Fn(),
}

impl RehearsedRig<'_> {
    /// A measurement folder whose files name `model`, and its records.
    pub(crate) fn folder(&self, model: &Machine) -> Result<(ResultsFolder, Vec<Listed>), RehearsalError> {
        let mut folder = ResultsFolder::new();
        let records = self.add_records(&mut folder, "")?;
        let list = rehearsed_list(&records);
        let absent = model.tool.is_absent();
        folder.add("measurement.yaml", if absent { list.replace("tool: tool.yaml", "tool: none") } else { list })?;
        for (name, text) in machine_files(model) {
            folder.add(name, text)?;
        }
        Ok((folder, records))
    }

    /// Adds a sweep and a hammer test at every speed and the controller `pid.json` below `prefix` (empty, or ending in
    /// `/`). The shaft has twice the elements of its file, because the elements of a file are an approximation that no
    /// rig shares.
    pub(crate) fn add_records(&self, folder: &mut ResultsFolder, prefix: &str) -> Result<Vec<Listed>, RehearsalError> {
        let Self { controller, rehearsal, .. } = self;
        let truth = &refined_around_tilting(self.truth);
        let mut listed = vec![];
        for rpm in self.speeds_rpm {
            (self.watch)();
            let growth = growth_rate_at(truth, controller, *rpm)?;
            if growth >= 0.0 {
                return Err(RehearsalError::Unstable(unstable_words(growth, *rpm)));
            }
            let sweep = format!("sweep-{rpm:.0}.csv");
            let record = rehearsal.sweep(truth, *controller, *rpm, &sweep)?;
            folder.add(&format!("{prefix}{sweep}"), sweep_csv(&record))?;
            (self.watch)();
            let hammer = format!("hammer-{rpm:.0}.csv");
            let record = rehearsal.hammer(truth, *controller, *rpm)?;
            folder.add(&format!("{prefix}{hammer}"), hammer_csv(&record))?;
            listed.push(("sweep", sweep, *rpm));
            listed.push(("hammer", hammer, *rpm));
        }
        folder.add(&format!("{prefix}pid.json"), controller_json(controller, None))?;
        Ok(listed)
    }
}
