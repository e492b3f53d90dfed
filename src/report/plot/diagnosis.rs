//! Pictures of diagnosis: residual in standard deviations, localisation map, recovered impedance, ranking of
//! hypotheses.

use super::Curve;
use super::figure::{Axis, Figure, HeatMap, Panel, Series, SeriesShape};
use super::loops::{add_response, bode_panels};
use super::style::{Color, Dash, Look, Marker, Role};
use crate::linalg::c64;

/// Columns of a localisation map; more lines are pooled by their largest score.
const MAP_COLUMNS: usize = 160;

/// Residual before and after in units of σ, one panel a channel, two a row.
pub fn residual(title: &str, panels: &[(&str, Vec<Curve>)]) -> Figure {
    let drawn = panels.iter().map(|(name, curves)| {
        let mut panel = Panel::new(name, Axis::log("Frequency", "Hz"), Axis::log("Residual", "σ"));
        panel.series = curves.iter().map(Curve::series).collect();
        panel.level(1.0, "1 σ");
        panel.height_px = 215;
        panel
    });
    Figure::new(title, "Difference of measurement and model in standard deviations over frequency.", drawn.collect())
        .with_columns(if panels.len() > 1 { 2 } else { 1 })
}

/// One channel: measured, before, after in magnitude and phase, and the residuals before and after in σ.
pub fn channel(
    title: &str,
    quantity: &str,
    unit: &str,
    frequency_hz: &[f64],
    [measured, before, after]: [&[c64]; 3],
    residuals: [&[f64]; 2],
) -> Figure {
    let mut panels = bode_panels(quantity, unit);
    let mut sigma = Panel::new("", Axis::log("Frequency", "Hz"), Axis::log("Residual", "σ"));
    for (name, response, look) in [
        ("model before", before, Role::Nominal.look()),
        ("model after", after, Role::Updated.look()),
        ("measured", measured, Role::Measured.look()),
    ] {
        add_response(&mut panels, name, frequency_hz, response, look);
    }
    for (name, values, role) in
        [("model before", residuals[0], Role::Nominal), ("model after", residuals[1], Role::Updated)]
    {
        sigma.series.push(Series::curve(name, frequency_hz, values, role.look()));
    }
    sigma.level(1.0, "1 σ");
    (panels[0].height_px, panels[1].height_px, sigma.height_px) = (215, 130, 190);
    Figure::stacked(
        title,
        "Measured response with the model before and after the correction, magnitude and phase, and the residuals in \
         standard deviations.",
        panels.into_iter().chain([sigma]),
    )
}

/// Localisation map of what remains: dark is unexplained, light is explained. Rows from the top, the machine without a
/// law first.
pub(crate) fn localisation_left(
    title: &str,
    ports: &[String],
    frequency_hz: &[f64],
    left: &[Vec<f64>],
    label: &str,
) -> Figure {
    // Categories count from the bottom.
    let names: Vec<String> = ports.iter().rev().cloned().collect();
    let rows: Vec<Vec<f64>> = left.iter().rev().cloned().collect();
    let mut figure = localisation(title, &names, frequency_hz, &rows, label);
    for panel in &mut figure.panels {
        panel.series.clear();
    }
    figure.description =
        "What a free law at each place leaves unexplained, over frequency; light is explained.".to_owned();
    figure
}

