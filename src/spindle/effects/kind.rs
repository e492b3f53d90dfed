//! The kinds of effects.

/// The catalogue, in the order of [`super::table::TABLE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum EffectKind {
    /// Delay added to the loop.
    LoopDelay,
    /// First-order amplifier bandwidth that replaces the nominal one.
    AmplifierBandwidth,
    /// Amplifier of second order that replaces the nominal one.
    AmplifierSecondOrder,
    /// ki → ki/(1 + √(jω/ω_e)).
    EddyCurrents,
    /// ki → ki tanh(√(jω/ω_l))/√(jω/ω_l).
    LaminatedCore,
    /// Second-order low-pass in the sensor, ζ = 0.707.
    SensorLowpass,
    /// Axial shift of the sensor plane, + to the rear.
    SensorOffset,
    /// Axial shift of the actuator plane, + to the rear.
    ActuatorOffset,
    /// Factor on ks.
    NegativeStiffness,
    /// Factor on ki.
    ForceConstant,
    /// Factor on the sensor gain.
    SensorGain,
    /// f_x += ε ki i_y and f_y += ε ki i_x.
    BearingCoupling,
    /// Sensor axes turned by an angle: x' = x cos θ + y sin θ, y' = −x sin θ + y cos θ.
    AxisMisalignment,
    /// Share of one sensor signal in another.
    SensorCrosstalk,
    /// Rate of a coil current in a sensor signal.
    CurrentPickup,
    /// Factor on the gyroscopic matrix; replaces `gyroscopics: false`.
    Gyroscopic,
    /// Rotating stiffness-proportional damping: βK(ṙ − jΩr).
    InternalDamping,
    /// Circulatory force at a position, f = jq r: q > 0 drives forward whirl.
    CrossCoupling,
    /// Factor on the damping ratio of one flexible mode.
    ModalDamping,
    /// Springs between tool and nose face.
    ToolJoint,
    /// Mass at the tip of the tool.
    ToolMass,
    /// Mass at a position.
    AddedMass,
    /// Rigid disc at a position.
    AddedDisc,
    /// Stator mass on its foundation, in series with both bearings; sensors ride on it.
    HousingMode,
    /// Factor on the modulus of a region.
    RegionStiffness,
    /// Spring to ground at a position; negative is a pull.
    AddedStiffness,
    /// Damper to ground at a position.
    AddedDamper,
    /// Moment against the slope of the shaft at a position; negative for the magnetic tilting of a thrust disc.
    TiltingStiffness,
}
