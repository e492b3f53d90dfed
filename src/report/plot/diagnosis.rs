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
pub fn residual(title: &str, panels: &[(impl AsRef<str>, Vec<Curve>)]) -> Figure {
    let drawn = panels.iter().map(|(name, curves)| {
        let mut panel = Panel::new(name.as_ref(), Axis::log("Frequency", "Hz"), Axis::log("Residual", "σ"));
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

/// Localisation map of what a free law at each place leaves unexplained, over frequency: dark is unexplained, light is
/// explained. `left[place][line]` belongs to `frequency_hz[line]`; places from the top.
pub fn localisation(title: &str, places: &[String], frequency_hz: &[f64], left: &[Vec<f64>], label: &str) -> Figure {
    let group = frequency_hz.len().div_ceil(MAP_COLUMNS).max(1);
    let groups: Vec<&[f64]> = frequency_hz.chunks(group).collect();
    let centres: Vec<f64> = groups.iter().map(|g| g.iter().sum::<f64>() / g.len() as f64).collect();
    // Categories count from the bottom.
    let names = places.iter().rev().cloned().collect();
    let pool =
        |row: &Vec<f64>| row.chunks(group).map(|g| g.iter().copied().fold(f64::NEG_INFINITY, f64::max)).collect();
    let pooled: Vec<Vec<f64>> = left.iter().rev().map(pool).collect();
    // Edges half way (in the logarithm) between the columns.
    let mut edges: Vec<f64> = centres.windows(2).map(|w| w.iter().product::<f64>().sqrt()).collect();
    edges.insert(0, frequency_hz.first().copied().unwrap_or(1.0));
    edges.push(frequency_hz.last().copied().unwrap_or(10.0));
    let cells = pooled.iter().flatten().filter(|s| s.is_finite());
    let (low, high) = cells.fold((0.0f64, f64::NEG_INFINITY), |(low, high), s| (low.min(*s), high.max(*s)));
    let high = if high > low { high } else { low + 1.0 };
    let mut panel = Panel::new("", Axis::log("Frequency", "Hz"), Axis::categories("", names));
    panel.heat = Some(HeatMap { x_edges: edges, values: pooled, label: label.to_owned(), range: [low, high] });
    panel.height_px = 70 + 22 * places.len().clamp(4, 40) as u32;
    let words = "What a free law at each place leaves unexplained, over frequency; light is explained.";
    Figure::new(title, words, vec![panel])
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
    let points = scores.iter().rev().enumerate().map(|(k, score)| (*score, k as f64));
    let mut panel = Panel::new("", Axis::linear(label, ""), Axis::categories("", reversed));
    let look = Look::line(Color::Sky, Dash::Solid);
    let bars = Series::of_points(label, points, look).with_shape(SeriesShape::LyingBars { height: 0.6 });
    panel.series.push(bars.without_entry());
    panel.height_px = 60 + 22 * names.len().clamp(3, 40) as u32;
    Figure::new(title, "Hypotheses in order of how well they explain the difference.", vec![panel])
}
