//! Lines of a sweep that something outside the loop disturbs: hum of the mains, run-out at multiples of the speed.
//!
//! A disturbed line scatters over its repeats more than its neighbours do, and its signals are no larger for it; noise
//! that a resonance of the loop amplifies grows with the signal there. With one repeat the experiments of the other
//! plane of axes, in which hardly anything responds, stand in for the scatter.

use super::frf::{AXES, MeasuredFrf, SweepRecord};
use crate::linalg::c64;

/// Neighbours on either side that a line is compared with; the nearest of them shares its leakage and is left out.
const NEIGHBOURS: usize = 6;
/// A line with fewer neighbours to compare with is taken as it is.
const FEWEST: usize = 4;
/// Rounds of gains and weights.
const ROUNDS: usize = 3;
/// Probability of a quiet line to count as disturbed, as −ln p: one record in a thousand has one among a thousand
/// lines.
const RARE: f64 = 14.0;
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
    /// Largest standard deviation of these lines relative to that of their neighbours.
    pub factor: f64,
}

impl PollutedLines {
    /// What is the matter, as a sentence without its end.
    pub fn words(&self) -> String {
        let lines: Vec<String> = self.hz.iter().map(|hz| format!("{hz:.1}")).collect();
        let from = match self.source {
            PollutionSource::Mains => "the mains",
            PollutionSource::Speed => "run-out or unbalance at multiples of the speed",
            PollutionSource::Unknown => "something outside the loop",
        };
        let (noun, verb) = if self.hz.len() == 1 { ("line", "scatters") } else { ("lines", "scatter") };
        format!(
            "the {noun} at {} Hz {verb} up to {:.1} times as much as the neighbours, from {from}",
            lines.join(", "),
            self.factor
        )
    }
}

/// The disturbed lines of a record, and the record without them; `sweep` is its index.
pub fn without_polluted_lines(
    (sweep, record): (usize, &SweepRecord),
    frf: &MeasuredFrf,
) -> (Vec<PollutedLines>, SweepRecord) {
    let excess = excess_of_lines(record, frf);
    let (_, _, repeats, _) = record.current.dim();
    let limit = MEDIAN_MARGIN * rare_ratio(degrees_of_freedom(repeats));
    let is_peak = |k: usize| {
        // A single repeat is compared with its neighbours, which a disturbed line disturbs.
        repeats > 1 || (k == 0 || excess[k] >= excess[k - 1]) && excess.get(k + 1).is_none_or(|next| excess[k] >= *next)
    };
    let polluted = with_skirts((0..excess.len()).map(|k| excess[k] > limit && is_peak(k)).collect(), &excess);
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
            None => list.push(PollutedLines { sweep, hz: vec![hz], source, factor }),
        }
    }
    list.sort_by_key(|own| own.source);
    let kept: Vec<usize> = (0..excess.len()).filter(|k| !polluted.contains(k)).collect();
    (list, record.with_lines(&kept))
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

/// Complex degrees of freedom of the scatter of a line over all axes and experiments. A single repeat has the two quiet
/// experiments of each axis, each less what its neighbours are off by.
fn degrees_of_freedom(repeats: usize) -> f64 {
    let each = if repeats > 1 { AXES * (repeats - 1) } else { 2 };
    (AXES * each) as f64
}

/// The ratio t that a mean of n exponentially distributed squares exceeds with the probability e^(−[`RARE`]) at most:
/// n (t − 1 − ln t) = [`RARE`] (Chernoff's bound).
fn rare_ratio(n: f64) -> f64 {
    let mut t = 1.0 + (2.0 * RARE / n).sqrt();
    // Newton's steps on a convex function from its right side.
    for _ in 0..20 {
        t -= (t - 1.0 - t.ln() - RARE / n) / (1.0 - 1.0 / t);
    }
    t
}

