//! A spindle with its tool as Python holds it.

use super::compute::{compute, end_with, failure_error};
use super::convert::{SystemOut, system, to_value_error};
use super::measured;
use super::results::{NativeResults, results};
use crate::augment::weights::Weights;
use crate::controller::Controller;
use crate::controller::anti_windup::firmware_rows;
use crate::export::c::{c_identifier, stability_words};
use crate::export::firmware::{Firmware, Format, write_all};
use crate::export::json::controller_json;
use crate::identify::Rehearsal;
use crate::input::pid::{load_pid, read_pid};
use crate::input::{
    InputError, NO_TOOL, load_controller, load_machine, load_weights, read_controller, read_spindle, read_tool,
    read_weights, shipped, spindle_yaml, tool_yaml, usual_tool,
};
use crate::lti::Response;
use crate::pid::settings::TuneSettings;
use crate::pipeline::batch::one_tool;
use crate::pipeline::compared::{Ground, KnownFigures, compare_controller, own_controllers};
use crate::pipeline::firmware_proof::proven_as_rounded;
use crate::pipeline::levitating_pid::levitating_pid;
use crate::pipeline::pid_loop::{PidController, PidLoop, PidOrigin, tune_pid};
use crate::pipeline::progress::Event;
use crate::pipeline::run::{Extent, Task};
use crate::pipeline::sampled::sample_controller;
use crate::pipeline::settings::DesignSettings;
use crate::pipeline::simulation::{SimulationCase, SimulationWish, simulate_controller};
use crate::pipeline::study::{Questions, study};
use crate::predict::chatter::{CuttingMaterial, Engagement, USUAL_TEETH, USUAL_WIDTH};
use crate::predict::time::TimeSettings;
use crate::report::batch::BatchRow;
use crate::report::compared::{add_compared, add_own, all_acceptable, controller_keys};
use crate::report::design_study::design_report;
use crate::report::modes::ModesSummary;
use crate::report::pid::pid_report;
use crate::report::plot::Role;
use crate::report::rehearsed::RehearsedRig;
use crate::report::results::ResultsFolder;
use crate::report::summary::json;
use crate::report::time_response::simulation_report;
use crate::report::tool::tool_report;
use crate::report::whole::Report;
use crate::spindle::{Machine, ModelDetail, Plant};
use crate::workflow::Failure;
use numpy::{Complex64, PyArray3, ToPyArray};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// A machine.
#[pyclass(name = "Machine", frozen)]
pub(super) struct NativeMachine(Machine);

/// Rows and columns of the response: four axes, two directions of the tool plane.
const CHANNELS: usize = 6;

#[pymethods]
impl NativeMachine {
    /// Reads a spindle and a tool: paths, shipped names, or `none` as the tool; without a tool the usual one.
    #[staticmethod]
    fn load(python: Python<'_>, spindle: String, tool: Option<String>) -> PyResult<Self> {
        compute(python, move |_| {
            let tool = tool.map_or_else(|| usual_tool(&spindle).map(str::to_owned), Ok);
            Ok(load_machine(&spindle, &tool?)?)
        })
        .map(Self)
    }

    /// A machine from the texts of its files, YAML or JSON; `none` stands for no tool.
    #[staticmethod]
    fn read(python: Python<'_>, spindle: String, tool: String) -> PyResult<Self> {
        compute(python, move |_| {
            let spindle = read_spindle("spindle", &spindle)?;
            if tool == NO_TOOL {
                return Ok(Machine::without_tool(spindle)?);
            }
            let tool = read_tool("tool", &tool, &spindle)?;
            Ok(Machine::new(spindle, tool)?)
        })
        .map(Self)
    }

    /// The text of a `spindle` or a `tool` that is given by path or shipped name; `none` stands for no tool.
    #[staticmethod]
    fn text(kind: &str, source: &str) -> PyResult<String> {
        if kind == "tool" && source == NO_TOOL {
            return Ok(source.to_owned());
        }
        let known = if kind == "tool" { shipped::TOOLS } else { shipped::SPINDLES };
        shipped::text(source, kind, known).map_err(|e| failure_error(&e.into()))
    }

    /// Name of the spindle and of the tool.
    fn names(&self) -> (String, String) {
        (self.0.spindle.name.clone(), self.0.tool.name.clone())
    }

    /// Top speed, rpm.
    fn max_rpm(&self) -> f64 {
        self.0.spindle.max_rpm
    }

    /// The spindle file and the tool file, `none` where there is no tool.
    fn files(&self) -> (String, String) {
        let tool = &self.0.tool;
        let tool = if tool.is_absent() { NO_TOOL.to_owned() } else { tool_yaml(tool) };
        (spindle_yaml(&self.0.spindle), tool)
    }

