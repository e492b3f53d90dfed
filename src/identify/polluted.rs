//! Lines of a sweep that something outside the loop disturbs: hum of the mains, run-out at multiples of the speed.
//!
//! A disturbed line scatters over its repeats more than its neighbours do, and its signals are no larger for it; noise
//! that a resonance of the loop amplifies grows with the signal there. A single repeat does not tell. Hum whose
//! phase hardly moves from one repeat to the next is alike in all of them: it shows where lines at multiples of the
//! mains leave the model and their neighbours do not.

use super::frf::{AXES, MeasuredFrf, SweepRecord};
use super::repeat_scatter::{RepeatScatter, rare_ratio};

/// Neighbours on either side that a line is compared with.
const NEIGHBOURS: usize = 6;
/// A line with fewer neighbours to compare with is taken as it is.
const FEWEST: usize = 4;
/// What the medians of some eleven neighbours may be too low by.
const MEDIAN_MARGIN: f64 = 1.5;
/// Excess, as power, of a line beside a disturbed one that counts as its skirt: as much disturbance as noise.
const SKIRT: f64 = 2.0;
/// Most multiples of the mains frequency that are looked for: beyond, they are as dense as the lines.
const MAINS_MULTIPLES: usize = 8;
/// Deviation of the mains, and how far a line beside its multiple still shows it.
const MAINS_RELATIVE: f64 = 0.004;
const MAINS_LINE_HZ: f64 = 0.5;

/// Where the disturbance of a line comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PollutionSource {
    /// The mains, 50 or 60 Hz and multiples.
    Mains,
    /// Multiples of the speed.
    Speed,
    /// Neither.
    Unknown,
}

impl PollutionSource {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mains => "mains",
            Self::Speed => "speed",
            Self::Unknown => "unknown",
        }
    }
}

/// Disturbed lines of one record, of one source.
#[derive(Clone, Debug, PartialEq)]
pub struct PollutedLines {
    /// Index of the sweep among the records.
    pub sweep: usize,
    /// The lines, Hz, ascending.
    pub hz: Vec<f64>,
    /// Where it comes from.
    pub source: PollutionSource,
    /// Largest standard deviation of these lines, or distance from the model, relative to that of their neighbours.
    pub factor: f64,
    /// Whether it is alike in every repeat, so that the model alone shows it.
    pub steady: bool,
}

/// Ratio of lines that a sentence takes together: the skirts of one sharp resonance.
const SAME_PLACE: f64 = 1.01;

impl PollutedLines {
    /// What is the matter, as a sentence without its end.
    pub fn words(&self) -> String {
        let groups = self.hz.chunk_by(|a, b| *b < SAME_PLACE * a).map(|group| match group {
            [first, .., last] => format!("{first:.1} to {last:.1} ({} of them)", group.len()),
            _ => group.iter().map(|hz| format!("{hz:.1}")).collect(),
        });
        let place = match self.source {
            PollutionSource::Mains => ", at multiples of the mains frequency",
            PollutionSource::Speed => ", beside multiples of the speed as run-out and unbalance are",
            PollutionSource::Unknown => ", for a reason that their frequencies do not tell",
        };
        let verb = if self.steady { "leave" } else { "scatter" };
        let (noun, ending) = if self.hz.len() == 1 { ("line", "s") } else { ("lines", "") };
        let from = if self.steady { " the model, alike in every repeat," } else { "" };
        format!(
            "the {noun} at {} Hz {verb}{ending}{from} up to {:.1} times as much as the neighbours{place}",
            groups.collect::<Vec<String>>().join(", "),
            self.factor
        )
    }
}

/// The disturbed lines of a record, and the record without them; `sweep` is its index.
pub fn without_polluted_lines(
    sweep: usize,
    record: &SweepRecord,
    frf: &MeasuredFrf,
) -> (Vec<PollutedLines>, SweepRecord) {
    let repeats = record.repeats();
    if repeats < 2 {
        return (vec![], record.clone());
    }
    let excess = excess_of_lines(record, frf);
    // Complex degrees of freedom of the scatter of a line over all axes and experiments.
    let limit = MEDIAN_MARGIN * rare_ratio((AXES * AXES * (repeats - 1)) as f64);
    let polluted = with_skirts(excess.iter().map(|own| *own > limit).collect(), &excess);
    if polluted.is_empty() {
        return (vec![], record.clone());
    }
    let mut list: Vec<PollutedLines> = vec![];
    for line in &polluted {
        let (source, hz) = (source_of(*line, record), record.frequency_hz[*line]);
        let factor = excess[*line].sqrt();
        match list.iter_mut().find(|own| own.source == source) {
            Some(own) => {
                own.hz.push(hz);
                own.factor = own.factor.max(factor);
            }
            None => list.push(PollutedLines { sweep, hz: vec![hz], source, factor, steady: false }),
        }
    }
    list.sort_by_key(|own| own.source);
    let kept: Vec<usize> = (0..excess.len()).filter(|k| !polluted.contains(k)).collect();
    let run_out = list.iter().any(|own| own.source == PollutionSource::Speed);
    (list, SweepRecord { run_out, ..record.with_lines(&kept) })
}

