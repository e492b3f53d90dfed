//! The mistakes that are tried on a record, and how each is taken out of a response.
//!
//! A fault acts on G as G' = A·G·B with A, B of scales, signs and permutations, as conjugation, or as a factor on the
//! frequencies; every one has an exact inverse. In a set of faults scales and signs belong to the channel names of
//! the record, so they are undone before permutations: candidates are listed in that order and sets keep it.

use super::faults::{HammerQuantity, RecordFault, Signal};
use super::spectrum::Spectrum;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const AXES: usize = 4;
/// Factors between frequencies as written and in Hz: rad/s, kHz, 1/min, and the same conversion made the wrong way
/// round.
const CLOCKS: [f64; 6] = [TAU, 1e-3, 60.0, 1.0 / TAU, 1e3, 1.0 / 60.0];

/// Candidates for a sweep. G tells y × f from u × f only within a channel: of all channels together, one of the two
/// is listed, and a reversed sign of everything stands under y.
pub(crate) fn of_sweep() -> Vec<RecordFault> {
    let (u, y) = (Signal::Current, Signal::Displacement);
    let unit = |signal, decades, channel| RecordFault::Unit { signal, decades, channel };
    let mut list = vec![];
    list.extend([6, 3, 9, 2, 1].map(|d| unit(y, d, None)));
    list.extend([3, 6, 2, 1].map(|d| unit(u, d, None)));
    for signal in [y, u] {
        for k in 0..AXES {
            list.extend([6, 3, 9, 2, 1, -1, -2, -3].map(|d| unit(signal, d, Some(k))));
        }
    }
    list.push(RecordFault::Sign { channel: None, signal: y });
    for signal in [y, u] {
        list.extend((0..AXES).map(|k| RecordFault::Sign { channel: Some(k), signal }));
    }
    list.push(RecordFault::Conjugate);
    list.extend(CLOCKS.map(|factor| RecordFault::Clock { factor }));
    list.extend([y, u].map(|signal| RecordFault::PlanesSwapped { signal }));
    for signal in [y, u] {
        for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3), (0, 3), (1, 2)] {
            list.push(RecordFault::ChannelsSwapped { a, b, signal });
        }
    }
    list
}

pub(crate) fn of_hammer() -> Vec<RecordFault> {
    let signal = Signal::Compliance;
    let unit = |decades| RecordFault::Unit { signal, decades, channel: None };
    let mut list: Vec<RecordFault> = [6, 3, 9, -3, 1, -1, 2, -2].map(unit).to_vec();
    list.push(RecordFault::Sign { channel: None, signal });
    list.push(RecordFault::Conjugate);
    list.extend(CLOCKS.map(|factor| RecordFault::Clock { factor }));
    list.extend([HammerQuantity::Accelerance, HammerQuantity::Mobility].map(RecordFault::Quantity));
    list
}

/// The response without the faults, undone in list order, `outputs` entries a column.
pub(crate) fn undone(data: &Spectrum, outputs: usize, faults: &[RecordFault]) -> Spectrum {
    let mut spectrum = data.clone();
    for fault in faults {
        undo(&mut spectrum, outputs, fault);
    }
    spectrum
}

fn undo(spectrum: &mut Spectrum, outputs: usize, fault: &RecordFault) {
    if let RecordFault::Clock { factor } = fault {
        for f in &mut spectrum.frequency_hz {
            *f /= factor;
        }
        return;
    }
    for (line, f) in spectrum.entries.iter_mut().zip(&spectrum.frequency_hz) {
        let inputs = line.len() / outputs.max(1);
        for i in 0..outputs {
            for j in 0..inputs {
                let entry = &mut line[i + outputs * j];
                let hit = |signal: Signal, channel: Option<usize>| match (signal, channel) {
                    (_, None) => true,
                    (Signal::Current, Some(k)) => j == k,
                    (_, Some(k)) => i == k,
                };
                match *fault {
                    RecordFault::Sign { channel, signal } if hit(signal, channel) => {
                        entry.phase += PI;
                    }
                    RecordFault::Unit { signal, decades, channel } if hit(signal, channel) => {
                        // G = Y U⁻¹: what multiplies u divides G.
                        let inverse = if signal == Signal::Current { decades } else { -decades };
                        *entry = entry.scale_decades(inverse);
                    }
                    RecordFault::Conjugate => entry.phase = -entry.phase,
                    RecordFault::Quantity(quantity) => {
                        let order = quantity.order();
                        let gain = (TAU * f).powi(-order);
                        *entry = entry.times(gain, -FRAC_PI_2 * f64::from(order));
                    }
                    _ => {}
                }
            }
        }
        match *fault {
            RecordFault::ChannelsSwapped { a, b, signal } => exchange(line, outputs, signal, a, b),
            RecordFault::PlanesSwapped { signal } => {
                exchange(line, outputs, signal, 0, 2);
                exchange(line, outputs, signal, 1, 3);
            }
            _ => {}
        }
    }
}

/// Exchanges rows (sensor signals) or columns (currents).
fn exchange<T>(line: &mut [T], outputs: usize, signal: Signal, a: usize, b: usize) {
    let inputs = line.len() / outputs.max(1);
    if signal == Signal::Current {
        (0..outputs).for_each(|i| line.swap(i + outputs * a, i + outputs * b));
    } else {
        (0..inputs).for_each(|j| line.swap(a + outputs * j, b + outputs * j));
    }
}
