//! The outcome of model updating as JSON, tables and figures.

use super::plot::shaft::{OutlinePiece, ShapeCurve, Station, StationKind, mode_shapes};
use super::plot::updating::{determinability, frequency_errors, modulus_factors};
use super::plot::{Figure, Role};
use super::tables::Table;
use crate::spindle::Machine;
use crate::update::{PeakError, PeakKind, Updated};
use serde_json::{Map, Value, json};

/// The `updating` object of `summary.json`. Lists stand in the order of the measured lists; `null` where a peak was not
/// measured or has no counterpart in the model.
pub fn updating_json(fit: &Updated) -> Value {
    let factors: Map<String, Value> = fit
        .factors
        .iter()
        .map(|f| (f.region.clone(), json!(f.factor)))
        .collect();
    let deviations: Map<String, Value> = fit
        .factors
        .iter()
        .filter_map(|f| Some((f.region.clone(), json!(f.standard_deviation_ln?))))
        .collect();
    let combinations: Vec<Value> = fit
        .determined
        .combinations
        .iter()
        .filter(|c| c.singular_value > 1.0)
        .map(|c| {
            let weights: Map<String, Value> = fit
                .factors
                .iter()
                .zip(&c.weights)
                .map(|(f, w)| (f.region.clone(), json!(w)))
                .collect();
            json!({"singular_value": c.singular_value, "shrinkage": c.shrinkage, "weights": weights})
        })
        .collect();
    let singular_values: Vec<f64> = fit
        .determined
        .combinations
        .iter()
        .map(|c| c.singular_value)
        .collect();
    let shapes: Vec<Value> = fit
        .shapes
        .iter()
        .map(|s| json!({"mode": s.mode, "model_mode": s.model_mode, "mac": s.mac}))
        .collect();
    json!({
        "method": fit.method.name(),
        "evaluations": fit.evaluations,
        "iterations": fit.iterations,
        "modulus_factors": factors,
        "modulus_factors_standard_deviation_ln": deviations,
        "errors_hz": by_list(fit, PeakError::error_hz),
        "errors_percent": by_list(fit, PeakError::error_percent),
        "model_hz": by_list(fit, |e| e.after_hz),
        "model_before_hz": by_list(fit, |e| e.before_hz),
        "measured_hz": by_list(fit, |e| Some(e.measured_hz)),
        "measured_relative_standard_deviation": by_list(fit, |e| Some(e.relative_sd)),
        "held_out": held_out(fit),
        "noise_estimated": fit.noise_estimated,
        "largest_error_percent": finite(fit.largest_error_percent()),
        "mac": fit.shapes.iter().map(|s| s.mac).collect::<Vec<f64>>(),
        "mode_shapes": shapes,
        "singular_values": singular_values,
        "determined_combinations": combinations,
        "explained": fit.explanation.explained,
        "statement": fit.explanation.statement,
        "chi_squared": fit.explanation.statistic,
        "chi_squared_limit": fit.explanation.limit,
    })
}

fn finite(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { Value::Null }
}

/// `{resonances: […], antiresonances: {front: […], …}}` of one figure per measured peak.
fn by_list(fit: &Updated, value: impl Fn(&PeakError) -> Option<f64>) -> Value {
    let place = |list: &mut Vec<Value>, e: &PeakError| {
        while list.len() < e.number {
            list.push(Value::Null);
        }
        if let Some(slot) = list.get_mut(e.number - 1) {
            *slot = json!(value(e));
        }
    };
    let mut resonances = vec![];
    let mut zeros: Vec<(String, Vec<Value>)> = vec![];
    for e in &fit.errors {
        match e.kind {
            PeakKind::Resonance => place(&mut resonances, e),
            PeakKind::Antiresonance => {
                let known = zeros.iter().position(|(name, _)| name == &e.frf);
                let k = known.unwrap_or_else(|| {
                    zeros.push((e.frf.clone(), vec![]));
                    zeros.len() - 1
                });
                place(&mut zeros[k].1, e);
            }
        }
    }
    let zeros: Map<String, Value> = zeros.into_iter().map(|(n, l)| (n, json!(l))).collect();
    json!({"resonances": resonances, "antiresonances": zeros})
}

/// Names of the FRFs that the fit did not use.
fn held_out(fit: &Updated) -> Vec<&str> {
    let mut names: Vec<&str> = vec![];
    for e in fit.errors.iter().filter(|e| !e.used) {
        if !names.contains(&e.frf.as_str()) {
            names.push(&e.frf);
        }
    }
    names
}

/// Name of a peak in tables and pictures: `resonance 1`, `antiresonance front 2`.
fn label(e: &PeakError) -> String {
    match e.kind {
        PeakKind::Resonance => format!("r {}", e.number),
        PeakKind::Antiresonance => format!("a {} {}", e.frf, e.number),
    }
}

/// The table of errors in Hz and %, models side by side as in Table 1 of the reference method.
pub fn error_table(models: &[(&str, &Updated)]) -> Table {
    let mut header = vec![
        "kind".to_owned(),
        "frf".to_owned(),
        "number".to_owned(),
        "measured_hz".to_owned(),
        "before_hz".to_owned(),
    ];
    for (name, _) in models {
        for unit in ["hz", "error_hz", "error_percent"] {
            header.push(format!("{name}_{unit}"));
        }
    }
    let mut table = Table::new(header);
    let Some((_, first)) = models.first() else {
        return table;
    };
    let cell = |v: Option<f64>| Table::number(v.unwrap_or(f64::NAN));
    for (k, e) in first.errors.iter().enumerate() {
        let mut row = vec![
            match e.kind {
                PeakKind::Resonance => "resonance".to_owned(),
                PeakKind::Antiresonance => "antiresonance".to_owned(),
            },
            e.frf.clone(),
            e.number.to_string(),
            Table::number(e.measured_hz),
            cell(e.before_hz),
        ];
        for (_, fit) in models {
            let of = fit.errors.get(k);
            row.push(cell(of.and_then(|e| e.after_hz)));
            row.push(cell(of.and_then(PeakError::error_hz)));
            row.push(cell(of.and_then(PeakError::error_percent)));
        }
        table.push(row);
    }
    table
}

