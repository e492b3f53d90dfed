//! The outcome of model updating as topic of the summary, tables and figures.

use super::pictures::Picture;
use super::plot::shaft::{OutlinePiece, Station, StationKind, mode_shapes};
use super::plot::updating::{determinability, frequency_errors, modulus_factors};
use super::plot::{Curve, Figure, Role};
use super::tables::Table;
use crate::spindle::Machine;
use crate::update::{PeakError, PeakKind, ShapeComparison, Updated};
use serde_json::{Map, Value, json};

/// `updating`. Lists stand in the order of the measured lists; none where a peak was not measured or has no counterpart
/// in the model.
pub(crate) fn updating_topic(fit: &Updated) -> Value {
    let combinations = &fit.determined.combinations;
    let deviations = fit.factors.iter().filter_map(|f| Some((f.region.clone(), json!(f.standard_deviation_ln?))));
    // Combinations of factors that the data determine.
    let determined = combinations.iter().filter(|c| c.singular_value > 1.0).map(|c| {
        let weights = by_region(fit, c.weights.iter().copied());
        json!({ "singular_value": c.singular_value, "shrinkage": c.shrinkage, "weights": weights })
    });
    let shapes = fit.shapes.iter();
    let shapes = shapes.map(|s| json!({ "mode": s.mode, "model_mode": s.model_mode, "mac": s.mac }));
    json!({
        "method": fit.method.name(),
        "evaluations": fit.evaluations,
        "iterations": fit.iterations,
        "modulus_factors": by_region(fit, fit.factors.iter().map(|f| f.factor)),
        "modulus_factors_standard_deviation_ln": deviations.collect::<Value>(),
        "errors_hz": peak_lists(fit, PeakError::error_hz),
        "errors_percent": peak_lists(fit, PeakError::error_percent),
        "model_hz": peak_lists(fit, |e| e.after_hz),
        "model_before_hz": peak_lists(fit, |e| e.before_hz),
        "measured_hz": peak_lists(fit, |e| Some(e.measured_hz)),
        "measured_relative_standard_deviation": peak_lists(fit, |e| Some(e.relative_sd)),
        "held_out": held_out(fit),
        "noise_estimated": fit.noise_estimated,
        "largest_error_percent": fit.largest_error_percent(),
        "mac": fit.shapes.iter().map(|s| s.mac).collect::<Vec<_>>(),
        "mode_shapes": shapes.collect::<Vec<_>>(),
        "singular_values": combinations.iter().map(|c| c.singular_value).collect::<Vec<_>>(),
        "determined_combinations": determined.collect::<Vec<_>>(),
        "explained": fit.explanation.explained,
        "statement": fit.explanation.statement,
        "chi_squared": fit.explanation.statistic,
        "chi_squared_limit": fit.explanation.limit,
    })
}

/// Values under the names of the regions.
fn by_region(fit: &Updated, values: impl Iterator<Item = f64>) -> Value {
    fit.factors.iter().zip(values).map(|(f, value)| (f.region.clone(), json!(value))).collect()
}

/// One figure per measured peak: `resonances`, and `antiresonances` by the name of the FRF.
fn peak_lists(fit: &Updated, value: impl Fn(&PeakError) -> Option<f64>) -> Value {
    let (mut resonances, mut antiresonances) = (vec![], Map::new());
    for e in &fit.errors {
        let figure = json!(value(e));
        match e.kind {
            PeakKind::Resonance => place(&mut resonances, e.number, figure),
            PeakKind::Antiresonance => {
                if let Value::Array(list) = antiresonances.entry(&e.frf).or_insert_with(|| json!([])) {
                    place(list, e.number, figure);
                }
            }
        }
    }
    json!({ "resonances": resonances, "antiresonances": antiresonances })
}

/// Sets the figure of the peak of that number, from 1; those before it that have none are `null`.
fn place(list: &mut Vec<Value>, number: usize, figure: Value) {
    if list.len() < number {
        list.resize(number, Value::Null);
    }
    list[number - 1] = figure;
}

/// Names of the FRFs that the fit did not use.
fn held_out(fit: &Updated) -> Vec<String> {
    let mut names: Vec<String> = vec![];
    for e in fit.errors.iter().filter(|e| !e.used) {
        if !names.contains(&e.frf) {
            names.push(e.frf.clone());
        }
    }
    names
}

/// Name of a peak in pictures: `r 1` is a resonance, `a front 2` an antiresonance.
fn label(e: &PeakError) -> String {
    match e.kind {
        PeakKind::Resonance => format!("r {}", e.number),
        PeakKind::Antiresonance => format!("a {} {}", e.frf, e.number),
    }
}

