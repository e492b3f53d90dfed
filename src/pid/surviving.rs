//! A law that keeps a rotor stable from rest to beyond its top speed, where gyroscopics decide: per bearing a lead with
//! a roll-off, C = kp (1 + T_d s/(1 + s/w_d)) / (s²/w² + 1.4 s/w + 1), the same in x and y, u = −C y.
//!
//! Nutation and precession ask for phase lead at frequencies far apart, which a law tuned at rest does not give. Starts
//! are drawn from the rigid rotor on its negative stiffness; the best of them are improved by a simplex (Nelder and
//! Mead) on the largest growth rate of the sampled loop, first over a few speeds, then over more. The search sees the
//! modes of the design and some above; what it finds is judged on the full model.

use super::parameters::LOWPASS_DAMPING;
use super::rigid_bearing::{RigidBearing, rigid_bearings};
use crate::augment::plane::isotropic;
use crate::controller::in_step;
use crate::controller::verification_error::VerificationError;
use crate::linalg::simplex_search::descend_simplex;
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::{append, both_planes};
use crate::lti::sample::tustin;
use crate::lti::{Continuous, Discrete, StateSpace};
use crate::rotor::PlanarModes;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Starts drawn, and how many of them are improved on few speeds, then on more.
const STARTS: usize = 320;
const TRIED: usize = 10;
const KEPT: usize = 3;
/// Speeds from rest to the last one: those on which starts are judged and tried, and those of the end.
const FEW_SPEEDS: usize = 5;
const SPEEDS: usize = 13;
/// Speeds of the full model at which what is found is judged: between those of the search as well.
const JUDGED_SPEEDS: usize = 25;
/// Steps of a simplex on few speeds and on more.
const TRIED_STEPS: usize = 250;
const KEPT_STEPS: usize = 400;
/// Modes above those of the design that the search sees.
const FURTHER_MODES: usize = 3;
/// Numbers of a bearing: gain, derivative time, its corner, corner of the roll-off.
const PER_BEARING: usize = 4;
/// Edge of the first simplex, in logarithms: a third of an octave and more.
const EDGE: f64 = 0.25;
const SEED: u64 = 1;
/// Growth of a loop that cannot be computed, 1/s.
const HOPELESS: f64 = 1e12;

/// A loop at the speed where it decays least or grows most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstGrowth {
    /// Largest growth rate, 1/s; negative: stable.
    pub rate_per_s: f64,
    /// Frequency of the mode that grows, Hz.
    pub frequency_hz: f64,
    /// Speed, rpm.
    pub speed_rpm: f64,
}

/// What the search ends with.
#[derive(Clone, Debug)]
pub struct SurvivingLaw {
    /// The controller of one plane, m to A.
    pub plane: StateSpace<Discrete>,
    /// Where its loop is worst, on the full model.
    pub worst: WorstGrowth,
    /// Laws judged.
    pub evaluations: usize,
    /// Last speed, rpm.
    pub to_rpm: f64,
}

impl SurvivingLaw {
    /// What was searched and how far it came, as a sentence.
    pub(crate) fn words(&self) -> String {
        let WorstGrowth { rate_per_s, frequency_hz, speed_rpm } = self.worst;
        let came = if rate_per_s < 0.0 { "decays" } else { "grows" };
        format!(
            "Of {} leads with a roll-off, the same in x and y, searched from rest to {:.0} rpm, the best {came} with \
             {:.3} 1/s at {speed_rpm:.0} rpm ({frequency_hz:.1} Hz); that is a search, no proof that none exists.",
            self.evaluations,
            self.to_rpm,
            rate_per_s.abs()
        )
    }
}

