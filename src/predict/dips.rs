//! Dips of a stiffness curve: where a resonance shows, and how much. The same for predictions and for measured records.
//!
//! The prominence of a local minimum is M/m: m is its value, M the lower of two maxima, those between it and the next
//! deeper minimum (or the end of the curve) on either side. A resonance that is hardly visible has a prominence near
//! one.

/// A dip of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dip {
    /// Where, Hz.
    pub frequency_hz: f64,
    /// How deep, N/m.
    pub stiffness_n_per_m: f64,
    /// Height of the sides over the dip, ≥ 1.
    pub prominence: f64,
}

/// Dips between two frequencies with at least this prominence, ascending.
pub fn dips(
    frequency_hz: &[f64],
    stiffness_n_per_m: &[f64],
    from_hz: f64,
    to_hz: f64,
    least_prominence: f64,
) -> Vec<Dip> {
    let inside: Vec<(f64, f64)> = frequency_hz
        .iter()
        .copied()
        .zip(stiffness_n_per_m.iter().copied())
        .filter(|(f, k)| *f >= from_hz && *f <= to_hz && k.is_finite())
        .collect();
    let side = |walk: &mut dyn Iterator<Item = &(f64, f64)>, floor: f64| -> f64 {
        walk.take_while(|(_, k)| *k >= floor).map(|(_, k)| *k).fold(floor, f64::max)
    };
    inside
        .windows(3)
        .enumerate()
        .filter(|(_, w)| w[1].1 < w[0].1 && w[1].1 <= w[2].1)
        .map(|(k, w)| {
            let (f, floor) = w[1];
            let left = side(&mut inside[..=k].iter().rev(), floor);
            let right = side(&mut inside[k + 2..].iter(), floor);
            Dip { frequency_hz: f, stiffness_n_per_m: floor, prominence: left.min(right) / floor }
        })
        .filter(|d| d.prominence >= least_prominence)
        .collect()
}
