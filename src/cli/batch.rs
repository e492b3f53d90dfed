//! `muspin batch`: a run per tool or variant, each in a folder of its own, and one table over all.
//!
//! A folder is written as soon as its tool is done; one that was computed from the same inputs before is read back. A
//! tool that fails leaves the others alone.

use super::Failure;
use super::batch_arguments::Arguments;
use super::batch_plan::{collect_rows, plan, read_row};
use super::batch_variants::{Variant, variants};
use super::console::{CommandEnd, Console, REPORT};
use super::design_progress::{told, told_of};
use super::progress::{Progress, lock};
use crate::augment::weights::Weights;
use crate::export::firmware::sha256_hex;
use crate::input::load_weights;
use crate::pipeline::batch::one_tool;
use crate::pipeline::run::{Extent, Task};
use crate::pipeline::settings::{DesignSettings, EarlierDesign};
use crate::report::batch::{BatchRow, ROW_FILE, figures, overview, sentences, shown_rows, table, tools_words, verdict};
use crate::report::tool::tool_report;
use crate::report::whole::{Report, ReportError, machine_tag};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    if let Some(folder) = &arguments.collect {
        console.claim(&arguments.out, &REPORT, &[])?;
        return finish(Report::default(), &collect_rows(folder)?, f64::NAN, arguments, console);
    }
    let weights = load_weights(&arguments.weights)?;
    // Every file is read before the first design starts.
    let variants = variants(arguments)?;
    if let Some(folder) = &arguments.plan {
        return plan(arguments, folder, &variants, console);
    }
    if !arguments.no_table {
        console.claim(&arguments.out, &REPORT, &[])?;
    }
    for variant in &variants {
        console.claim(&variant.folder(&arguments.out), &[ROW_FILE], &[])?;
    }
    let progress = Progress::start(console);
    let rows = all(arguments, &variants, &weights, &progress, console)?;
    progress.end(arguments.timings);
    let top_hz = variants.first().map(|v| v.machine.spindle.max_rpm / 60.0);
    let mut report = Report::default();
    report.summary.set("spindle", variants.first().map(|v| v.machine.spindle.name.as_str()));
    report.summary.set("weights", weights.name.as_str());
    if rows.iter().all(|r| r.failure.is_some()) {
        let first = rows.first().and_then(|r| r.failure.clone());
        return Err(Failure::new(format!("every tool failed; the first: {}", first.unwrap_or_default()))
            .with_hint("`muspin check` on the spindle and tool files shows more"));
    }
    finish(report, &rows, top_hz.unwrap_or(f64::NAN), arguments, console)
}

/// The rows of all variants, in their order. None depends on another: as many are computed at a time as there are
/// threads, each of which helps the others where it has to wait. With `--timings` it is one at a time, so that the time
/// of a stage is its own.
fn all(
    arguments: &Arguments,
    variants: &[Variant],
    weights: &Weights,
    progress: &Progress,
    console: &Console,
) -> Result<Vec<BatchRow>, Failure> {
    let next = AtomicUsize::new(0);
    let found = Mutex::new(vec![]);
    progress.share(0, variants.len());
    let in_turn = || {
        while let Some((number, variant)) = take_next(variants, &next) {
            let row = one(arguments, variant, weights, progress, console);
            if row.is_err() {
                // What cannot be written ends the batch.
                next.store(variants.len(), Ordering::Relaxed);
            }
            let mut found = lock(&found);
            found.push((number, row));
            progress.share(found.len(), variants.len());
        }
    };
    if arguments.timings.are_asked() {
        in_turn();
    } else {
        // A closure for each thread: one that could be stolen would run inside another tool.
        rayon::broadcast(|_| in_turn());
    }
    let mut found = std::mem::take(&mut *lock(&found));
    found.sort_by_key(|(number, _)| *number);
    found.into_iter().map(|(_, row)| row).collect()
}

/// The next variant that nobody has taken.
fn take_next<'a>(variants: &'a [Variant], next: &AtomicUsize) -> Option<(usize, &'a Variant)> {
    let number = next.fetch_add(1, Ordering::Relaxed);
    variants.get(number).map(|variant| (number, variant))
}