/// The law whose loop decays fastest where it decays least, from rest to `to_rpm`.
///
/// # Errors
/// [`VerificationError`] when the machine cannot be modelled. A law whose loop is unstable is no error:
/// [`SurvivingLaw::worst`] says how far it came.
pub fn find_surviving_law(machine: &Machine, to_rpm: f64) -> Result<SurvivingLaw, VerificationError> {
    let modes = PlanarModes::new(&machine.rotor()?).map_err(SpindleError::Shaft)?;
    let nyquist = PI * machine.spindle.electronics.sample_rate_hz;
    let bending = modes.flexible_hz().first().map_or(0.1 * nyquist, |hz| TAU * hz);
    let rule = LeadRule { bearings: rigid_bearings(machine, bending)?, nyquist_rad_s: nyquist };
    let flexible = machine.spindle.flexible_modes + FURTHER_MODES;
    let detail = ModelDetail::Modes { flexible, static_residual: false };
    let count = AtomicUsize::new(0);
    let few = SampledSpeeds::of(machine, detail, to_rpm, FEW_SPEEDS)?;
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let drawn: Vec<Vec<f64>> = (0..STARTS).map(|_| rule.draw(&mut random)).collect();
    let mut starts: Vec<(f64, Vec<f64>)> = drawn.into_par_iter().map(|x| (few.growth(&rule, &x), x)).collect();
    count.fetch_add(STARTS, Ordering::Relaxed);
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(TRIED);
    let improve =
        |speeds: &SampledSpeeds, starts, steps| improve(Growth { speeds, rule: &rule, count: &count }, starts, steps);
    let mut tried = improve(&few, starts, TRIED_STEPS);
    tried.truncate(KEPT);
    let all = SampledSpeeds::of(machine, detail, to_rpm, SPEEDS)?;
    let ends = improve(&all, tried, KEPT_STEPS);
    let judged = SampledSpeeds::of(machine, ModelDetail::Full, to_rpm, JUDGED_SPEEDS)?;
    let judge = |x: &Vec<f64>| {
        let plane = rule.plane(x).map_err(in_step("law that survives"))?;
        let worst = judged.worst(&plane).map_err(in_step("law that survives"))?;
        Ok::<_, VerificationError>((plane, worst))
    };
    let laws: Vec<_> = ends.par_iter().map(|(_, x)| judge(x)).collect::<Result<_, _>>()?;
    let best = laws.into_iter().min_by(|a, b| a.1.rate_per_s.total_cmp(&b.1.rate_per_s));
    let none = || SpindleError::Numeric(NumericError::NotFinite { what: "starts of a law that survives" });
    let (plane, worst) = best.ok_or_else(none)?;
    Ok(SurvivingLaw { plane, worst, evaluations: count.load(Ordering::Relaxed), to_rpm })
}

/// Improves each start by a simplex; the best first.
fn improve(growth: Growth<'_>, starts: Vec<(f64, Vec<f64>)>, steps: usize) -> Vec<(f64, Vec<f64>)> {
    let one = |(before, x): (f64, Vec<f64>)| {
        let vertex = |k: usize| {
            let mut moved = x.clone();
            moved[k] += EDGE;
            moved
        };
        let simplex = std::iter::once(x.clone()).chain((0..x.len()).map(vertex)).collect();
        let end = descend_simplex(simplex, steps, |x| growth.of(x)).filter(|end| end.value < before);
        end.map_or((before, x), |end| (end.value, end.point))
    };
    let mut ends: Vec<(f64, Vec<f64>)> = starts.into_par_iter().map(one).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    ends
}

/// Largest growth rate as an objective, counted.
#[derive(Clone, Copy)]
struct Growth<'a> {
    speeds: &'a SampledSpeeds,
    rule: &'a LeadRule,
    count: &'a AtomicUsize,
}

impl Growth<'_> {
    fn of(&self, x: &[f64]) -> f64 {
        self.count.fetch_add(1, Ordering::Relaxed);
        self.speeds.growth(self.rule, x)
    }
}

/// The plant at several speeds, sampled.
struct SampledSpeeds(Vec<(f64, Plant, StateSpace<Discrete>)>);

impl SampledSpeeds {
    /// So many speeds from rest to the last, evenly spaced.
    fn of(machine: &Machine, detail: ModelDetail, to_rpm: f64, count: usize) -> Result<Self, VerificationError> {
        let machine = isotropic(machine);
        let at = |k: usize| {
            let speed_rpm = to_rpm * k as f64 / (count - 1) as f64;
            let plant = Plant::new(&machine, speed_rpm * TAU / 60.0, detail)?;
            let sampled = plant.sample_plant()?;
            Ok((speed_rpm, plant, sampled))
        };
        Ok(Self((0..count).into_par_iter().map(at).collect::<Result<_, SpindleError>>()?))
    }

