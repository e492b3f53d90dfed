//! `muspin spectra`: samples of force and response to a frequency response with coherence, as the CSV of a hammer
//! record; modes of a free decay.

use super::console::{CommandEnd, Console};
use super::{Failure, stdout};
use crate::identify::decay::decay_modes;
use crate::identify::spectra::{
    AveragedFrf, Averaging, Estimator, Excitation, Leakage, Motion, SpectralWindow, averaged_frf, clipped_samples,
};
use crate::input::time_record::{TimeRecord, TimeSignal, load_time_record};
use crate::linalg::c64;
use serde_json::json;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Time record (CSV, WAV, UFF, MAT); given again for every further tap
    #[arg(long, required = true)]
    time: Vec<String>,
    /// Signal of the force: column, channel from 1, node:direction, variable
    #[arg(long, required_unless_present = "decay")]
    force: Option<String>,
    /// Signal of the response; with --decay it may be given several times
    #[arg(long, required = true)]
    response: Vec<String>,
    /// What the response is
    #[arg(long, value_enum, default_value = "displacement")]
    motion: Motion,
    /// N in a unit of the force signal; negative for a sensor that points the other way
    #[arg(long, default_value_t = 1.0, allow_hyphen_values = true)]
    force_scale: f64,
    /// m, m/s or m/s² in a unit of the response signal
    #[arg(long, default_value_t = 1.0, allow_hyphen_values = true)]
    response_scale: f64,
    /// Samples a second, Hz, where the file does not say it
    #[arg(long)]
    sample_rate_hz: Option<f64>,
    /// Noise is that of the response (h1), of the force (h2) or of both (hv)
    #[arg(long, value_enum, default_value = "h1")]
    estimator: Estimator,
    /// Hann for what goes on, rectangular for taps that die away, exponential for taps that do not
    #[arg(long, value_enum, default_value = "hann")]
    window: SpectralWindow,
    /// Samples of a segment; default: a quarter of the record, without a Hann window all of it
    #[arg(long)]
    segment: Option<usize>,
    /// Share of a segment that the next one takes up again
    #[arg(long, default_value_t = 0.5)]
    overlap: f64,
    /// The response decays freely, without force: its modes with damping (JSON)
    #[arg(
        long,
        conflicts_with_all = ["force", "segment", "estimator", "overlap", "motion", "force_scale", "response_scale"]
    )]
    decay: bool,
    /// Start of the decay, s; default: the largest sample of the first response
    #[arg(long)]
    from_s: Option<f64>,
}

impl Arguments {
    /// Refuses numbers that no record has.
    fn check(&self) -> Result<(), Failure> {
        let scale = |x: f64| x.is_finite() && x != 0.0;
        let begins = |x: f64| x.is_finite() && x >= 0.0;
        let rate = |x: f64| x.is_finite() && x > 0.0;
        let (at_begin, no_decay) = (self.from_s.unwrap_or_default(), self.from_s.is_some() && !self.decay);
        let rules = [
            ("force-scale", self.force_scale, scale(self.force_scale), "a number other than zero"),
            ("response-scale", self.response_scale, scale(self.response_scale), "a number other than zero"),
            ("from-s", at_begin, begins(at_begin), "a time from zero on"),
            ("from-s", at_begin, !no_decay, "left out without --decay"),
            ("sample-rate-hz", self.sample_rate_hz.unwrap_or(1.0), self.sample_rate_hz.is_none_or(rate), "positive"),
        ];
        match rules.into_iter().find(|(.., holds, _)| !holds) {
            Some((name, value, _, rule)) => Err(Failure::new(format!("--{name}: {value} must be {rule}"))),
            None => Ok(()),
        }
    }
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    arguments.check()?;
    let records = arguments.time.iter().map(|file| load_time_record(file)).collect::<Result<Vec<_>, _>>()?;
    let rate = sample_rate_hz(arguments, &records)?;
    if arguments.decay {
        return decay(arguments, &records, rate);
    }
    let (force, response) = (arguments.force.as_deref().unwrap_or_default(), &arguments.response);
    let [response] = response.as_slice() else {
        return Err(Failure::new("--response: a frequency response has one").with_hint("call it again for the others"));
    };
    if force == response {
        return Err(Failure::new(format!("--response: {response:?} is the force")).with_hint("name two signals"));
    }
    let scaled_by = |signal: &[f64], scale: f64| signal.iter().map(|x| x * scale).collect::<Vec<f64>>();
    let mut signals = vec![];
    for record in &records {
        let (force, response) = (record.signal(force)?, record.signal(response)?);
        check_quantities(force, response, arguments.motion)?;
        for (signal, of) in [(force, "force"), (response, "response")] {
            clipped_words(&signal.samples).iter().for_each(|words| eprintln!("note: the {of} {words}"));
        }
        let (force, response) = (&force.samples, &response.samples);
        signals.push((scaled_by(force, arguments.force_scale), scaled_by(response, arguments.response_scale)));
    }
    let excitations: Vec<Excitation<'_>> =
        signals.iter().map(|(force, response)| Excitation { force, response }).collect();
    let averaging = Averaging {
        window: arguments.window,
        estimator: arguments.estimator,
        segment: arguments.segment,
        overlap: arguments.overlap,
    };
    let found = averaged_frf(&excitations, rate, &averaging).map_err(|words| {
        Failure::new(words).with_hint("choose --segment, --overlap and --window, or take longer records")
    })?;
    let notes = notes(&found);
    notes.iter().for_each(|words| eprintln!("note: {words}"));
    let lines = found.frequency_hz.iter().zip(&found.response);
    let compliance: Vec<c64> =
        lines.map(|(hz, h)| h * arguments.motion.to_displacement(*hz, found.added_damping_hz)).collect();
    write(&found, &compliance, console)
}

