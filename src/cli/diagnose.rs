//! `muspin diagnose`: find where simulation and measurement disagree, name the missing effect, show the gap shrink.
//! Writes the corrected spindle and tool, `summary.json`, the report and its pictures.

use super::design::finish;
use super::progress::Progress;
use super::{Failure, Outcome, stdout};
use crate::diagnose::experiment::{Axis, Measurement, Tap};
use crate::diagnose::judge::Rival;
use crate::diagnose::localise::PortScore;
use crate::diagnose::{DiagnoseError, Diagnosis, NamedEffect, Verdict, diagnose};
use crate::input::{load_controller, load_measurement, spindle_yaml, tool_yaml};
use crate::report::plot::diagnosis::{impedance, localisation, ranking};
use crate::report::results::ResultsFolder;
use crate::report::summary::{Summary, number, numbers};
use crate::report::tables::Table;
use crate::spindle::{Effect, EffectKind, Location};
use serde_json::{Map, Value, json};

/// Arguments of `muspin diagnose`.
#[derive(clap::Args, Debug, Default)]
pub struct Arguments {
    /// Measurement folder with measurement.yaml
    #[arg(long)]
    measurement: String,
    /// Spindle file or shipped name; default: that of the measurement
    #[arg(long)]
    spindle: Option<String>,
    /// Tool file or shipped name; default: that of the measurement
    #[arg(long)]
    tool: Option<String>,
    /// Folder for corrected files, summary and report
    #[arg(long, default_value = "results/diagnosis")]
    out: String,
}

