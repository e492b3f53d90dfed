//! Pictures of a comparison's worst cases: stiffness and sensitivity, a panel per axis and speed. In each a band leads
//! from the nominal curve of every controller to the bound that no rotor within the uncertainty passes.

use super::pictures::Picture;
use super::plot::figure::{Axis, Figure, Panel, Series, SeriesShape};
use super::plot::loops::add_zone_limits;
use super::plot::style::{Look, Role};
use crate::pipeline::worst::WorstPrediction;
use crate::predict::worst_case::{Extreme, WorstCurve};

/// Worst cases of one controller: role, name, cases in the same order for every controller.
pub(crate) type NamedWorst = (Role, String, Vec<WorstPrediction>);

/// Curves of one axis that differ by less than this fraction from those of the other are not drawn twice.
const SAME: f64 = 1e-6;

/// A quantity of the worst cases: how the axes are called, the curve of one, a value in the unit of the picture.
struct WorstQuantity<'a> {
    axes: &'a [&'a str],
    curve: fn(&WorstPrediction, usize) -> &WorstCurve,
    shown: fn(f64) -> f64,
    scale: Axis,
    height_px: u32,
}

/// The pictures; none when every set of loops holds an unstable one.
pub(crate) fn worst_figures(all: &[NamedWorst]) -> Vec<(Picture, Figure)> {
    let stiffness = WorstQuantity {
        axes: &["x", "y"],
        curve: |w, axis| &w.worst.compliance[axis],
        shown: |compliance| 1e-6 * compliance.recip(),
        scale: Axis::log("Dynamic stiffness", "N/µm"),
        height_px: 330,
    };
    let sensitivity = WorstQuantity {
        axes: &["front x", "front y", "rear x", "rear y"],
        curve: |w, axis| &w.worst.sensitivity[axis],
        shown: |s| 20.0 * s.log10(),
        scale: Axis::linear("|S|", "dB").with_range(-20.0, 25.0),
        height_px: 290,
    };
    let stiffness = panels(all, &stiffness);
    let mut sensitivity = panels(all, &sensitivity);
    sensitivity.iter_mut().for_each(add_zone_limits);
    if stiffness.is_empty() {
        return vec![];
    }
    let stiffness = Figure::new(
        "Worst dynamic stiffness over the uncertainty of the natural frequencies",
        "Dynamic stiffness at the tool: nominal line, and the band down to the smallest that any rotor within the \
         uncertainty has.",
        stiffness,
    );
    let sensitivity = Figure::new(
        "Worst sensitivity over the uncertainty of the natural frequencies",
        "Sensitivity of the control axes: nominal line, and the band up to the largest over the uncertainty.",
        sensitivity,
    );
    vec![(Picture::StiffnessWorst, stiffness), (Picture::SensitivityWorst, sensitivity.with_columns(2))]
}

fn panels(all: &[NamedWorst], quantity: &WorstQuantity) -> Vec<Panel> {
    let curve = quantity.curve;
    let first = all.first().map(|(_, _, cases)| cases.as_slice());
    let asked = first.unwrap_or_default().iter().filter(|w| w.asked);
    let mut found = vec![];
    for speed_rpm in asked.map(|w| w.speed_rpm) {
        // A set of loops with an unstable one is left out.
        let at = |cases: &'_ [WorstPrediction]| {
            let same = |w: &WorstPrediction| w.speed_rpm == speed_rpm && w.is_stable();
            cases.iter().position(same)
        };
        for (axis, name) in quantity.axes.iter().enumerate() {
            // y follows x in every list; it is drawn where some controller makes it differ.
            let twin = axis % 2 == 1
                && all.iter().all(|(_, _, cases)| {
                    at(cases).and_then(|k| cases.get(k)).is_none_or(|w| same(curve(w, axis - 1), curve(w, axis)))
                });
            if twin {
                continue;
            }
            let curves = all
                .iter()
                .filter_map(|(role, name, cases)| Some((*role, name.as_str(), curve(cases.get(at(cases)?)?, axis))));
            let curves: Vec<(Role, &str, &WorstCurve)> = curves.collect();
            if !curves.is_empty() {
                found.push(panel(&format!("{name}, {speed_rpm:.0} rpm"), quantity, &curves));
            }
        }
    }
    found
}

fn panel(heading: &str, quantity: &WorstQuantity, curves: &[(Role, &str, &WorstCurve)]) -> Panel {
    let mut panel = Panel::new(heading, Axis::log("Frequency", "Hz"), quantity.scale.clone());
    let series = |name: &str, curve: &WorstCurve, of: fn(&Extreme) -> f64, look: Look| {
        let lines = curve.frequency_hz.iter().zip(&curve.lines);
        Series::of_points(name, lines.map(|(hz, e)| (*hz, (quantity.shown)(of(e)))), look)
    };
    for (role, name, curve) in curves {
        // No rotor within the uncertainty passes the upper bound.
        let lower = curve.lines.iter().map(|e| (quantity.shown)(e.upper)).collect();
        let area = series(&format!("{name}, worst case"), curve, |e| e.nominal, role.look());
        panel.series.push(area.with_shape(SeriesShape::Band { lower }));
    }
    for (role, name, curve) in curves {
        panel.series.push(series(name, curve, |e| e.nominal, role.look()));
        let attained = series(&format!("{name}, attained"), curve, |e| e.lower, role.look().with_width(0.7));
        panel.series.push(attained.without_entry());
    }
    panel.height_px = quantity.height_px;
    panel
}

fn same(a: &WorstCurve, b: &WorstCurve) -> bool {
    let close = |x: f64, y: f64| (x - y).abs() <= SAME * x.abs().max(y.abs()) || x == y;
    a.lines.len() == b.lines.len()
        && a.lines.iter().zip(&b.lines).all(|(p, q)| close(p.nominal, q.nominal) && close(p.upper, q.upper))
}
