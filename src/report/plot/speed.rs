//! Pictures over speed: decay with the intervals in which stability is proven, and μ of the rotating plant.

use super::figure::{Axis, Figure, Panel, Series, SeriesShape};
use super::style::{Color, Dash, Look, Marker};
use crate::controller::speed_proof::SpeedInterval;

/// Above, how far each centre's proof reaches beyond a speed (every speed lies under a tent); below, the growth rate.
pub(crate) fn stability_over_speed(title: &str, centres: &[SpeedInterval], max_rpm: f64) -> Figure {
    let speed = || Axis::linear("Speed", "rpm");
    let mut reach = Panel::new("", speed(), Axis::linear("Proven beyond", "rpm"));
    for (k, c) in centres.iter().filter(|c| c.radius_rpm > 0.0).enumerate() {
        let x = [c.centre_rpm - c.radius_rpm, c.centre_rpm, c.centre_rpm + c.radius_rpm];
        let (name, look) = ("speeds proven stable round each one computed", Look::line(Color::Blue, Dash::Solid));
        let tent = Series::curve(name, &x, &[0.0, c.radius_rpm, 0.0], look);
        let tent = tent.with_shape(SeriesShape::Band { lower: vec![0.0; 3] });
        reach.series.push(if k == 0 { tent } else { tent.without_entry() });
    }
    let mut growth = Panel::new("", speed(), Axis::linear("Growth rate", "1/s"));
    let growth_rates = centres.iter().map(|c| (c.centre_rpm, c.growth_rate_per_s));
    let look = Look::line(Color::Vermillion, Dash::Solid).with_marker(Marker::Circle);
    growth.series.push(Series::of_points("slowest closed-loop pole", growth_rates, look));
    growth.level(0.0, "unstable above");
    let last = centres.iter().map(|c| c.centre_rpm + c.radius_rpm).fold(max_rpm, f64::max);
    for panel in [&mut reach, &mut growth] {
        panel.height_px = 230;
        panel.x.range = Some([0.0, last]);
        panel.marks.push(super::figure::Mark::top_speed(max_rpm));
    }
    Figure::new(
        title,
        "Intervals of speed in which the sampled loop is proven stable, and the growth rate at their centres.",
        vec![reach, growth],
    )
}

/// μ of the specification over speed; values that are not finite (unstable loops) are gaps.
pub(crate) fn mu_over_speed(title: &str, speed_rpm: &[f64], mu: &[f64]) -> Figure {
    let mut panel = Panel::new("", Axis::linear("Speed", "rpm"), Axis::linear("Peak of µ", ""));
    let look = Look::line(Color::Blue, Dash::Solid).with_marker(Marker::Disc);
    panel.series.push(Series::curve("specification as written, true gyroscopics", speed_rpm, mu, look));
    panel.level(1.0, "µ = 1");
    let top = mu.iter().filter(|m| m.is_finite()).fold(1.0, |a: f64, b| a.max(*b));
    panel.y.range = Some([0.0, (top * 1.1 * 5.0).ceil() / 5.0]);
    panel.height_px = 260;
    Figure::new(title, "Peak of µ of the specification over speed with the gyroscopic plant.", vec![panel])
}
