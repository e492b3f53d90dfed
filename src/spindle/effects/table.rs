//! The table of effects: one entry describes one effect for files, plant, diagnosis and report.
//!
//! To add an effect: a variant of [`EffectKind`] with its entry in [`TABLE`], its action in `action`, and a
//! derivative in [`crate::spindle::response`] where differences are not good enough. Sources of the physics: G.
//! Schweitzer, E. H. Maslen (eds.), *Magnetic Bearings*, Springer 2009, chapters 2, 4 and 12; M. I. Friswell et al.,
//! *Dynamics of Rotating Machines*, Cambridge 2010, chapter 7.

use super::coordinate::Coordinate;
use super::entry::{COMMON, ELECTRONIC, Entry, HERTZ, Parameter, Shown, Site, Starts, positive, signed_parameter};
use super::kind::EffectKind;
use super::lags;
use super::location::LocationKind;
use super::scale::MachineScale;

/// A factor on a number of the machine, shown as a deviation in percent.
const FACTOR_OFF: Parameter = positive("factor", Coordinate::Logarithm, |_| (-2.0, 2.0), Shown::PercentOff);

/// A shift of a plane.
const OFFSET: Parameter = signed_parameter(
    "offset_m",
    // A millimetre where the magnets are 200 mm apart.
    Coordinate::Linear(|machine| 5e-3 * machine.bearing_span_m),
    |_| (-30.0, 30.0),
    Shown::Scaled(1e3, " mm"),
);

const GRAMS: Shown = Shown::Either(1e3, " g", ["less", "more"]);
const NEWTONS_PER_METRE: Shown = Shown::Scaled(1.0, " N/m");
const SQUARE_MILLIMETRES: Shown = Shown::Scaled(1e6, " kg mm²");

