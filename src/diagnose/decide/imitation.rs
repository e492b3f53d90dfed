//! Sets of effects that only imitate a law which is in no catalogue.
//!
//! Lags in the loop (delay, amplifier, iron, sensor filter) are all smooth in frequency, and a few of them together
//! come close to any smooth law. Two that work against each other, or three, say the law and not what makes it.

use super::candidate::Candidate;
use crate::spindle::EffectKind;
use crate::spindle::effects::entry::Site;

/// Lags of which a set may hold so many and still name them.
const MOST_LAGS: usize = 2;

/// Whether the lags of a set are parts of one law without a name.
pub(crate) fn imitates_a_lag(set: &Candidate) -> bool {
    let both = set.effects.iter().zip(&set.fit.at.theta);
    let lags = both.filter(|(h, _)| is_lag(h.kind)).map(|(h, theta)| h.size(theta));
    let (slower, faster): (Vec<f64>, Vec<f64>) = lags.partition(|size| *size > 0.0);
    let opposed = !slower.is_empty() && !faster.is_empty();
    opposed || slower.len() + faster.len() > MOST_LAGS
}

/// Effects of the electronics that the whole loop can have, but for gains: their first coordinate grows with the lag.
fn is_lag(kind: EffectKind) -> bool {
    let is_gain = matches!(kind, EffectKind::ForceConstant | EffectKind::SensorGain);
    kind.entry().sites.contains(&Site::Loop) && !is_gain
}
