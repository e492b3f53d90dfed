//! A report under construction: the results folder with its summary, page and controller files.

use super::cascade::cascade_topic;
use super::html::{self, HtmlError};
use super::loop_figures::{bearings_topic, loop_figures, tool_step_topic, unbalance_topic};
use super::margins::stable_margin_topic;
use super::page_summary::VerdictLine;
use super::pictures::{Picture, PictureName};
use super::place_words::{at_output, summary_at_output};
use super::plot::PictureFormat;
use super::plot::figure::Figure;
use super::prediction_summary::{sensitivity_topic, stiffness_topic};
use super::results::{ResultsError, ResultsFolder};
use super::summary::Summary;
use super::thrust::{thrust_figure, thrust_files, thrust_topic};
use crate::controller::{Controller, MachineTag};
use crate::export::c::c_identifier;
use crate::export::error::FirmwareError;
use crate::export::firmware::{Firmware, Format, sha256_hex, write_all};
use crate::export::json::controller_json;
use crate::export::problem::problem_files;
use crate::input::machine_files;
use crate::pipeline::PipelineError;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::Design;
use crate::pipeline::loop_curves::LoopCurves;
use crate::pipeline::problem_set::ProblemSet;
use crate::pipeline::thrust::ThrustDesign;
use crate::spindle::{Machine, RotorOnSupports, SpindleError};
use serde_json::json;
use std::path::Path;
use thiserror::Error;