    /// The design model at a speed as a continuous system with Padé approximants of the delay.
    fn plant<'py>(&self, python: Python<'py>, rpm: f64, pade_order: usize) -> PyResult<SystemOut<'py>> {
        let (machine, speed) = (self.0.clone(), check_speed(rpm)?);
        if pade_order > PADE_LIMIT {
            return Err(to_value_error(format!("pade_order = {pade_order} must be at most {PADE_LIMIT}")));
        }
        let found = compute(python, move |_| Ok(Plant::design_model(&machine, speed)?.state_space(pade_order)?))?;
        Ok(system(python, &found))
    }

    /// Responses of the full model with exact delay at angular frequencies, lines × outputs × inputs.
    fn response<'py>(
        &self,
        python: Python<'py>,
        omega: Vec<f64>,
        rpm: f64,
    ) -> PyResult<Bound<'py, PyArray3<Complex64>>> {
        let (machine, speed) = (self.0.clone(), check_speed(rpm)?);
        if let Some(bad) = omega.iter().find(|w| !w.is_finite()) {
            return Err(to_value_error(format!("omega holds {bad}: give numbers in rad/s")));
        }
        let all = compute(python, move |_| {
            let plant = Plant::new(&machine, speed, ModelDetail::Full)?;
            let mut all = ndarray::Array3::zeros((omega.len(), CHANNELS, CHANNELS));
            for (k, w) in omega.iter().enumerate() {
                let h = plant.at(*w);
                for (i, j) in (0..CHANNELS).flat_map(|i| (0..CHANNELS).map(move |j| (i, j))) {
                    all[[k, i, j]] = Complex64::new(h[(i, j)].re, h[(i, j)].im);
                }
            }
            Ok(all)
        })?;
        Ok(all.to_pyarray(python))
    }

    /// Resonances and plausibility of a measurement folder.
    fn identify(&self, python: Python<'_>, measurement: String) -> PyResult<NativeResults> {
        let machine = self.0.clone();
        results(python, move |stop| measured::identify(&machine, &measurement, stop))
    }

    /// The machine with the frequencies of a measurement folder, and the results.
    fn update(&self, python: Python<'_>, measurement: String) -> PyResult<(Self, NativeResults)> {
        let machine = self.0.clone();
        let (machine, found) = compute(python, move |stop| {
            let (machine, report) = measured::update(&machine, &measurement, stop)?;
            Ok((machine, NativeResults::of(report)?))
        })?;
        Ok((Self(machine), found))
    }

    /// The controller (JSON) that meets a weights file, and the results; `progress` is called with words.
    #[pyo3(signature = (weights, polish, progress=None))]
    fn design(
        &self,
        python: Python<'_>,
        weights: String,
        polish: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(String, NativeResults)> {
        let machine = self.0.clone();
        compute(python, move |stop| {
            let weights = weights_on(&machine, &weights)?;
            let settings = if polish { DesignSettings::with_polish() } else { DesignSettings::default() };
            let told = |event: Event<'_>| {
                stop.here();
                tell(progress.as_ref(), &event);
            };
            let study = study(&machine, &weights, &settings, Questions::default(), &mut { told })?;
            let report = design_report(&machine, &study, settings.route)?;
            Ok((controller_text(&study.design.delivery.controller), NativeResults::of(report)?))
        })
    }

    /// The corrected machine, and the results.
    fn diagnose(&self, python: Python<'_>, measurement: String) -> PyResult<(Self, NativeResults)> {
        let machine = self.0.clone();
        let (machine, found) = compute(python, move |stop| {
            let (machine, report) = measured::diagnose(&machine, &measurement, stop)?;
            Ok((machine, NativeResults::of(report)?))
        })?;
        Ok((Self(machine), found))
    }

    /// Modes of the free rotor over speed, as JSON.
    fn modes(&self, python: Python<'_>, rpm: Vec<f64>) -> PyResult<String> {
        let machine = self.0.clone();
        rpm.iter().try_for_each(|rpm| check_speed(*rpm).map(|_| ()))?;
        compute(python, move |_| Ok(json(&ModesSummary::of(&machine, &rpm)?).to_string()))
    }

    /// A tuned PID, or one with given numbers (a file or JSON): its controller as JSON, and the results.
    fn pid(
        &self,
        python: Python<'_>,
        numbers: Option<String>,
        rpm: Option<Vec<f64>>,
        seed: u64,
    ) -> PyResult<(String, NativeResults)> {
        let machine = self.0.clone();
        compute(python, move |_| {
            let settings = TuneSettings { seed, ..TuneSettings::quick() };
            let pid = match numbers {
                None => tune_pid(&machine, &settings)?,
                Some(numbers) => {
                    let rate_hz = machine.spindle.electronics.sample_rate_hz;
                    let given = if is_json(&numbers) {
                        read_pid("pid", &numbers, rate_hz)
                    } else {
                        load_pid(&numbers, rate_hz)
                    };
                    PidController { controller: given?.sample(&machine)?, origin: PidOrigin::Given, further: None }
                }
            };
            let top_rpm = machine.spindle.max_rpm;
            let rpm = rpm.unwrap_or_else(|| vec![0.0, 0.5 * top_rpm, top_rpm]);
            let found = PidLoop::close(&machine, pid, &rpm, settings.mode_shift)?;
            let report = pid_report(&machine, &found, &settings)?;
            Ok((controller_text(&found.pid.controller), NativeResults::of(report)?))
        })
    }

    /// Controllers (files or JSON) side by side at speeds in rpm.
    fn compare(
        &self,
        python: Python<'_>,
        controllers: Vec<String>,
        weights: String,
        rpm: Option<Vec<f64>>,
    ) -> PyResult<NativeResults> {
        let machine = self.0.clone();
        results(python, move |stop| {
            let weights = weights_on(&machine, &weights)?;
            let rpm = rpm.unwrap_or_else(|| vec![0.0, machine.spindle.max_rpm]);
            let ground = Ground {
                machine: &machine,
                speeds_rpm: &rpm,
                mode_uncertainty: &weights.mode_uncertainty,
                material: &CuttingMaterial::ALUMINIUM,
                cut: &Engagement::down_milling(machine.tool.teeth.unwrap_or(USUAL_TEETH), USUAL_WIDTH),
            };
            let mut report = Report::of("compare", &machine);
            let (mut met, mut list) = (true, vec![]);
            for (k, given) in controllers.iter().enumerate() {
                list.push((Role::Other(k), controller(given)?, KnownFigures::default()));
            }
            if list.is_empty() {
                let own = own_controllers(&machine, &weights, TuneSettings::quick(), &mut |_| stop.here())?;
                met = own.design.meets_targets();
                list = add_own(&mut report.summary, own);
            }
            let names = controller_keys(&list);
            let mut compared = vec![];
            for (name, (role, controller, known)) in names.iter().zip(&list) {
                stop.here();
                let one = compare_controller(&ground, name, controller, known)?;
                compared.push((*role, one));
            }
            let met = met && all_acceptable(&compared);
            add_compared(&mut report, &ground, &compared, vec![], met)?;
            Ok(report)
        })
    }

    /// Time response with a controller (a file or JSON); `options` by name: rpm, grade (m/s), force (N), push (s),
    /// duration (s), ramp (s), bus_voltage (V).
    fn simulate(
        &self,
        python: Python<'_>,
        controller: String,
        case: String,
        options: BTreeMap<String, f64>,
        noise_seed: Option<u64>,
    ) -> PyResult<NativeResults> {
        let machine = self.0.clone();
        results(python, move |_| {
            let names = SimulationCase::ALL.map(SimulationCase::name);
            let Some(case) = SimulationCase::from_name(&case) else {
                return Err(Failure::new(format!("case {case:?} is none of {}", names.join(", "))));
            };
            let option = |name: &str| options.get(name).copied();
            let wish = SimulationWish {
                case,
                speed_rpm: option("rpm"),
                grade_m_s: option("grade"),
                force_n: option("force"),
                push_s: option("push"),
                duration_s: option("duration"),
                ramp_s: option("ramp"),
            };
            let usual = TimeSettings::default();
            let bus_voltage_v = option("bus_voltage").unwrap_or(usual.bus_voltage_v);
            let settings = TimeSettings { noise_seed, bus_voltage_v, ..usual };
            let given = self::controller(&controller)?;
            let sampled = sample_controller(&machine, &given)?;
            let simulated = simulate_controller(&machine, &sampled, &wish, &settings)?;
            Ok(simulation_report(&machine, &given.name, case.name(), &simulated)?)
        })
    }

    /// A measurement folder of a machine (this one where none is given) at speeds in rpm, with this one as its model.
    fn rehearse(
        &self,
        python: Python<'_>,
        truth: Option<PyRef<'_, Self>>,
        controller: Option<String>,
        rpm: Vec<f64>,
        repeats: usize,
        seed: u64,
    ) -> PyResult<NativeResults> {
        let model = self.0.clone();
        let truth = truth.map_or_else(|| model.clone(), |truth| truth.0.clone());
        rpm.iter().try_for_each(|rpm| check_speed(*rpm).map(|_| ()))?;
        if !(1..=100).contains(&repeats) {
            return Err(to_value_error(format!("repeats = {repeats} must lie between 1 and 100")));
        }
        compute(python, move |stop| {
            let watch = || stop.here();
            let controller = match controller {
                Some(given) => self::controller(&given)?,
                None => levitating_pid(&model, &truth, &rpm, &watch)?,
            };
            let usual = Rehearsal::usual(&truth)?;
            let rehearsal = Rehearsal { repeats, seed, ..usual };
            let (controller, rehearsal) = (&controller, &rehearsal);
            let rig = RehearsedRig { truth: &truth, controller, rehearsal, speeds_rpm: &rpm, watch: &watch };
            let (folder, _) = rig.folder(&model)?;
            Ok(NativeResults::files_only(folder))
        })
    }

    /// One tool of a batch: its row as JSON, and its results.
    fn run_tool(
        &self,
        python: Python<'_>,
        weights: String,
        polish: bool,
        quick: bool,
    ) -> PyResult<(String, NativeResults)> {
        let machine = self.0.clone();
        compute(python, move |stop| {
            let weights = weights_on(&machine, &weights)?;
            let settings = if polish { DesignSettings::with_polish() } else { DesignSettings::default() };
            let task = Task {
                nominal: &machine,
                targets: None,
                weights: &weights,
                settings: &settings,
                pid: TuneSettings::quick(),
                extent: if quick { Extent::Controller } else { Extent::Everything },
            };
            let found = one_tool(&task, false, &mut |_| stop.here())?;
            let row = BatchRow::of(&machine.tool.name, "", &found);
            let report = tool_report(&found, &weights)?;
            Ok((json(&row).to_string(), NativeResults::of(report)?))
        })
    }

    /// Firmware files of a controller (a file or JSON), and a sentence about its stability.
    fn export(
        &self,
        python: Python<'_>,
        controller: String,
        prefix: Option<String>,
    ) -> PyResult<(String, NativeResults)> {
        let machine = self.0.clone();
        compute(python, move |_| {
            let given = self::controller(&controller)?;
            let sampled = sample_controller(&machine, &given)?;
            let (rows, _) = firmware_rows(&sampled.law, &machine)?;
            let verification = proven_as_rounded(&machine, &rows)?;
            let stability = stability_words(&verification);
            if !verification.is_proven() {
                return Err(Failure::new(stability));
            }
            let firmware = Firmware {
                discrete: &sampled.controller,
                continuous: sampled.prewarp_hz.map(|_| &given),
                scaled: &rows,
                verification: &verification,
                machine: &format!("{} with {}", machine.spindle.name, machine.tool.name),
                tag: None,
                prefix: &prefix.unwrap_or_else(|| c_identifier(machine.short_name())),
            };
            let written = write_all(&firmware, &Format::ALL)?;
            let mut folder = ResultsFolder::new();
            for (name, bytes) in written.files {
                folder.add(&name, bytes)?;
            }
            Ok((stability, NativeResults::files_only(folder)))
        })
    }
}

