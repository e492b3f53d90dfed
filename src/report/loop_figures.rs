//! The pictures that control engineers know: Bode diagram of the controller, Nyquist diagram, closed-loop poles,
//! Campbell diagram, unbalance response over speed.

use super::pictures::Picture;
use super::plot::figure::{Axis, Figure, Mark, Panel, Series};
use super::plot::loops::{ResponseCurve, bode, nyquist};
use super::plot::shaft::{CampbellLine, campbell};
use super::plot::{Color, Dash, Look, Marker, Role};
use super::summary::finite;
use crate::controller::Controller;
use crate::pipeline::PipelineError;
use crate::pipeline::comparison::Prediction;
use crate::predict::loop_shape::{DiscMargin, LoopShape, unbalance_response};
use crate::rotor::modes::PlanarModes;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use serde::Serialize;
use std::f64::consts::TAU;

/// Speeds of the unbalance response: 2 % of the top speed apart.
const UNBALANCE_SPEEDS: usize = 60;
/// Speeds of the Campbell diagram.
const CAMPBELL_SPEEDS: usize = 9;
/// The Campbell diagram ends there, Hz: the bending modes that a bearing acts on.
const CAMPBELL_TO_HZ: f64 = 5000.0;
/// 1 g mm in kg m.
const GRAM_MILLIMETRE: f64 = 1e-6;

/// Pictures, and the disc margin of the loop at rest; nothing of a loop that is unstable at rest.
pub type LoopFigures = (Vec<(Picture, Figure)>, Option<DiscMargin>);

/// The pictures of a controller; `rest` and `speed` are its predictions at rest and at top speed.
///
/// # Errors
/// [`PipelineError`] when a plant or an eigenvalue iteration fails.
pub fn loop_figures(
    machine: &Machine,
    controller: &Controller,
    [rest, speed]: [&Prediction; 2],
) -> Result<LoopFigures, PipelineError> {
    let mut figures = vec![(Picture::Campbell, campbell_of(machine)?)];
    if !rest.is_stable() {
        return Ok((figures, None));
    }
    let plant = Plant::new(machine, 0.0, ModelDetail::Full)?;
    let lines = &lines(&plant, &rest.sensitivity.frequency_hz);
    let shape = LoopShape::new(&plant, controller, lines).map_err(SpindleError::from)?;
    let names = ["front to front", "rear to rear", "rear to front"];
    let roles = [Role::Mu, Role::Pid, Role::Other(0)];
    let curves: Vec<ResponseCurve> = (0..3)
        .map(|k| ResponseCurve {
            name: names[k],
            role: roles[k],
            frequency_hz: lines,
            response: &shape.controller[k],
        })
        .collect();
    figures.push((
        Picture::ControllerBode,
        bode(
            "Controller with its hold",
            "|current / displacement|",
            "A/m",
            &curves,
            &[],
        ),
    ));
    let names: Vec<String> = (1..=shape.loci.len())
        .map(|k| format!("locus {k}"))
        .collect();
    let loci: Vec<ResponseCurve> = names
        .iter()
        .zip(&shape.loci)
        .enumerate()
        .map(|(k, (name, locus))| ResponseCurve {
            name,
            role: Role::Other(k),
            frequency_hz: lines,
            response: locus,
        })
        .collect();
    let margin = shape.disc_margin();
    figures.push((
        Picture::Nyquist,
        nyquist(
            "Characteristic loci of the loop at rest",
            &loci,
            shape.peak_sensitivity.0,
        ),
    ));
    figures.push((Picture::Poles, poles([rest, speed])));
    let top = machine.spindle.max_rpm;
    figures.push((
        Picture::UnbalanceSpeed,
        unbalance(machine, controller, top)?,
    ));
    Ok((figures, Some(margin)))
}

/// The lines of the predictions, dense round the poles of the closed loop, with more round those of the open one:
/// ratios from a tenth of a damping width to a tenth of the frequency.
fn lines(plant: &Plant, closed: &[f64]) -> Vec<f64> {
    let mut all = closed.to_vec();
    let (Some(low), Some(high)) = (closed.first().copied(), closed.last().copied()) else {
        return all;
    };
    for omega in plant.flexible_rad_s() {
        for k in 0..24 {
            let step = 4e-4 * 250f64.powf(f64::from(k) / 23.0);
            all.extend([1.0 - step, 1.0 + step].map(|ratio| omega / TAU * ratio));
        }
        all.push(omega / TAU);
    }
    all.retain(|hz| (low..=high).contains(hz));
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// `margins.<controller>`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MarginSummary {
    disc_radius: Option<f64>,
    frequency_hz: Option<f64>,
    smallest_gain_factor: Option<f64>,
    largest_gain_factor: Option<f64>,
    phase_deg: Option<f64>,
}

