//! Files of a diagnosis: tables and pictures.

use super::pictures::{Picture, PictureName};
use super::plot::diagnosis as plot;
use super::plot::style::Role;
use super::plot::{Curve, Figure};
use super::results::{ResultsError, ResultsFolder};
use super::tables::Table;
use crate::diagnose::Diagnosis;
use crate::diagnose::decide::residuals::{MeasuredChannel, Record};
use crate::diagnose::locate::localisation::PortScore;
use crate::diagnose::locate::place::Place;
use crate::diagnose::locate::recovered_law::Law;
use crate::linalg::c64;
use crate::spindle::Location;
use crate::spindle::effects::AXIS_NAMES as AXES;
use crate::spindle::response::SIDE;
use std::f64::consts::TAU;

type Named = (PictureName, Figure);

/// Lines of the localisation map; the ports that explain least are left out.
const MAP_ROWS: usize = 12;

/// Tables and pictures.
///
/// # Errors
/// [`ResultsError`] for a picture that cannot be drawn.
pub fn stage(folder: &mut ResultsFolder, d: &Diagnosis) -> Result<(), ResultsError> {
    let mut figures = localisation(d);
    figures.extend(laws(d));
    figures.extend(ranking(d));
    figures.extend(channels(d));
    folder.add_plots(figures)?;
    hypotheses(folder, d)?;
    correction(folder, d)?;
    let mut table = Table::with_columns(&["data", "gap_before", "gap_after"]);
    let (used, held) = (d.gaps(false), d.gaps(true));
    for (name, (before, after)) in
        [("used", used), (d.held_out.as_str(), held), ("all records, fitted to all", (d.gap_before, d.gap_after))]
    {
        table.push(vec![name.into(), Table::number(before), Table::number(after)]);
    }
    folder.add_table("gap.csv", &table)
}

fn localisation(d: &Diagnosis) -> Vec<Named> {
    let all = || d.localisation.ports.iter();
    let ports: Vec<&PortScore> = all().filter(|p| p.place != Place::Nowhere).take(MAP_ROWS).collect();
    let Some(best) = ports.first() else {
        return vec![];
    };
    let mut order: Vec<usize> = (0..best.frequency_hz.len()).collect();
    order.sort_by(|a, b| best.frequency_hz[*a].total_cmp(&best.frequency_hz[*b]));
    let hz: Vec<f64> = order.iter().map(|i| best.frequency_hz[*i]).collect();
    let mut names = vec!["no law".to_owned()];
    names.extend(ports.iter().map(|p| p.port.clone()));
    // Noise alone leaves about 1: what lies below counts as explained.
    let decades = |values: &[f64]| -> Vec<f64> {
        order.iter().map(|i| values.get(*i).map_or(f64::NAN, |v| v.max(1.0).log10())).collect()
    };
    let mut scores = vec![decades(&best.line_before)];
    scores.extend(ports.iter().map(|p| decades(&p.line_after)));
    let title = "Where model and measurement disagree: what a free law at each place leaves unexplained";
    let map = plot::localisation(title, &names, &hz, &scores, "log10 of χ² per residual that remains");
    let words: Vec<String> = all()
        .map(|p| match p.law() {
            Some(_) => format!("{}: {}", p.port, p.shape()),
            None => p.port.clone(),
        })
        .collect();
    let bars: Vec<f64> = all().map(|p| (1.0 + p.chi2_after).log10()).collect();
    let title = "Places, best first, with the law recovered there";
    let places = plot::ranking(title, &words, &bars, "log10(1 + χ² left)");
    vec![(Picture::Localisation.into(), map), (Picture::LocalisationPlaces.into(), places)]
}

fn laws(d: &Diagnosis) -> Vec<Named> {
    let Some(best) = d.localisation.named_port() else {
        return vec![];
    };
    let mut figures = vec![];
    for (k, law) in best.laws.iter().enumerate() {
        let which = if law.name.is_empty() { String::new() } else { format!(" ({})", law.name) };
        let title = format!("Missing law at: {}{which}", best.port);
        // Lines on which the law is smaller than its own deviation say nothing about its shape.
        let shown: Vec<_> = law
            .values
            .iter()
            .zip(&law.sd)
            .map(|(v, sd)| if v.norm() > *sd { *v } else { c64::new(f64::NAN, f64::NAN) })
            .collect();
        if shown.iter().all(|v| v.re.is_nan()) {
            continue;
        }
        let figure = plot::impedance(&title, law.unit.text(), &law.frequency_hz, &shown, &law.fitted, &law.words());
        figures.push((Picture::Impedance.with_number(k + 1), figure));
    }
    figures
}

