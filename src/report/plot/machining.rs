//! Pictures for the user of the spindle: chatter lobes, and a batch of tools side by side.

use super::Curve;
use super::figure::{Axis, Figure, Panel, Series};
use super::style::{Color, Dash, Look};

/// Stability lobes: limiting depth of cut (m) over spindle speed (rpm), drawn in mm; below a curve cutting is stable.
pub fn chatter_lobes(title: &str, curves: &[Curve], max_rpm: f64) -> Figure {
    let mut panel = Panel::new("", Axis::linear("Spindle speed", "rpm"), Axis::linear("Depth of cut", "mm"));
    panel.series = curves.iter().map(|c| c.map_values(|y| 1e3 * y)).collect();
    panel.height_px = 380;
    let mut depths: Vec<f64> =
        panel.series.iter().flat_map(|s| s.y.iter().copied()).filter(|y| y.is_finite()).collect();
    depths.sort_by(f64::total_cmp);
    // The peaks between lobes go to infinity: the picture ends where nine tenths of the curve are shown.
    if let Some(top) = depths.get(depths.len() * 9 / 10).filter(|t| **t > 0.0) {
        panel.y.range = Some([0.0, 1.4 * top]);
    }
    panel.x.range = Some([0.0, max_rpm]);
    Figure::new(title, "Largest stable depth of cut over spindle speed.", vec![panel])
}

/// One bar a tool and quantity: `quantities` are heading, unit, reference line and for each controller its values.
#[derive(Clone, Debug)]
pub struct ToolQuantity<'a> {
    /// Heading and axis label.
    pub label: &'a str,
    /// Unit.
    pub unit: &'a str,
    /// Reference lines with their names.
    pub references: Vec<(f64, &'a str)>,
    /// Name and values over the tools.
    pub bars: Vec<(&'a str, Vec<f64>)>,
}

/// A batch of tools: one panel a quantity, one group of bars a tool.
pub fn tools(title: &str, tools: &[String], quantities: &[ToolQuantity]) -> Figure {
    const COLORS: [Color; 4] = [Color::Blue, Color::Orange, Color::Green, Color::Purple];
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in quantities.iter().flat_map(|q| &q.bars) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let last = quantities.len().saturating_sub(1);
    let panels = quantities.iter().enumerate().map(|(row, q)| {
        // The heading says what it is, the axis only in which unit.
        let mut panel = Panel::new(q.label, Axis::categories("", tools.to_vec()), Axis::linear(q.unit, ""));
        panel.y.range = outlier_free(q);
        for (k, (name, values)) in q.bars.iter().enumerate() {
            let place = names.iter().position(|n| n == name).unwrap_or(0) % COLORS.len();
            let look = Look::line(COLORS[place], Dash::Solid);
            panel.series.push(Series::grouped_bars(name, values, look, [k, q.bars.len()], 0.76));
        }
        q.references.iter().for_each(|(value, name)| panel.level(*value, *name));
        panel.height_px = if row == last { 215 } else { 175 };
        panel
    });
    let mut figure = Figure::stacked(title, "Designs for each tool side by side.", panels);
    // Every name of a tool is to be read: a name takes up to 110 px.
    figure.width_px = figure.width_px.max(110 * tools.len() as u32 + 120);
    figure
}

/// A range that shows most bars well when one of them is out of all proportion (it then ends at the frame; the table
/// has its value); `None` when all of them fit.
fn outlier_free(q: &ToolQuantity) -> Option<[f64; 2]> {
    let bars = q.bars.iter().flat_map(|(_, values)| values.iter().copied());
    let lines = q.references.iter().map(|(value, _)| *value);
    let mut values: Vec<f64> = bars.filter(|v| v.is_finite() && *v > 0.0).collect();
    values.sort_by(f64::total_cmp);
    let (median, largest) = (*values.get(values.len() / 2)?, *values.last()?);
    let limit = 2.5 * median;
    if largest <= limit {
        return None;
    }
    let shown = values.iter().copied().filter(|v| *v <= limit).chain(lines);
    Some([0.0, 1.15 * shown.fold(0.0, f64::max)])
}

/// Dynamic stiffness of every tool (N/m over Hz, drawn in N/µm), one panel a controller: heading and curves.
pub(crate) fn tool_stiffness(title: &str, panels: &[(&str, Vec<Curve>)], marked_hz: f64) -> Figure {
    // One range for both, round the softest points of the tools: far above them, and far below the usual, nothing is
    // decided.
    let softest = panels.iter().flat_map(|(_, curves)| curves).map(|c| {
        let finite = c.y.iter().copied().filter(|y| *y > 0.0);
        1e-6 * finite.fold(f64::INFINITY, f64::min)
    });
    let mut softest: Vec<f64> = softest.filter(|y| y.is_finite()).collect();
    softest.sort_by(f64::total_cmp);
    let range = softest.first().zip(softest.get(softest.len() / 2));
    let range = range.map(|(least, median)| (least.max(median / 60.0) * 0.7, 40.0 * median));
    let drawn = panels.iter().map(|(name, curves)| {
        let y = Axis::log("Dynamic stiffness", "N/µm");
        let y = range.map_or(y.clone(), |(low, high)| y.with_range(low, high));
        let mut panel = Panel::new(name, Axis::log("Frequency", "Hz"), y);
        panel.series = curves.iter().map(|c| c.map_values(|y| 1e-6 * y)).collect();
        panel.marks = vec![super::figure::Mark::top_speed(marked_hz)];
        panel.height_px = 330;
        panel
    });
    Figure::new(title, "Dynamic stiffness at the tool with each tool of the batch; higher is stiffer.", drawn.collect())
}
