//! Limits of a polish.

/// Limits of a loop, each kept apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopLimits {
    /// Band of the tool's dynamic stiffness, Hz.
    pub stiffness_band_hz: (f64, f64),
    /// Largest |S_jj| of the machine as modelled, at rest and top speed.
    pub sensitivity: f64,
    /// Factor on that limit for rotors with shifted modes and beyond the top speed.
    pub shifted_sensitivity: f64,
    /// Largest |S_jj| with weak magnets.
    pub weak_sensitivity: f64,
    /// From here on the gain of the controller is limited, Hz.
    pub high_frequency_hz: f64,
    /// Largest entry of K there, A/m.
    pub high_frequency_gain_a_per_m: f64,
    /// Sensor noise, rms, m.
    pub sensor_noise_m: f64,
    /// Largest rms current from that noise, A.
    pub noise_current_a: f64,
    /// Largest μ of the specification; without effect when there is no specification.
    pub mu: f64,
    /// Factor on the compliance that the floors of the tool's stiffness allow; 1 holds them as asked.
    pub tool_softness: f64,
}

/// Softness granted to rotors that are not the machine at rest: the objective is the largest tool compliance over all
/// of them, at top speed counted times 1 − 0.04, with shifted modes times 1 − 0.08, so that the corners of the
/// uncertainty do not cost the machine as modelled.
pub(super) const AT_TOP_SPEED: f64 = 0.96;
pub(super) const SHIFTED: f64 = 0.92;

/// Parts of the force of the front and the rear magnets with which the loop at rest keeps a margin: a current at its
/// limit acts on the loop like a lower gain, in one bearing or in both, and a rotor thrown into its backup bearings
/// comes back when the loop bears that.
pub(super) const WEAK_MAGNETS: [[f64; 2]; 5] = [[0.7, 0.7], [0.5, 0.5], [0.35, 0.35], [1.0, 0.35], [0.35, 1.0]];
/// Magnets weaker than this part only have to be stable with half the margin.
pub(super) const WEAKEST_BELOW: f64 = 0.5;
/// Factor on the largest |S_jj| with those.
pub(super) const WEAKEST: f64 = 2.0;
/// Largest |S_jj| with the others: the margin at which zone C of ISO 14839-3 ends, that of the anti-windup.
pub(crate) const WEAK_SENSITIVITY: f64 = 5.0;
