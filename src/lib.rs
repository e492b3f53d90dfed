//! `muspin`: from spindle drawing and measured sweeps to a robust magnetic-bearing controller that firmware can load.
//!
//! The modules are the pipeline, in order; each may use those above it, never the reverse:
//!
//! | module | what it is |
//! |---|---|
//! | [`linalg`], [`lti`] | dense algebra; state space, norms, sampling, reduction |
//! | [`rotor`] | Timoshenko beam elements, modes, whirl |
//! | [`spindle`] | bearings, electronics, effects, the plant and its response with derivatives |
//! | [`identify`] | G = Y U⁻¹ from closed-loop sweeps, its resonances and antiresonances |
//! | [`update`] | moduli moved until the model has them |
//! | [`augment`] | weights and uncertainty: the generalized plant |
//! | [`robust`] | H∞ synthesis, μ bounds, D-K iteration |
//! | [`controller`] | reduction, discretisation, arithmetic, proof over speed, PID |
//! | [`predict`] | stiffness at the tool, sensitivity, worst cases, time responses |
//! | [`diagnose`] | which effect is missing from the model |
//! | [`pipeline`] | the steps of a run, without files |
//! | [`input`], [`report`], [`workflow`], [`cli`] | files, pages and tables, what commands and Python share, commands |
//!
//! One sign convention: u = K y, closed by linear fractional transformations:
//!
//! ```text
//!            ┌─────┐
//!        ┌───┤  Δ  │◄──┐
//!        │   └─────┘   │
//!        │   ┌─────┐   │
//!        └──►│     ├───┘
//!     w ────►│  P  ├────► z
//!        ┌──►│     ├───┐
//!        │   └─────┘   │
//!        │ u ┌─────┐ y │
//!        └───┤  K  │◄──┘
//!            └─────┘
//! ```
//!
//! # Own plant: H∞, D-K, discrete controller
//!
//! A mass on the negative stiffness of a magnet, ω² = k_s/m, which is uncertain by 20 %. States are x and ẋ/ω, in time
//! 1/ω.
//!
//! ```
//! use muspin::controller::discretise::discretise_law;
//! use muspin::prelude::*;
//!
//! // w = (uncertainty, load, sensor noise), then u;  z = (uncertainty, x, 0.1 u), then y = x + 0.01 n.
//! let omega = 200.0;
//! let a = [[0.0, omega], [omega, 0.0]];
//! let b = [[0.0, 0.0, 0.0, 0.0], [0.2 * omega, omega, 0.0, omega]];
//! let c = [[1.0, 0.0], [1.0, 0.0], [0.0, 0.0], [1.0, 0.0]];
//! let d = [[0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 0.1], [0.0, 0.0, 0.01, 0.0]];
//! let plant = GeneralizedPlant {
//!     system: StateSpace::new(
//!         Mat::from_fn(2, 2, |i, j| a[i][j]),
//!         Mat::from_fn(2, 4, |i, j| b[i][j]),
//!         Mat::from_fn(4, 2, |i, j| c[i][j]),
//!         Mat::from_fn(4, 4, |i, j| d[i][j]),
//!         Continuous,
//!     )?,
//!     controls: 1,
//!     measurements: 1,
//!     blocks: vec![
//!         Block::ComplexFull { rows: 1, cols: 1 },
//!         Block::ComplexFull { rows: 2, cols: 2 },
//!     ],
//! };
//! let single = hinf::synthesise(&plant, &hinf::HinfSettings::default())?;
//! assert!(single.closed_loop_norm <= 1.01 * single.gamma_opt);
//!
//! // μ with the structure of the blocks is below γ, which has none; both bounds are certified.
//! let found = dk::iterate(&plant, &dk::DkSettings::default(), &mut |_| {})?;
//! assert!(found.mu_lower_peak <= found.mu_peak && found.mu_peak < single.gamma);
//!
//! let continuous = Controller {
//!     name: "one mass".to_owned(),
//!     law: ControlLaw::Continuous(found.controller),
//! };
//! let sampled = discretise_law(&continuous, 1e-4, omega / 6.28)?;
//! assert!(matches!(sampled.unwrap().law, ControlLaw::Discrete(_)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Updating a model
//!
//! ```
//! use muspin::prelude::*;
//! use muspin::update::{Target, machine::gauss_newton};
//!
//! // A shaft 10 % stiffer in the motor region than its drawing, and the resonances that it would show.
//! let drawing = load_machine("reference", "paper-tool")?;
//! let region = drawing.regions()[0].clone();
//! let effect = Effect::new(EffectKind::RegionStiffness, Location::Region(region), vec![1.1])?;
//! let real = drawing.clone().with_effect(effect);
//! let modes = |machine: &Machine| -> Result<Vec<f64>, Box<dyn std::error::Error>> {
//!     Ok(Plant::design_model(machine, 0.0)?.flexible_rad_s().iter().map(|w| w / 6.283_185_307).collect())
//! };
//! let targets = Targets {
//!     resonances: modes(&real)?.into_iter().map(|f| Some(Target::read_off(f))).collect(),
//!     ..Targets::default()
//! };
//! let updated = gauss_newton(&drawing, &targets, &UpdateSettings::default())?;
//! for (found, wanted) in modes(&updated.machine)?.iter().zip(modes(&real)?) {
//!     assert!((found / wanted - 1.0).abs() < 1e-3);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Diagnosing a discrepancy
//!
//! ```
//! use muspin::diagnose::data::measurement::RecordSet;
//! use muspin::identify::SweepRecord;
//! use muspin::prelude::*;
//! use ndarray::Array4;
//!
//! // A sweep of a machine with 60 g at the tip of the tool that the model does not know: four experiments,
//! // one current each.
//! let model = load_machine("reference", "paper-tool")?;
//! let effect = Effect::new(EffectKind::ToolMass, Location::None, vec![0.06])?;
//! let plant = Plant::new(&model.clone().with_effect(effect), 0.0, ModelDetail::Full)?;
//! let frequency_hz: Vec<f64> = (0..200).map(|k| 40.0 * 80f64.powf(k as f64 / 199.0)).collect();
//! // 0.1 % of noise from a fixed pattern, different in each of three repeats.
//! let noise = |k: usize| 1e-3 * c64::new((k as f64 * 12.9898).sin(), (k as f64 * 78.233).sin());
//! let one = |same: bool| c64::new(f64::from(u8::from(same)), 0.0);
//! let current = Array4::from_shape_fn((200, 4, 3, 4), |(_, e, _, axis)| one(e == axis));
//! let response: Vec<_> = frequency_hz.iter().map(|f| plant.at(6.283_185_307 * f)).collect();
//! let signal = Array4::from_shape_fn((200, 4, 3, 4), |(k, e, p, axis)| {
//!     response[k][(axis, e)] * (1.0 + noise(k * 48 + e * 12 + p * 4 + axis))
//! });
//! let left_out = vec![];
//! let name = "sweep".to_owned();
//! let sweep = SweepRecord { name, speed_rpm: 0.0, frequency_hz, current, signal, left_out, run_out: false };
//! let found = diagnose(&model, &RecordSet { sweeps: vec![sweep], taps: vec![] }, &|_| {})?;
//! assert_eq!(found.verdict, Verdict::Named);
//! assert_eq!(found.effects[0].effect.kind, EffectKind::ToolMass);
//! assert!((found.effects[0].effect.values[0] / 0.06 - 1.0).abs() < 0.05);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![warn(missing_docs, unreachable_pub)]
// What the crate keeps to itself is called by the commands and by the report in the end.
#![cfg_attr(not(feature = "cli"), allow(dead_code))]

