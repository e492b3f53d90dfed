//! Pictures of model updating: modulus factors, what the data determine, errors per frequency.

use super::figure::{Axis, Figure, Panel, Series, SeriesShape};
use super::style::{Color, Dash, Look};

/// Modulus factors as bars with the standard deviations that data and prior leave.
pub fn modulus_factors(title: &str, regions: &[String], factor: &[f64], standard_deviation: &[f64]) -> Figure {
    let positions: Vec<f64> = (0..factor.len()).map(|k| k as f64).collect();
    let mut panel = Panel::new("", Axis::categories("Region", regions.to_vec()), Axis::linear("Modulus factor", ""));
    let bars = Series::curve("updated factor", &positions, factor, Look::line(Color::Sky, Dash::Solid));
    let error = (standard_deviation.len() == factor.len()).then(|| standard_deviation.to_vec());
    panel.series.push(Series { y_error: error, ..bars.with_shape(SeriesShape::Bars { width: 0.62 }) });
    // A factor is positive: a standard deviation larger than the factor says so by reaching the axis.
    let tops = factor.iter().enumerate().map(|(k, f)| f + standard_deviation.get(k).copied().unwrap_or(0.0));
    let top = tops.filter(|t| t.is_finite()).fold(1.0, f64::max);
    panel.y.range = Some([0.0, (top * 5.5).ceil() / 5.0]);
    panel.level(1.0, "nominal");
    Figure::new(title, "Factor on the modulus of each region after updating, with its standard deviation.", vec![panel])
}

/// Singular values of the sensitivity and how much of each region the data determine (0 nothing, 1 all).
pub fn determinability(title: &str, singular_values: &[f64], regions: &[String], determined: &[f64]) -> Figure {
    let count = |n: usize| (1..=n).map(|k| k as f64).collect::<Vec<f64>>();
    let x = Axis::linear("Combination of regions", "").with_range(0.4, singular_values.len().max(2) as f64 + 0.6);
    let mut values =
        Panel::new("Singular values of the sensitivity", x.with_step(1.0), Axis::log("Singular value", ""));
    let look = Look::points(Color::Blue, super::Marker::Disc);
    values.series.push(Series::curve("singular value", &count(singular_values.len()), singular_values, look));
    let mut share = Panel::new(
        "Share of each region that the data determine",
        Axis::categories("Region", regions.to_vec()),
        Axis::linear("Share", "").with_range(0.0, 1.0),
    );
    let positions: Vec<f64> = (0..determined.len()).map(|k| k as f64).collect();
    let bars = Series::curve("determined by the data", &positions, determined, Look::line(Color::Sky, Dash::Solid));
    share.series.push(bars.with_shape(SeriesShape::Bars { width: 0.62 }));
    values.height_px = 260;
    share.height_px = 260;
    Figure::new(title, "What the measured frequencies determine of the moduli.", vec![values, share])
}

/// Errors of the frequencies in percent, one group of bars a frequency, one bar a model (nominal, resonances only,
/// all).
pub fn frequency_errors(title: &str, frequencies: &[String], models: &[(&str, Vec<f64>)]) -> Figure {
    const COLORS: [Color; 4] = [Color::Grey, Color::Vermillion, Color::Blue, Color::Green];
    let mut panel = Panel::new("", Axis::categories("Frequency", frequencies.to_vec()), Axis::linear("Error", "%"));
    for (m, ((name, errors), color)) in models.iter().zip(COLORS.iter().cycle()).enumerate() {
        let look = Look::line(*color, Dash::Solid);
        panel.series.push(Series::grouped_bars(name, errors, look, [m, models.len()], 0.8));
    }
    Figure::new(
        title,
        "Errors of resonances and antiresonances of each model against the measured values.",
        vec![panel],
    )
}
