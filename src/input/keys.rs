//! Every number that a file holds: unit, the range that real machines keep to, the range outside which it is
//! refused, and why.
//!
//! Outside the plausible range a value is said and used; outside the possible one it is an error. Both name the unit
//! that it looks like. The ranges are those of rotors on active magnetic bearings, from small turbo spindles to
//! compressors.

pub use super::key::{Key, KeyGroup};
use super::key::{Range, group, keys, number, positive};
use super::{curve, uncertainty};

const LENGTH: &str = "elements of a shaft are fractions of a millimetre to some decimetres long";
const DIAMETER: &str = "shafts on magnetic bearings are a few millimetres to some decimetres thick";

pub(crate) const MATERIAL: &[Key] = keys! {
    number "youngs_modulus_pa" "Pa" [[1e10, 8e11], [1e9, 2e12]]
        "magnesium has 45 GPa, steel 206 GPa, cemented carbide 650 GPa";
    number "density_kg_m3" "kg/m³" [[1000.0, 2e4], [500.0, 2.5e4]]
        "carbon fibre has 1 600 kg/m³, steel 7 850 kg/m³, tungsten 19 300 kg/m³";
    number "poisson_ratio" "" [[0.05, 0.46], [0.0, 1.0]] "metals lie between 0.2 and 0.45";
};

pub(crate) const ELEMENT: &[Key] = keys! {
    number "length_m" "m" [[2e-4, 0.3], [1e-5, 5.0]] LENGTH;
    number "outer_diameter_m" "m" [[2e-4, 0.5], [5e-5, 3.0]] DIAMETER;
    number "inner_diameter_m" "m" [[1e-4, 0.4], [0.0, 3.0]] DIAMETER;
    number "mass_outer_diameter_m" "m" [[2e-4, 0.6], [0.0, 3.0]] DIAMETER;
    number "mass_inner_diameter_m" "m" [[1e-4, 0.5], [0.0, 3.0]] DIAMETER;
    number "modulus_scale" "" [[0.05, 5.0], [1e-3, 1e3]]
        "laminations and joints take a shaft to a tenth of its modulus at least";
};

pub(crate) const DISC: &[Key] = keys! {
    number "position_m" "m" [[0.0, 3.0], [0.0, 10.0]] "shafts on magnetic bearings are shorter than 3 m";
    number "mass_kg" "kg" [[1e-5, 200.0], [0.0, 1e4]] "discs of a spindle have grams to some kilograms";
    number "polar_inertia_kg_m2" "kg m²" [[1e-11, 10.0], [0.0, 1e3]]
        "m r²/2 of a disc of 100 kg and 0.4 m radius is 8 kg m²";
    number "diametral_inertia_kg_m2" "kg m²" [[1e-11, 10.0], [0.0, 1e3]]
        "m r²/4 of a disc of 100 kg and 0.4 m radius is 4 kg m²";
    number "thickness_m" "m" [[2e-4, 0.3], [1e-5, 5.0]]
        "in the place of mass and inertia; discs are millimetres to decimetres thick";
    number "outer_diameter_m" "m" [[2e-3, 1.0], [5e-5, 3.0]]
        "with thickness_m; wheels are some centimetres to some decimetres wide";
    number "inner_diameter_m" "m" [[1e-4, 0.4], [0.0, 3.0]] "with thickness_m; none unless given";
};

const BEARING: &[Key] = keys! {
    number "ki_n_per_a" "N/A" KI KI_WHY;
    number "ks_n_per_m" "N/m" KS KS_WHY;
    number "max_force_n" "N" [[1.0, 1e5], [1e-2, 1e7]] "radial bearings carry some newtons to some ten kilonewtons";
    number "bias_current_a" "A" BIAS BIAS_WHY;
    number "max_current_a" "A" COIL COIL_WHY;
    number "gap_m" "m" GAP GAP_WHY;
    number "sensor_gain" "" GAIN GAIN_WHY;
};
const BIAS: [Range; 2] = [[0.05, 50.0], [1e-3, 1e3]];
const BIAS_WHY: &str = "coils are biased with some tenths to some ten amperes";
const COIL: [Range; 2] = [[0.1, 200.0], [1e-3, 1e4]];
const COIL_WHY: &str = "switching amplifiers give some to some ten amperes";
const GAP: [Range; 2] = [[5e-5, 3e-3], [1e-5, 2e-2]];
const GAP_WHY: &str = "air gaps are 0.2 to 1 mm";
const KI: [Range; 2] = [[1.0, 5e3], [1e-2, 1e6]];
const KI_WHY: &str = "bearings of 50 N to 5 kN have 10 to 1000 N/A";
const KS: [Range; 2] = [[1e3, 1e8], [0.0, 1e10]];
const KS_WHY: &str = "bearings of 50 N to 5 kN have 10⁴ to 10⁷ N/m";
const GAIN: [Range; 2] = [[0.5, 2.0], [1e-2, 1e2]];
const GAIN_WHY: &str = "a factor near 1 on the calibrated signal";
const AXES_KI: &[Key] = keys! { number "x" "N/A" KI KI_WHY; number "y" "N/A" KI KI_WHY; };
const AXES_KS: &[Key] = keys! { number "x" "N/m" KS KS_WHY; number "y" "N/m" KS KS_WHY; };
const AXES_GAIN: &[Key] = keys! { number "x" "" GAIN GAIN_WHY; number "y" "" GAIN GAIN_WHY; };