/// An enum whose variants are declared with their names in files and on the command line.
macro_rules! named {
    ($(#[$about:meta])* $vis:vis enum $type:ident { $($(#[$meaning:meta])* $variant:ident = $name:literal,)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $type { $(#[doc = concat!("`", $name, "`.")] $(#[$meaning])* $variant,)* }

        #[allow(dead_code)]
        impl $type {
            /// All of them, in order.
            $vis const ALL: [Self; [$($name,)*].len()] = [$(Self::$variant,)*];

            /// Its name.
            $vis fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The one of that name.
            $vis fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|one| one.name() == name)
            }
        }
    };
}

// In the order of the pipeline; blank lines keep it.

pub mod guide;

pub mod linalg;

pub mod lti;

pub mod rotor;

pub mod spindle;

pub mod identify;

pub mod update;

pub mod augment;

pub mod robust;

pub mod controller;

pub mod pid;

pub mod predict;

pub mod diagnose;

pub mod pipeline;

pub mod input;

#[cfg(feature = "cli")]
pub mod export;

#[cfg(feature = "cli")]
pub mod report;

#[cfg(feature = "cli")]
pub mod workflow;

pub mod prelude;

#[cfg(feature = "cli")]
pub mod cli;

#[cfg(feature = "python")]
pub mod python;