fn ranking(d: &Diagnosis) -> Option<Named> {
    if d.ranking.is_empty() {
        return None;
    }
    let names: Vec<String> =
        d.ranking.iter().map(|(e, score)| format!("{} {}   +{score:.1}", e.kind.name(), spot(&e.location))).collect();
    let above: Vec<f64> = d.ranking.iter().map(|r| (1.0 + r.1.max(0.0)).log10()).collect();
    let title = "Hypotheses, best first: score χ² + d ln N above the best";
    let figure = plot::ranking(title, &names, &above, "log10(1 + score above the best); a tie below 0.9");
    Some((Picture::Ranking.into(), figure))
}

fn hypotheses(folder: &mut ResultsFolder, d: &Diagnosis) -> Result<(), ResultsError> {
    if d.ranking.is_empty() {
        return Ok(());
    }
    let mut table = Table::with_columns(&["effect", "where", "parameters", "score_above_best"]);
    for (e, score) in &d.ranking {
        let values = e.kind.parameters().iter().zip(&e.values);
        let values: Vec<String> = values.map(|(p, v)| format!("{} {v:.6e}", p.name)).collect();
        table.push(vec![e.kind.name().into(), spot(&e.location), values.join("; "), Table::number(*score)]);
    }
    folder.add_table("ranking.csv", &table)
}

fn spot(location: &Location) -> String {
    match location {
        Location::None => String::new(),
        Location::Bearing(b) => b.name().into(),
        Location::Axis(axis) => AXES[*axis % 4].into(),
        Location::Across { from, to } => format!("{} to {}", AXES[*from % 4], AXES[*to % 4]),
        Location::Position(z) => format!("at {:.0} mm", 1e3 * z),
        Location::InPlane(z, plane) => format!("at {:.0} mm in {}", 1e3 * z, plane.name()),
        Location::Mode(m) => format!("mode {m}"),
        Location::Region(r) => r.clone(),
    }
}

fn channels(d: &Diagnosis) -> Vec<Named> {
    let mut figures = vec![];
    for (k, channel) in d.channels.iter().enumerate() {
        let hz: Vec<f64> = channel.omega_rad_s.iter().map(|w| w / TAU).collect();
        let rpm = channel.speed_rad_s * 60.0 / TAU;
        let part = if channel.held_out { "held out" } else { "used" };
        let (words, quantity, unit, kind, which) = match channel.record {
            Record::Sweep(i, j) => (
                format!("current {} to sensor {}", AXES[j], AXES[i]),
                "|sensor / current|",
                "m/A",
                Picture::Channel,
                format!("{}-from-{}", AXES[i], AXES[j]),
            ),
            Record::Hammer(axis) => {
                let axis = ["x", "y"][axis.min(1)];
                (format!("hammer at the tool, {axis}"), "Compliance", "m/N", Picture::Hammer, axis.to_owned())
            }
        };
        // Further records of one kind carry their number.
        let twin = d.channels[..k].iter().filter(|c| c.record == channel.record).count();
        let detail = match twin {
            0 => which,
            earlier => format!("{which}-{}", earlier + 1),
        };
        let title = format!("{words}, {rpm:.0} rpm ({part})");
        let (before, after) = channel.residual();
        let responses: [&[c64]; 3] = [&channel.measured, &channel.before, &channel.after];
        let figure = plot::channel(&title, quantity, unit, &hz, responses, [&before, &after]);
        figures.push((kind.with_detail(detail), figure));
    }
    figures.push(overview(d));
    figures
}