const THRUST: &[Key] = keys! {
    number "ki_n_per_a" "N/A" KI KI_WHY;
    number "ks_n_per_m" "N/m" KS KS_WHY;
    number "bias_current_a" "A" BIAS BIAS_WHY;
    number "max_current_a" "A" COIL COIL_WHY;
    number "gap_m" "m" GAP GAP_WHY;
    number "mass_kg" "kg" [[1e-2, 5e3], [1e-6, 1e7]] "that of rotor and tool unless given";
    number "disc_mass_kg" "kg" [[1e-3, 1e3], [1e-6, 1e7]] "thrust discs have a tenth to a third of the rotor's mass";
    number "disc_mode_hz" "Hz" [[100.0, 2e4], [1.0, 1e7]] "thrust discs bend like an umbrella at some kilohertz";
    number "disc_damping_ratio" "" [[1e-4, 0.1], [0.0, 1.0]] "steel with shrink fits; 0.002 unless given";
    number "eddy_corner_hz" "Hz" [[1.0, 1e5], [1e-3, 1e9]] "solid cores weaken from some ten to some hundred hertz on";
};

const ELECTRONICS: &[Key] = keys! {
    number "amplifier_bandwidth_hz" "Hz" [[50.0, 1e5], [1.0, 1e7]] "current loops reach 500 Hz to 5 kHz";
    number "sensor_bandwidth_hz" "Hz" [[200.0, 1e6], [10.0, 1e8]]
        "position sensors reach some kilohertz to some ten kilohertz";
    number "sensor_noise_m" "m" [[1e-11, 5e-6], [0.0, 1e-4]] "position sensors have 10 nm to 1 µm of noise";
    number "delay_s" "s" [[1e-7, 2e-3], [0.0, 1e-2]] "one and a half samples at 1 to 100 kHz are 15 µs to 1.5 ms";
    number "sample_rate_hz" "Hz" [[1e3, 5e5], [100.0, 1e7]] "magnetic bearings are sampled at 5 to 100 kHz";
};

const PLANES: &[Key] = {
    const WHERE: [Range; 2] = [[0.0, 3.0], [0.0, 10.0]];
    const WHY: &str = "shafts on magnetic bearings are shorter than 3 m";
    keys! {
        number "front_sensor_m" "m" WHERE WHY;
        number "front_actuator_m" "m" WHERE WHY;
        number "rear_actuator_m" "m" WHERE WHY;
        number "rear_sensor_m" "m" WHERE WHY;
    }
};

const EFFECT: &[Key] = keys! {
    number "delay_s" "s" [[1e-8, 1e-3], [0.0, 1e-2]]
        "delays between controller and coil are microseconds to a few samples";
    number "bandwidth_hz" "Hz" [[50.0, 1e6], [1.0, 1e9]] "amplifiers and sensors reach 500 Hz to 100 kHz";
    number "corner_hz" "Hz" [[1.0, 1e7], [1e-3, 1e12]]
        "eddy currents begin at some hertz in solid and some kilohertz in laminated cores";
    number "offset_m" "m" [[1e-6, 0.1], [0.0, 1.0]] "planes are known to some millimetres";
    number "mass_kg" "kg" [[1e-5, 1e4], [0.0, 1e6]] "parts of a spindle and its housing have grams to tonnes";
};