fn sample_rate_hz(arguments: &Arguments, records: &[TimeRecord]) -> Result<f64, Failure> {
    let mut rate = arguments.sample_rate_hz;
    for own in records.iter().filter_map(|r| r.sample_rate_hz) {
        // Times that are printed with four digits make a rate of four digits.
        if rate.is_some_and(|rate: f64| (rate / own - 1.0).abs() > 1e-3) {
            return Err(Failure::new("the records, or --sample-rate-hz, have different sample rates")
                .with_hint("records of one call are taken at one rate"));
        }
        rate = rate.or(Some(own));
    }
    rate.filter(|rate| rate.is_finite() && *rate > 0.0).ok_or_else(|| {
        Failure::new("no sample rate").with_hint("give --sample-rate-hz, or a column time_s in the file")
    })
}

/// Refuses signals whose units, where the file states them, are not those of a force and of the motion.
fn check_quantities(force: &TimeSignal, response: &TimeSignal, motion: Motion) -> Result<(), Failure> {
    let motion_of = |[length, time, newton]: [i32; 3]| match newton {
        0 => Motion::of_exponents([length, time]),
        _ => None,
    };
    if force.dimensions.is_some_and(|dimensions| dimensions != [0, 0, 1]) {
        return Err(Failure::new(format!("--force: the file states that {:?} is no force", force.name)));
    }
    match response.dimensions.map(motion_of) {
        Some(None) => Err(Failure::new(format!("--response: the file states that {:?} is no motion", response.name))),
        Some(Some(stated)) if stated != motion => {
            let (name, stated) = (&response.name, stated.name());
            let words = format!("--response: the file states that {name:?} is of {stated}, not {}", motion.name());
            Err(Failure::new(words).with_hint(format!("add --motion {stated}")))
        }
        _ => Ok(()),
    }
}

/// What is to be said of a signal whose largest values are cut off, if they are.
fn clipped_words(samples: &[f64]) -> Option<String> {
    let clipped = clipped_samples(samples);
    (clipped > 0)
        .then(|| format!("is cut off at its largest values ({clipped} samples): what is read from it is wrong"))
}

