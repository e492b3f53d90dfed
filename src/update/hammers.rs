//! Targets from hammer tests of a rotor that no loop holds: it hangs, or stands on springs that the model has.

use super::UpdateError;
use super::targets::{FrfTargets, Target, Targets};
use crate::identify::HammerFrf;
use crate::identify::hammer::identify_taps;
use crate::identify::peaks::Antiresonance;
use crate::rotor::Rotor;
use crate::rotor::spectrum::lowest_hz;

/// A hammer test and where it was taken.
#[derive(Clone, Copy, Debug)]
pub struct PlacedTap<'a> {
    /// Name of its response in reports.
    pub name: &'a str,
    /// The response.
    pub frf: &'a HammerFrf,
    /// Where the displacement is read and where the force acts, m from the nose face.
    pub places_m: [f64; 2],
}

/// Resonances and antiresonances of hammer tests on the same lines; those of transfer responses are held out. `springs`
/// are place and stiffness of what the rotor stands on, m and N/m.
///
/// # Errors
/// [`UpdateError::NoTargets`] when no resonance stands out; as for a rotor that cannot be assembled.
pub fn hammer_targets(rotor: &Rotor, springs: Vec<(f64, f64)>, taps: &[PlacedTap<'_>]) -> Result<Targets, UpdateError> {
    let frfs: Vec<&HammerFrf> = taps.iter().map(|tap| tap.frf).collect();
    let (poles, zeros) = identify_taps(&frfs, lowest_hz(rotor)?);
    if poles.is_empty() {
        return Err(UpdateError::NoTargets { what: "no resonance stands out of the hammer tests" });
    }
    let of = |frequency_hz: f64, sd: f64| Target::free(frequency_hz, Some(sd));
    let antiresonances = taps.iter().zip(zeros).map(|(tap, zeros)| FrfTargets {
        name: tap.name.to_owned(),
        output_m: tap.places_m[0],
        input_m: tap.places_m[1],
        antiresonances: zeros
            .into_iter()
            .map(|zero| match zero {
                Antiresonance::Found { frequency_hz, standard_deviation_hz } => {
                    Some(of(frequency_hz, standard_deviation_hz))
                }
                Antiresonance::NotIdentified { .. } => None,
            })
            .collect(),
        held_out: tap.places_m[0] != tap.places_m[1],
    });
    Ok(Targets {
        resonances: poles.iter().map(|p| Some(of(p.frequency_hz, p.standard_deviation_hz))).collect(),
        antiresonances: antiresonances.collect(),
        springs,
        ..Targets::default()
    })
}
