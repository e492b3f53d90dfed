//! The measured plant: magnitude, phase and coherence of the sixteen entries of G.

use super::figure::{Axis, Figure, Panel, Series};
use super::loops::{add_response, bode_panels};
use super::style::Role;
use crate::identify::MeasuredFrf;
use crate::identify::frf::AXIS_NAMES;
use crate::linalg::c64;

/// Planes by the numbers of their axes.
const PLANES: [(&str, [usize; 2]); 2] = [("x", [0, 2]), ("y", [1, 3])];

/// The entries of a measured plant in four pictures, sensors of a plane over currents of a plane, those of one plane
/// first, each with its detail (`x`, `x-from-y`); a picture without an entry that the record determines is left out.
pub fn measured_plant(frf: &MeasuredFrf) -> Vec<(String, Figure)> {
    let pairs = [(0, 0), (1, 1), (0, 1), (1, 0)].map(|(to, from)| (PLANES[to], PLANES[from]));
    let drawn = pairs.map(|((to, outputs), (from, inputs))| {
        let entries = inputs.into_iter().flat_map(|input| outputs.map(|output| (output, input)));
        let entries: Vec<(usize, usize)> = entries.filter(|(_, input)| frf.determined[*input]).collect();
        let detail = if to == from { to.to_owned() } else { format!("{to}-from-{from}") };
        (!entries.is_empty()).then(|| (detail, entries_figure(frf, [to, from], &entries)))
    });
    drawn.into_iter().flatten().collect()
}

fn entries_figure(frf: &MeasuredFrf, [to, from]: [&str; 2], entries: &[(usize, usize)]) -> Figure {
    let mut panels = bode_panels("|sensor / current|", "m/A");
    let mut coherence = Panel::new("", Axis::log("Frequency", "Hz"), Axis::linear("Coherence", ""));
    coherence.y.range = Some([0.0, 1.05]);
    coherence.height_px = 200;
    for (k, (output, input)) in entries.iter().enumerate() {
        let name = format!("{} from {}", AXIS_NAMES[*output], AXIS_NAMES[*input]);
        let look = Role::Other(k).look();
        let response: Vec<c64> = (0..frf.len()).map(|line| frf.response[(line, *output, *input)]).collect();
        add_response(&mut panels, &name, &frf.frequency_hz, &response, look);
        let values: Vec<f64> = (0..frf.len()).map(|line| frf.coherence(line, *output, *input)).collect();
        coherence.series.push(Series::curve(&name, &frf.frequency_hz, &values, look));
    }
    let [magnitude, phase] = panels;
    let title = format!("Measured plant, {:.0} rpm (sensors in {to} over currents in {from})", frf.speed_rpm);
    let words = "Magnitude, phase and coherence of the open-loop plant that the sweep gives; the coherence is that of \
                 one input and one output whose response scatters as much over the repeats.";
    Figure::stacked(&title, words, [magnitude, phase, coherence])
}
