//! Resonances that a set of FRFs share, each with damping and standard deviation: candidates from a stabilisation
//! diagram (`stabilisation`, `lscf`), then maximum likelihood (`selection`, `local`). Antiresonances of each.
//!
//! Limits: damping ratios up to 8 %; a mode needs about two lines in its half bandwidth, or neighbours of lines that
//! see its flanks.

pub use super::antiresonances::{Antiresonance, antiresonances};
pub use super::channel::{Channel, Resonance};
use super::lscf::Responses;
use super::selection::{FittedMode, Survey};
pub use super::stabilisation::DiagramPole;
use super::stabilisation::{pole_clusters, stabilisation_diagram};
use crate::linalg::c64;

/// Resonances that the channels share, ascending. All channels have the same lines.
pub fn resonances(frequency_hz: &[f64], channels: &[Channel]) -> Vec<Resonance> {
    poly_reference(frequency_hz, channels, 1).0
}

/// Resonances of FRFs of outputs over inputs, ascending, and the stabilisation diagram behind them: channel index =
/// input + inputs·output. Lists that are no whole rows of inputs count as outputs of one.
pub fn poly_reference(frequency_hz: &[f64], channels: &[Channel], inputs: usize) -> (Vec<Resonance>, Vec<DiagramPole>) {
    let inputs = if inputs > 0 && channels.len().is_multiple_of(inputs) { inputs } else { 1 };
    let all: Vec<Channel> = channels.iter().map(with_least_noise).collect();
    let told: Vec<usize> = (0..channels.len()).filter(|c| channels[*c].value.iter().any(|v| v.norm() > 0.0)).collect();
    if told.is_empty() {
        return (vec![], vec![]);
    }
    // Outputs and inputs that no channel tells of leave their equations undetermined.
    let has_input = |i: usize| told.iter().any(|c| c % inputs == i);
    let has_output = |o: usize| told.iter().any(|c| c / inputs == o);
    let rows = (0..all.len()).filter(|c| has_input(c % inputs) && has_output(c / inputs));
    let rows: Vec<Channel> = rows.map(|c| all[c].clone()).collect();
    let telling = (0..inputs).filter(|i| has_input(*i)).count();
    let diagram = stabilisation_diagram(&Responses { frequency_hz, channels: &rows, inputs: telling });
    let mut own: Vec<Channel> = told.iter().map(|c| all[*c].clone()).collect();
    for (k, channel) in own.iter_mut().enumerate() {
        // The next channel may be one that tells nothing.
        if told.get(k + 1) != Some(&(told[k] + 1)) {
            channel.with_next.clear();
        }
    }
    let survey = Survey::of(frequency_hz, own.iter().collect());
    let modes = survey.modes(&pole_clusters(&diagram));
    let found = modes.iter().map(|m| resonance(m, &told, channels.len())).collect();
    (found, diagram)
}

/// The channel with a noise that is nowhere zero: rounding of its largest value; one that tells nothing has none.
fn with_least_noise(channel: &Channel) -> Channel {
    let largest = channel.value.iter().map(|v| v.norm()).fold(0.0, f64::max);
    if largest == 0.0 {
        return Channel { sigma: vec![0.0; channel.sigma.len()], ..channel.clone() };
    }
    let least = largest * f64::EPSILON;
    Channel { sigma: channel.sigma.iter().map(|s| s.max(least)).collect(), ..channel.clone() }
}

/// `told` are the numbers of the channels with values.
fn resonance(mode: &FittedMode, told: &[usize], channels: usize) -> Resonance {
    let frequency_hz = mode.pole_hz.norm();
    let mut residue_over_sd = vec![0.0; channels];
    let mut of_channels = vec![c64::new(0.0, 0.0); channels];
    for (c, (residue, sd)) in told.iter().zip(&mode.residues) {
        of_channels[*c] = residue * mode.half_hz;
        // Near the pole 1/(f_k² − f²) = −1/((f − f_k)·2f_k): a positive modal product has a negative residue in f.
        residue_over_sd[*c] = -residue.re.signum() * residue.norm() / sd;
    }
    Resonance {
        frequency_hz,
        standard_deviation_hz: mode.sd_hz,
        damping_ratio: (mode.pole_hz.im / frequency_hz).max(0.0),
        residue_over_sd,
        residue: of_channels,
    }
}