const DAMPING: Key = number(
    "damping_ratio[]",
    "",
    [[1e-5, 0.1], [0.0, 1.0]],
    "steel shafts with shrink fits have 0.001 to 0.02 of critical damping",
);

/// A spindle file.
pub const SPINDLE: &[KeyGroup] = &[
    group("rotor.materials.*", MATERIAL),
    group("rotor.elements[]", ELEMENT),
    group("rotor.discs[]", DISC),
    group(
        "rotor",
        &[
            DAMPING,
            number("flexible_modes", "", [[1.0, 10.0], [0.0, 1e4]], "a controller acts on the first few bending modes"),
        ],
    ),
    group("planes", PLANES),
    group("bearings.front", BEARING),
    group("bearings.rear", BEARING),
    group("bearings.front.ki_n_per_a", AXES_KI),
    group("bearings.rear.ki_n_per_a", AXES_KI),
    group("bearings.front.ks_n_per_m", AXES_KS),
    group("bearings.rear.ks_n_per_m", AXES_KS),
    group("bearings.front.sensor_gain", AXES_GAIN),
    group("bearings.rear.sensor_gain", AXES_GAIN),
    group("thrust", THRUST),
    group("electronics", ELECTRONICS),
    group(
        "speed",
        keys! {
            number "max_rpm" "rpm" [[100.0, 3e5], [1.0, 2e6]]
                "the surface of a steel rotor bursts near 300 m/s: 300 000 rpm at 20 mm";
        },
    ),
    group(
        "",
        keys! {
            number "backup_clearance_m" "m" [[1e-5, 1.5e-3], [2e-6, 1e-2]]
                "backup bearings have about half the air gap, 0.1 to 0.5 mm";
        },
    ),
    group(
        "",
        &[number(
            "output_m",
            "m",
            [[0.0, 3.0], [0.0, 10.0]],
            "shafts on magnetic bearings are shorter than 3 m; at the tool plane, without a tool at the nose face",
        )],
    ),
    group(
        "backup_bearings",
        keys! {
            number "contact_stiffness_n_per_m" "N/m" [[1e6, 1e9], [1e3, 1e12]]
                "rolling bearings of spindle size have about 1e8 N/m, resilient mounts less; 3e7 unless given";
            number "contact_damping_n_s_per_m" "N s/m" [[10.0, 1e6], [0.0, 1e9]]
                "15 % of the critical damping of half the rotor on the contact stiffness unless given";
            number "friction" "" [[0.01, 0.6], [0.0, 2.0]]
                "lubricated steel has 0.1, dry contact up to 0.4; 0.1 unless given";
            number "contact_radius_m" "m" [[1e-3, 0.2], [1e-4, 1.0]]
                "that of the shaft at the actuators, on average, unless given";
        },
    ),
    group(
        "stiffness_band",
        keys! {
            number "from_hz" "Hz" [[0.01, 100.0], [1e-3, 1e5]]
                "below it the integral part of a controller makes the tool stiff; 1 unless given";
            number "to_hz" "Hz" [[50.0, 5e4], [1e-2, 1e6]]
                "that of the cutting forces: tooth passing with its harmonics; 4000 unless given";
        },
    ),
    group("effects[]", EFFECT),
];

const STIFF: [Range; 2] = [[10.0, 1e10], [0.0, 1e13]];
const STIFF_WHY: &str = "bungees have 100 N/m, rolling bearings 1e8 N/m; none unless given";
const DAMPED: [Range; 2] = [[0.1, 1e6], [0.0, 1e9]];
const DAMPED_WHY: &str = "squeeze films have some thousand N s/m; none unless given";
const SUPPORT: &[Key] = keys! {
    number "position_m" "m" [[0.0, 3.0], [0.0, 10.0]] "shafts on magnetic bearings are shorter than 3 m";
    number "stiffness_n_per_m" "N/m" STIFF STIFF_WHY;
    number "damping_n_s_per_m" "N s/m" DAMPED DAMPED_WHY;
};
const SUPPORT_STIFFNESS: &[Key] = &[number("x", "N/m", STIFF, STIFF_WHY), number("y", "N/m", STIFF, STIFF_WHY)];
const SUPPORT_DAMPING: &[Key] = &[number("x", "N s/m", DAMPED, DAMPED_WHY), number("y", "N s/m", DAMPED, DAMPED_WHY)];

