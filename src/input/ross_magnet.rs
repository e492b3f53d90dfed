//! The magnets of a ROSS file with their PID, and the PID of two magnets as a controller.

use super::error::InputError;
use super::ross_notes::GroupedNotes;
use super::ross_table::RossTable;
use crate::controller::{ControlLaw, Controller};
use crate::linalg::{Mat, NumericError};
use crate::lti::{Continuous, StateSpace};
use std::f64::consts::PI;

/// The magnet of a bearing, per axis, after Schweitzer and Maslen, Magnetic Bearings, p. 343, as ROSS has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RossMagnet {
    /// Force per control current, N/A.
    pub ki_n_per_a: f64,
    /// Negative stiffness as a positive number, N/m.
    pub ks_n_per_m: f64,
    /// Bias current, A.
    pub bias_current_a: f64,
    /// Air gap, m.
    pub gap_m: f64,
    /// Its PID, for x and y; none where the controller was a transfer function, which ROSS does not save.
    pub pid: Option<[RossPid; 2]>,
}

/// The PID of an axis in A and m, amplifier and sensor included: i = −(kp + ki/s + kd s/(1 + s/corner)) x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RossPid {
    /// Proportional gain, A/m.
    pub proportional_a_per_m: f64,
    /// Integral gain, A/(m s).
    pub integral_a_per_m_s: f64,
    /// Derivative gain, A s/m.
    pub derivative_a_s_per_m: f64,
    /// Corner of the low pass in the derivative, rad/s.
    pub corner_rad_s: f64,
}

/// Corner of the derivative that ROSS takes where the file has none, rad/s.
const ROSS_CORNER_RAD_S: f64 = 1e4;

impl RossMagnet {
    /// Both constants from gap (m), bias current (A), pole area (m²), turns and half the angle between the poles (rad).
    fn of(gap_m: f64, bias_current_a: f64, area_m2: f64, turns: f64, angle: f64) -> Self {
        let factor = 4.0 * angle.cos() * 4e-7 * PI * turns * turns * area_m2 / 4.0;
        Self {
            ki_n_per_a: factor * bias_current_a / gap_m.powi(2),
            ks_n_per_m: factor * bias_current_a.powi(2) / gap_m.powi(3),
            bias_current_a,
            gap_m,
            pid: None,
        }
    }
}

/// The magnet of a bearing's table, none where the bearing is no magnet; what a spindle file has no place for goes to
/// `notes`.
pub(super) fn read_magnet(table: &RossTable, notes: &mut GroupedNotes) -> Result<Option<RossMagnet>, InputError> {
    let keys = ["g0", "i0", "ag", "nw", "alpha"];
    let lacking: Vec<&str> = keys.into_iter().filter(|k| !table.has(k)).collect();
    if !lacking.is_empty() {
        // `alpha` alone is the contact angle of a ball bearing.
        if ["g0", "i0", "ag", "nw"].iter().any(|k| table.has(k)) {
            let words = format!("a magnet without {}: its constants are to be given", lacking.join(", "));
            notes.add(table.name, words);
        }
        return Ok(None);
    }
    let [bias, other_bias] = table.pair("i0", 0.0)?;
    if bias != other_bias {
        let words = format!(
            "i0: bias currents of {bias} A in x and {other_bias} A in y; a spindle file has one for both: ki, ks and \
             bias current are those of x"
        );
        notes.add(table.name, words);
    } else {
        let words = format!("i0: ki, ks and the bias current follow from one bias current of {bias} A in x and y");
        notes.add(table.name, words);
    }
    let turn = table.number("sensors_axis_rotation").unwrap_or(0.0);
    if turn != 0.0 {
        let words = format!(
            "sensors_axis_rotation: magnets and sensors are turned by {:.4} degrees; x and y of the spindle file are \
             their axes",
            turn.to_degrees()
        );
        notes.add(table.name, words);
    }
    let (gap, area, turns) = (table.number("g0")?, table.number("ag")?, table.number("nw")?);
    let magnet = RossMagnet::of(gap, bias, area, turns, table.number("alpha")?);
    Ok(Some(RossMagnet { pid: read_pid(table, notes)?, ..magnet }))
}

fn read_pid(table: &RossTable, notes: &mut GroupedNotes) -> Result<Option<[RossPid; 2]>, InputError> {
    let gain = |key: &str| if table.has(key) { table.number(key) } else { Ok(0.0) };
    let (kp, ki, kd) = (gain("kp_pid")?, gain("ki_pid")?, gain("kd_pid")?);
    if [kp, ki, kd] == [0.0; 3] {
        notes.add(table.name, "no gains of a PID: a controller given as transfer function is not in a file of ROSS");
        return Ok(None);
    }
    let corner = if table.has("n_f") { table.number("n_f")? } else { ROSS_CORNER_RAD_S };
    if corner <= 0.0 {
        return Err(table
            .wrong(format!("n_f: {corner} must be positive"))
            .with_hint("it is the corner of the derivative's low pass in rad/s"));
    }
    let (amplifier, sensor) = (table.pair("k_amp", 1.0)?, table.pair("k_sense", 1.0)?);
    Ok(Some([0, 1].map(|axis: usize| {
        let through = amplifier[axis] * sensor[axis];
        RossPid {
            proportional_a_per_m: through * kp,
            integral_a_per_m_s: through * ki,
            derivative_a_s_per_m: through * kd,
            corner_rad_s: corner,
        }
    })))
}

/// The PIDs of the front and of the rear magnet, each x and y, as one controller in continuous time: an integrator and
/// a low pass for every channel.
pub(crate) fn pid_controller(name: &str, magnets: [[RossPid; 2]; 2]) -> Result<Controller, NumericError> {
    let channels = magnets.as_flattened();
    let width = channels.len();
    let mut a = Mat::zeros(2 * width, 2 * width);
    let mut b = Mat::zeros(2 * width, width);
    let mut c = Mat::zeros(width, 2 * width);
    let mut d = Mat::zeros(width, width);
    for (channel, pid) in channels.iter().enumerate() {
        let (integrator, low_pass) = (2 * channel, 2 * channel + 1);
        // kd s/(1 + s/w) = kd w (1 − w/(s + w)).
        let at_once = pid.derivative_a_s_per_m * pid.corner_rad_s;
        b[(integrator, channel)] = 1.0;
        c[(channel, integrator)] = -pid.integral_a_per_m_s;
        a[(low_pass, low_pass)] = -pid.corner_rad_s;
        b[(low_pass, channel)] = pid.corner_rad_s;
        c[(channel, low_pass)] = at_once;
        d[(channel, channel)] = -(pid.proportional_a_per_m + at_once);
    }
    let law = ControlLaw::Continuous(StateSpace::new(a, b, c, d, Continuous)?);
    Ok(Controller { name: name.to_owned(), law })
}
