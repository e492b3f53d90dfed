//! Time response of the levitated rotor with what linear predictions leave out: the magnets' force law, coil and
//! voltage limits, sampling, computation delay, quantised sensors, clamps of the firmware, backup bearings.
//!
//! Shaft and sensors: linear, ẋ = A x + B f, without magnetic stiffness, which is part of the force law. Integrator:
//! exponential, second order (ETD2: Cox and Matthews 2002): x⁺ = Φx + Γ₀f(x) + Γ₁(f(x̂) − f(x)), x̂ = Φx + Γ₀f(x),
//! exact for the shaft, so that no numerical damping hides a lightly damped mode. The controller runs as firmware does,
//! in float32: sampled, held, its output limited, its slow states conditioned while an output is limited
//! ([`crate::controller::anti_windup`]). The command takes effect after the pure delay, rounded to a substep.

use super::time_force::{BackupBearing, Magnet};
use crate::controller::arithmetic::Float32Program;
use crate::linalg::{Mat, NumericError, exponential};
use crate::lti::delay::hold;
use crate::rotor::PlanarModes;
use crate::spindle::correction::{LawSite, PlacedLaw};
use crate::spindle::plant::AXES;
use crate::spindle::{Effective, Machine, ModelDetail, Plant, Side, SpindleError};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Force and displacement channels: tool, front and rear actuator, x and y each.
pub(crate) const LOADS: usize = 6;
/// Largest signal that still counts as a simulation, in clearances: beyond, the run is stopped as diverged.
const DIVERGED: f64 = 100.0;

/// What the spindle file leaves open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSettings {
    /// Flexible modes per plane; unless given, all below 0.8 of half the sample rate.
    pub flexible_modes: Option<usize>,
    /// Steps of the integrator per sample period.
    pub substeps: usize,
    /// Bus voltage of the amplifiers, V.
    pub bus_voltage_v: f64,
    /// Time over which the reference moves from where the rotor rests to the centre after switching on, s; 0 for at
    /// once.
    pub reference_ramp_s: f64,
    /// Smallest step of the digitised sensor signal, m; 0 for none. 16 bit over ±10 V at 20 V/mm: 15 nm.
    pub quantum_m: f64,
    /// White sensor noise of the spindle file, with this seed; `None` for none.
    pub noise_seed: Option<u64>,
}

impl Default for TimeSettings {
    fn default() -> Self {
        Self {
            flexible_modes: None,
            substeps: 20,
            bus_voltage_v: 300.0,
            reference_ramp_s: 0.0,
            quantum_m: 20.0 / 65536.0 / 20.0e3,
            noise_seed: None,
        }
    }
}

/// What acts on the rotor, and when.
pub struct Scenario<'a> {
    /// Speed, rad/s.
    pub speed_rad_s: f64,
    /// Length, s, after time zero.
    pub duration_s: f64,
    /// Time before zero in which magnets and controller are off, s.
    pub rest_s: f64,
    /// Loads (N) at tool, front and rear actuator (x, y each) at a time.
    pub load_n: &'a (dyn Fn(f64) -> [f64; LOADS] + Sync),
}

/// One sample of the response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSample {
    /// Time, s.
    pub time_s: f64,
    /// Sensor signals front_x, front_y, rear_x, rear_y before quantisation, m.
    pub sensors_m: [f64; AXES],
    /// Displacements tool, front and rear actuator (x, y each), m.
    pub displacements_m: [f64; LOADS],
    /// Control currents, A.
    pub currents_a: [f64; AXES],
    /// Coil voltages since the sample before, each where it was largest, V.
    pub voltages_v: [f64; AXES],
    /// Magnetic forces, N.
    pub forces_n: [f64; AXES],
    /// Normal and friction forces of the backup bearings, front then rear (x, y each), N.
    pub contact_n: [f64; AXES],
}

/// A response with counts of what limited it.
#[derive(Clone, Debug)]
pub struct TimeResponse {
    /// One entry per controller sample from time zero.
    pub samples: Vec<TimeSample>,
    /// Part of the substeps in which the voltage limited some current.
    pub voltage_limited: f64,
    /// Part of the samples in which some command stood at its limit.
    pub current_limited: f64,
    /// Part of the substeps with contact.
    pub in_contact: f64,
    /// Start of the first and end of the last substep with contact, s; nothing without contact.
    pub contact_s: Option<(f64, f64)>,
    /// Time of the last sample in which some command stood at its limit, s.
    pub last_limited_s: Option<f64>,
    /// True when the run was stopped because it left every reasonable range.
    pub diverged: bool,
}

