//! Sets of effects that only imitate a law which is in no catalogue.
//!
//! Lags in the loop (delay, amplifier, iron, sensor filter) are all smooth in frequency, and a few of them together
//! come close to any smooth law. At one place, two that work against each other, or three, say the law and not what
//! makes it.

use super::candidate::Candidate;
use crate::spindle::effects::entry::Site;
use crate::spindle::{Bearings, EffectKind, Location};

/// Lags at one place of which a set may hold so many and still name them.
const MOST_LAGS: usize = 2;

/// Whether the lags of a set at one place are parts of one law without a name.
pub(crate) fn imitates_a_lag(set: &Candidate) -> bool {
    let both = || set.effects.iter().zip(&set.fit.at.theta).filter(|(h, _)| is_lag(h.kind));
    both().any(|(first, _)| {
        let here = both().filter(|(h, _)| place(&h.place) == place(&first.place));
        let (slower, faster): (Vec<f64>, Vec<f64>) = here.map(|(h, theta)| h.size(theta)).partition(|size| *size > 0.0);
        !slower.is_empty() && !faster.is_empty() || slower.len() + faster.len() > MOST_LAGS
    })
}

/// A delay of the loop acts in both bearings alike.
fn place(of: &Location) -> Location {
    if *of == Location::None { Location::Bearing(Bearings::Both) } else { of.clone() }
}

/// Effects of the electronics that the whole loop can have, but for gains: their first coordinate grows with the lag.
fn is_lag(kind: EffectKind) -> bool {
    let is_gain = matches!(kind, EffectKind::ForceConstant | EffectKind::SensorGain);
    kind.entry().sites.contains(&Site::Loop) && !is_gain
}
