//! Worst cases over the uncertainty beside the nominal curves: a band from one to the other for every controller.

use super::figure::{Axis, Figure, Panel, Series, SeriesShape};
use super::loops::zone_limits;
use super::style::Role;

/// Nominal values and both bounds of one controller over frequency, in the unit of the picture.
#[derive(Clone, Debug)]
pub(crate) struct WorstBand {
    pub name: String,
    pub role: Role,
    pub frequency_hz: Vec<f64>,
    pub nominal: Vec<f64>,
    /// Attained by some plant of the set.
    pub attained: Vec<f64>,
    /// Not passed by any plant of the set.
    pub bound: Vec<f64>,
}

/// One panel: heading and the bands in it.
pub(crate) type WorstPanel = (String, Vec<WorstBand>);

/// Dynamic stiffness, N/m, drawn in N/µm.
pub(crate) fn worst_stiffness(title: &str, panels: &[WorstPanel]) -> Figure {
    let drawn = panels.iter().map(|(name, bands)| {
        let y = Axis::log("Dynamic stiffness", "N/µm");
        panel(name, y, bands, |k| 1e-6 * k, 330)
    });
    Figure::new(
        title,
        "Dynamic stiffness at the tool: nominal line, and the band down to the smallest that any rotor within the \
         uncertainty has.",
        drawn.collect(),
    )
}

/// Sensitivity, drawn in dB with the zones of ISO 14839-3.
pub(crate) fn worst_sensitivity(title: &str, panels: &[WorstPanel]) -> Figure {
    let drawn = panels.iter().map(|(name, bands)| {
        let y = Axis::linear("|S|", "dB").with_range(-20.0, 25.0);
        let mut panel = panel(name, y, bands, |s| 20.0 * s.log10(), 290);
        panel.levels = zone_limits();
        panel
    });
    Figure::new(
        title,
        "Sensitivity of the control axes: nominal line, and the band up to the largest over the uncertainty.",
        drawn.collect(),
    )
    .with_columns(2)
}

fn panel(name: &str, y: Axis, bands: &[WorstBand], unit: impl Fn(f64) -> f64, height_px: u32) -> Panel {
    let mut panel = Panel::new(name, Axis::log("Frequency", "Hz"), y);
    let convert = |v: &[f64]| v.iter().map(|x| unit(*x)).collect::<Vec<f64>>();
    for band in bands {
        let look = band.role.look();
        let shape = SeriesShape::Band { lower: convert(&band.bound) };
        let name = format!("{}, worst case", band.name);
        let area = Series::curve(&name, &band.frequency_hz, &convert(&band.nominal), look);
        panel.series.push(area.with_shape(shape));
    }
    for band in bands {
        let look = band.role.look();
        let line = |name: &str, values: &[f64], width: f64| {
            Series::curve(name, &band.frequency_hz, &convert(values), look.with_width(width))
        };
        panel.series.push(line(&band.name, &band.nominal, look.width_px));
        let attained = format!("{}, attained", band.name);
        panel.series.push(line(&attained, &band.attained, 0.7).without_entry());
    }
    panel.height_px = height_px;
    panel
}