/// Why a simulation could not be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TimeError {
    /// The plant could not be built.
    #[error(transparent)]
    Plant(#[from] SpindleError),
    /// The integrator could not be prepared.
    #[error("integrator: {0}")]
    Numeric(#[from] NumericError),
    /// A setting that no simulation can follow.
    #[error("{what} = {value} must be {rule}")]
    Setting {
        /// The setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The rule.
        rule: &'static str,
    },
    /// A law without a name acts at currents.
    #[error("a co-simulation unit has no place for the law that a correction puts at currents")]
    NoUnit,
}

/// Runs a scenario with a controller from rest states.
///
/// # Errors
/// [`TimeError`] for settings out of range or a plant that cannot be built.
pub fn simulate(
    machine: &Machine,
    controller: &Float32Program,
    scenario: &Scenario<'_>,
    settings: &TimeSettings,
) -> Result<TimeResponse, TimeError> {
    check(scenario, settings)?;
    let period = machine.spindle.electronics.sample_period_s();
    let step = period / settings.substeps as f64;
    let mut shaft = SampledShaft::new(machine, scenario.speed_rad_s, settings, step)?;
    let samples = |seconds: f64| (seconds / period).round() as usize;
    let (before, after) = (samples(scenario.rest_s), samples(scenario.duration_s));
    let mut controller = controller.clone();
    let mut noise = settings.noise_seed.map(ChaCha8Rng::seed_from_u64);
    // Commands waiting for their time: the newest goes in behind the pure delay.
    let mut waiting: VecDeque<(usize, [f64; AXES])> = VecDeque::new();
    let mut command = [0.0; AXES];
    let mut response = TimeResponse {
        samples: Vec::with_capacity(after),
        voltage_limited: 0.0,
        current_limited: 0.0,
        in_contact: 0.0,
        contact_s: None,
        last_limited_s: None,
        diverged: false,
    };
    let late = shaft.late_substeps(period);
    let mut tick = 0usize;
    let mut rest: Option<[f64; AXES]> = None;
    for k in 0..before + after {
        let live = k >= before;
        let time = (k as f64 - before as f64) * period;
        let sample = shaft.observe(time, live, &(scenario.load_n)(time));
        shaft.voltages = [0.0; AXES];
        if live {
            let start = *rest.get_or_insert(sample.sensors_m);
            // What is left of the way of the reference; no ramp is none from the first sample on.
            let left = (1.0 - time / settings.reference_ramp_s).max(0.0);
            let left = if left.is_finite() { left } else { 0.0 };
            let mut y = [0.0; AXES];
            for ((y, clean), start) in y.iter_mut().zip(sample.sensors_m).zip(start) {
                let deviation = noise.as_mut().map_or(0.0, normal) * shaft.noise_m;
                let signal = quantise(clean + deviation, settings.quantum_m);
                *y = (signal - left * start) as f32;
            }
            let u = controller.step(&y);
            let mut wanted = [0.0; AXES];
            for (w, value) in wanted.iter_mut().zip(&u) {
                *w = f64::from(*value);
            }
            if u.iter().any(|v| v.abs() >= controller.output_limit_a) {
                response.current_limited += 1.0;
                response.last_limited_s = Some(time);
            }
            waiting.push_back((tick + late, wanted));
            response.samples.push(sample);
        }
        for substep in 0..settings.substeps {
            while let Some((due, wanted)) = waiting.front().copied()
                && due <= tick
            {
                command = wanted;
                waiting.pop_front();
            }
            let now = time + substep as f64 * step;
            let limited = shaft.advance(&command, live, &|s| (scenario.load_n)(now + s));
            if live {
                response.voltage_limited += f64::from(u8::from(limited));
                response.in_contact += f64::from(u8::from(shaft.touching));
                if shaft.touching {
                    let first = response.contact_s.map_or(now, |(first, _)| first);
                    response.contact_s = Some((first, now + step));
                }
            }
            tick += 1;
        }
        if !shaft.is_reasonable() {
            response.diverged = true;
            break;
        }
    }
    let count = response.samples.len().max(1) as f64;
    response.current_limited /= count;
    response.voltage_limited /= count * settings.substeps as f64;
    response.in_contact /= count * settings.substeps as f64;
    Ok(response)
}

fn check(scenario: &Scenario<'_>, settings: &TimeSettings) -> Result<(), TimeError> {
    let rules = [
        ("duration_s", scenario.duration_s, 0.0, 60.0, "between 0 and 60 s"),
        ("speed_rad_s", scenario.speed_rad_s, 0.0, 1e5, "between 0 and 1e5 rad/s"),
        ("substeps", settings.substeps as f64, 1.0, 1000.0, "between 1 and 1000"),
        ("bus_voltage", settings.bus_voltage_v, 1e-3, 1e5, "a positive voltage"),
        ("reference_ramp_s", settings.reference_ramp_s, 0.0, 60.0, "between 0 and 60 s"),
        ("quantum_m", settings.quantum_m, 0.0, 1e-3, "between 0 and 1 mm"),
    ];
    for (what, value, low, high, rule) in rules {
        if !(low..=high).contains(&value) {
            return Err(TimeError::Setting { what, value, rule });
        }
    }
    Ok(())
}

/// Part of the band up to half the sample rate whose modes take part: those above are hardly excited by the hold, and
/// the sampled loop does not tell them from their images.
const BAND: f64 = 0.8;

/// Flexible modes below [`BAND`] of half the sample rate; not fewer than the design model has.
fn modes_in_band(machine: &Machine) -> Result<usize, SpindleError> {
    let modes = PlanarModes::new(&machine.rotor()?).map_err(SpindleError::Shaft)?;
    let highest_hz = 0.5 * BAND * machine.spindle.electronics.sample_rate_hz;
    let inside = modes.flexible_hz().iter().filter(|f| **f < highest_hz).count();
    Ok(inside.max(machine.spindle.flexible_modes))
}

/// Shaft, sensors and magnets between two samples.
pub(crate) struct SampledShaft {
    /// Φ of a substep.
    pub(crate) phi: Mat<f64>,
    /// Γ₀ and Γ₁ of a substep.
    pub(crate) gamma: [Mat<f64>; 2],
    /// State to four sensor signals and six displacements.
    pub(crate) outputs: Mat<f64>,
    /// Forces to the same, by the modes that do not take part. Magnets and contact see the modes that do.
    pub(crate) direct: Mat<f64>,
    /// State to the rates of the six displacements.
    pub(crate) velocities: Mat<f64>,
    state: Mat<f64>,
    currents: [f64; AXES],
    voltages: [f64; AXES],
    /// Axis by axis.
    pub(crate) magnets: [Magnet; AXES],
    /// Share of what the current of an axis makes that acts along the other axis, bearing by bearing.
    pub(crate) coupling_ratios: [f64; 2],
    /// Both backup bearings.
    pub(crate) backup: BackupBearing,
    pub(crate) speed_rad_s: f64,
    /// Substep, s.
    pub(crate) step_s: f64,
    /// Delay from sampling to current command, half of the hold included, s.
    pub(crate) delay_s: f64,
    noise_m: f64,
    touching: bool,
    /// Laws without a name at currents, before the amplifiers.
    command_laws: Vec<CommandLaw>,
}

/// The factor 1 + X(s) of a law at the current of an axis, held over a substep.
struct CommandLaw {
    axis: usize,
    /// State to state, and command to state.
    step: (Mat<f64>, Mat<f64>),
    read: Mat<f64>,
    direct: f64,
    state: Mat<f64>,
}

impl CommandLaw {
    fn of_machine(effective: &Effective, step_s: f64) -> Result<Vec<Self>, NumericError> {
        let one = |own: &PlacedLaw| {
            let LawSite::Current(axis) = own.site else { return Ok(None) };
            let law = own.law.state_space()?;
            let state = Mat::zeros(law.order(), 1);
            let step = hold(&law.a, &law.b, step_s)?;
            Ok(Some(Self { axis, step, read: law.c, direct: 1.0 + law.d[(0, 0)], state }))
        };
        effective.laws.iter().filter_map(|own| one(own).transpose()).collect()
    }

    /// The command that the amplifier gets; the law moves on by a substep.
    fn advance(&mut self, command: f64) -> f64 {
        let seen = (0..self.state.nrows()).map(|k| self.read[(0, k)] * self.state[(k, 0)]).sum::<f64>();
        let seen = seen + self.direct * command;
        let forced = Mat::from_fn(self.state.nrows(), 1, |i, _| self.step.1[(i, 0)] * command);
        self.state = &self.step.0 * &self.state + forced;
        seen
    }
}

impl SampledShaft {
    /// Substeps from a sample to its current command: the delay without the half of the hold.
    pub(crate) fn late_substeps(&self, period_s: f64) -> usize {
        ((self.delay_s - 0.5 * period_s).max(0.0) / self.step_s).round() as usize
    }

    /// The shaft of a machine at a speed, with substeps of `step_s`.
    pub(crate) fn new(
        machine: &Machine,
        speed_rad_s: f64,
        settings: &TimeSettings,
        step_s: f64,
    ) -> Result<Self, TimeError> {
        let effective = machine.effective();
        let contact = machine.spindle.backup_contact()?;
        // The force law brings the negative stiffness; the shaft here gets none (a file may not say zero).
        let mut free = machine.clone();
        free.spindle.front.ks_n_per_m = f64::MIN_POSITIVE;
        free.spindle.rear.ks_n_per_m = f64::MIN_POSITIVE;
        let flexible = match settings.flexible_modes {
            Some(count) => count,
            None => modes_in_band(machine)?,
        };
        let detail = ModelDetail::Modes { flexible, static_residual: true };
        let plant = Plant::new(&free, speed_rad_s, detail)?;
        let loads: Vec<usize> = (AXES..AXES + LOADS).collect();
        let all: Vec<usize> = (0..AXES + LOADS).collect();
        let system = plant.state_space(0)?.select(&all, &loads);
        let n = system.order();
        // e^{[[A, B, 0], [0, 0, I/h], [0, 0, 0]]h}: Φ, Γ₀ = ∫e^{As}B, Γ₁ = ∫e^{As}B(1 − s/h).
        let joint = Mat::from_fn(n + 2 * LOADS, n + 2 * LOADS, |i, j| {
            if i < n && j < n {
                system.a[(i, j)] * step_s
            } else if i < n && j < n + LOADS {
                system.b[(i, j - n)] * step_s
            } else if i >= n && i < n + LOADS && j == i + LOADS {
                1.0
            } else {
                0.0
            }
        });
        let e = exponential(&joint)?;
        let part = |column: usize, width: usize| e.submatrix(0, column, n, width).to_owned();
        let displacements = system.c.submatrix(AXES, 0, LOADS, n).to_owned();
        let magnet = |k: usize| {
            let (side, own) = ([Side::Front, Side::Rear][k / 2], &effective.bearings[k / 2]);
            Magnet::new(machine.spindle.bearing(side), own, k % 2, settings.bus_voltage_v)
        };
        Ok(Self {
            phi: part(0, n),
            gamma: [part(n, LOADS), part(n + LOADS, LOADS)],
            velocities: &displacements * &system.a,
            outputs: system.c,
            direct: system.d,
            state: Mat::zeros(n, 1),
            currents: [0.0; AXES],
            voltages: [0.0; AXES],
            magnets: std::array::from_fn(magnet),
            coupling_ratios: effective.bearings.each_ref().map(|b| b.coupling_ratio),
            backup: BackupBearing {
                clearance_m: machine.spindle.backup_clearance_m,
                stiffness_n_per_m: contact.stiffness_n_per_m,
                damping_n_s_per_m: contact.damping_n_s_per_m,
                friction: contact.friction,
                radius_m: contact.radius_m,
            },
            speed_rad_s,
            step_s,
            delay_s: effective.delay_s,
            noise_m: machine.spindle.electronics.sensor_noise_m,
            touching: false,
            command_laws: CommandLaw::of_machine(&effective, step_s)?,
        })
    }

    /// Whether laws without a name act at currents.
    pub(crate) fn has_command_laws(&self) -> bool {
        !self.command_laws.is_empty()
    }

    /// Magnetic and contact forces at a state: (front_x, front_y, rear_x, rear_y) each.
    fn forces(&self, state: &Mat<f64>, live: bool) -> ([f64; AXES], [f64; AXES]) {
        let (x, v) = (&self.outputs * state, &self.velocities * state);
        let (mut magnetic, mut contact) = ([0.0; AXES], [0.0; AXES]);
        for bearing in 0..2 {
            let first = 2 * bearing;
            // Displacements at the actuators stand behind the four sensors and the tool; velocities behind the tool.
            let at = [x[(AXES + 2 + first, 0)], x[(AXES + 3 + first, 0)]];
            let moving = [v[(2 + first, 0)], v[(3 + first, 0)]];
            if live {
                let axes = [0, 1].map(|axis| (&self.magnets[first + axis], self.currents[first + axis], at[axis]));
                let across = axes.map(|(magnet, current, x)| magnet.current_force_n(current, x));
                for (axis, (magnet, current, x)) in axes.into_iter().enumerate() {
                    magnetic[first + axis] =
                        magnet.force_n(current, x) + self.coupling_ratios[bearing] * across[1 - axis];
                }
            }
            let touch = self.backup.force_n(at, moving, self.speed_rad_s);
            contact[first] = touch[0];
            contact[first + 1] = touch[1];
        }
        (magnetic, contact)
    }

    /// All forces on the shaft as a column: loads, and bearings on top of them.
    fn total(&self, state: &Mat<f64>, live: bool, load: &[f64; LOADS]) -> (Mat<f64>, bool) {
        let (magnetic, contact) = self.forces(state, live);
        let column =
            Mat::from_fn(LOADS, 1, |i, _| load[i] + if i >= 2 { magnetic[i - 2] + contact[i - 2] } else { 0.0 });
        (column, contact.iter().any(|f| *f != 0.0))
    }

    /// One substep; `load` gives the loads at a time from its start. True when the voltage limited a current.
    fn advance(&mut self, command: &[f64; AXES], live: bool, load: &dyn Fn(f64) -> [f64; LOADS]) -> bool {
        let (start, touching) = self.total(&self.state, live, &load(0.0));
        let mut limited = false;
        if live {
            let mut command = *command;
            for law in &mut self.command_laws {
                command[law.axis] = law.advance(command[law.axis]);
            }
            for (k, current) in self.currents.iter_mut().enumerate() {
                let magnet = &self.magnets[k];
                let (next, held) = magnet.advance(*current, command[k], self.step_s);
                let voltage = magnet.voltage_v(next - *current, self.step_s);
                if voltage.abs() > self.voltages[k].abs() {
                    self.voltages[k] = voltage;
                }
                *current = next;
                limited |= held;
            }
        }
        let predicted = &self.phi * &self.state + &self.gamma[0] * &start;
        let (end, _) = self.total(&predicted, live, &load(self.step_s));
        self.state = predicted + &self.gamma[1] * (end - start);
        self.touching = touching;
        limited
    }

    fn observe(&self, time_s: f64, live: bool, load: &[f64; LOADS]) -> TimeSample {
        let (forces_n, contact_n) = self.forces(&self.state, live);
        let (total, _) = self.total(&self.state, live, load);
        let x = &self.outputs * &self.state + &self.direct * &total;
        TimeSample {
            time_s,
            sensors_m: std::array::from_fn(|k| x[(k, 0)]),
            displacements_m: std::array::from_fn(|k| x[(AXES + k, 0)]),
            currents_a: self.currents,
            voltages_v: self.voltages,
            forces_n,
            contact_n,
        }
    }

    fn is_reasonable(&self) -> bool {
        let x = &self.outputs * &self.state;
        (0..x.nrows()).all(|k| x[(k, 0)].abs() < DIVERGED * self.backup.clearance_m)
    }
}

fn quantise(value: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (value / quantum).round() * quantum } else { value }
}

/// Standard normal deviate (Box and Muller).
fn normal(random: &mut ChaCha8Rng) -> f64 {
    let u: f64 = 1.0 - random.random::<f64>();
    let v: f64 = random.random();
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}