/// Localisation map: score of every port over frequency. `scores[port][line]` belong to `frequency_hz[line]`.
/// The port and line with the largest score carry a diamond.
pub fn localisation(title: &str, ports: &[String], frequency_hz: &[f64], scores: &[Vec<f64>], label: &str) -> Figure {
    let group = frequency_hz.len().div_ceil(MAP_COLUMNS).max(1);
    let groups: Vec<&[f64]> = frequency_hz.chunks(group).collect();
    let centres: Vec<f64> = groups.iter().map(|g| g.iter().sum::<f64>() / g.len() as f64).collect();
    let pooled: Vec<Vec<f64>> = scores
        .iter()
        .map(|row| row.chunks(group).map(|g| g.iter().copied().fold(f64::NEG_INFINITY, f64::max)).collect())
        .collect();
    // Edges half way (in the logarithm) between the columns.
    let mut edges: Vec<f64> = centres.windows(2).map(|w| w.iter().product::<f64>().sqrt()).collect();
    edges.insert(0, frequency_hz.first().copied().unwrap_or(1.0));
    edges.push(frequency_hz.last().copied().unwrap_or(10.0));
    let cells = || pooled.iter().enumerate().flat_map(|(row, v)| v.iter().enumerate().map(move |(k, s)| (row, k, *s)));
    let (low, high) = cells()
        .map(|c| c.2)
        .filter(|s| s.is_finite())
        .fold((0.0f64, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)));
    let high = if high > low { high } else { low + 1.0 };
    let mut panel = Panel::new("", Axis::log("Frequency", "Hz"), Axis::categories("", ports.to_vec()));
    let best = cells().filter(|c| c.2.is_finite()).fold(None, |best: Option<(usize, usize, f64)>, c| match best {
        Some(b) if b.2 >= c.2 => Some(b),
        _ => Some(c),
    });
    if let Some((row, column, _)) = best {
        let x = centres.get(column).copied().unwrap_or(f64::NAN);
        let look = Look::points(Color::Orange, Marker::Diamond);
        let name = format!("largest score: {}", ports.get(row).map_or("", String::as_str));
        panel.series.push(Series::curve(&name, &[x], &[row as f64], look));
    }
    panel.heat = Some(HeatMap { x_edges: edges, values: pooled, label: label.to_owned(), range: [low, high] });
    panel.height_px = 70 + 22 * ports.len().clamp(4, 40) as u32;
    Figure::new(
        title,
        "How well a missing effect at each port would explain the difference, over frequency.",
        vec![panel],
    )
}

/// Recovered impedance at the port that was found, with the fitted shape: magnitude and phase.
pub fn impedance(
    title: &str,
    unit: &str,
    frequency_hz: &[f64],
    recovered: &[c64],
    fitted: &[c64],
    shape: &str,
) -> Figure {
    let mut panels = bode_panels("Magnitude", unit);
    let fitted_name = format!("fitted: {shape}");
    let both = [
        ("recovered from the data", recovered, data_look(frequency_hz.len())),
        (fitted_name.as_str(), fitted, Look::line(Color::Blue, Dash::Solid)),
    ];
    for (name, values, look) in both.into_iter().filter(|b| b.1.len() == frequency_hz.len()) {
        add_response(&mut panels, name, frequency_hz, values, look);
    }
    (panels[0].height_px, panels[1].height_px) = (250, 200);
    let words = "Impedance that the model lacks, as recovered from the data, and the fitted shape.";
    Figure::stacked(title, words, panels)
}

/// Data as open circles, or as a dotted line where circles would run into each other.
fn data_look(points: usize) -> Look {
    if points <= 120 { Look::points(Color::Black, Marker::Circle) } else { Role::Measured.look() }
}

/// Ranking of hypotheses: the larger the score the better. Best first; drawn from the top.
pub fn ranking(title: &str, names: &[String], scores: &[f64], label: &str) -> Figure {
    let reversed: Vec<String> = names.iter().rev().cloned().collect();
    let x: Vec<f64> = scores.iter().rev().copied().collect();
    let y: Vec<f64> = (0..x.len()).map(|k| k as f64).collect();
    let mut panel = Panel::new("", Axis::linear(label, ""), Axis::categories("", reversed));
    let look = Look::line(Color::Sky, Dash::Solid);
    panel
        .series
        .push(Series::curve(label, &x, &y, look).with_shape(SeriesShape::LyingBars { height: 0.6 }).without_entry());
    panel.height_px = 60 + 22 * names.len().clamp(3, 40) as u32;
    Figure::new(title, "Hypotheses in order of how well they explain the difference.", vec![panel])
}
