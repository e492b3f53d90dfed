//! Overspeed up to which a loop has to be stable.

/// Margin over the top speed that the loop should survive.
pub(crate) const OVERSPEED: f64 = 1.2;
/// Speeds computed from the top speed to that margin, as shares of the top speed.
pub(super) const OVERSPEEDS: [f64; 3] = [1.0, 1.1, OVERSPEED];