impl From<&DiscMargin> for MarginSummary {
    fn from(margin: &DiscMargin) -> Self {
        let [low, high] = margin.gain();
        Self {
            disc_radius: finite(margin.radius),
            frequency_hz: finite(margin.frequency_hz),
            smallest_gain_factor: finite(low),
            largest_gain_factor: finite(high),
            phase_deg: finite(margin.phase_deg()),
        }
    }
}

fn top_speed(value: f64) -> Mark {
    Mark {
        value,
        label: "top speed".to_owned(),
        color: Color::Grey,
        dash: Dash::Dotted,
        legend: String::new(),
    }
}

fn poles(runs: [&Prediction; 2]) -> Figure {
    let mut panel = Panel::new(
        "",
        Axis::log("Frequency |s|/2π", "Hz"),
        Axis::log("Damping ratio", ""),
    );
    panel.height_px = 320;
    let looks = [
        Look::points(Color::Blue, Marker::Circle),
        Look::points(Color::Vermillion, Marker::Triangle),
    ];
    for (run, look) in runs.into_iter().zip(looks).filter(|(r, _)| r.is_stable()) {
        let found: Vec<(f64, f64)> = run
            .poles_rad_s
            .iter()
            .filter(|s| s.im > 0.0 && s.norm() > TAU)
            .map(|s| (s.norm() / TAU, -s.re / s.norm()))
            .collect();
        let (x, y): (Vec<f64>, Vec<f64>) = found.into_iter().unzip();
        let name = format!("{:.0} rpm", run.speed_rpm);
        panel.series.push(Series::curve(&name, &x, &y, look));
    }
    Figure::new(
        "Closed-loop poles",
        "Damping ratio of the oscillating poles of the sampled loop over their frequency, s = ln(z)/T.",
        vec![panel],
    )
}

fn campbell_of(machine: &Machine) -> Result<Figure, PipelineError> {
    let rotor = machine.rotor()?;
    let top = machine.spindle.max_rpm;
    // The rigid-body modes of the free rotor stay far below half its first bending mode.
    let bending = PlanarModes::new(&rotor).map_err(SpindleError::from)?;
    let lowest = 0.5 * TAU * bending.flexible_hz().first().copied().unwrap_or_default();
    let mut lines: Vec<CampbellLine> = vec![];
    for k in 1..=CAMPBELL_SPEEDS {
        let rpm = top * k as f64 / CAMPBELL_SPEEDS as f64;
        let found = machine.whirl(rpm * TAU / 60.0, CAMPBELL_TO_HZ)?;
        for sense in [-1i8, 1] {
            let whirling = found.modes.iter().filter(|m| m.whirl as i8 == sense);
            for mode in whirling.filter(|m| m.natural_rad_s > lowest) {
                // Modes come in ascending order: each goes to the first line that has none at this speed yet.
                let open = |l: &CampbellLine| l.whirl == sense && l.speed_rpm.len() == k - 1;
                let at = match lines.iter().position(open) {
                    Some(at) => at,
                    None if k == 1 => {
                        lines.push(CampbellLine {
                            whirl: sense,
                            speed_rpm: vec![],
                            frequency_hz: vec![],
                        });
                        lines.len() - 1
                    }
                    None => break,
                };
                lines[at].speed_rpm.push(rpm);
                lines[at].frequency_hz.push(mode.natural_rad_s / TAU);
            }
        }
    }
    Ok(campbell(
        "Bending modes of the free rotor over speed",
        &lines,
        &[1.0, 2.0],
    ))
}

fn unbalance(
    machine: &Machine,
    controller: &Controller,
    top: f64,
) -> Result<Figure, PipelineError> {
    let speeds: Vec<f64> = (1..=UNBALANCE_SPEEDS)
        .map(|k| 1.2 * top * k as f64 / UNBALANCE_SPEEDS as f64)
        .collect();
    let found = unbalance_response(machine, controller, &speeds)?;
    let mut panel = Panel::new(
        "",
        Axis::linear("Speed", "rpm"),
        Axis::log("Displacement for 1 g mm at the tool", "µm"),
    );
    panel.marks.push(top_speed(top));
    let looks = [
        ("tool", Color::Blue, Dash::Solid),
        ("front bearing", Color::Vermillion, Dash::Dashed),
        ("rear bearing", Color::Green, Dash::DashDot),
    ];
    for (k, (name, color, dash)) in looks.into_iter().enumerate() {
        let y: Vec<f64> = found.iter().map(|d| d[k] * GRAM_MILLIMETRE * 1e6).collect();
        panel
            .series
            .push(Series::curve(name, &speeds, &y, Look::line(color, dash)));
    }
    Ok(Figure::new(
        "Unbalance response over speed",
        "Amplitude of the circular motion that an unbalance of 1 g mm at the tool plane causes, closed loop of the \
         full model.",
        vec![panel],
    ))
}