/// Hum that is alike in every repeat, and the record without its lines: those round multiples of the mains frequency
/// whose squared distances from the model, `misfit`, mean over all channels in σ², stand out of their neighbours.
pub fn without_steady_hum(sweep: usize, record: &SweepRecord, misfit: &[f64]) -> Option<(PollutedLines, SweepRecord)> {
    let hz = &record.frequency_hz;
    if misfit.len() != hz.len() {
        return None;
    }
    let excess: Vec<f64> = (0..hz.len())
        .map(|k| match median_near(misfit, k, |apart| apart > 1) {
            median if median > 0.0 => misfit[k] / median,
            _ => 0.0,
        })
        .collect();
    // One complex square a channel.
    let limit = MEDIAN_MARGIN * rare_ratio((AXES * AXES) as f64);
    let beside = |k: usize| mains_multiples().any(|f| is_next_to(hz, k, f));
    let hum = with_skirts((0..hz.len()).map(|k| excess[k] > limit && beside(k)).collect(), &excess);
    let factor = hum.iter().map(|k| excess[*k]).reduce(f64::max)?.sqrt();
    let kept: Vec<usize> = (0..hz.len()).filter(|k| !hum.contains(k)).collect();
    let lines = hum.iter().map(|k| hz[*k]).collect();
    let polluted = PollutedLines { sweep, hz: lines, source: PollutionSource::Mains, factor, steady: true };
    Some((polluted, record.with_lines(&kept)))
}

/// Multiples of the mains frequencies, Hz.
fn mains_multiples() -> impl Iterator<Item = f64> {
    [50.0, 60.0].into_iter().flat_map(|base| (1..=MAINS_MULTIPLES).map(move |multiple| base * multiple as f64))
}

/// Whether line `k` is the nearest below or above a frequency that lies in the band.
fn is_next_to(hz: &[f64], k: usize, of_hz: f64) -> bool {
    let above = hz.partition_point(|f| *f < of_hz);
    above > 0 && above < hz.len() && (k == above || k + 1 == above)
}

/// The numbers of the lines that are disturbed, with those beside them that still scatter more than theirs: leakage
/// falls off line by line.
fn with_skirts(mut is_polluted: Vec<bool>, excess: &[f64]) -> Vec<usize> {
    let mut grows = true;
    while grows {
        grows = false;
        for k in 0..excess.len() {
            let beside = k > 0 && is_polluted[k - 1] || is_polluted.get(k + 1) == Some(&true);
            if !is_polluted[k] && beside && excess[k] > SKIRT {
                is_polluted[k] = true;
                grows = true;
            }
        }
    }
    (0..excess.len()).filter(|k| is_polluted[*k]).collect()
}

/// Scatter of every line relative to that of its neighbours, as power, mean over the axes; the smaller of the plain
/// ratio and of that relative to the power of the signals.
fn excess_of_lines(record: &SweepRecord, frf: &MeasuredFrf) -> Vec<f64> {
    let lines = frf.len();
    let medians = |values: &[f64]| (0..values.len()).map(|k| median_near(values, k, |_| true)).collect();
    let scatter = RepeatScatter::of(record, frf, &medians).scatter;
    let power: Vec<[f64; AXES]> = (0..lines)
        .map(|k| std::array::from_fn(|i| (0..AXES).map(|e| frf.signal[(k, i, e)].norm_sqr()).sum()))
        .collect();
    let relative: Vec<[f64; AXES]> =
        scatter.iter().zip(&power).map(|(s, p)| std::array::from_fn(|i| s[i] / p[i].max(f64::MIN_POSITIVE))).collect();
    (0..lines).map(|k| over_neighbours(&scatter, k).min(over_neighbours(&relative, k))).collect()
}

/// A line of `values` over the median of its neighbours, mean over the axes; zero where there is nothing to compare.
fn over_neighbours(values: &[[f64; AXES]], line: usize) -> f64 {
    let ratio = |i: usize| {
        let axis: Vec<f64> = values.iter().map(|own| own[i]).collect();
        // The nearest neighbours share the leakage of a line.
        let median = median_near(&axis, line, |apart| apart > 1);
        if median > 0.0 { values[line][i] / median } else { 0.0 }
    };
    (0..AXES).map(ratio).sum::<f64>() / AXES as f64
}

/// Median of the values near a line, those at a distance that counts; zero where fewer than [`FEWEST`] do.
fn median_near(values: &[f64], line: usize, counts: impl Fn(usize) -> bool) -> f64 {
    let range = line.saturating_sub(NEIGHBOURS)..(line + NEIGHBOURS + 1).min(values.len());
    let mut own: Vec<f64> = range.filter(|k| counts(k.abs_diff(line))).map(|k| values[k]).collect();
    own.sort_by(f64::total_cmp);
    if own.len() < FEWEST { 0.0 } else { own[own.len() / 2] }
}

/// The source of a disturbed line: a multiple of the speed between its neighbours, or a multiple of the mains close by.
fn source_of(line: usize, record: &SweepRecord) -> PollutionSource {
    let at = |k: usize| record.frequency_hz[k];
    let hz = at(line);
    let below = if line > 0 { at(line - 1) } else { 0.0 };
    let above = record.frequency_hz.get(line + 1).copied().unwrap_or(hz);
    let has_multiple = |of_hz: f64| (below / of_hz).floor() < (above / of_hz).floor();
    let mains = [50.0, 60.0].into_iter().any(|base| {
        let multiple = (hz / base).round();
        let within = MAINS_RELATIVE * hz + MAINS_LINE_HZ;
        (1.0..=MAINS_MULTIPLES as f64).contains(&multiple) && (hz - multiple * base).abs() <= within
    });
    let turns_hz = record.speed_rpm.abs() / 60.0;
    let on_a_multiple = turns_hz > 0.0 && {
        let multiple = hz / turns_hz;
        (multiple - multiple.round()).abs() * turns_hz < MAINS_LINE_HZ
    };
    if mains && !on_a_multiple {
        PollutionSource::Mains
    } else if turns_hz > 0.0 && has_multiple(turns_hz) {
        PollutionSource::Speed
    } else {
        PollutionSource::Unknown
    }
}
