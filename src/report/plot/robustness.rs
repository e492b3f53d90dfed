//! Pictures of synthesis: μ per iteration with both bounds, D-scale fits, μ against the controller's order.

use super::Curve;
use super::figure::{Axis, Figure, Panel, Series, SeriesShape};
use super::style::{Color, Dash, Look, Marker, Role};

/// μ over frequency after one step of the iteration.
#[derive(Clone, Copy, Debug)]
pub struct MuStep<'a> {
    /// Name: `step 1`, `discrete, rounded`.
    pub name: &'a str,
    /// Frequencies, Hz.
    pub frequency_hz: &'a [f64],
    /// Upper bound.
    pub upper: &'a [f64],
    /// Lower bound; empty if it was not computed.
    pub lower: &'a [f64],
}

/// Upper bounds of every step as lines; the last step also as the band between its bounds.
pub fn mu_over_frequency(title: &str, steps: &[MuStep]) -> Figure {
    let mut panel = Panel::new("", Axis::log("Frequency", "Hz"), Axis::linear("µ", ""));
    panel.height_px = 360;
    let last = steps.len().saturating_sub(1);
    for (k, step) in steps.iter().enumerate() {
        let look = if k == last {
            Look::line(Color::Blue, Dash::Solid).with_width(2.2)
        } else {
            // Blue is kept for the last step.
            let look = Role::Other(k % 5 + 1).look();
            Look { width_px: 1.3, ..look }
        };
        if k == last && step.lower.len() == step.upper.len() {
            let name = format!("{}: between the bounds", step.name);
            let band = Series::curve(&name, step.frequency_hz, step.upper, look);
            panel.series.push(band.with_shape(SeriesShape::Band { lower: step.lower.to_vec() }));
        }
        let name = format!("{}: upper bound", step.name);
        panel.series.push(Series::curve(&name, step.frequency_hz, step.upper, look));
    }
    panel.level(1.0, "µ = 1");
    let top = steps.iter().flat_map(|s| s.upper).filter(|u| u.is_finite()).fold(1.0, |a: f64, b| a.max(*b));
    // Early steps can be orders of magnitude above 1; what is decided lies near it.
    if top > 6.0 {
        panel.y = Axis::log("µ", "");
    } else {
        panel.y.range = Some([0.0, (top * 1.08 * 5.0).ceil() / 5.0]);
    }
    Figure::new(
        title,
        "Bounds of the structured singular value over frequency for each step of the iteration; the target is below 1.",
        vec![panel],
    )
}

/// Peak of μ and γ over the steps of the iteration.
pub fn mu_per_iteration(title: &str, gamma: &[f64], mu_peak: &[f64]) -> Figure {
    let steps = |n: usize| (1..=n).map(|k| k as f64).collect::<Vec<f64>>();
    let last = gamma.len().max(mu_peak.len()).max(2) as f64;
    let x = Axis::linear("Step", "").with_range(0.7, last + 0.3).with_step(1.0);
    let mut panel = Panel::new("", x, Axis::linear("Peak", ""));
    let (orange, blue) = (Look::line(Color::Vermillion, Dash::Dashed), Look::line(Color::Blue, Dash::Solid));
    panel.series = vec![
        Series::curve("γ of the H∞ step", &steps(gamma.len()), gamma, orange.with_marker(Marker::Square)),
        Series::curve("peak of µ (upper bound)", &steps(mu_peak.len()), mu_peak, blue.with_marker(Marker::Disc)),
    ];
    panel.level(1.0, "1");
    panel.height_px = 260;
    Figure::new(
        title,
        "γ and the peak of µ of the synthesis problem after each step of the D-K iteration.",
        vec![panel],
    )
}

/// One D scale: the points the bound asks for, and the fitted transfer function.
#[derive(Clone, Copy, Debug)]
pub struct PlottedScale<'a> {
    /// Block and order: `tool, order 3`.
    pub name: &'a str,
    /// Frequencies, Hz.
    pub frequency_hz: &'a [f64],
    /// Magnitudes asked for.
    pub data: &'a [f64],
    /// Magnitudes of the fit.
    pub fit: &'a [f64],
}

/// Each D scale in a panel of its own, two a row: points and fit.
pub fn d_fits(title: &str, fits: &[PlottedScale]) -> Figure {
    let panels = fits.iter().map(|f| {
        let mut panel = Panel::new(f.name, Axis::log("Frequency", "Hz"), Axis::log("|D|", ""));
        panel.series = vec![
            Series::curve("asked for by the bound", f.frequency_hz, f.data, Look::line(Color::Black, Dash::Dotted)),
            Series::curve("fitted", f.frequency_hz, f.fit, Look::line(Color::Blue, Dash::Solid)),
        ];
        panel.height_px = 215;
        panel
    });
    Figure::new(title, "D scales over frequency: values of the bound and the rational fits.", panels.collect())
        .with_columns(2)
}

/// μ of the reduced controllers against their order, with the budget; the chosen order is marked.
pub fn mu_against_order(title: &str, curves: &[Curve], budget: f64, chosen: (f64, f64)) -> Figure {
    let mut panel = Panel::new("", Axis::linear("Order of the controller", ""), Axis::linear("Peak of µ", ""));
    panel.series =
        curves.iter().map(|c| Series::curve(c.name, c.x, c.y, c.role.look().with_marker(Marker::Circle))).collect();
    let name = format!("chosen: order {}", chosen.0);
    let star = Look::points(Color::Black, Marker::Diamond);
    panel.series.push(Series::curve(&name, &[chosen.0], &[chosen.1], star));
    panel.level(budget, format!("budget {budget:.3}"));
    // Orders too low to stabilise give values without meaning for the choice.
    let finite = curves.iter().flat_map(|c| c.y).filter(|y| y.is_finite());
    let high = finite.fold(budget, |a: f64, b| a.max(*b)).min(3.0 * budget);
    panel.y.range = Some([0.0, (high * 10.8).ceil() / 10.0]);
    let largest = curves.iter().flat_map(|c| c.x).chain([&chosen.0]).fold(1.0, |a: f64, b| a.max(*b));
    panel.x.range = Some([0.0, largest + 1.0]);
    Figure::new(title, "Peak of µ of the synthesis problem with reduced controllers, against their order.", vec![panel])
}