/// The row of a variant: read back where it was computed from the same inputs before, else computed, and its folder
/// written.
fn one(
    arguments: &Arguments,
    variant: &Variant,
    weights: &Weights,
    progress: &Progress,
    console: &Console,
) -> Result<BatchRow, Failure> {
    let out = variant.folder(&arguments.out);
    let weights = &weights.on(&variant.machine)?;
    let settings = DesignSettings {
        earlier: arguments.from.design(&variant.machine)?,
        ..if arguments.no_polish { DesignSettings::default() } else { DesignSettings::with_polish() }
    };
    let inputs = inputs_sha256(arguments, variant, weights, &settings.earlier);
    if !arguments.again
        && let Some(row) = read_row(&Path::new(&out).join(ROW_FILE))
        && row.inputs_sha256 == inputs
        && row.failure.is_none()
    {
        progress.line(format!("{}: read from {out}", variant.name));
        return Ok(row);
    }
    let task = Task {
        nominal: &variant.machine,
        targets: None,
        weights,
        settings: &settings,
        pid: arguments.pid.settings(),
        extent: if arguments.quick { Extent::Controller } else { Extent::Everything },
    };
    progress.line(format!("{}: begun", variant.name));
    let alone = arguments.timings.are_asked();
    let found = one_tool(&task, arguments.tightening, &mut |event| {
        if alone { told(progress, event) } else { told_of(progress, &variant.name, event) }
    });
    if alone {
        progress.start_stage("report");
    }
    let mut report = Report::default();
    let row = match found {
        Ok(found) => {
            report = tool_report(&found, weights)?;
            BatchRow::of(&variant.name, &inputs, &found)
        }
        Err(error) => BatchRow::failed_row(&variant.name, &inputs, error.to_string()),
    };
    let json = serde_json::to_string_pretty(&row).map_err(|e| Failure::new(e.to_string()))?;
    report.folder.add(ROW_FILE, json + "\n").map_err(ReportError::from)?;
    match row.failure {
        None => console.writing(|| report.write(&out, &arguments.pictures.formats))?,
        // A folder without figures has no page.
        Some(_) => console.writing(|| report.folder.write(Path::new(&out)))?,
    }
    Ok(row)
}

/// Hash of everything that a row depends on.
fn inputs_sha256(
    arguments: &Arguments,
    variant: &Variant,
    weights: &Weights,
    earlier: &Option<EarlierDesign>,
) -> String {
    let text = format!(
        "{} {} {:?} {:?} {:?} {} {}{}{}",
        env!("CARGO_PKG_VERSION"),
        machine_tag(&variant.machine, "", "").hash,
        weights,
        earlier,
        arguments.pid,
        arguments.quick,
        arguments.tightening,
        if arguments.no_polish { " no polish" } else { "" },
        arguments.pictures.further(),
    );
    sha256_hex(text.as_bytes())
}

fn finish(
    mut report: Report,
    rows: &[BatchRow],
    top_hz: f64,
    arguments: &Arguments,
    console: &Console,
) -> Result<CommandEnd, Failure> {
    let met = rows.iter().all(BatchRow::met);
    let sentence = verdict(rows);
    report.summary.set("run", "batch");
    report.summary.set("tool", tools_words(rows));
    report.summary.set("plain_words", sentences(rows));
    report.summary.set("table", overview(rows));
    report.verdict(met, &sentence);
    let table = table(rows);
    let out = arguments.out.as_str();
    if !arguments.no_table {
        report.folder.add_table("tools.csv", &table).map_err(ReportError::from)?;
        report.figures(figures(rows, top_hz))?;
        console.writing(|| report.write(out, &arguments.pictures.formats))?;
    }
    let head = ["tool", "specification", "μ at rest", "order", "stiffness with μ", "with PID", "zone", "stable to rpm"];
    let end = CommandEnd::met(met, sentence.as_str()).data(table.to_csv(), report.summary.value());
    let shown = end.row(head).rows(shown_rows(rows));
    Ok(if arguments.no_table {
        shown
    } else {
        shown.file(format!("{out}/report.html")).file(format!("{out}/tools.csv"))
    })
}