    /// Where the loop with a controller of one plane is worst.
    fn worst(&self, plane: &StateSpace<Discrete>) -> Result<WorstGrowth, NumericError> {
        let law = both_planes(plane);
        let mut worst = WorstGrowth { rate_per_s: f64::NEG_INFINITY, frequency_hz: 0.0, speed_rpm: 0.0 };
        for (speed_rpm, plant, sampled) in &self.0 {
            let time = &sampled.time;
            let poles = time.continuous_poles(plant.loop_poles(sampled, &law)?);
            if let Some(pole) = poles.iter().max_by(|a, b| a.re.total_cmp(&b.re))
                && pole.re > worst.rate_per_s
            {
                let frequency_hz = pole.im.abs() / TAU;
                worst = WorstGrowth { rate_per_s: pole.re, frequency_hz, speed_rpm: *speed_rpm };
            }
        }
        Ok(worst)
    }

    /// Largest growth rate with parameters, 1/s.
    fn growth(&self, rule: &LeadRule, x: &[f64]) -> f64 {
        let found = rule.plane(x).and_then(|plane| self.worst(&plane));
        found.ok().map(|worst| worst.rate_per_s).filter(|rate| rate.is_finite()).unwrap_or(HOPELESS)
    }
}

/// What laws are made from.
struct LeadRule {
    bearings: [RigidBearing; 2],
    nyquist_rad_s: f64,
}

impl LeadRule {
    /// A start: of each bearing the stiffness over the negative one, the crossover of the rigid rotor with it, and lead
    /// and corners around that, in logarithms.
    fn draw(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let mut spread = |from: f64, to: f64| from * (to / from).powf(random.random::<f64>());
        let mut own = |bearing: &RigidBearing| {
            let stiffness = spread(1.2, 8.0);
            let crossover = bearing.omega_rad_s * (stiffness - 1.0).sqrt() * spread(0.6, 2.0);
            let corner = |over: f64| (crossover * over).min(0.8 * self.nyquist_rad_s);
            let (lead, roll_off) = (spread(2.0, 60.0), spread(3.0, 60.0));
            [stiffness, spread(0.3, 3.0) / crossover, corner(lead), corner(roll_off)].map(f64::ln)
        };
        let [front, rear] = &self.bearings;
        [own(front), own(rear)].concat()
    }

    /// The sampled controller of one plane.
    fn plane(&self, x: &[f64]) -> Result<StateSpace<Discrete>, NumericError> {
        let own = |number: usize| self.axis(number, &x[PER_BEARING * number..PER_BEARING * (number + 1)]);
        tustin(&append(&own(0)?, &own(1)?), PI / self.nyquist_rad_s)
    }

    /// The controller of a bearing: state of the lead, then the roll-off in its frequency.
    fn axis(&self, number: usize, logs: &[f64]) -> Result<StateSpace<Continuous>, NumericError> {
        let bearing = &self.bearings[number];
        let [stiffness, derivative_s, corner, roll_off] = std::array::from_fn(|k| logs[k].exp());
        let unit = bearing.mass_kg * bearing.omega_rad_s.powi(2) / bearing.ki_n_per_a;
        let gain_a_per_m = -stiffness * unit;
        let direct = 1.0 + derivative_s * corner;
        let a = [
            [-corner, 0.0, 0.0],
            [0.0, 0.0, roll_off],
            [-roll_off * derivative_s * corner, -roll_off, -2.0 * LOWPASS_DAMPING * roll_off],
        ];
        let b = [corner, 0.0, roll_off * direct];
        StateSpace::new(
            Mat::from_fn(3, 3, |i, j| a[i][j]),
            Mat::from_fn(3, 1, |i, _| b[i]),
            Mat::from_fn(1, 3, |_, j| if j == 1 { gain_a_per_m } else { 0.0 }),
            Mat::zeros(1, 1),
            Continuous,
        )
    }
}
