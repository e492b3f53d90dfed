//! Amplification factors of the unbalance response (API 617): the speed of a maximum over the width of the range in
//! which the response is above 1/√2 of it.

use crate::lti::line_maximum::LineMaximum;
use std::f64::consts::FRAC_1_SQRT_2;

/// A maximum of the unbalance response over speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalSpeed {
    /// Speed of the maximum, rpm.
    pub speed_rpm: f64,
    /// Ends of the range above 1/√2 of it, rpm; not a number where the response stays above.
    pub half_power_rpm: [f64; 2],
    /// Speed over width; where the response stays above on one side, over twice the width of the other, and zero where
    /// it does on both.
    pub amplification: f64,
}

/// Above this factor a speed is critical, below it the response is well damped (API 617).
const CRITICAL: f64 = 2.5;
/// Tolerance of a place, as a share of the distance of the speeds on both sides: where those are 2 % apart it moves a
/// factor of fifty, whose range is as wide as that, by 4 %.
const PLACE: f64 = 1e-2;

impl CriticalSpeed {
    /// Distance of the speed from the speeds of operation that API 617 asks for, as a share: of one above them
    /// 10 + 17 (1 − 1/(A − 1.5)) percent; zero of a response that is well damped.
    pub fn separation_asked(&self) -> f64 {
        if self.amplification < CRITICAL {
            return 0.0;
        }
        0.10 + 0.17 * (1.0 - 1.0 / (self.amplification - 1.5))
    }

    /// Whether it is far enough from every speed up to the top speed: above it by what is asked, or well damped.
    pub fn is_acceptable(&self, top_rpm: f64) -> bool {
        self.separation_asked() == 0.0 || self.speed_rpm >= (1.0 + self.separation_asked()) * top_rpm
    }
}

/// Every maximum of a response between the first and the last of some speeds, from its values there and between.
///
/// # Errors
/// Those of the response.
pub fn find_critical_speeds<E>(
    speeds_rpm: &[f64],
    values: &[f64],
    response: &dyn Fn(f64) -> Result<f64, E>,
) -> Result<Vec<CriticalSpeed>, E> {
    let mut found = vec![];
    for k in 1..speeds_rpm.len().min(values.len()).saturating_sub(1) {
        if values[k] < values[k - 1] || values[k] <= values[k + 1] {
            continue;
        }
        let point = |k: usize| (speeds_rpm[k], values[k]);
        let tolerance = PLACE * (speeds_rpm[k + 1] - speeds_rpm[k - 1]);
        let mut search = LineMaximum::new([point(k - 1), point(k), point(k + 1)], tolerance);
        while let Some(rpm) = search.next() {
            search.add(rpm, response(rpm)?);
        }
        let (speed_rpm, largest) = search.best();
        let level = FRAC_1_SQRT_2 * largest;
        // From the maximum outwards to the first speed below the level, unless another maximum comes before it.
        let end = |mut side: Box<dyn Iterator<Item = usize>>| -> Result<f64, E> {
            let mut inside = speed_rpm;
            let first = side.find(|i| values[*i] < level || values[*i] > largest);
            let Some(outside) = first.filter(|i| values[*i] < level) else { return Ok(f64::NAN) };
            let mut outside = speeds_rpm[outside];
            while (outside - inside).abs() > tolerance {
                let middle = 0.5 * (inside + outside);
                *(if response(middle)? < level { &mut outside } else { &mut inside }) = middle;
            }
            Ok(0.5 * (inside + outside))
        };
        let low = end(Box::new((0..k).rev()))?;
        let high = end(Box::new(k + 1..values.len()))?;
        let [below, above] = [speed_rpm - low, high - speed_rpm];
        let width = match (below.is_finite(), above.is_finite()) {
            (true, true) => below + above,
            (true, false) => 2.0 * below,
            (false, true) => 2.0 * above,
            (false, false) => f64::INFINITY,
        };
        found.push(CriticalSpeed { speed_rpm, half_power_rpm: [low, high], amplification: speed_rpm / width });
    }
    Ok(found)
}
