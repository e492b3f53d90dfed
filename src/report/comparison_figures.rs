//! Pictures of a comparison's worst cases: stiffness and sensitivity, a panel per axis and speed.

use super::pictures::Picture;
use super::plot::worst::{WorstBand, WorstPanel, worst_sensitivity, worst_stiffness};
use super::plot::{Figure, Role};
use crate::pipeline::worst::WorstPrediction;
use crate::predict::worst_case::{Extreme, WorstCurve};

/// Worst cases of one controller: role, name, cases in the same order for every controller.
pub(crate) type NamedWorst = (Role, String, Vec<WorstPrediction>);

/// Curves of one axis that differ by less than this fraction from those of the other are not drawn twice.
const SAME: f64 = 1e-6;

/// The pictures; none when every set of loops holds an unstable one.
pub(crate) fn worst_figures(all: &[NamedWorst]) -> Vec<(Picture, Figure)> {
    let stiffness = panels(
        all,
        &["x", "y"],
        |w, axis| &w.worst.compliance[axis],
        |e| [e.nominal, e.lower, e.upper].map(f64::recip),
    );
    let sensitivity = panels(
        all,
        &["front x", "front y", "rear x", "rear y"],
        |w, axis| &w.worst.sensitivity[axis],
        |e| [e.nominal, e.lower, e.upper],
    );
    let title = "over the uncertainty of the natural frequencies";
    if stiffness.is_empty() {
        return vec![];
    }
    vec![
        (Picture::StiffnessWorst, worst_stiffness(&format!("Worst dynamic stiffness {title}"), &stiffness)),
        (Picture::SensitivityWorst, worst_sensitivity(&format!("Worst sensitivity {title}"), &sensitivity)),
    ]
}

fn panels(
    all: &[NamedWorst],
    axes: &[&str],
    curve: impl Fn(&WorstPrediction, usize) -> &WorstCurve,
    values: impl Fn(&Extreme) -> [f64; 3],
) -> Vec<WorstPanel> {
    let first = all.first().map(|(_, _, cases)| cases.as_slice());
    let asked = first.unwrap_or_default().iter().filter(|w| w.asked);
    let mut found = vec![];
    for speed_rpm in asked.map(|w| w.speed_rpm) {
        // A set of loops with an unstable one is left out.
        let at = |cases: &'_ [WorstPrediction]| {
            let same = |w: &WorstPrediction| w.speed_rpm == speed_rpm && w.is_stable();
            cases.iter().position(same)
        };
        for (axis, name) in axes.iter().enumerate() {
            // y follows x in every list; it is drawn where some controller makes it differ.
            let twin = axis % 2 == 1
                && all.iter().all(|(_, _, cases)| {
                    at(cases).and_then(|k| cases.get(k)).is_none_or(|w| same(curve(w, axis - 1), curve(w, axis)))
                });
            if twin {
                continue;
            }
            let bands: Vec<WorstBand> = all
                .iter()
                .filter_map(|(role, name, cases)| {
                    let curve = curve(cases.get(at(cases)?)?, axis);
                    let column =
                        |k: usize| curve.lines.iter().map(|e| values(e).get(k).copied().unwrap_or(f64::NAN)).collect();
                    Some(WorstBand {
                        name: name.clone(),
                        role: *role,
                        frequency_hz: curve.frequency_hz.clone(),
                        nominal: column(0),
                        attained: column(1),
                        bound: column(2),
                    })
                })
                .collect();
            let heading = format!("{name}, {speed_rpm:.0} rpm");
            if !bands.is_empty() {
                found.push((heading, bands));
            }
        }
    }
    found
}

fn same(a: &WorstCurve, b: &WorstCurve) -> bool {
    let close = |x: f64, y: f64| (x - y).abs() <= SAME * x.abs().max(y.abs()) || x == y;
    a.lines.len() == b.lines.len()
        && a.lines.iter().zip(&b.lines).all(|(p, q)| close(p.nominal, q.nominal) && close(p.upper, q.upper))
}
