//! The pictures that control engineers know: Bode diagram of the controller, Nyquist diagram, closed-loop poles,
//! Campbell diagram, unbalance response over speed.

use super::pictures::Picture;
use super::plot::figure::{Axis, Figure, Mark, Panel, Series};
use super::plot::loops::{ResponseCurve, bode, nyquist};
use super::plot::shaft::{CampbellLine, campbell};
use super::plot::{Color, Dash, Look, Marker, Role};
use super::summary::finite;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::loop_curves::{LoopCurves, UnbalanceCurve, WhirlLine};
use crate::predict::loop_shape::{DiscMargin, LoopShape};
use serde::Serialize;
use std::f64::consts::TAU;

/// 1 g mm in kg m.
const GRAM_MILLIMETRE: f64 = 1e-6;

/// The pictures of a loop; `runs` are its predictions at rest and at top speed. Of a loop that is unstable at rest only
/// that of the free rotor.
pub(crate) fn loop_figures(curves: &LoopCurves, runs: [&Prediction; 2], top_rpm: f64) -> Vec<(Picture, Figure)> {
    let whirl: Vec<CampbellLine> = curves.whirl.iter().map(CampbellLine::from).collect();
    let whirl = campbell("Bending modes of the free rotor over speed", &whirl, &[1.0, 2.0]);
    let mut figures = vec![(Picture::Campbell, whirl)];
    let Some(stable) = &curves.stable else {
        return figures;
    };
    figures.push((Picture::ControllerBode, controller_bode(&stable.shape)));
    figures.push((Picture::Nyquist, loci(&stable.shape)));
    figures.push((Picture::Poles, poles(runs)));
    let unbalance = unbalance(&stable.unbalance, top_rpm);
    figures.push((Picture::UnbalanceSpeed, unbalance));
    figures
}

impl From<&WhirlLine> for CampbellLine {
    fn from(line: &WhirlLine) -> Self {
        Self { whirl: line.whirl, speed_rpm: line.speed_rpm.clone(), frequency_hz: line.frequency_hz.clone() }
    }
}

fn controller_bode(shape: &LoopShape) -> Figure {
    let names = ["front to front", "rear to rear", "rear to front"];
    let roles = [Role::Mu, Role::Pid, Role::Other(0)];
    let curves: Vec<ResponseCurve> = (0..3)
        .map(|k| ResponseCurve {
            name: names[k],
            role: roles[k],
            frequency_hz: &shape.frequency_hz,
            response: &shape.controller[k],
        })
        .collect();
    bode("Controller with its hold", "|current / displacement|", "A/m", &curves, &[])
}

fn loci(shape: &LoopShape) -> Figure {
    let names: Vec<String> = (1..=shape.loci.len()).map(|k| format!("locus {k}")).collect();
    let loci: Vec<ResponseCurve> = names
        .iter()
        .zip(&shape.loci)
        .enumerate()
        .map(|(k, (name, locus))| ResponseCurve {
            name,
            role: Role::Other(k),
            frequency_hz: &shape.frequency_hz,
            response: locus,
        })
        .collect();
    nyquist("Characteristic loci of the loop at rest", &loci, shape.peak_sensitivity.0)
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

fn poles(runs: [&Prediction; 2]) -> Figure {
    let mut panel = Panel::new("", Axis::log("Frequency |s|/2π", "Hz"), Axis::log("Damping ratio", ""));
    panel.height_px = 320;
    let looks = [Look::points(Color::Blue, Marker::Circle), Look::points(Color::Vermillion, Marker::Triangle)];
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

fn unbalance(curve: &UnbalanceCurve, top_rpm: f64) -> Figure {
    let mut panel =
        Panel::new("", Axis::linear("Speed", "rpm"), Axis::log("Displacement for 1 g mm at the tool", "µm"));
    panel.marks.push(Mark::top_speed(top_rpm));
    let looks = [
        ("tool", Color::Blue, Dash::Solid),
        ("front bearing", Color::Vermillion, Dash::Dashed),
        ("rear bearing", Color::Green, Dash::DashDot),
    ];
    for (k, (name, color, dash)) in looks.into_iter().enumerate() {
        let size = curve.displacement.iter();
        let y: Vec<f64> = size.map(|d| d[k] * GRAM_MILLIMETRE * 1e6).collect();
        panel.series.push(Series::curve(name, &curve.speed_rpm, &y, Look::line(color, dash)));
    }
    Figure::new(
        "Unbalance response over speed",
        "Amplitude of the circular motion that an unbalance of 1 g mm at the tool plane causes, closed loop of the \
         full model.",
        vec![panel],
    )
}