/// A rotor without magnets.
pub const ROTOR: &[KeyGroup] = &[
    group("rotor.materials.*", MATERIAL),
    group("rotor.elements[]", ELEMENT),
    group("rotor.discs[]", DISC),
    group("rotor", &[DAMPING]),
    group("supports[]", SUPPORT),
    group("supports[].stiffness_n_per_m", SUPPORT_STIFFNESS),
    group("supports[].damping_n_s_per_m", SUPPORT_DAMPING),
];

/// A tool file.
pub const TOOL: &[KeyGroup] = &[
    group("materials.*", MATERIAL),
    group("elements[]", ELEMENT),
    group("discs[]", DISC),
    group(
        "",
        keys! {
            number "tool_plane_m" "m" [[1e-3, 0.5], [0.0, 3.0]]
                "tools stand out of the nose by some millimetres to some decimetres";
            number "teeth" "" [[1.0, 12.0], [1.0, 200.0]] "cutters have some teeth";
        },
    ),
];

const LIMITS: &[Key] = {
    const FORCE: [Range; 2] = [[1e-2, 1e5], [1e-6, 1e7]];
    const PATH: [Range; 2] = [[1e-8, 2e-3], [1e-12, 0.1]];
    const CUT: &str = "cutting forces are some newtons to some kilonewtons";
    const MOVE: &str = "a rotor may move some micrometres in an air gap below a millimetre";
    const CROSS: &str = "loads change from static to dynamic between 1 Hz and some hundred hertz";
    keys! {
        positive "max_dc_load_n" "N" FORCE CUT;
        positive "max_hf_load_n" "N" FORCE CUT;
        positive "max_dc_displacement_m" "m" PATH MOVE;
        positive "max_hf_displacement_m" "m" PATH MOVE;
        positive "load_crossover_hz" "Hz" [[0.1, 1e4], [1e-4, 1e7]] CROSS;
        positive "displacement_crossover_hz" "Hz" [[0.1, 1e4], [1e-4, 1e7]] CROSS;
    }
};

/// A weights file.
pub const WEIGHTS: &[KeyGroup] = &[
    group("tool", LIMITS),
    group("front", LIMITS),
    group("rear", LIMITS),
    group(
        "",
        keys! {
            number "mode_uncertainty[]" "" [[1e-4, 0.3], [0.0, 1.0]] "natural frequencies are known to some per cent";
            positive "current_limit_a" "A" [[0.01, 100.0], [1e-6, 1e6]]
                "control currents are below the bias current of some amperes";
            positive "current_rolloff_hz" "Hz" [[50.0, 1e5], [0.1, 1e9]] "current loops reach 500 Hz to 5 kHz";
            number "current_rolloff_ratio" "" [[1.5, 1e3], [1.0, 1e9]] "10 is a decade of roll-off";
            positive "tool_tightening" "" [[0.2, 20.0], [1e-9, 1e9]]
                "a specification is tightened by tens of per cent";
            positive "sensor_noise_m" "m" [[1e-11, 5e-6], [1e-15, 1e-3]] "position sensors have 10 nm to 1 µm of noise";
            positive "complementary_sensitivity_limit" "" [[0.5, 50.0], [1e-3, 1e6]]
                "ISO 14839-3 rates peaks of 3 to 5";
            positive "integral_corner_hz" "Hz" [[1e-3, 100.0], [1e-9, 1e6]]
                "integral action ends below the first resonance";
            number "mode_shift" "" [[0.001, 0.1], [0.0, 0.5]] "a PID holds modes shifted by 0.03";
            positive "least_decay_per_s" "1/s" [[0.1, 100.0], [1e-3, 1e4]]
                "loops come to rest within hundredths of a second to seconds";
        },
    ),
    group("uncertainty", uncertainty::KEYS),
    group("uncertainty.actuator", uncertainty::ACTUATOR_KEYS),
    group("uncertainty.sensor", uncertainty::SENSOR_KEYS),
    group("over_frequency.*", curve::KEYS),
    group("tool_stiffness[]", TOOL_STIFFNESS),
];

const TOOL_STIFFNESS: &[Key] = {
    const WHERE: [Range; 2] = [[0.1, 1e4], [1e-6, 1e6]];
    const WHY: &str = "the stiffness of a tool counts between 1 Hz and some kilohertz";
    keys! {
        positive "from_hz" "Hz" WHERE WHY;
        positive "to_hz" "Hz" WHERE WHY;
        positive "at_least_n_per_m" "N/m" [[1e3, 1e9], [1e-3, 1e12]] "tools on magnets have 0.1 to 100 N/µm";
    }
};

