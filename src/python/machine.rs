//! A spindle with its tool as Python holds it.

use super::compute::compute;
use super::convert::{SystemOut, system, to_value_error};
use crate::cli::Failure;
use crate::cli::embedded;
use crate::export::json::controller_json;
use crate::input::{load_machine, load_weights, spindle_yaml, tool_yaml};
use crate::lti::Response;
use crate::spindle::{Machine, ModelDetail, Plant};
use numpy::{Complex64, PyArray3, ToPyArray};
use pyo3::prelude::*;
use std::f64::consts::TAU;

/// A machine.
#[pyclass(name = "Machine", frozen)]
pub(super) struct NativeMachine(Machine);

/// Rows and columns of the response: four axes, two directions of the tool plane.
const CHANNELS: usize = 6;

#[pymethods]
impl NativeMachine {
    /// Reads a spindle and a tool: paths or shipped names.
    #[staticmethod]
    fn load(python: Python<'_>, spindle: String, tool: String) -> PyResult<Self> {
        compute(python, move |_| load_machine(&spindle, &tool).map_err(|e| words(e.into()))).map(Self)
    }

    /// Name of the spindle and of the tool.
    fn names(&self) -> (String, String) {
        (self.0.spindle.name.clone(), self.0.tool.name.clone())
    }

    /// Top speed, rpm.
    fn max_rpm(&self) -> f64 {
        self.0.spindle.max_rpm
    }

    /// The spindle file and the tool file.
    fn files(&self) -> (String, String) {
        (spindle_yaml(&self.0.spindle), tool_yaml(&self.0.tool))
    }

    /// The design model at a speed as a continuous system with Padé approximants of the delay.
    fn plant<'py>(&self, python: Python<'py>, rpm: f64, pade_order: usize) -> PyResult<SystemOut<'py>> {
        let (machine, speed) = (self.0.clone(), check_speed(rpm)?);
        if pade_order > PADE_LIMIT {
            return Err(to_value_error(format!("pade_order = {pade_order} must be at most {PADE_LIMIT}")));
        }
        let found = compute(python, move |_| {
            let plant = Plant::design_model(&machine, speed).map_err(|e| e.to_string())?;
            plant.state_space(pade_order).map_err(|e| e.to_string())
        })?;
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
            let plant = Plant::new(&machine, speed, ModelDetail::Full).map_err(|e| e.to_string())?;
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

    /// The machine with the frequencies of a measurement folder, and the figures as JSON.
    fn update(&self, python: Python<'_>, measurement: String) -> PyResult<(Self, String)> {
        let machine = self.0.clone();
        let (machine, figures) =
            compute(python, move |_| embedded::update_machine(&machine, &measurement).map_err(words))?;
        Ok((Self(machine), figures.to_string()))
    }

    /// The controller (JSON) that meets a weights file, and the figures as JSON.
    fn design(&self, python: Python<'_>, weights: String, polish: bool) -> PyResult<(String, String)> {
        let machine = self.0.clone();
        let (design, figures) = compute(python, move |stop| {
            let weights = load_weights(&weights).map_err(|e| words(e.into()))?;
            let progress = || stop.here();
            embedded::design_controller(&machine, &weights, polish, &progress).map_err(words)
        })?;
        let controller = controller_json(&design.delivery.controller, None);
        Ok((String::from_utf8_lossy(&controller).into_owned(), figures.to_string()))
    }

    /// The corrected machine, and the figures as JSON.
    fn diagnose(&self, python: Python<'_>, measurement: String) -> PyResult<(Self, String)> {
        let machine = self.0.clone();
        let (machine, figures) = compute(python, move |stop| {
            let progress = || stop.here();
            embedded::diagnose_machine(&machine, &measurement, &progress).map_err(words)
        })?;
        Ok((Self(machine), figures.to_string()))
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

/// The words of a failure, hint included, without the `error:` that a terminal shows.
fn words(failure: Failure) -> String {
    let text = failure.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    text.trim_end().to_owned()
}
