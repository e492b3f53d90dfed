//! Entries of the table for what makes a loop later: delay, amplifiers, eddy currents, low-passes of the sensors.

use super::coordinate::Coordinate;
use super::entry::{ELECTRONIC, Entry, HERTZ, Shown, Site, Starts, positive, signed_parameter};
use super::kind::EffectKind;
use super::location::LocationKind;
use super::scale::MachineScale;

/// Start of a corner frequency that is far above the band.
const FROM_HIGH_CORNER: Starts = Starts::At(&[&[0.1]]);

/// The entry of [`EffectKind::LoopDelay`].
pub(super) const LOOP_DELAY: Entry = Entry {
    kind: EffectKind::LoopDelay,
    name: "loop_delay",
    location: LocationKind::None,
    one_axis: true,
    parameters: &[signed_parameter(
        "delay_s",
        Coordinate::Linear(|machine| 0.2 * machine.sample_period_s),
        // The total delay is half a sample at least.
        |machine| (-machine.spare_delay_s / (0.2 * machine.sample_period_s), 100.0),
        Shown::Either(1e6, " µs", ["faster", "slower"]),
    )],
    sites: &[Site::Loop],
    // A hundredth of a sample.
    matters: |size, _, _| size.abs() > 0.05,
    sentence: "{at} is {0} {way} than the model",
    advice: "design with the corrected file, and look for computing or PWM time that the model leaves out",
    ..ELECTRONIC
};

/// The entry of [`EffectKind::AmplifierBandwidth`].
pub(super) const AMPLIFIER_BANDWIDTH: Entry = Entry {
    kind: EffectKind::AmplifierBandwidth,
    name: "amplifier_bandwidth",
    one_axis: true,
    parameters: &[positive(
        "bandwidth_hz",
        Coordinate::Slowness(|machine| 2.0 * machine.sample_period_s),
        // 25 times the sample rate at most.
        |machine| {
            let own = (machine.amplifier_bandwidth_hz * machine.sample_period_s).recip();
            (0.5 * (0.04 - own), 1e2)
        },
        HERTZ,
    )],
    replaces: true,
    sites: &[Site::Currents, Site::Loop],
    // 2 % of the bandwidth.
    matters: |size, _, machine| 2.0 * size.abs() * machine.amplifier_bandwidth_hz * machine.sample_period_s > 0.02,
    sentence: "the amplifier of {at} has a bandwidth of {0}",
    advice: "measure command to coil current, and check current controller and bus voltage",
    ..ELECTRONIC
};

/// The entry of [`EffectKind::AmplifierSecondOrder`].
pub(super) const AMPLIFIER_SECOND_ORDER: Entry = Entry {
    kind: EffectKind::AmplifierSecondOrder,
    name: "amplifier_second_order",
    one_axis: true,
    parameters: &[
        positive("frequency_hz", Coordinate::Inverse(MachineScale::half_sample_rate_hz), |_| (0.02, 50.0), HERTZ),
        positive("damping_ratio", Coordinate::Logarithm, |_| (-3.0, 2.0), Shown::Scaled(1.0, "")),
    ],
    replaces: true,
    sites: &[Site::Currents, Site::Loop],
    // At the lag of the present amplifier, well damped.
    starts: Starts::InPlaceOf(|machine| {
        let damping_ratio: f64 = 0.7;
        let frequency_hz = 2.0 * damping_ratio * machine.amplifier_bandwidth_hz;
        vec![machine.half_sample_rate_hz() / frequency_hz, damping_ratio.ln()]
    }),
    sentence: "the amplifier of {at} is of second order, {0} with a damping ratio of {1}",
    advice: "measure command to coil current, and check the gains of the current controller",
    ..ELECTRONIC
};

/// The entry of [`EffectKind::EddyCurrents`].
pub(super) const EDDY_CURRENTS: Entry = Entry {
    kind: EffectKind::EddyCurrents,
    name: "eddy_currents",
    one_axis: true,
    parameters: &[positive(
        "corner_hz",
        Coordinate::InverseSquare(MachineScale::half_sample_rate_hz),
        |_| (0.02, 50.0),
        HERTZ,
    )],
    replaces: true,
    sites: &[Site::Currents, Site::Loop],
    starts: FROM_HIGH_CORNER,
    // A corner below fifty times the sample rate.
    matters: |size, _, _| size.abs() > 0.1,
    sentence: "eddy currents weaken {at} from a corner of {0} on",
    advice: "look for solid or thick laminated parts in the flux path, and design with the corrected file",
    ..ELECTRONIC
};

/// The entry of [`EffectKind::LaminatedCore`].
pub(super) const LAMINATED_CORE: Entry = Entry {
    kind: EffectKind::LaminatedCore,
    name: "laminated_core",
    one_axis: true,
    parameters: &[positive(
        "corner_hz",
        Coordinate::Inverse(MachineScale::half_sample_rate_hz),
        |_| (0.02, 50.0),
        HERTZ,
    )],
    replaces: true,
    sites: &[Site::Currents, Site::Loop],
    starts: FROM_HIGH_CORNER,
    // A lag of 1/(3 ω_l), a hundredth of a sample, as a delay of that length.
    matters: |size, _, _| size.abs() > 0.1,
    sentence: "eddy currents in the laminations weaken {at} from a corner of {0} on",
    advice: "compare with the thickness of the sheets, and design with the corrected file",
    ..ELECTRONIC
};

/// The entry of [`EffectKind::SensorLowpass`].
pub(super) const SENSOR_LOWPASS: Entry = Entry {
    kind: EffectKind::SensorLowpass,
    name: "sensor_lowpass",
    one_axis: true,
    parameters: &[positive(
        "bandwidth_hz",
        Coordinate::Inverse(MachineScale::half_sample_rate_hz),
        |_| (0.02, 50.0),
        HERTZ,
    )],
    replaces: true,
    sites: &[Site::Sensors, Site::Loop],
    starts: FROM_HIGH_CORNER,
    // A corner below ten times the sample rate.
    matters: |size, _, _| size.abs() > 0.05,
    sentence: "the sensors of {at} have a low-pass at {0}",
    advice: "check the anti-alias filter and the demodulation of these sensors",
    ..ELECTRONIC
};