/// A file of frequencies.
pub const FREQUENCIES: &[KeyGroup] = {
    const RANGE: [Range; 2] = [[10.0, 5e4], [1e-3, 1e8]];
    const WHY: &str = "bending modes of a spindle lie between 50 Hz and 20 kHz";
    &[
        group("", &[number("resonances_hz[]", "Hz", RANGE, WHY)]),
        group("antiresonances_hz", &[number("front[]", "Hz", RANGE, WHY), number("rear[]", "Hz", RANGE, WHY)]),
    ]
};

/// The list of a measurement folder.
pub const MEASUREMENT: &[KeyGroup] = &[group(
    "records[]",
    keys! {
        number "speed_rpm" "rpm" [[10.0, 3e5], [0.0, 2e6]]
            "the surface of a steel rotor bursts near 300 m/s: 300 000 rpm at 20 mm";
        number "response_m" "m" HIT HIT_WHY;
        number "force_m" "m" HIT HIT_WHY;
    },
)];

const HIT: [Range; 2] = [[0.0, 3.0], [0.0, 10.0]];
const HIT_WHY: &str = "shafts on magnetic bearings are shorter than 3 m; at the tool plane unless given";

/// Other units that a number in a unit is written in by mistake, with their size.
pub(crate) fn other_units(unit: &str) -> &'static [(&'static str, f64)] {
    match unit {
        "m" => &[("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9), ("inches", 0.0254)],
        "Pa" => &[("GPa", 1e9), ("MPa", 1e6)],
        "kg/m³" => &[("g/cm³", 1e3), ("t/mm³", 1e12)],
        "kg" => &[("g", 1e-3), ("t", 1e3)],
        "kg m²" => &[("kg mm²", 1e-6), ("g mm²", 1e-9)],
        "s" => &[("ms", 1e-3), ("µs", 1e-6)],
        "Hz" => &[("kHz", 1e3), ("MHz", 1e6), ("rpm", 1.0 / 60.0)],
        "N/m" => &[("N/µm", 1e6), ("N/mm", 1e3)],
        "N" => &[("kN", 1e3), ("mN", 1e-3)],
        "A" => &[("mA", 1e-3)],
        "rpm" => &[("krpm", 1e3), ("Hz", 60.0)],
        "" => &[("per cent", 1e-2)],
        _ => &[],
    }
}

/// A PID file.
pub const PID: &[KeyGroup] = &[
    group("front", CHANNEL),
    group("rear", CHANNEL),
    group("translation", CHANNEL),
    group("tilt", CHANNEL),
    group("front.notches[]", NOTCH),
    group("rear.notches[]", NOTCH),
    group("translation.notches[]", NOTCH),
    group("tilt.notches[]", NOTCH),
    group("front.lead", LEAD),
    group("rear.lead", LEAD),
    group("translation.lead", LEAD),
    group("tilt.lead", LEAD),
];

const CORNER: [Range; 2] = [[1.0, 1e5], [1e-3, 1e7]];
const CORNER_WHY: &str = "controllers act between some hertz and half their sample rate";

const CHANNEL: &[Key] = keys! {
    number "stiffness_n_per_m" "N/m" [[1e3, 1e9], [0.0, 1e11]] "magnets hold with 10⁴ to 10⁸ N/m";
    number "gain_a_per_m" "A/m" [[1e2, 1e7], [0.0, 1e9]] "a micrometre asks for a milliampere to an ampere";
    number "integral_a_per_m_s" "A/(m s)" [[1e1, 1e9], [0.0, 1e12]] "the integral acts within seconds";
    number "damping_a_s_per_m" "A s/m" [[1e-2, 1e5], [0.0, 1e8]] "derivative times are a tenth of a millisecond up";
    number "derivative_rolloff_hz" "Hz" CORNER CORNER_WHY;
    number "rolloff_hz" "Hz" CORNER CORNER_WHY;
};

const LEAD: &[Key] = &[number("zero_hz", "Hz", CORNER, CORNER_WHY), number("pole_hz", "Hz", CORNER, CORNER_WHY)];

const NOTCH: &[Key] = keys! {
    number "frequency_hz" "Hz" CORNER CORNER_WHY;
    number "depth" "" [[0.05, 1.0], [0.0, 1.0]] "0.9 leaves a tenth of the gain";
    number "width" "" [[1e-3, 2.0], [0.0, 10.0]] "bandwidth over frequency";
};