/// Figures of an updating with their stems: factors, determinability, errors, mode shapes. `models` names the fits, the
/// delivered one first.
pub fn figures(machine: &Machine, models: &[(&str, &Updated)]) -> Vec<(&'static str, Figure)> {
    let Some((name, fit)) = models.first() else {
        return vec![];
    };
    let regions: Vec<String> = fit.factors.iter().map(|f| f.region.clone()).collect();
    let factor: Vec<f64> = fit.factors.iter().map(|f| f.factor).collect();
    let deviation: Vec<f64> = fit
        .factors
        .iter()
        .filter_map(|f| Some(f.factor * f.standard_deviation_ln?))
        .collect();
    // Share of a region's prior variance that the data have removed.
    let prior: Vec<f64> = (0..regions.len())
        .map(|i| {
            fit.determined
                .prior_standard_deviation_ln
                .get(i)
                .copied()
                .unwrap_or(1.0)
        })
        .collect();
    let share: Vec<f64> = fit
        .determined
        .standard_deviation_ln
        .iter()
        .zip(&prior)
        .map(|(after, before)| 1.0 - (after / before).powi(2))
        .collect();
    // Combinations that the data say nothing about have no place on a logarithmic axis.
    let singular: Vec<f64> = fit
        .determined
        .combinations
        .iter()
        .map(|c| c.singular_value)
        .filter(|s| *s > 1e-3)
        .collect();
    let labels: Vec<String> = fit.errors.iter().map(label).collect();
    let before: Vec<f64> = fit
        .errors
        .iter()
        .map(|e| {
            e.before_hz
                .map_or(0.0, |f| 100.0 * (f / e.measured_hz - 1.0))
        })
        .collect();
    let after: Vec<(&str, Vec<f64>)> = models
        .iter()
        .map(|(n, f)| {
            let each = |e: &PeakError| e.error_percent().unwrap_or(0.0);
            (*n, f.errors.iter().map(each).collect())
        })
        .collect();
    let mut bars: Vec<(&str, &[f64])> = vec![("before", &before)];
    bars.extend(after.iter().map(|(n, e)| (*n, e.as_slice())));
    let mut list = vec![
        (
            "modulus_factors",
            modulus_factors("Modulus factors", &regions, &factor, &deviation),
        ),
        (
            "determinability",
            determinability("What the data determine", &singular, &regions, &share),
        ),
        (
            "frequency_errors",
            frequency_errors("Errors of the model", &labels, &bars),
        ),
    ];
    list.push(("mode_shapes", shapes_figure(machine, name, fit)));
    list
}

fn shapes_figure(machine: &Machine, name: &str, fit: &Updated) -> Figure {
    let z = fit.rotor.node_positions_m();
    let mut at = fit.rotor.from_m();
    let outline: Vec<OutlinePiece> = fit
        .rotor
        .sections()
        .iter()
        .map(|s| {
            let from_m = at;
            at += s.length_m;
            OutlinePiece {
                from_m,
                to_m: at,
                diameter_m: 0.5 * (s.outer_diameter_m[0] + s.outer_diameter_m[1]),
            }
        })
        .collect();
    let [f, r] = machine.effective().bearings;
    let station = |name, position_m, kind| Station {
        name,
        position_m,
        kind,
    };
    let stations = [
        station("sensor", f.sensor_m, StationKind::Sensor),
        station("AMB", f.actuator_m, StationKind::Actuator),
        station("AMB", r.actuator_m, StationKind::Actuator),
        station("sensor", r.sensor_m, StationKind::Sensor),
    ];
    let deflection = |shape: &Vec<[f64; 2]>| -> Vec<f64> { shape.iter().map(|v| v[0]).collect() };
    let shown = fit.after.shapes.len().min(3);
    let after: Vec<Vec<f64>> = fit.after.shapes.iter().map(deflection).collect();
    let before: Vec<Vec<f64>> = fit.before.shapes.iter().map(deflection).collect();
    let measured: Vec<Option<(Vec<f64>, Vec<f64>)>> = (0..shown)
        .map(|k| {
            let s = fit.shapes.iter().find(|s| s.model_mode == k + 1)?;
            Some(s.points.iter().map(|(z, a, _)| (*z, *a)).unzip())
        })
        .collect();
    let modes: Vec<(String, Vec<ShapeCurve<'_>>)> = (0..shown)
        .map(|k| {
            let mut curves = vec![ShapeCurve {
                name,
                role: Role::Updated,
                position_m: z,
                amplitude: &after[k],
            }];
            if let Some(b) = before.get(k) {
                curves.push(ShapeCurve {
                    name: "before",
                    role: Role::Nominal,
                    position_m: z,
                    amplitude: b,
                });
            }
            if let Some((z, a)) = &measured[k] {
                curves.push(ShapeCurve {
                    name: "measured",
                    role: Role::Measured,
                    position_m: z,
                    amplitude: a,
                });
            }
            (
                format!("mode {}: {:.0} Hz", k + 1, fit.after.poles_hz[k]),
                curves,
            )
        })
        .collect();
    mode_shapes("Mode shapes", &outline, &stations, &modes)
}