impl From<DiagnoseError> for Failure {
    fn from(error: DiagnoseError) -> Self {
        let hint = match &error {
            DiagnoseError::NoSweep => "add a record of kind sweep to measurement.yaml",
            DiagnoseError::NoController { .. } => "add `controller:` to the hammer record",
            _ => "check spindle, tool and measurement",
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let loaded = load_measurement(&arguments.measurement)?;
    let machine = loaded.machine(arguments.spindle.as_deref(), arguments.tool.as_deref())?;
    let controllers = loaded
        .hammers
        .iter()
        .map(|h| match &h.controller {
            Some(path) => Ok(load_controller(path)?),
            None => Err(Failure::from(DiagnoseError::NoController {
                speed_rpm: h.frf.speed_rpm,
            })),
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let measurement = Measurement {
        sweeps: loaded.sweeps.iter().map(|s| s.record.clone()).collect(),
        taps: loaded
            .hammers
            .iter()
            .zip(&controllers)
            .map(|(h, k)| Tap {
                frf: h.frf.clone(),
                axis: if h.axis == 0 { Axis::X } else { Axis::Y },
                controller: k,
            })
            .collect(),
    };
    let progress = Progress::start();
    let found = diagnose(&machine, &measurement, &|what: &str| progress.stage(what))?;
    drop(progress);
    let mut summary = Summary::new();
    summary.set("diagnosis", summarised(&found));
    let mut folder = ResultsFolder::new();
    folder.add("spindle.yaml", spindle_yaml(&found.corrected.spindle))?;
    folder.add("tool.yaml", tool_yaml(&found.corrected.tool))?;
    pictures(&mut folder, &found)?;
    finish(&mut folder, &mut summary, &arguments.out)?;
    stdout::data(|out| out.write_all((summary.to_json() + "\n").as_bytes()))?;
    eprintln!("{}", sentence(&found));
    Ok(match found.verdict {
        Verdict::Unexplained => Outcome::TargetMissed,
        _ => Outcome::Done,
    })
}

fn summarised(d: &Diagnosis) -> Value {
    json!({
        "verdict": d.verdict.name(),
        "sentence": sentence(d),
        "effects": d.effects.iter().map(effect_json).collect::<Vec<_>>(),
        "tie": d.tie.iter().map(rival_json).collect::<Vec<_>>(),
        "gap_before": number(d.gap_before),
        "gap_after": number(d.gap_after),
        "gap_before_held_out": number(d.gap_before_held_out),
        "gap_after_held_out": number(d.gap_after_held_out),
        "held_out": d.held_out,
        "next_measurement": d.next_measurement,
        "worst_block": {
            "chi2_per_residual": number(d.misfit.value),
            "output": d.misfit.output,
            "input": d.misfit.input,
            "from_hz": number(d.misfit.band_hz.0),
            "to_hz": number(d.misfit.band_hz.1),
        },
        "localisation": d.localisation.ports.iter().map(port_json).collect::<Vec<_>>(),
        "ranking": d.ranking.iter().map(|(e, score)| json!({
            "effect": e.kind.name(), "where": place(&e.location), "score_above_best": number(*score),
        })).collect::<Vec<_>>(),
    })
}

fn place(location: &Location) -> Value {
    match location {
        Location::None => json!({}),
        Location::Bearing(b) => json!({"bearing": b.name()}),
        Location::Position(z) => json!({"position_m": number(*z)}),
        Location::Mode(mode) => json!({"mode": mode}),
        Location::Region(region) => json!({"region": region}),
    }
}

fn effect_json(e: &NamedEffect) -> Value {
    let keyed = |values: Vec<Value>| -> Map<String, Value> {
        let names = e.effect.kind.parameters().iter().map(|n| (*n).to_owned());
        names.zip(values).collect()
    };
    let mut deviations = keyed(e.standard_deviations.iter().map(|x| number(*x)).collect());
    if let Some(sd) = e.position_sd_m {
        deviations.insert("position_m".into(), number(sd));
    }
    json!({
        "effect": e.effect.kind.name(),
        "where": place(&e.effect.location),
        "parameters": keyed(e.effect.values.iter().map(|x| number(*x)).collect()),
        "standard_deviations": deviations,
        "intervals_90": keyed(e.intervals.iter().map(|(a, b)| numbers(&[*a, *b])).collect()),
    })
}

fn rival_json(rival: &Rival) -> Value {
    let mut value = match &rival.effects[..] {
        [one] => effect_json(one),
        several => json!({"effects": several.iter().map(effect_json).collect::<Vec<_>>()}),
    };
    if let Value::Object(map) = &mut value {
        map.insert("score_above_best".into(), number(rival.score_above_best));
    }
    value
}

fn port_json(p: &PortScore) -> Value {
    json!({
        "port": p.port,
        "chi2_before": number(p.chi2_before),
        "chi2_after": number(p.chi2_after),
        "shape": p.shape(),
    })
}

/// The verdict in one sentence.
fn sentence(d: &Diagnosis) -> String {
    let gap = format!(
        "the gap falls from {:.2} to {:.2}, on held-out data ({}) from {:.2} to {:.2}",
        d.gap_before, d.gap_after, d.held_out, d.gap_before_held_out, d.gap_after_held_out
    );
    let all = |effects: &[NamedEffect]| {
        let words: Vec<String> = effects.iter().map(|e| words(&e.effect)).collect();
        words.join(", and ")
    };
    match d.verdict {
        Verdict::Adequate => {
            format!("The model describes the measurement; only small parameters moved: {gap}.")
        }
        Verdict::Named => format!("{}: {gap}.", capital(&all(&d.effects))),
        Verdict::Tie => {
            let members: Vec<String> = d.tie.iter().map(|r| all(&r.effects)).collect();
            format!(
                "Either {}: the data cannot tell; {gap}.",
                members.join(", or ")
            )
        }
        Verdict::Unexplained => match d.localisation.ports.first() {
            Some(port) => format!(
                "Something is missing that is in no catalogue; it sits most likely at: {}, and looks like {} \
                 (reduced χ² {:.1} falls to {:.1} with a free law there).",
                port.port, port.shape(), port.chi2_before, port.chi2_after
            ),
            None => "Something is missing that is in no catalogue.".into(),
        },
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or(String::new(), |c| c.to_uppercase().chain(letters).collect())
}

fn words(e: &Effect) -> String {
    let v = |i: usize| e.values.get(i).copied().unwrap_or_default();
    let at = match &e.location {
        Location::Bearing(b) => match b.name() {
            "both" => "both bearings".to_owned(),
            name => format!("the {name} bearing"),
        },
        Location::Position(z) => format!("z = {:.0} mm", 1e3 * z),
        Location::Mode(mode) => format!("flexible mode {mode}"),
        Location::Region(region) => format!("region {region}"),
        Location::None => String::new(),
    };
    let percent = |factor: f64| format!("{:+.1} %", 100.0 * (factor - 1.0));
    match e.kind {
        EffectKind::LoopDelay => {
            let way = if v(0) < 0.0 { "faster" } else { "slower" };
            format!(
                "the loop is {:.1} µs {way} than the model",
                1e6 * v(0).abs()
            )
        }
        EffectKind::AmplifierBandwidth => {
            format!("the amplifier of {at} has a bandwidth of {:.0} Hz", v(0))
        }
        EffectKind::EddyCurrents => format!(
            "eddy currents weaken {at} from a corner of {:.0} Hz on",
            v(0)
        ),
        EffectKind::SensorLowpass => {
            format!("the sensors of {at} have a low-pass at {:.0} Hz", v(0))
        }
        EffectKind::SensorOffset => format!(
            "the sensor plane of {at} sits {:+.2} mm off, + to the rear",
            1e3 * v(0)
        ),
        EffectKind::ActuatorOffset => format!(
            "the actuator plane of {at} sits {:+.2} mm off, + to the rear",
            1e3 * v(0)
        ),
        EffectKind::NegativeStiffness => {
            format!("the negative stiffness of {at} is {} off", percent(v(0)))
        }
        EffectKind::ForceConstant => format!("the force constant of {at} is {} off", percent(v(0))),
        EffectKind::SensorGain => format!("the sensor gain of {at} is {} off", percent(v(0))),
        EffectKind::BearingCoupling => {
            format!("{at}: x and y are coupled by {:.2} % of ki", 100.0 * v(0))
        }
        EffectKind::AxisMisalignment => {
            format!("the sensor axes of {at} are turned by {:.2}°", v(0))
        }
        EffectKind::Gyroscopic => format!("the gyroscopic effect counts {:.2} times", v(0)),
        EffectKind::InternalDamping => format!(
            "the rotor has internal damping with a loss time of {:.3} µs",
            1e6 * v(0)
        ),
        EffectKind::CrossCoupling => {
            format!("a circulatory stiffness of {:.3e} N/m acts at {at}", v(0))
        }
        EffectKind::ModalDamping => {
            format!("the damping of {at} is {:.2} times that of the model", v(0))
        }
        EffectKind::ToolJoint => format!(
            "the tool sits in a joint of {:.3e} N/m and {:.3e} N m/rad",
            v(0),
            v(1)
        ),
        EffectKind::ToolMass => format!("the tip of the tool carries {:.1} g more", 1e3 * v(0)),
        EffectKind::AddedMass => format!("{:.1} g more sit at {at}", 1e3 * v(0)),
        EffectKind::HousingMode => {
            format!("the housing of {:.0} kg resonates at {:.0} Hz", v(0), v(1))
        }
        EffectKind::RegionStiffness => format!("the modulus of {at} is {} off", percent(v(0))),
        EffectKind::AddedStiffness => format!("a stiffness of {:.3e} N/m acts at {at}", v(0)),
    }
}

fn pictures(folder: &mut ResultsFolder, d: &Diagnosis) -> Result<(), Failure> {
    let ports = &d.localisation.ports;
    if let Some(best) = ports.first() {
        let names: Vec<String> = ports.iter().map(|p| p.port.clone()).collect();
        // Share of the misfit that a port explains, line by line.
        let scores: Vec<Vec<f64>> = ports
            .iter()
            .map(|p| {
                p.line_after
                    .iter()
                    .map(|c| -(c.max(1e-12)).log10())
                    .collect()
            })
            .collect();
        let map = localisation(
            "Where model and measurement disagree",
            &names,
            &best.frequency_hz,
            &scores,
            "−log10 χ² that remains",
        );
        folder.add_plot("diagnosis-localisation", &map)?;
        let title = format!("Missing law at: {}", best.port);
        if let Some(l) = best.law() {
            let law = impedance(&title, l.unit.text(), &l.frequency_hz, &l.values, &l.fitted, &l.words());
            folder.add_plot("diagnosis-impedance", &law)?;
        }
    }
    if !d.ranking.is_empty() {
        let names: Vec<String> = d.ranking.iter().map(|(e, _)| words(e)).collect();
        let worst = d.ranking.last().map_or(0.0, |r| r.1);
        let scores: Vec<f64> = d
            .ranking
            .iter()
            .map(|(_, s)| ((worst - s).max(0.0) + 1.0).log10())
            .collect();
        let figure = ranking(
            "Explanations",
            &names,
            &scores,
            "log10 of the score below the worst shown",
        );
        folder.add_plot("diagnosis-ranking", &figure)?;
    }
    let mut table = Table::with_columns(&["data", "gap_before", "gap_after"]);
    for (name, before, after) in [
        ("all records", d.gap_before, d.gap_after),
        (
            d.held_out.as_str(),
            d.gap_before_held_out,
            d.gap_after_held_out,
        ),
    ] {
        table.push(vec![
            name.into(),
            Table::number(before),
            Table::number(after),
        ]);
    }
    folder.add_table("gap.csv", &table)?;
    // Residual against frequency, channel by channel, and the correction without a name at the best port.
    let mut correction = Table::with_columns(&["frequency_hz", "re", "im"]);
    if let Some(best) = ports.first() {
        if let Some(l) = best.law() {
            for (f, x) in l.frequency_hz.iter().zip(&l.values) {
                correction.push_numbers(&[*f, x.re, x.im]);
            }
        }
    }
    folder.add_table("correction.csv", &correction)?;
    Ok(())
}