/// What is to be said of a response.
fn notes(found: &AveragedFrf) -> Vec<String> {
    let resolution = found.frequency_hz.first().copied().unwrap_or(0.0);
    let mut notes = vec![format!(
        "{} segments of {} samples, lines of {resolution:.4} Hz, as good as {:.1} independent averages",
        found.segments, found.segment, found.averages
    )];
    if found.segments == 1 {
        notes.push("a single segment has no coherence: its column is left out".to_owned());
    }
    match found.leakage {
        Leakage::OfPeak { frequency_hz, relative_error } => notes.push(format!(
            "leakage: the highest peak, at {frequency_hz:.2} Hz, is wrong by {:.1} % of its size, judged by segments \
             half as long",
            100.0 * relative_error
        )),
        Leakage::LeftAtEnd(part) => notes.push(format!(
            "leakage: {:.1} % of the response are left at the end of the segments, noise included",
            100.0 * part
        )),
    }
    if found.added_damping_hz > 0.0 {
        notes.push(format!(
            "the exponential window adds {:.4} Hz to damping ratio times frequency of every mode",
            found.added_damping_hz
        ));
    }
    notes
}

fn write(found: &AveragedFrf, compliance: &[c64], console: &Console) -> Result<CommandEnd, Failure> {
    let coherent = found.segments > 1;
    if console.writes_data() {
        stdout::data(|out| {
            writeln!(out, "frequency_hz,h_re,h_im{}", if coherent { ",coherence,averages" } else { "" })?;
            for (k, h) in compliance.iter().enumerate() {
                write!(out, "{},{:e},{:e}", found.frequency_hz[k], h.re, h.im)?;
                if coherent {
                    // Readers take a coherence above zero.
                    write!(out, ",{:e},{}", found.coherence[k].max(f64::MIN_POSITIVE), found.averages.max(1.0))?;
                }
                writeln!(out)?;
            }
            Ok(())
        })?;
        return Ok(CommandEnd::without_answer(true));
    }
    let parts = |part: fn(&c64) -> f64| compliance.iter().map(part).collect::<Vec<f64>>();
    let columns = json!({
        "frequency_hz": found.frequency_hz,
        "h_re": parts(|h| h.re),
        "h_im": parts(|h| h.im),
        "coherence": coherent.then_some(&found.coherence),
        "averages": found.averages,
        "added_damping_hz": found.added_damping_hz,
    });
    Ok(CommandEnd::done(format!("{} lines", compliance.len()))
        .data(String::new(), columns)
        .next("the same command with > hammer.csv writes a hammer record, --json prints its columns"))
}

fn decay(arguments: &Arguments, records: &[TimeRecord], rate: f64) -> Result<CommandEnd, Failure> {
    let [record] = records else {
        return Err(Failure::new("--decay: one record").with_hint("modes of several decays are found one by one"));
    };
    let names = arguments.response.iter();
    let signals =
        names.map(|name| record.signal(name).map(|s| s.samples.as_slice())).collect::<Result<Vec<&[f64]>, _>>()?;
    for words in signals.iter().filter_map(|signal| clipped_words(signal)) {
        eprintln!("note: a response {words}");
    }
    let first = signals.first().copied().unwrap_or_default();
    let largest = || (0..first.len()).max_by(|a, b| first[*a].abs().total_cmp(&first[*b].abs())).unwrap_or(0);
    let from = arguments.from_s.map_or_else(largest, |from| (from * rate).round().max(0.0) as usize);
    if from >= first.len() {
        return Err(Failure::new("--from-s lies behind the end of the record").with_hint("it counts from the start"));
    }
    let modes = decay_modes(&signals, rate, from);
    let list: Vec<_> = modes
        .iter()
        .map(|mode| {
            json!({
                "frequency_hz": mode.frequency_hz,
                "standard_deviation_hz": mode.standard_deviation_hz,
                "damping_ratio": mode.damping_ratio,
                "damping_ratio_standard_deviation": mode.standard_deviation_hz / mode.frequency_hz,
            })
        })
        .collect();
    let answer = json!({ "from_s": from as f64 / rate, "modes": list });
    let rows = modes.iter().map(|mode| {
        let (hz, sd) = (mode.frequency_hz, mode.standard_deviation_hz);
        vec![format!("{hz:.3}"), format!("{sd:.4}"), format!("{:.6}", mode.damping_ratio), format!("{:.6}", sd / hz)]
    });
    Ok(CommandEnd::met(!modes.is_empty(), format!("{} modes of the decay", modes.len()))
        .answer(&answer)
        .row(["Hz", "standard deviation, Hz", "damping ratio", "standard deviation"])
        .rows(rows))
}