/// Scatter of every line relative to that of its neighbours, as power, mean over the axes; the smaller of the plain
/// ratio and of that relative to the power of the signals.
fn excess_of_lines(record: &SweepRecord, frf: &MeasuredFrf) -> Vec<f64> {
    let (lines, _, repeats, _) = record.current.dim();
    let scatter = if repeats > 1 { scatter_of_repeats(record, frf) } else { scatter_of_quiet_experiments(frf) };
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
        let median = median_near(values, (line, i), 1);
        if median > 0.0 { values[line][i] / median } else { 0.0 }
    };
    (0..AXES).map(ratio).sum::<f64>() / AXES as f64
}

/// Median of an axis over the lines near one, those up to `apart` from it left out; zero with fewer than four.
fn median_near(values: &[[f64; AXES]], (line, axis): (usize, usize), apart: usize) -> f64 {
    let range = line.saturating_sub(NEIGHBOURS)..(line + NEIGHBOURS + 1).min(values.len());
    let mut own: Vec<f64> = range.filter(|k| apart == 0 || k.abs_diff(line) > apart).map(|k| values[k][axis]).collect();
    own.sort_by(f64::total_cmp);
    if own.len() < FEWEST { 0.0 } else { own[own.len() / 2] }
}

/// Mean square of y − Ĝu over repeats and experiments, the gain of each repeat and axis taken out.
fn scatter_of_repeats(record: &SweepRecord, frf: &MeasuredFrf) -> Vec<[f64; AXES]> {
    let (lines, experiments, repeats, _) = record.current.dim();
    let predicted = |k: usize, e: usize, p: usize, i: usize| {
        (0..AXES).fold(c64::new(0.0, 0.0), |sum, j| sum + frf.response[(k, i, j)] * record.current[(k, e, p, j)])
    };
    let mut scatter = vec![[0.0; AXES]; lines];
    for i in 0..AXES {
        let mut gains = vec![0.0; repeats];
        // Gains and the noise that weighs their lines depend on each other only weakly.
        for _ in 0..ROUNDS {
            for (k, own) in scatter.iter_mut().enumerate() {
                let each = (0..experiments).flat_map(|e| gains.iter().enumerate().map(move |(p, gain)| (e, p, gain)));
                let off = |(e, p, gain): (usize, usize, &f64)| {
                    (record.signal[(k, e, p, i)] - predicted(k, e, p, i) * (1.0 + gain)).norm_sqr()
                };
                own[i] = each.map(off).sum::<f64>() / (experiments * (repeats - 1)) as f64;
            }
            let weight: Vec<f64> =
                (0..lines).map(|k| median_near(&scatter, (k, i), 0).max(f64::MIN_POSITIVE).recip()).collect();
            for (p, gain) in gains.iter_mut().enumerate() {
                let (mut top, mut bottom) = (0.0, f64::MIN_POSITIVE);
                for (k, weight) in weight.iter().enumerate() {
                    for e in 0..experiments {
                        let y = predicted(k, e, p, i);
                        top += weight * (y.conj() * (record.signal[(k, e, p, i)] - y)).re;
                        bottom += weight * y.norm_sqr();
                    }
                }
                *gain = top / bottom;
            }
            let mean = gains.iter().sum::<f64>() / repeats as f64;
            gains.iter_mut().for_each(|gain| *gain -= mean);
        }
    }
    scatter
}

/// Mean square of what the signals of the experiments in the other plane differ by from the mean of both neighbours.
fn scatter_of_quiet_experiments(frf: &MeasuredFrf) -> Vec<[f64; AXES]> {
    let lines = frf.len();
    let off = |k: usize, i: usize, e: usize| {
        if k == 0 || k + 1 >= lines {
            return 0.0;
        }
        let y = |k: usize| frf.signal[(k, i, e)];
        (y(k) - (y(k - 1) + y(k + 1)) * 0.5).norm_sqr()
    };
    let quiet = |k: usize, i: usize| (0..AXES).filter(move |e| e % 2 != i % 2).map(move |e| (k, i, e));
    (0..lines).map(|k| std::array::from_fn(|i| quiet(k, i).map(|(k, i, e)| off(k, i, e)).sum::<f64>() / 2.0)).collect()
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
