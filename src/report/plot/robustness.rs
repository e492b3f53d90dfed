//! Pictures of synthesis: μ per iteration with both bounds, D-scale fits, μ against the controller's order.

use super::Curve;
use super::figure::{Axis, Figure, Panel, Series, SeriesShape};
use super::style::{Color, Dash, Look, Marker, Role};
use crate::pipeline::certificates::DScaleCurve;

/// μ over frequency for each step, by its name (`step 1`, `discrete, rounded`): frequencies in Hz with upper and lower
/// bound. Upper bounds of every step as lines; the last step also as the band between its bounds.
pub fn mu_over_frequency(title: &str, steps: &[(&str, &[(f64, f64, f64)])]) -> Figure {
    let mut panel = Panel::new("", Axis::log("Frequency", "Hz"), Axis::linear("µ", ""));
    panel.height_px = 360;
    let last = steps.len().saturating_sub(1);
    let mut top = 1.0f64;
    for (k, (name, curve)) in steps.iter().enumerate() {
        let column = |of: fn(&(f64, f64, f64)) -> f64| curve.iter().map(of).collect::<Vec<f64>>();
        let (x, upper) = (column(|line| line.0), column(|line| line.1));
        let look = if k == last {
            Look::line(Color::Blue, Dash::Solid).with_width(2.2)
        } else {
            // Blue is kept for the last step.
            Role::Other(k % 5 + 1).look().with_width(1.3)
        };
        if k == last {
            let band = Series::curve(&format!("{name}: between the bounds"), &x, &upper, look);
            panel.series.push(band.with_shape(SeriesShape::Band { lower: column(|line| line.2) }));
        }
        panel.series.push(Series::curve(&format!("{name}: upper bound"), &x, &upper, look));
        top = upper.into_iter().filter(|u| u.is_finite()).fold(top, f64::max);
    }
    panel.level(1.0, "µ = 1");
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

/// Each D scale in a panel of its own under its name, two a row: the points that the bound asks for, and the fit.
pub fn d_fits(title: &str, names: &[String], scales: &[DScaleCurve]) -> Figure {
    let panels = names.iter().zip(scales).map(|(name, d)| {
        let mut panel = Panel::new(name, Axis::log("Frequency", "Hz"), Axis::log("|D|", ""));
        let asked = Look::line(Color::Black, Dash::Dotted);
        panel.series = vec![
            Series::curve("asked for by the bound", &d.frequency_hz, &d.asked, asked),
            Series::curve("fitted", &d.frequency_hz, &d.used, Look::line(Color::Blue, Dash::Solid)),
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
