//! Pictures of frequency responses and loops: Bode, dynamic stiffness, sensitivity, Nyquist.

use super::Curve;
use super::figure::{Axis, Figure, Mark, Panel, Series};
use super::style::{Color, Dash, Look, Marker};
use crate::linalg::c64;
use crate::update::PeakKind;

/// A published or measured frequency to mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkedFrequency {
    /// Hz.
    pub frequency_hz: f64,
    /// Resonance or antiresonance.
    pub peak: PeakKind,
}

/// Bode diagram over Hz, magnitude over phase. `quantity` and `unit` name the magnitude (`|sensor / current|`, `m/A`);
/// marked frequencies stand above it.
pub fn bode(title: &str, quantity: &str, unit: &str, curves: &[Curve<c64>], marked: &[MarkedFrequency]) -> Figure {
    let mut panels = bode_panels(quantity, unit);
    for c in curves {
        add_response(&mut panels, c.name, c.x, c.y, c.role.look());
    }
    panels[0].marks = marks(marked, true);
    panels[1].marks = marks(marked, false);
    let names: Vec<&str> = curves.iter().map(|c| c.name).collect();
    let words = format!("Magnitude and phase over frequency of {}.", names.join(", "));
    Figure::stacked(title, &words, panels)
}

/// Panels of magnitude and phase; `quantity` and `unit` name the magnitude.
pub(super) fn bode_panels(quantity: &str, unit: &str) -> [Panel; 2] {
    let frequency = || Axis::log("Frequency", "Hz");
    let degrees = Axis::linear("Phase", "°").with_range(-180.0, 180.0).with_step(90.0);
    let phase = Panel { height_px: 215, ..Panel::new("", frequency(), degrees) };
    [Panel::new("", frequency(), Axis::log(quantity, unit)), phase]
}

/// Adds magnitude and phase of a response; the phase is broken where it jumps round.
pub(super) fn add_response([magnitude, phase]: &mut [Panel; 2], name: &str, x: &[f64], response: &[c64], look: Look) {
    let size: Vec<f64> = response.iter().map(|h| h.norm()).collect();
    let angle: Vec<f64> = response.iter().map(|h| h.arg().to_degrees()).collect();
    magnitude.series.push(Series::curve(name, x, &size, look));
    phase.series.push(Series { break_at_jump: Some(180.0), ..Series::curve(name, x, &angle, look) });
}

fn marks(marked: &[MarkedFrequency], labelled: bool) -> Vec<Mark> {
    marked
        .iter()
        .filter(|m| m.frequency_hz.is_finite())
        .map(|m| {
            let (color, dash, legend) = match m.peak {
                PeakKind::Resonance => (Color::Vermillion, Dash::Dashed, "published resonance"),
                PeakKind::Antiresonance => (Color::Green, Dash::Dotted, "published antiresonance"),
            };
            let label = if labelled { format!("{:.0}", m.frequency_hz) } else { String::new() };
            Mark { value: m.frequency_hz, label, color, dash, legend: legend.to_owned() }
        })
        .collect()
}

/// Dynamic stiffness at the tool, one panel an axis. Curves are in N/m over Hz; the picture is in N/µm.
/// `marked_hz` are frequencies of interest (the spindle frequency) with their labels.
pub fn dynamic_stiffness(title: &str, panels: &[(impl AsRef<str>, Vec<Curve>)], marked_hz: &[(f64, &str)]) -> Figure {
    let drawn = panels.iter().enumerate().map(|(k, (name, curves))| {
        let mut panel = Panel::new(name.as_ref(), Axis::log("Frequency", "Hz"), Axis::log("Dynamic stiffness", "N/µm"));
        panel.series = curves.iter().map(|c| c.map_values(|y| 1e-6 * y)).collect();
        panel.marks =
            marked_hz.iter().map(|(value, label)| Mark::dotted(*value, if k == 0 { label } else { "" })).collect();
        panel.height_px = if panels.len() > 1 { 280 } else { 380 };
        panel
    });
    let words = "Magnitude of force over displacement at the tool plane over frequency; higher is stiffer.";
    Figure::stacked(title, words, drawn)
}

/// Adds the zone limits of ISO 14839-3, dB.
pub(crate) fn add_zone_limits(panel: &mut Panel) {
    for (value, label) in [(9.5, "A | B  9.5"), (12.0, "B | C  12"), (14.0, "C | D  14")] {
        panel.level(value, label);
    }
}

/// Sensitivity of each axis in dB with the zone limits of ISO 14839-3. `panels`: axis name and curves of |S| (plain
/// ratio) over Hz.
pub fn sensitivity(title: &str, panels: &[(impl AsRef<str>, Vec<Curve>)]) -> Figure {
    let values = || panels.iter().flat_map(|p| &p.1).flat_map(|c| c.y.iter().copied());
    let lowest = values().filter(|y| *y > 0.0).fold(0.1, f64::min);
    let highest = values().filter(|y| y.is_finite()).fold(6.0, f64::max);
    // One range for all axes, so that they can be compared; below −40 dB nothing is decided.
    let low = (10.0 * (2.0 * lowest.log10()).floor()).max(-40.0);
    let high = 5.0 * (4.0 * highest.log10()).ceil();
    let drawn = panels.iter().map(|(name, curves)| {
        let y = Axis::linear("|S|", "dB").with_range(low, high.max(20.0));
        let mut panel = Panel::new(name.as_ref(), Axis::log("Frequency", "Hz"), y);
        panel.series = curves.iter().map(|c| c.map_values(|s| 20.0 * s.log10())).collect();
        add_zone_limits(&mut panel);
        panel.height_px = 290;
        panel
    });
    let columns = if panels.len() > 1 { 2 } else { 1 };
    Figure::new(
        title,
        "Sensitivity of each control axis; the dashed lines are the zone limits A, B, C, D of ISO 14839-3 in dB.",
        drawn.collect(),
    )
    .with_columns(columns)
}

/// Nyquist curves of open loops L (the critical point is −1: pass L of the negative-feedback loop), with the circle of
/// the largest admissible sensitivity round it.
pub fn nyquist(title: &str, loops: &[Curve<c64>]) -> Figure {
    let range = 3.0;
    let mut panel = Panel::new(
        "",
        Axis::linear("Real part of L", "").with_range(-range, range),
        Axis::linear("Imaginary part of L", "").with_range(-range, range),
    );
    panel.equal_aspect = true;
    panel.height_px = 520;
    panel.series.push(Series::curve("critical point", &[-1.0], &[0.0], Look::points(Color::Black, Marker::Cross)));
    for l in loops {
        panel.series.push(Series::of_points(l.name, l.y.iter().map(|h| (h.re, h.im)), l.role.look()));
    }
    Figure::new(title, "Open loops in the complex plane near the critical point.", vec![panel])
}