/// Residuals of the direct channels, and of the held-out ones, in one picture.
fn overview(d: &Diagnosis) -> Named {
    let shown: Vec<&MeasuredChannel> = d
        .channels
        .iter()
        .filter(|c| match c.record {
            Record::Sweep(i, j) => i == j || i % 2 == 0 && j == i + 1 || c.held_out && i % 2 == j % 2,
            Record::Hammer(_) => true,
        })
        .take(14)
        .collect();
    let data: Vec<(Vec<f64>, (Vec<f64>, Vec<f64>))> =
        shown.iter().map(|c| (c.omega_rad_s.iter().map(|w| w / TAU).collect(), c.residual())).collect();
    let panels: Vec<(String, Vec<Curve>)> = shown
        .iter()
        .zip(&data)
        .map(|(c, (hz, (before, after)))| {
            let held = if c.held_out { ", held out" } else { "" };
            let name = match c.record {
                Record::Sweep(i, j) => format!("{} from {}{held}", AXES[i], AXES[j]),
                Record::Hammer(axis) => format!("hammer {}{held}", ["x", "y"][axis.min(1)]),
            };
            let curve = |name, role, y| Curve { name, role, x: hz, y };
            (name, vec![curve("before", Role::Nominal, before), curve("after", Role::Updated, after)])
        })
        .collect();
    (Picture::Residual.into(), plot::residual("Residual in standard deviations, before and after", &panels))
}

/// Tables of the laws: those on the same lines share one, the others follow under a number.
fn law_tables(folder: &mut ResultsFolder, place: &Place, laws: &[Law]) -> Result<(), ResultsError> {
    let mut alike: Vec<Vec<&Law>> = vec![];
    for law in laws {
        match alike.iter_mut().find(|group| group[0].frequency_hz == law.frequency_hz) {
            Some(group) => group.push(law),
            None => alike.push(vec![law]),
        }
    }
    for (number, group) in alike.iter().enumerate() {
        let mut header = vec!["frequency_hz".to_owned()];
        for law in group {
            let name =
                if law.name.is_empty() { "law".to_owned() } else { format!("law_{}", law.name.replace(' ', "_")) };
            let unit = law.unit.key();
            header.extend([format!("{name}_{unit}_re"), format!("{name}_{unit}_im"), format!("{name}_{unit}_sd")]);
        }
        header.push("place".to_owned());
        let mut table = Table::new(header);
        for (k, hz) in group[0].frequency_hz.iter().enumerate() {
            let mut row = vec![*hz];
            for law in group {
                let value = law.values.get(k).copied().unwrap_or(c64::new(f64::NAN, f64::NAN));
                row.extend([value.re, value.im, law.sd.get(k).copied().unwrap_or(f64::NAN)]);
            }
            let cells = row.into_iter().map(Table::number).chain([place.name_in_files()]);
            table.push(cells.collect());
        }
        let name = if number == 0 { "correction.csv".to_owned() } else { format!("correction-{}.csv", number + 1) };
        folder.add_table(&name, &table)?;
    }
    Ok(())
}

fn correction(folder: &mut ResultsFolder, d: &Diagnosis) -> Result<(), ResultsError> {
    let (Some(c), Some(best)) = (&d.correction, d.localisation.named_port()) else {
        return Ok(());
    };
    law_tables(folder, &best.place, &best.laws)?;
    // The header of `muspin frf`, so that whoever reads that reads this: sensors over currents, then the tool.
    let block = |from: usize, to: usize| (from..to).flat_map(move |i| (from..to).map(move |j| (i, j)));
    let entries: Vec<(usize, usize)> = block(0, 4).chain(block(4, 6)).collect();
    let name = |(i, j): (usize, usize)| match i {
        0..4 => format!("g_{}{}", i + 1, j + 1),
        _ => format!("t_{}{}", ["x", "y"][i - 4], ["x", "y"][j - 4]),
    };
    let parts = entries.iter().map(|entry| name(*entry)).flat_map(|name| [format!("{name}_re"), format!("{name}_im")]);
    let header: Vec<String> = std::iter::once("frequency_hz".to_owned()).chain(parts).collect();
    for (s, sweep) in c.sweeps.iter().enumerate() {
        let mut table = Table::new(header.clone());
        // The first sixteen channels belong to the first sweep, and so on.
        let omega = d.channels.get(16 * s).map_or(&[][..], |c| &c.omega_rad_s);
        for (f, w) in sweep.iter().zip(omega) {
            let values = entries.iter().map(|(i, j)| f[SIDE * i + j]).flat_map(|value| [value.re, value.im]);
            table.push_numbers(&std::iter::once(w / TAU).chain(values).collect::<Vec<f64>>());
        }
        let name = if s == 0 { "corrected-frf.csv".to_owned() } else { format!("corrected-frf-{}.csv", s + 1) };
        folder.add_table(&name, &table)?;
    }
    Ok(())
}
