//! Gyroscopic split of the flexible modes as natural-frequency uncertainty of the design at rest.
//! At speed Ω mode m splits into a backward and a forward whirl; an uncertainty of
//! r_m = r_table + max |f_whirl/f₀ − 1| at the highest speed covers both, and every speed between.

use crate::rotor::modes::{PlanarModes, RIGID};
use crate::rotor::whirl::Damping;
use crate::spindle::{Machine, SpindleError};
use std::f64::consts::TAU;

/// Split of one flexible mode.
#[derive(Clone, Copy, Debug)]
pub struct ModeSplit {
    /// Natural frequency at rest, rad/s.
    pub omega_rad_s: f64,
    /// Backward whirl at the highest speed, rad/s.
    pub backward_rad_s: f64,
    /// Forward whirl at the highest speed, rad/s.
    pub forward_rad_s: f64,
}

impl ModeSplit {
    /// Largest relative shift from the frequency at rest.
    pub(crate) fn relative(&self) -> f64 {
        let shift = |f: f64| (f / self.omega_rad_s - 1.0).abs();
        shift(self.backward_rad_s).max(shift(self.forward_rad_s))
    }
}

/// Split of the first `modes` flexible modes of the free-free rotor at `speed_rad_s`.
///
/// # Errors
/// [`SpindleError`] when the rotor or its eigenvalues fail.
pub fn gyroscopic_split(machine: &Machine, speed_rad_s: f64, modes: usize) -> Result<Vec<ModeSplit>, SpindleError> {
    let rotor = machine.rotor()?;
    let at_rest = PlanarModes::new(&rotor).map_err(SpindleError::Shaft)?;
    let omega: Vec<f64> = at_rest.omega_rad_s.iter().skip(RIGID).take(modes).copied().collect();
    let factor = if machine.spindle.gyroscopics { machine.effective().gyroscopic_factor } else { 0.0 };
    let top = omega.last().map_or(0.0, |w| 2.0 * w / TAU);
    let spectrum = rotor.whirl(speed_rad_s * factor, &Damping::None, &[], top).map_err(SpindleError::Shaft)?;
    // The forward nutation of the rigid rotor lies at Ω·Ip/Id, far below half the first flexible mode.
    let floor = 0.5 * omega.first().copied().unwrap_or(0.0);
    let of = |direction: f64| -> Vec<f64> {
        let flexible = spectrum.modes.iter().filter(|m| m.natural_rad_s > floor);
        let mut list: Vec<f64> = if speed_rad_s * factor == 0.0 {
            flexible.map(|m| m.natural_rad_s).step_by(2).collect()
        } else {
            flexible.filter(|m| m.whirl * direction > 0.0).map(|m| m.natural_rad_s).collect()
        };
        list.sort_by(f64::total_cmp);
        list
    };
    let (backward, forward) = (of(-1.0), of(1.0));
    Ok(omega
        .iter()
        .enumerate()
        .map(|(k, w)| ModeSplit {
            omega_rad_s: *w,
            backward_rad_s: backward.get(k).copied().unwrap_or(*w),
            forward_rad_s: forward.get(k).copied().unwrap_or(*w),
        })
        .collect())
}
