//! Faults of a record: what is wrong with the data, not with the machine. Names and fields are those of the file
//! format (`record_faults`); `factor` says data = true × factor.

use super::super::frf::AXIS_NAMES;

/// Which of the recorded quantities a fault concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Commanded currents, A.
    Current,
    /// Sensor signals, m.
    Displacement,
    /// Compliance of a hammer test, m/N.
    Compliance,
}

impl Signal {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Current => "u",
            Self::Displacement => "y",
            Self::Compliance => "h",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Current => "current",
            Self::Displacement => "sensor signal",
            Self::Compliance => "compliance",
        }
    }
}

/// What a hammer record holds in place of compliance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HammerQuantity {
    /// Velocity per force.
    Mobility,
    /// Acceleration per force.
    Accelerance,
}

impl HammerQuantity {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mobility => "mobility",
            Self::Accelerance => "accelerance",
        }
    }

    /// How many times the compliance is multiplied by jω.
    pub fn order(self) -> i32 {
        match self {
            Self::Mobility => 1,
            Self::Accelerance => 2,
        }
    }
}

/// One mistake in a record. Channels count from 0 in the order front_x, front_y, rear_x, rear_y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordFault {
    /// Two channels of one signal are exchanged.
    ChannelsSwapped {
        /// First channel.
        a: usize,
        /// Second channel.
        b: usize,
        /// Currents or sensor signals.
        signal: Signal,
    },
    /// Front and rear are exchanged in x and y.
    PlanesSwapped {
        /// Currents or sensor signals.
        signal: Signal,
    },
    /// A reversed sign.
    Sign {
        /// The channel; `None` for all of them.
        channel: Option<usize>,
        /// Currents, sensor signals or compliance.
        signal: Signal,
    },
    /// Another unit: data = true × 10^`decades`.
    Unit {
        /// Currents, sensor signals or compliance.
        signal: Signal,
        /// Exponent of ten.
        decades: i32,
        /// The channel; `None` for all of them.
        channel: Option<usize>,
    },
    /// Written for e^{−jωt}.
    Conjugate,
    /// Frequencies of the record = true frequencies × factor.
    Clock {
        /// The factor.
        factor: f64,
    },
    /// A hammer record that is not compliance.
    Quantity(HammerQuantity),
    /// The rotor turned at another speed than the record says.
    SpeedLabel {
        /// The speed that the data show, rpm.
        speed_rpm: f64,
    },
    /// Another tool was in the spindle.
    Tool,
    /// Another controller levitated the rotor.
    Controller,
    /// Hammer or probe with another calibration: compliance of the record = true compliance × factor.
    HammerCalibration {
        /// The factor.
        factor: f64,
    },
    /// The response of a hammer test comes late against the force.
    HammerDelay {
        /// Delay, s.
        delay_s: f64,
    },
    /// A mass, that of an accelerometer, hung at the tool in a hammer test.
    HammerMass {
        /// Mass, kg.
        mass_kg: f64,
    },
    /// The signals changed steadily from the first line to the last.
    Drift {
        /// Currents or sensor signals.
        signal: Signal,
        /// Relative change over the record.
        relative_change: f64,
    },
    /// The largest signals of the record were cut off at a limit.
    Clipping {
        /// The limit, in the unit of the signal.
        limit: f64,
        /// Currents or sensor signals.
        signal: Signal,
    },
    /// Lines above half the sample rate of the logger are folded: at f the record has what belongs to sample rate − f.
    Alias {
        /// Sample rate, Hz.
        sample_rate_hz: f64,
    },
    /// The record alone contradicts all others.
    Disagrees,
}

