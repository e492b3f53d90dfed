//! PID YAML (formats.md) to [`GivenPid`].

use super::error::InputError;
use super::error_list::ErrorList;
use super::keys;
use super::positive::positive;
use super::shipped;
use super::yaml;
use crate::pid::given::{ChannelCoordinates, GivenChannel, GivenPid, Notch, Restoring};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// A PID with given numbers, the same in x and y.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PidFile {
    /// Name of the controller.
    name: String,
    /// What the two channels act on: `bearings` or `tilt_translation`; bearings unless given.
    #[serde(default)]
    coordinates: CoordinatesFile,
    /// Front bearing.
    front: Option<ChannelFile>,
    /// Rear bearing.
    rear: Option<ChannelFile>,
    /// Displacement of the centre of gravity.
    translation: Option<ChannelFile>,
    /// Tilt times half the distance of the magnets.
    tilt: Option<ChannelFile>,
}

#[derive(Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum CoordinatesFile {
    #[default]
    Bearings,
    TiltTranslation,
}

/// A channel.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ChannelFile {
    /// Stiffness at the magnet that is left of its negative one; this or `gain_a_per_m`.
    stiffness_n_per_m: Option<f64>,
    /// Proportional gain; this or `stiffness_n_per_m`.
    gain_a_per_m: Option<f64>,
    /// Integral gain.
    #[schemars(extend("default" = 0.0))]
    integral_a_per_m_s: Option<f64>,
    /// Derivative gain.
    damping_a_s_per_m: f64,
    /// Corner of the first-order roll-off of the derivative.
    derivative_rolloff_hz: f64,
    /// Corner of a second-order roll-off of the whole, damping 0.7; none unless given.
    rolloff_hz: Option<f64>,
    /// A lead (a lag where the pole is lower); none unless given.
    lead: Option<LeadFile>,
    /// Notches.
    #[serde(default)]
    notches: Vec<NotchFile>,
}

/// (1 + s/zero)/(1 + s/pole).
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LeadFile {
    /// Corner of the zero.
    zero_hz: f64,
    /// Corner of the pole.
    pole_hz: f64,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NotchFile {
    /// Where the gain is smallest.
    frequency_hz: f64,
    /// Share of the gain that is taken away there, at most 1.
    depth: f64,
    /// Bandwidth over frequency.
    width: f64,
}

/// A PID from a path; its frequencies lie below half of the sample rate.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_pid(source: &str, sample_rate_hz: f64) -> Result<GivenPid, InputError> {
    read_pid(source, &shipped::text(source, "PID", &[])?, sample_rate_hz)
}

/// A PID from the text of a file; `file` names it in messages.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn read_pid(file: &str, text: &str, sample_rate_hz: f64) -> Result<GivenPid, InputError> {
    let mut errors = ErrorList::new(file, text);
    let pid = yaml::read(&mut errors, keys::PID).and_then(|read| given_pid(&mut errors, read, 0.5 * sample_rate_hz));
    errors.finish(pid)
}

/// The PID of a file; what its values break is added to the errors.
fn given_pid(errors: &mut ErrorList<'_>, read: PidFile, nyquist_hz: f64) -> Option<GivenPid> {
    let bearings = [("front", read.front), ("rear", read.rear)];
    let rigid = [("translation", read.translation), ("tilt", read.tilt)];
    let (coordinates, wanted, others) = match read.coordinates {
        CoordinatesFile::Bearings => (ChannelCoordinates::Bearings, bearings, rigid),
        CoordinatesFile::TiltTranslation => (ChannelCoordinates::TiltTranslation, rigid, bearings),
    };
    const HINT: &str = "bearings have the channels `front` and `rear`, `coordinates: tilt_translation` has \
                        `translation` and `tilt`";
    for (name, _) in others.iter().filter(|(_, channel)| channel.is_some()) {
        let rule = format!("{name}: is no channel of these coordinates");
        errors.add_rule(InputError::new(errors.file, rule).with_hint(HINT));
    }
    let channels = wanted.map(|(name, channel)| {
        if channel.is_none() {
            errors.add(InputError::new(errors.file, format!("{name}: is missing")).with_hint(HINT));
        }
        channel.and_then(|own| given_channel(errors, name, own, nyquist_hz))
    });
    let [Some(first), Some(second)] = channels else { return None };
    Some(GivenPid { name: read.name, coordinates, channels: [first, second] })
}