/// Why a report could not be made.
#[derive(Debug, Error)]
pub(crate) enum ReportError {
    #[error(transparent)]
    Results(#[from] ResultsError),
    #[error("report: {0}")]
    Page(#[from] HtmlError),
    #[error("firmware: {0}")]
    Firmware(#[from] FirmwareError),
    /// A picture that needs a model.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A rotor that cannot be drawn.
    #[error(transparent)]
    Machine(#[from] SpindleError),
}

/// A results folder on the way to being written.
#[derive(Default)]
pub(crate) struct Report {
    /// Files and pictures.
    pub folder: ResultsFolder,
    /// Figures by key.
    pub summary: Summary,
    /// Whether the machine has no tool, and its place is called output.
    at_output: bool,
}

impl Report {
    /// An empty report of a command on a machine.
    pub(crate) fn of(command: &str, machine: &Machine) -> Self {
        let mut report = Self { at_output: machine.tool.is_absent(), ..Self::default() };
        let summary = &mut report.summary;
        summary.set("run", command);
        summary.set("spindle", machine.spindle.name.as_str());
        summary.set("tool", machine.tool.name.as_str());
        if let Some(correction) = &machine.correction {
            let poles = correction.laws.iter().map(|own| own.law.order()).max().unwrap_or_default();
            summary.set("correction", json!({"poles": poles, "left_out_share": correction.left_out}));
        }
        report
    }

    /// An empty report of a command on a rotor without magnets.
    pub(crate) fn of_rotor(command: &str, rotor: &RotorOnSupports) -> Self {
        let mut report = Self::default();
        report.summary.set("run", command);
        report.summary.set("spindle", rotor.name.as_str());
        rotor.tool.iter().for_each(|tool| report.summary.set("tool", tool.name.as_str()));
        report
    }

    /// States whether every target is met, and the sentence about it.
    pub(crate) fn verdict(&mut self, met: bool, sentence: &str) {
        let verdict = VerdictLine { met: Some(met), sentence: sentence.to_owned() };
        self.summary.set("verdict", verdict);
    }

    pub(crate) fn figures<N: Into<PictureName>>(
        &mut self,
        figures: impl IntoIterator<Item = (N, Figure)>,
    ) -> Result<(), ReportError> {
        let figures = figures.into_iter();
        let figures = figures.map(|(name, figure)| (name.into(), figure));
        Ok(self.folder.add_plots(figures.collect())?)
    }

    /// Adds stiffness and sensitivity of a controller at rest and at top speed.
    pub(crate) fn predictions(&mut self, name: &str, both: [&Prediction; 2]) {
        let summary = &mut self.summary;
        summary.set(&format!("stiffness.{name}"), stiffness_topic(both));
        summary.set(&format!("sensitivity.{name}"), sensitivity_topic(both));
    }

    /// Adds the pictures of the loop of a controller and its margins at rest.
    pub(crate) fn loop_of(
        &mut self,
        name: &str,
        curves: &LoopCurves,
        runs: [&Prediction; 2],
        top_rpm: f64,
    ) -> Result<(), ReportError> {
        self.figures(loop_figures(curves, runs, top_rpm))?;
        self.summary.set("simulation.bearings", bearings_topic(&curves.capacity));
        if let Some(stable) = &curves.stable {
            self.summary.set(&format!("margins.{name}"), stable_margin_topic(stable));
            self.summary.set("simulation.step", tool_step_topic(&stable.step));
            self.summary.set("simulation.unbalance", unbalance_topic(&stable.unbalance, top_rpm));
            self.summary.set("simulation.cascade", cascade_topic(&stable.cascade));
        }
        Ok(())
    }

    /// Adds the machine's files, and at `place` (a folder with its slash, or beside them) JSON, `.mat`, C, tables and
    /// test vectors of the controller, and the PID.
    pub(crate) fn controller(
        &mut self,
        place: &str,
        machine: &Machine,
        design: &Design,
        pid: Option<&Controller>,
    ) -> Result<(), ReportError> {
        let tag = tag_from_below(machine, place.matches('/').count());
        for (file, bytes) in controller_files(machine, design, &tag)? {
            self.folder.add(&format!("{place}{file}"), bytes)?;
        }
        if let Some(pid) = pid {
            self.folder.add(&format!("{place}pid.json"), controller_json(pid, Some(&tag)))?;
        }
        if let Some(thrust) = &design.thrust {
            self.thrust(place, machine, thrust, controller_formats(design))?;
        }
        self.machine_files(machine)
    }

    /// Adds the thrust axis: its topic, its picture and the folder `thrust` of its controller.
    fn thrust(
        &mut self,
        place: &str,
        machine: &Machine,
        found: &ThrustDesign,
        formats: &[Format],
    ) -> Result<(), ReportError> {
        self.summary.set("thrust", thrust_topic(found));
        self.figures([(Picture::Thrust, thrust_figure(found))])?;
        let tag = tag_from_below(machine, 1 + place.matches('/').count());
        for (file, bytes) in thrust_files(machine, found, &tag, formats)? {
            self.folder.add(&format!("{place}thrust/{file}"), bytes)?;
        }
        Ok(())
    }

    /// Adds the machine's files and `controller/discrete.json` of a controller without a design.
    pub(crate) fn controller_alone(&mut self, machine: &Machine, controller: &Controller) -> Result<(), ReportError> {
        let tag = tag_from_below(machine, 1);
        self.folder.add("controller/discrete.json", controller_json(controller, Some(&tag)))?;
        self.machine_files(machine)
    }

    fn machine_files(&mut self, machine: &Machine) -> Result<(), ReportError> {
        for (name, text) in machine_files(machine) {
            self.folder.add(name, text)?;
        }
        Ok(())
    }

    /// Adds the folder `problem` with problems and answers of a design as state space.
    pub(crate) fn problem(&mut self, set: &ProblemSet) -> Result<(), ReportError> {
        for (file, bytes) in problem_files(set)? {
            self.folder.add(&format!("problem/{file}"), bytes)?;
        }
        Ok(())
    }

    /// Adds summary, page and pictures in further formats, and writes the folder whole.
    pub(crate) fn write(&mut self, out: &str, formats: &[PictureFormat]) -> Result<(), ReportError> {
        self.finish()?;
        self.folder.add_formats(formats)?;
        Ok(self.folder.write(Path::new(out))?)
    }

    /// Adds summary and page.
    pub(crate) fn finish(&mut self) -> Result<(), ReportError> {
        if self.at_output {
            self.summary = summary_at_output(&self.summary);
            self.folder.reword_pictures(at_output);
        }
        let page = html::report(&self.summary.value(), &self.folder.pictures())?;
        let page = if self.at_output { at_output(&page) } else { page };
        self.folder.add("report.html", page)?;
        Ok(self.folder.add("summary.json", self.summary.to_json())?)
    }
}

/// A machine with a loop that is unstable or not proven stable gets no firmware; `export --force-unverified` makes it
/// from `discrete.json`.
fn controller_formats(design: &Design) -> &'static [Format] {
    if design.has_firmware() { &Format::ALL } else { &[Format::Json] }
}

/// The files of a delivered controller in every format that its loop allows; `tag` names the machine's files beside it.
fn controller_files(
    machine: &Machine,
    design: &Design,
    tag: &MachineTag,
) -> Result<Vec<(String, Vec<u8>)>, FirmwareError> {
    let name = format!("{} with {}", machine.spindle.name, machine.tool.name);
    let written = write_all(
        &Firmware {
            discrete: &design.delivery.controller,
            // The design's own continuous controller lives in the w plane; no frequency there is a true one.
            continuous: None,
            scaled: &design.delivery.realisation,
            verification: &design.delivery.verification,
            machine: &name,
            tag: Some(tag),
            prefix: &c_identifier(machine.short_name()),
        },
        controller_formats(design),
    )?;
    Ok(written.files)
}

/// The tag of a machine whose files lie so many folders above.
fn tag_from_below(machine: &Machine, folders: usize) -> MachineTag {
    let up = "../".repeat(folders);
    machine_tag(machine, &format!("{up}spindle.yaml"), &format!("{up}tool.yaml"))
}

/// The tag of a machine whose files are found under these paths.
pub(crate) fn machine_tag(machine: &Machine, spindle: &str, tool: &str) -> MachineTag {
    let text: String = machine_files(machine).into_iter().map(|(_, text)| text).collect();
    MachineTag { spindle: spindle.to_owned(), tool: tool.to_owned(), hash: sha256_hex(text.as_bytes()) }
}