impl RecordFault {
    /// The name in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::ChannelsSwapped { .. } => "channels_swapped",
            Self::PlanesSwapped { .. } => "planes_swapped",
            Self::Sign { .. } => "sign",
            // Mobility and accelerance are other units of the response too: m/(N s) and m/(N s²) in place of m/N.
            Self::Unit { .. } | Self::Quantity(_) => "unit",
            Self::Conjugate => "conjugate",
            Self::Clock { .. } => "clock",
            Self::SpeedLabel { .. } => "speed_label",
            Self::Tool => "tool",
            Self::Controller => "controller",
            Self::HammerCalibration { .. } => "hammer_calibration",
            Self::HammerDelay { .. } => "hammer_delay",
            Self::HammerMass { .. } => "hammer_mass",
            Self::Drift { .. } => "drift",
            Self::Clipping { .. } => "clipping",
            Self::Alias { .. } => "alias",
            Self::Disagrees => "disagrees",
        }
    }

    /// What is wrong, as a clause.
    pub(crate) fn words(&self) -> String {
        match *self {
            Self::ChannelsSwapped { a, b, signal } => {
                format!("the {}s of {} and {} are swapped", signal.words(), AXIS_NAMES[a], AXIS_NAMES[b])
            }
            Self::PlanesSwapped { signal } => {
                format!("the {}s of the front and the rear plane are swapped", signal.words())
            }
            Self::Sign { channel, signal } => match (channel, signal) {
                (Some(k), _) => format!("the sign of the {} of {} is reversed", signal.words(), AXIS_NAMES[k]),
                (None, Signal::Compliance) => "the sign of the compliance is reversed".into(),
                (None, _) => "the sign of all sensor signals, or of all currents, is reversed".into(),
            },
            Self::Unit { signal, decades, channel } => {
                let what = match (channel, signal) {
                    (Some(k), _) => format!("the {} of {}", signal.words(), AXIS_NAMES[k]),
                    (None, Signal::Compliance) => "the compliance".into(),
                    (None, _) => format!("all {}s", signal.words()),
                };
                let verb = if channel.is_none() && signal != Signal::Compliance { "are" } else { "is" };
                match unit_name(signal, decades) {
                    Some((found, expected)) => {
                        format!("the unit of {what} looks like {found}, not {expected}")
                    }
                    None if decades > 0 => {
                        format!("{what} {verb} too large by a factor of 1e{decades} (unit or scale)")
                    }
                    None => format!("{what} {verb} too small by a factor of 1e{} (unit or scale)", -decades),
                }
            }
            Self::Conjugate => "the spectra are conjugate: written for e^(-jωt), muspin reads e^(+jωt)".into(),
            Self::Clock { factor } => match clock_unit(factor) {
                Some(unit) => format!("the unit of the frequencies looks like {unit}, not Hz"),
                None => format!("the frequencies are true frequencies times {factor}"),
            },
            Self::Quantity(quantity) => {
                format!("the record is {}, not compliance", quantity.name())
            }
            Self::SpeedLabel { speed_rpm } => {
                format!("the rotor turned at {speed_rpm:.0} rpm, not at the speed of the record")
            }
            Self::Tool => "another tool was in the spindle".into(),
            Self::Controller => "another controller levitated the rotor".into(),
            Self::HammerCalibration { factor } => {
                format!("the compliance is {factor:.4} times the true one (calibration of hammer or probe)")
            }
            Self::HammerDelay { delay_s } if delay_s < 0.0 => {
                format!("the force comes {:.2} µs after the response", -1e6 * delay_s)
            }
            Self::HammerDelay { delay_s } => format!("the response comes {:.2} µs after the force", 1e6 * delay_s),
            Self::HammerMass { mass_kg } => format!("{:.2} g more hung at the tool than in the sweeps", 1e3 * mass_kg),
            Self::Drift { signal, relative_change } => format!(
                "all {}s changed by {:.2} % from the first line to the last",
                signal.words(),
                100.0 * relative_change
            ),
            Self::Clipping { limit, signal } => format!(
                "the {}s are cut off at {limit:.4e} {}",
                signal.words(),
                if signal == Signal::Current { "A" } else { "m" }
            ),
            Self::Alias { sample_rate_hz } => format!(
                "the lines above {:.1} Hz are folded at half a sample rate of {sample_rate_hz:.1} Hz",
                0.5 * sample_rate_hz
            ),
            Self::Disagrees => "this record alone contradicts all others, and no known mistake explains it".into(),
        }
    }

    /// What to do about it, as an imperative clause.
    pub(crate) fn remedy(&self) -> String {
        let columns = |signal: Signal, channel: Option<usize>| match (signal, channel) {
            (Signal::Compliance, _) => "h_re and h_im".to_owned(),
            (_, Some(k)) => format!("{0}{1}_re and {0}{1}_im", signal.name(), k + 1),
            (_, None) => format!("{0}1_re to {0}4_im", signal.name()),
        };
        match *self {
            Self::ChannelsSwapped { a, b, signal } => {
                format!("exchange the columns {0}{1} and {0}{2}, or the cables", signal.name(), a + 1, b + 1)
            }
            Self::PlanesSwapped { signal } => {
                format!("exchange the columns {0}1 with {0}3 and {0}2 with {0}4, or the cables", signal.name())
            }
            Self::Sign { channel, signal } => {
                format!("change the sign of the columns {}", columns(signal, channel))
            }
            Self::Unit { signal, decades, channel } => {
                format!("multiply the columns {} by 1e{}", columns(signal, channel), -decades)
            }
            Self::Conjugate => "change the sign of all imaginary parts".into(),
            Self::Clock { factor } => match clock_unit(factor) {
                Some("kHz") => "multiply the column frequency_hz by 1000".into(),
                Some("rad/s") => "divide the column frequency_hz by 2π".into(),
                _ => format!("divide the column frequency_hz by {factor}"),
            },
            Self::Quantity(HammerQuantity::Mobility) => {
                "divide the response by jω, or give it as a universal file that says mobility".into()
            }
            Self::Quantity(HammerQuantity::Accelerance) => {
                "divide the response by -ω², or give it as a universal file that says accelerance".into()
            }
            Self::SpeedLabel { speed_rpm } => format!("write speed_rpm: {speed_rpm:.0}"),
            Self::Tool => "name the tool that was in the spindle".into(),
            Self::Controller => "name the controller that levitated the rotor".into(),
            Self::HammerCalibration { factor } => {
                format!("divide the columns h_re and h_im by {factor:.4}, and calibrate hammer and probe")
            }
            Self::HammerDelay { .. } => {
                "compare the phases of both channels of the analyser, with the filter of the charge amplifier".into()
            }
            Self::HammerMass { .. } => {
                "weigh the accelerometer with its magnet, take a lighter one or a probe without contact".into()
            }
            Self::Drift { .. } => "let the electronics warm up, and repeat the sweep in the opposite direction".into(),
            Self::Clipping { .. } => {
                "leave out the lines that reach the limit, and repeat the record with less excitation".into()
            }
            Self::Alias { .. } => {
                "sample faster than twice the highest line, with a filter before the converter".into()
            }
            Self::Disagrees => "repeat the record".into(),
        }
    }
}

/// The unit that a factor points at, and the one of the format.
fn unit_name(signal: Signal, decades: i32) -> Option<(&'static str, &'static str)> {
    match (signal, decades) {
        (Signal::Displacement, 2) => Some(("cm", "m")),
        (Signal::Displacement, 3) => Some(("mm", "m")),
        (Signal::Displacement, 6) => Some(("µm", "m")),
        (Signal::Displacement, 9) => Some(("nm", "m")),
        (Signal::Current, 3) => Some(("mA", "A")),
        (Signal::Current, 6) => Some(("µA", "A")),
        (Signal::Compliance, 3) => Some(("mm/N", "m/N")),
        (Signal::Compliance, 6) => Some(("µm/N", "m/N")),
        (Signal::Compliance, 9) => Some(("nm/N", "m/N")),
        _ => None,
    }
}

/// The unit in which frequencies were written when they are true ones times `factor`.
fn clock_unit(factor: f64) -> Option<&'static str> {
    let near = |value: f64| (factor / value - 1.0).abs() < 1e-9;
    if near(1e-3) {
        Some("kHz")
    } else if near(std::f64::consts::TAU) {
        Some("rad/s")
    } else if near(60.0) {
        Some("1/min")
    } else {
        None
    }
}
