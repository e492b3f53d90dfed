//! Machines that differ from the drawing in one quantity: one factor at a time, to either side.

use crate::rotor::Section;
use crate::spindle::Machine;

named! {
    /// A quantity that a batch may vary, as it is named on the command line.
    pub enum Quantity {
        /// Force–current factor of both bearings.
        Ki = "ki",
        /// Negative stiffness of both bearings.
        Ks = "ks",
        /// Gain of both sensors.
        SensorGain = "sensor_gain",
        /// Delay of the electronics.
        Delay = "delay",
        /// Bandwidth of the amplifiers.
        AmplifierBandwidth = "amplifier_bandwidth",
        /// Damping ratios of the flexible modes.
        Damping = "damping",
        /// Young's moduli of every element, tool included.
        Modulus = "modulus",
    }
}

impl Quantity {
    /// The machine with this quantity times a factor.
    #[must_use]
    pub fn scale_quantity(self, machine: &Machine, factor: f64) -> Machine {
        let mut varied = machine.clone();
        let spindle = &mut varied.spindle;
        for bearing in [&mut spindle.front, &mut spindle.rear] {
            match self {
                Self::Ki => bearing.ki_n_per_a *= factor,
                Self::Ks => bearing.ks_n_per_m *= factor,
                Self::SensorGain => bearing.sensor_gain *= factor,
                _ => {}
            }
        }
        match self {
            Self::Delay => spindle.electronics.delay_s *= factor,
            Self::AmplifierBandwidth => spindle.electronics.amplifier_bandwidth_hz *= factor,
            Self::Damping => spindle.damping_ratio.iter_mut().for_each(|z| *z *= factor),
            Self::Modulus => {
                let stiffer = |s: &mut Section| s.modulus_scale *= factor;
                spindle.sections.iter_mut().for_each(stiffer);
                varied.tool.sections.iter_mut().for_each(stiffer);
            }
            _ => {}
        }
        varied
    }
}

/// A quantity with its relative half width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// What varies.
    pub quantity: Quantity,
    /// Half width, relative.
    pub relative: f64,
}

/// The machine as drawn, and each quantity at both ends of its range; names say what differs.
pub fn variants(machine: &Machine, variations: &[Variation]) -> Vec<(String, Machine)> {
    let tool = &machine.tool.name;
    let mut all = vec![(tool.clone(), machine.clone())];
    for v in variations {
        for (sign, word) in [(-1.0, "minus"), (1.0, "plus")] {
            let percent = 100.0 * v.relative;
            let name = format!("{tool}-{}-{word}-{percent}", v.quantity.name());
            let factor = 1.0 + sign * v.relative;
            all.push((name, v.quantity.scale_quantity(machine, factor)));
        }
    }
    all
}