/// The table of errors in Hz and %, models side by side as in Table 1 of the reference method.
pub(crate) fn error_table(models: &[(&str, &[PeakError])]) -> Table {
    let mut header = ["kind", "frf", "number", "measured_hz", "before_hz"].map(str::to_owned).to_vec();
    for (name, _) in models {
        header.extend(["hz", "error_hz", "error_percent"].map(|unit| format!("{name}_{unit}")));
    }
    let mut table = Table::new(header);
    let Some((_, first)) = models.first() else {
        return table;
    };
    let cell = |v: Option<f64>| Table::number(v.unwrap_or(f64::NAN));
    for (k, e) in first.iter().enumerate() {
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
        for (_, errors) in models {
            let of = errors.get(k);
            row.push(cell(of.and_then(|e| e.after_hz)));
            row.push(cell(of.and_then(PeakError::error_hz)));
            row.push(cell(of.and_then(PeakError::error_percent)));
        }
        table.push(row);
    }
    table
}

/// Measured mode shapes beside those of the model.
pub(crate) fn shape_table(shapes: &[ShapeComparison]) -> Table {
    let mut table = Table::with_columns(&["mode", "position_m", "measured_scaled", "model"]);
    for shape in shapes {
        for (z, measured, model) in &shape.points {
            table.push_numbers(&[shape.mode as f64, *z, *measured, *model]);
        }
    }
    table
}

/// Pictures of an updating: factors, determinability, errors, mode shapes; a rotor without magnets has no machine.
/// `models` names the fits, the delivered one first.
pub(crate) fn figures(machine: Option<&Machine>, models: &[(&str, &Updated)]) -> Vec<(Picture, Figure)> {
    let Some((name, fit)) = models.first() else {
        return vec![];
    };
    let regions: Vec<String> = fit.factors.iter().map(|f| f.region.clone()).collect();
    let factor: Vec<f64> = fit.factors.iter().map(|f| f.factor).collect();
    let deviation: Vec<f64> = fit.factors.iter().filter_map(|f| Some(f.factor * f.standard_deviation_ln?)).collect();
    // Share of a region's prior variance that the data have removed.
    let prior: Vec<f64> =
        (0..regions.len()).map(|i| fit.determined.prior_standard_deviation_ln.get(i).copied().unwrap_or(1.0)).collect();
    let after = fit.determined.standard_deviation_ln.iter();
    let share: Vec<f64> = after.zip(&prior).map(|(after, before)| 1.0 - (after / before).powi(2)).collect();
    // Combinations that the data say nothing about have no place on a logarithmic axis.
    let singular: Vec<f64> =
        fit.determined.combinations.iter().map(|c| c.singular_value).filter(|s| *s > 1e-3).collect();
    vec![
        (Picture::ModulusFactors, modulus_factors("Modulus factors", &regions, &factor, &deviation)),
        (Picture::Determinability, determinability("What the data determine", &singular, &regions, &share)),
        (Picture::FrequencyErrors, errors_figure(&errors_of(models))),
        (Picture::ModeShapes, shapes_figure(machine, name, fit)),
    ]
}

/// The tables of errors of fits.
pub(crate) fn errors_of<'a>(models: &[(&'a str, &'a Updated)]) -> Vec<(&'a str, &'a [PeakError])> {
    models.iter().map(|(name, fit)| (*name, fit.errors.as_slice())).collect()
}

/// The errors before and of every model, per cent.
pub(crate) fn errors_figure(models: &[(&str, &[PeakError])]) -> Figure {
    let first = models.first().map_or(&[][..], |(_, errors)| errors);
    let labels: Vec<String> = first.iter().map(label).collect();
    let before = |e: &PeakError| e.before_hz.map_or(0.0, |f| 100.0 * (f / e.measured_hz - 1.0));
    let after = |e: &PeakError| e.error_percent().unwrap_or(0.0);
    let mut bars: Vec<(&str, Vec<f64>)> = vec![("before", first.iter().map(before).collect())];
    bars.extend(models.iter().map(|(name, errors)| (*name, errors.iter().map(after).collect())));
    frequency_errors("Errors of the model", &labels, &bars)
}

fn shapes_figure(machine: Option<&Machine>, name: &str, fit: &Updated) -> Figure {
    let z = fit.rotor.node_positions_m();
    let station = |name, position_m, kind| Station { name, position_m, kind };
    let bearings = machine.iter().flat_map(|own| own.effective().bearings);
    let stations: Vec<Station> = bearings
        .flat_map(|b| {
            [station("sensor", b.sensor_m, StationKind::Sensor), station("AMB", b.actuator_m, StationKind::Actuator)]
        })
        .collect();
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
    let modes: Vec<(String, Vec<Curve<'_>>)> = (0..shown)
        .map(|k| {
            let mut curves = vec![Curve { name, role: Role::Updated, x: z, y: &after[k] }];
            if let Some(b) = before.get(k) {
                curves.push(Curve { name: "before", role: Role::Nominal, x: z, y: b });
            }
            if let Some((z, a)) = &measured[k] {
                curves.push(Curve { name: "measured", role: Role::Measured, x: z, y: a });
            }
            (format!("mode {}: {:.0} Hz", k + 1, fit.after.poles_hz[k]), curves)
        })
        .collect();
    mode_shapes("Mode shapes", &OutlinePiece::list(&fit.rotor), &stations, &modes)
}