fn given_channel(errors: &mut ErrorList<'_>, name: &str, read: ChannelFile, nyquist_hz: f64) -> Option<GivenChannel> {
    for (key, value) in [("stiffness_n_per_m", read.stiffness_n_per_m), ("gain_a_per_m", read.gain_a_per_m)] {
        positive(errors, &format!("{name}.{key}"), value);
    }
    let lead = read.lead.as_ref();
    let corners = [
        ("derivative_rolloff_hz", Some(read.derivative_rolloff_hz)),
        ("rolloff_hz", read.rolloff_hz),
        ("lead.zero_hz", lead.map(|lead| lead.zero_hz)),
        ("lead.pole_hz", lead.map(|lead| lead.pole_hz)),
    ];
    for (key, hz) in corners {
        check_frequency(errors, &format!("{name}.{key}"), hz, nyquist_hz);
    }
    let integral = read.integral_a_per_m_s.unwrap_or(0.0);
    for (key, value) in [("integral_a_per_m_s", integral), ("damping_a_s_per_m", read.damping_a_s_per_m)] {
        if !(value.is_finite() && value >= 0.0) {
            let rule = format!("{name}.{key}: {value} must be zero or a positive number");
            errors.add_rule(InputError::new(errors.file, rule).with_hint("a force that pushes back is positive"));
        }
    }
    for (k, notch) in read.notches.iter().enumerate() {
        let path = |key: &str| format!("{name}.notches[{k}].{key}");
        check_frequency(errors, &path("frequency_hz"), Some(notch.frequency_hz), nyquist_hz);
        positive(errors, &path("width"), Some(notch.width));
        if !(notch.depth > 0.0 && notch.depth <= 1.0) {
            let rule = format!("{}: {} must be above 0 and at most 1", path("depth"), notch.depth);
            errors.add_rule(InputError::new(errors.file, rule).with_hint("0.9 leaves a tenth of the gain"));
        }
    }
    let restoring = match (read.gain_a_per_m, read.stiffness_n_per_m) {
        (Some(gain_a_per_m), None) => Some(Restoring::Gain(gain_a_per_m)),
        (None, Some(net_n_per_m)) => Some(Restoring::Stiffness(net_n_per_m)),
        _ => {
            let rule = format!("{name}: one of gain_a_per_m and stiffness_n_per_m is needed, and only one");
            errors.add(InputError::new(errors.file, rule).with_hint("gain = (stiffness + ks)/ki of the magnet"));
            None
        }
    };
    let notches = read.notches.iter();
    Some(GivenChannel {
        restoring: restoring?,
        integral_a_per_m_s: integral,
        damping_a_s_per_m: read.damping_a_s_per_m,
        derivative_corner_rad_s: TAU * read.derivative_rolloff_hz,
        lead_rad_s: read.lead.map(|lead| [TAU * lead.zero_hz, TAU * lead.pole_hz]),
        notches: notches.map(|n| Notch { omega_rad_s: TAU * n.frequency_hz, depth: n.depth, width: n.width }).collect(),
        roll_off_rad_s: read.rolloff_hz.map(|hz| TAU * hz),
    })
}

/// Adds an error unless a frequency is positive, below that of Nyquist, or not there.
fn check_frequency(errors: &mut ErrorList<'_>, path: &str, hz: Option<f64>, nyquist_hz: f64) {
    positive(errors, path, hz);
    if let Some(hz) = hz.filter(|hz| *hz >= nyquist_hz) {
        let rule = format!("{path}: {hz} Hz is not below half of the sample rate of the spindle, {nyquist_hz} Hz");
        errors.add_rule(InputError::new(errors.file, rule).with_hint("a sampled controller has no corner there"));
    }
}
