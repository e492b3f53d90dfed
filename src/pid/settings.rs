//! Requirements on a tuned PID, and effort of the search.

use crate::augment::weights::MODE_SHIFT;
use crate::controller::amplifier_demand::AmplifierDemand;

/// Requirements and effort of a tuning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TuneSettings {
    /// Sensitivity peak aimed at, dB; zone B ends at 12 dB.
    pub sensitivity_db: f64,
    /// Relative shift of the flexible frequencies, both ways, that the loop must survive.
    pub mode_shift: f64,
    /// Largest rms current from sensor noise, A.
    pub noise_current_a: f64,
    /// Largest singular value of the controller above the modes of the model, A/m.
    pub high_frequency_gain_a_per_m: f64,
    /// Starts drawn from the machine's own dynamics and screened.
    pub starts: usize,
    /// A few steps are tried from six times as many starts, a round is descended from twice as many, and after every
    /// few rounds the worse half of them ends.
    pub basins: usize,
    /// Steps of a round of such a descent at most.
    pub steps: usize,
    /// Such rounds at most, each on renewed lines.
    pub rounds: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Searches from this seed and the next ones, of which the best PID is taken.
    pub searches: usize,
    /// Speeds at which the full plant is checked, from 0 to the largest.
    pub speeds: usize,
}

impl TuneSettings {
    /// For a whole run: a few seconds.
    pub fn quick() -> Self {
        Self {
            // A quarter of a decibel below the end of zone B: peaks between the lines of the search.
            sensitivity_db: 11.8,
            mode_shift: MODE_SHIFT,
            noise_current_a: 0.1,
            // Without a delivered controller to be held to: a micrometre of noise or of an unknown mode above those of
            // the model asks for two amperes at most.
            high_frequency_gain_a_per_m: 2.0e6,
            starts: 6000,
            basins: 3,
            steps: 240,
            rounds: 8,
            seed: 1,
            searches: 1,
            speeds: 6,
        }
    }

    /// For a PID that the polish goes on from: as many starts, a short descent.
    pub fn start() -> Self {
        Self { steps: 120, rounds: 2, ..Self::quick() }
    }

    /// The same search with the amplifier limits of a delivered controller. Where its loop is unstable and has no noise
    /// current, the limit stays.
    #[must_use]
    pub fn held_to(self, demand: &AmplifierDemand) -> Self {
        let noise = demand.noise_current_a;
        Self {
            high_frequency_gain_a_per_m: demand.high_frequency_gain_a_per_m,
            noise_current_a: if noise.is_finite() { noise } else { self.noise_current_a },
            ..self
        }
    }

    /// The best of four searches: where one ends depends on its starts, by a few percent of stiffness on most machines
    /// and by a fifth on some.
    pub fn thorough() -> Self {
        Self { searches: 4, speeds: 11, ..Self::quick() }
    }
}