/// True for the text of a JSON object, which no path is.
fn is_json(given: &str) -> bool {
    given.trim_start().starts_with('{')
}

/// A controller of a file or of its JSON text.
fn controller(given: &str) -> Result<Controller, InputError> {
    if is_json(given) { read_controller("controller", given) } else { load_controller(given) }
}

/// The weights of a file, a shipped name or a JSON text, on a machine.
fn weights_on(machine: &Machine, given: &str) -> Result<Weights, Failure> {
    let found = if is_json(given) { read_weights("weights", given) } else { load_weights(given) };
    Ok(found?.on(machine)?)
}

fn controller_text(controller: &Controller) -> String {
    String::from_utf8_lossy(&controller_json(controller, None)).into_owned()
}

/// Calls `progress` with the words of an event; an exception there ends the computation.
fn tell(progress: Option<&Py<PyAny>>, event: &Event<'_>) {
    let Some(progress) = progress else {
        return;
    };
    let words = match event {
        Event::Begins(part) => (*part).to_owned(),
        Event::Found(words) => (*words).to_owned(),
        Event::Stage(stage) => format!("done: {stage}"),
        Event::Step(step) => format!("D-K step {}: mu {:.4}", step.iteration + 1, step.mu_peak),
    };
    if let Err(error) = Python::attach(|python| progress.call1(python, (words,)).map(|_| ())) {
        end_with(error);
    }
}

/// Order of a Padé approximant beyond which its coefficients leave the range where they are exact.
const PADE_LIMIT: usize = 10;

fn check_speed(rpm: f64) -> PyResult<f64> {
    if rpm.is_finite() && rpm >= 0.0 {
        Ok(rpm * TAU / 60.0)
    } else {
        Err(to_value_error(format!("rpm = {rpm} must be zero or a positive number")))
    }
}
