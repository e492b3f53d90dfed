//! The cascade of a run-up: spectra at the tool over speed as a picture and as a topic of the summary.

use super::plot::figure::{Axis, Figure, HeatMap, Panel, Series};
use super::plot::{Color, Dash, Look};
use crate::predict::cascade::{Cascade, FORCE_DENSITY_N, UNBALANCE_KG_M};
use serde_json::{Value, json};

/// 1 g mm in kg m.
pub(super) const GRAM_MILLIMETRE: f64 = 1e-6;
/// What 0 dB stands for, m.
const NANOMETRE: f64 = 1e-9;
/// Largest range of the colours, dB.
const RANGE_DB: f64 = 80.0;

fn source(cascade: &Cascade) -> String {
    let width = cascade.edges_hz.windows(2).next().map_or(0.0, |ends| ends[1] - ends[0]);
    format!(
        "linear loop of the full model, unbalance of {} g mm and a force of {FORCE_DENSITY_N} N/√Hz at the tool, lines \
         of {width:.1} Hz",
        UNBALANCE_KG_M / GRAM_MILLIMETRE
    )
}

/// `simulation.cascade`: what the spectra are of, and for each speed the rms of all lines and of the unbalance.
pub(crate) fn cascade_topic(cascade: &Cascade) -> Value {
    let (rpm, hz, rms) = cascade.largest();
    let sentence = format!(
        "Cascade of a run-up: {}; the largest line is {:.3} µm rms at {hz:.0} Hz and {rpm:.0} rpm.",
        source(cascade),
        1e6 * rms
    );
    let rows = cascade.speed_rpm.iter().zip(&cascade.rms_m).zip(&cascade.unbalance_rms_m);
    let rows = rows.map(|((rpm, lines), once)| {
        let all = lines.iter().map(|line| line * line).sum::<f64>().sqrt();
        json!({ "speed_rpm": rpm, "rms_m": all, "unbalance_rms_m": once })
    });
    json!({
        "sentence": sentence,
        "force_n_per_sqrt_hz": FORCE_DENSITY_N,
        "unbalance_kg_m": UNBALANCE_KG_M,
        "speeds": rows.collect::<Vec<_>>(),
    })
}

/// Lines over frequency, a row a speed, with the line of the speed.
pub(crate) fn cascade_figure(cascade: &Cascade) -> Figure {
    let names = cascade.speed_rpm.iter().map(|rpm| format!("{rpm:.0}")).collect();
    let mut panel = Panel::new("", Axis::linear("Frequency", "Hz"), Axis::categories("Speed (rpm)", names));
    let decibels = |rms: &f64| 20.0 * (rms / NANOMETRE).max(f64::MIN_POSITIVE).log10();
    let values: Vec<Vec<f64>> = cascade.rms_m.iter().map(|lines| lines.iter().map(decibels).collect()).collect();
    let top = values.iter().flatten().fold(f64::NEG_INFINITY, |a: f64, b| a.max(*b));
    let top = if top.is_finite() { (top / 10.0).ceil() * 10.0 } else { 0.0 };
    let least = values.iter().flatten().fold(top, |a: f64, b| a.min(*b));
    let bottom = ((least / 10.0).floor() * 10.0).clamp(top - RANGE_DB, top - 10.0);
    panel.heat = Some(HeatMap {
        x_edges: cascade.edges_hz.clone(),
        values,
        label: "Displacement in x (dB over 1 nm rms)".to_owned(),
        range: [bottom, top],
    });
    let once: Vec<f64> = cascade.speed_rpm.iter().map(|rpm| rpm / 60.0).collect();
    let rows: Vec<f64> = (0..once.len()).map(|row| row as f64).collect();
    let look = Look::line(Color::Vermillion, Dash::Dashed).with_width(1.2);
    panel.series.push(Series::curve("1 × speed", &once, &rows, look));
    panel.height_px = 520;
    let words = format!("Spectrum of the displacement of the tool at each speed: {}.", source(cascade));
    Figure::new("Cascade of the run-up: spectra at the tool over speed", &words, vec![panel])
}