/// Every effect.
pub const TABLE: &[Entry] = &[
    lags::LOOP_DELAY,
    lags::AMPLIFIER_BANDWIDTH,
    lags::AMPLIFIER_SECOND_ORDER,
    lags::EDDY_CURRENTS,
    lags::LAMINATED_CORE,
    lags::SENSOR_LOWPASS,
    Entry {
        kind: EffectKind::SensorOffset,
        name: "sensor_offset",
        location: LocationKind::Bearing,
        parameters: &[OFFSET],
        sites: &[Site::SensorPlane],
        // A thousandth of the distance between the magnets.
        matters: |size, _, _| size.abs() > 0.2,
        sentence: "the sensor plane of {at} sits {0} off, + to the rear",
        advice: "check where the sensor ring sits on the drawing, and design with the corrected file",
        ..COMMON
    },
    Entry {
        kind: EffectKind::ActuatorOffset,
        name: "actuator_offset",
        location: LocationKind::Bearing,
        parameters: &[OFFSET],
        sites: &[Site::ActuatorPlane],
        // A thousandth of the distance between the magnets.
        matters: |size, _, _| size.abs() > 0.2,
        sentence: "the actuator plane of {at} sits {0} off, + to the rear",
        advice: "check where the magnet sits on the drawing, and design with the corrected file",
        ..COMMON
    },
    Entry {
        kind: EffectKind::NegativeStiffness,
        name: "negative_stiffness",
        location: LocationKind::Bearing,
        parameters: &[Parameter { positive: false, ..FACTOR_OFF }],
        sites: &[Site::Shaft],
        matters: |size, _, _| size.abs() > 0.03,
        sentence: "the negative stiffness of {at} is {0} off",
        advice: "check bias current and air gap (ks grows with i0² and falls with the cube of the gap)",
        ..COMMON
    },
    Entry {
        kind: EffectKind::ForceConstant,
        name: "force_constant",
        one_axis: true,
        parameters: &[FACTOR_OFF],
        sites: &[Site::Currents, Site::Loop],
        matters: |size, _, _| size.abs() > 0.02,
        sentence: "the force constant of {at} is {0} off",
        advice: "check bias current, air gap and the scale of the current command",
        ..ELECTRONIC
    },
    Entry {
        kind: EffectKind::SensorGain,
        name: "sensor_gain",
        one_axis: true,
        parameters: &[FACTOR_OFF],
        sites: &[Site::Sensors, Site::Loop],
        matters: |size, _, _| size.abs() > 0.02,
        sentence: "the sensor gain of {at} is {0} off",
        advice: "calibrate against the clearance from touch-down to touch-down",
        ..ELECTRONIC
    },
    Entry {
        kind: EffectKind::BearingCoupling,
        name: "bearing_coupling",
        parameters: &[signed_parameter(
            "ratio",
            Coordinate::Linear(|_| 1e-2),
            |_| (-50.0, 50.0),
            Shown::Scaled(100.0, " %"),
        )],
        couples_planes: true,
        sites: &[Site::AxisCoupling],
        // 0.1 % of the force constant.
        matters: |size, _, _| size.abs() > 0.1,
        sentence: "x and y of {at} are coupled by {0} of the force constant",
        advice: "look for flux leakage or unequal poles between the axes",
        ..ELECTRONIC
    },
    Entry {
        kind: EffectKind::AxisMisalignment,
        name: "axis_misalignment",
        parameters: &[signed_parameter(
            "angle_deg",
            Coordinate::Linear(|_| 1.0),
            |_| (-45.0, 45.0),
            Shown::Scaled(1.0, "°"),
        )],
        couples_planes: true,
        sites: &[Site::SensorAxes],
        // 0.1 degree.
        matters: |size, _, _| size.abs() > 0.1,
        sentence: "the sensor axes of {at} are turned by {0}",
        advice: "turn the sensor ring back, or rotate its signals in the controller",
        ..ELECTRONIC
    },
    Entry {
        kind: EffectKind::SensorCrosstalk,
        name: "sensor_crosstalk",
        location: LocationKind::Across,
        parameters: &[signed_parameter(
            "ratio",
            Coordinate::Linear(|_| 1e-2),
            |_| (-50.0, 50.0),
            Shown::Scaled(100.0, " %"),
        )],
        couples_planes: true,
        // 0.1 % of a signal.
        matters: |size, _, _| size.abs() > 0.1,
        sentence: "{0} of one sensor signal leaks into another, {at}",
        advice: "check cables, connectors and multiplexer of these two channels",
        ..ELECTRONIC
    },
    Entry {
        kind: EffectKind::CurrentPickup,
        name: "current_pickup",
        location: LocationKind::Across,
        parameters: &[signed_parameter(
            "m_per_a_s",
            Coordinate::Linear(MachineScale::pickup_unit_m_s_per_a),
            |_| (-50.0, 50.0),
            Shown::Scaled(1e12, " pm s/A"),
        )],
        couples_planes: true,
        // 0.1 % of the motion of the rigid rotor at the first bending frequency.
        matters: |size, _, _| size.abs() > 0.1,
        sentence: "a sensor picks up {0} of the rate of a current, {at}",
        advice: "lay sensor cables apart from those of the coils, and check their shields",
        ..ELECTRONIC
    },
    Entry {
        kind: EffectKind::Gyroscopic,
        name: "gyroscopic",
        parameters: &[signed_parameter("factor", Coordinate::Linear(|_| 1.0), |_| (-1.0, 3.0), Shown::Scaled(1.0, ""))],
        replaces: true,
        at_speed_only: true,
        sites: &[Site::Shaft],
        starts: Starts::AtPresent(|machine| machine.gyroscopic_factor),
        matters: |size, _, _| size.abs() > 0.03,
        sentence: "the gyroscopic effect counts {0} times",
        advice: "design with the corrected file at every speed",
        ..COMMON
    },
    Entry {
        kind: EffectKind::InternalDamping,
        name: "internal_damping",
        parameters: &[signed_parameter(
            "loss_time_s",
            // Damping of the first flexible mode, ζ = 0.0035.
            Coordinate::Linear(|machine| 7e-3 * machine.bending_time_s),
            |_| (-100.0, 100.0),
            Shown::Scaled(1e6, " µs"),
        )],
        sites: &[Site::Shaft],
        matters: |size, _, _| size.abs() > 0.02,
        sentence: "the rotor has internal damping with a loss time of {0}",
        advice: "verify stability at full speed with the corrected file, and check shrink fits",
        ..COMMON
    },
    Entry {
        kind: EffectKind::CrossCoupling,
        name: "cross_coupling",
        location: LocationKind::Position,
        parameters: &[signed_parameter(
            "stiffness_n_per_m",
            Coordinate::Linear(MachineScale::stiffness_unit_n_per_m),
            |_| (-200.0, 200.0),
            NEWTONS_PER_METRE,
        )],
        sites: &[Site::Shaft],
        // A thousandth of what the magnets pull with.
        matters: |size, _, machine| {
            machine.stiffness_unit_n_per_m() * size.abs() > 1e-3 * machine.negative_stiffness_n_per_m
        },
        sentence: "a circulatory stiffness of {0} acts at {at}",
        advice: "repeat with motor and coolant off to find its source, and verify stability at speed with the \
            corrected file",
        ..COMMON
    },
    Entry {
        kind: EffectKind::ModalDamping,
        name: "modal_damping",
        location: LocationKind::Mode,
        parameters: &[positive("factor", Coordinate::Logarithm, |_| (-4.0, 4.0), Shown::Scaled(1.0, ""))],
        // A factor of 1.4, or of 0.45: a ratio that is known to 20 % is that low once in three hundred; its logarithm
        // makes that look much rarer.
        matters: |size, _, _| size.abs() > if size < 0.0 { 0.8 } else { 0.35 },
        sentence: "the damping of {at} is {0} times that of the model",
        advice: "design with the corrected file, and check the fits that damp this mode",
        ..COMMON
    },
    Entry {
        kind: EffectKind::ToolJoint,
        name: "tool_joint",
        parameters: &[
            positive(
                "translational_n_per_m",
                Coordinate::Inverse(|machine| 0.1 * machine.nose_n_per_m),
                |_| (1e-3, 100.0),
                Shown::Scaled(1e-6, " N/µm"),
            ),
            positive(
                "rotational_n_m_per_rad",
                Coordinate::Inverse(|machine| 0.04 * machine.nose_n_m_per_rad),
                |_| (1e-3, 1000.0),
                Shown::Scaled(1e-3, " kN m/rad"),
            ),
            signed_parameter(
                "damping_n_m_s_per_rad",
                Coordinate::Linear(|m| 3e-4 * m.nose_n_m_per_rad * m.bending_time_s),
                // A joint takes energy out.
                |_| (0.0, 500.0),
                Shown::Scaled(1.0, " N m s/rad"),
            ),
        ],
        single: true,
        sites: &[Site::Joint],
        // A stiff joint, one as soft as collets get, and one of a small spindle.
        starts: Starts::At(&[&[1.0, 1.0, 0.0], &[6.0, 10.0, 0.5], &[25.0, 100.0, 0.01]]),
        // Twice E·d and 0.8 E·d³ at the nose: as stiff as the solid shaft.
        matters: |size, t, _| size.abs() > 0.05 || t.get(1).is_some_and(|turning| *turning > 0.05),
        sentence: "the tool sits in a flexible joint of {0} and {1}",
        advice: "clean and re-clamp the taper, check the drawbar force, and repeat; if it stays, design with the \
            corrected file",
        ..COMMON
    },
    Entry {
        kind: EffectKind::ToolMass,
        name: "tool_mass",
        parameters: &[signed_parameter(
            "mass_kg",
            Coordinate::Linear(|machine| 6e-4 * machine.rotor_mass_kg),
            |_| (-10.0, 100.0),
            GRAMS,
        )],
        sites: &[Site::Shaft, Site::Joint],
        // 0, 5, 15 and 40 g on a rotor of 8 kg: the resonance of a slender tool moves by more than its width.
        starts: Starts::At(&[&[0.0], &[1.0], &[3.0], &[8.0]]),
        // 0.3 g on a rotor of 8 kg.
        matters: |size, _, _| size.abs() > 0.06,
        sentence: "the tip of the tool carries {0} {way} than the model",
        advice: "weigh the tool, and correct the tool file",
        ..COMMON
    },
    Entry {
        kind: EffectKind::AddedMass,
        name: "added_mass",
        location: LocationKind::Position,
        parameters: &[signed_parameter(
            "mass_kg",
            Coordinate::Linear(|machine| 6e-3 * machine.rotor_mass_kg),
            |_| (-10.0, 60.0),
            GRAMS,
        )],
        sites: &[Site::Shaft],
        // 2 g on a rotor of 8 kg.
        matters: |size, _, _| size.abs() > 0.04,
        sentence: "{0} {way} sit at {at} than in the model",
        advice: "look for a part that is not in the drawing, or coolant in the bore",
        ..COMMON
    },
    Entry {
        kind: EffectKind::AddedDisc,
        name: "added_disc",
        location: LocationKind::Position,
        parameters: &[
            signed_parameter(
                "mass_kg",
                Coordinate::Linear(|machine| 6e-3 * machine.rotor_mass_kg),
                |_| (-10.0, 60.0),
                Shown::Scaled(1e3, " g"),
            ),
            signed_parameter(
                "polar_inertia_kg_m2",
                Coordinate::Linear(MachineScale::inertia_unit_kg_m2),
                |_| (0.0, 1000.0),
                SQUARE_MILLIMETRES,
            ),
            signed_parameter(
                "diametral_inertia_kg_m2",
                Coordinate::Linear(MachineScale::inertia_unit_kg_m2),
                |_| (0.0, 1000.0),
                SQUARE_MILLIMETRES,
            ),
        ],
        sites: &[Site::Shaft],
        // As for a mass, with a radius of gyration of a fortieth of the distance between the magnets: below, it is one.
        matters: |size, t, _| size.abs() > 0.04 && t.get(2).is_some_and(|inertia| *inertia > 0.04 * size.abs()),
        starts: Starts::At(&[&[0.0, 0.0, 0.0]]),
        sentence: "a disc of {0} with {1} about the axis and {2} about a diameter sits at {at}",
        advice: "look for a nut, a balancing ring or a thrust disc that is not in the drawing",
        ..COMMON
    },
    Entry {
        kind: EffectKind::HousingMode,
        name: "housing_mode",
        parameters: &[
            positive(
                "mass_kg",
                Coordinate::Inverse(|machine| 12.0 * machine.rotor_mass_kg),
                |_| (1e-3, 50.0),
                Shown::Scaled(1.0, " kg"),
            ),
            positive(
                "frequency_hz",
                Coordinate::Logarithm,
                |machine| {
                    let share = |share: f64| (share / machine.sample_period_s).ln();
                    (share(5e-4), share(0.3))
                },
                HERTZ,
            ),
            signed_parameter(
                "damping_ratio",
                Coordinate::Logarithm,
                |_| (1e-4f64.ln(), 0.7f64.ln()),
                Shown::Scaled(1.0, ""),
            ),
        ],
        sites: &[Site::Housing],
        starts: Starts::OverTheBand { first: 0.5, damping_ratio: 0.05 },
        // Six hundred times the rotor.
        matters: |size, _, _| size.abs() > 0.02,
        sentence: "the housing, {0}, resonates at {1} with a damping ratio of {2}",
        advice: "confirm with an accelerometer on the housing and the mount clamped, and design with the corrected \
            file",
        ..COMMON
    },
    Entry {
        kind: EffectKind::RegionStiffness,
        name: "region_stiffness",
        location: LocationKind::Region,
        parameters: &[FACTOR_OFF],
        sites: &[Site::Joint],
        // A region of several elements moves resonances further than a linear step follows.
        starts: Starts::At(&[&[0.0], &[-0.2], &[0.2]]),
        // 5 %, five times what careful updating leaves open.
        matters: |size, _, _| size.abs() > 0.05,
        sentence: "the modulus of {at} is {0} off",
        advice: "check the shrink fit or lamination stack of this region, and design with the corrected file",
        ..COMMON
    },
    Entry {
        kind: EffectKind::AddedStiffness,
        name: "added_stiffness",
        location: LocationKind::Position,
        one_axis: true,
        parameters: &[signed_parameter(
            "stiffness_n_per_m",
            Coordinate::Linear(MachineScale::stiffness_unit_n_per_m),
            |_| (-200.0, 200.0),
            NEWTONS_PER_METRE,
        )],
        sites: &[Site::Shaft],
        // A hundredth of what the magnets pull with: a careful ks is that far off.
        matters: |size, _, machine| {
            machine.stiffness_unit_n_per_m() * size.abs() > 0.01 * machine.negative_stiffness_n_per_m
        },
        sentence: "a stiffness of {0} acts at {at}",
        advice: "repeat with the motor off (its pull is negative), and look for seals or cables there",
        ..COMMON
    },
    Entry {
        kind: EffectKind::AddedDamper,
        name: "added_damper",
        location: LocationKind::Position,
        one_axis: true,
        parameters: &[signed_parameter(
            "damping_n_s_per_m",
            Coordinate::Linear(MachineScale::damping_unit_n_s_per_m),
            |_| (-20.0, 200.0),
            Shown::Scaled(1.0, " N s/m"),
        )],
        sites: &[Site::Shaft],
        // As a spring at the first bending frequency: a hundredth of what the magnets pull with.
        matters: |size, _, machine| {
            machine.stiffness_unit_n_per_m() * size.abs() > 0.01 * machine.negative_stiffness_n_per_m
        },
        sentence: "a damper of {0} acts at {at}",
        advice: "look for seals, films or a motor that damps there, and design with the corrected file",
        ..COMMON
    },
    Entry {
        kind: EffectKind::TiltingStiffness,
        name: "tilting_stiffness",
        location: LocationKind::Position,
        parameters: &[signed_parameter(
            "stiffness_n_m_per_rad",
            Coordinate::Linear(MachineScale::tilting_unit_n_m_per_rad),
            |_| (-200.0, 200.0),
            Shown::Scaled(1.0, " N m/rad"),
        )],
        // Thrust discs and axial bearings.
        on_spindle: true,
        sites: &[Site::Shaft],
        // A tenth of what the magnets tilt with; on a spindle of 8 kg this is 2000 N m/rad, which a thrust disc of
        // 100 mm has that pulls with 1 N/µm at its rim.
        matters: |size, _, machine| {
            let magnets = machine.negative_stiffness_n_per_m * machine.tilting_arm_m2();
            machine.tilting_unit_n_m_per_rad() * size.abs() > 0.1 * magnets
        },
        sentence: "a tilting stiffness of {0} acts at {at}",
        advice: "repeat with the axial bearing at another bias (magnetic tilting is negative and grows with its \
            square), and design with the corrected file",
        ..COMMON
    },
];
