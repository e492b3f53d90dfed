//! Slips of cables and columns that leave every response plausible: a column that is there twice, a pair of sensors
//! that counts double, RMS beside peak values, the hold once too often or not at all. A record without them has no such
//! check.

use super::Check;
use super::checks::MeasuredRecord;
use super::spectrum::median;
use crate::identify::frf::{AXES, AXIS_NAMES};
use crate::linalg::c64;
use crate::lti::held::hold_magnitude;
use ndarray::Array3;
use std::f64::consts::{LN_2, TAU};

/// Relative difference within which two columns are the same numbers, or one is a multiple of the other: records are
/// printed with six digits. Signals of two axes differ by noise alone a hundred times as much.
const SAME_NUMBERS: f64 = 1e-5;
/// Largest difference of ln of a ratio from that of a factor: x and y of a plane see the same rotor, within some per
/// cent of their sensors and magnets.
const SAME_PLANE: f64 = 0.06;
/// The same against the nominal machine, whose ki, ks and gains are known to some per cent.
const NOMINAL: f64 = 0.15;
/// Smallest |ln sinc(fT)| at the highest line at which the hold is looked for: 2 %, the size of errors of gain.
const HOLD_SHOWS: f64 = 0.02;
/// Largest difference from one hold of what the currents show, in holds.
const ONE_HOLD: f64 = 0.3;

/// The slips that a sweep shows.
pub(crate) fn slips(measured: &MeasuredRecord<'_>) -> Vec<Check> {
    let found = [
        repeated_column(&measured.frf.signal, "signal"),
        repeated_column(&measured.frf.current, "current"),
        factor_within_plane(measured),
        doubled_plane(measured),
        hold(measured),
    ];
    found.into_iter().flatten().collect()
}

/// Two columns that are the same numbers on every line, or one twice the other.
fn repeated_column(data: &Array3<c64>, what: &str) -> Option<Check> {
    let pairs = (0..AXES).flat_map(|a| (0..AXES).map(move |b| (a, b))).filter(|(a, b)| a != b);
    let mut factors = pairs.flat_map(|(a, b)| [(a, b, 1.0), (a, b, 2.0)]);
    let is_multiple = |&(a, b, factor): &(usize, usize, f64)| {
        data.outer_iter().all(|line| {
            let (first, second) = (line.row(a), line.row(b));
            first.iter().zip(second).all(|(x, y)| (x - y * factor).norm() <= SAME_NUMBERS * x.norm())
                && first.iter().any(|x| x.norm() > 0.0)
        })
    };
    let (a, b, factor) = factors.find(is_multiple)?;
    Some(Check {
        name: "repeated_column",
        value: factor,
        expected: "columns of their own".into(),
        ok: false,
        decides: true,
        words: format!(
            "the {what}s of {} and {} are the same numbers{} on every line: a column was written twice, or two inputs \
             hang on one sensor",
            AXIS_NAMES[a],
            AXIS_NAMES[b],
            if factor == 1.0 { "" } else { " but for a factor of 2" }
        ),
    })
}

/// Signals or currents of x and y of a plane that stand at 2 or √2 to each other.
fn factor_within_plane(m: &MeasuredRecord<'_>) -> Option<Check> {
    // By sign: whether the first or the second axis has more.
    let candidates = [LN_2, -LN_2, 0.5 * LN_2, -0.5 * LN_2];
    for plane in 0..2 {
        let (x, y) = (2 * plane, 2 * plane + 1);
        let (far_x, far_y) = ((x + 2) % AXES, (y + 2) % AXES);
        let ratio = |first: (usize, usize), second: (usize, usize)| {
            let each = |line: usize| {
                m.measured_log(line, first.0, first.1).magnitude - m.measured_log(line, second.0, second.1).magnitude
            };
            median((0..m.data.entries.len()).map(each))
        };
        let coaxial = ratio((x, x), (y, y))?;
        let of_signals = ratio((x, far_x), (y, far_y))?;
        let of_currents = ratio((far_x, x), (far_y, y))?;
        let near = |value: f64, wanted: f64| (value - wanted).abs() < SAME_PLANE;
        for ln_factor in candidates.into_iter().filter(|f| near(coaxial, *f)) {
            let what = if near(of_signals, ln_factor) && near(of_currents, 0.0) {
                "signal"
            } else if near(of_currents, ln_factor) && near(of_signals, 0.0) {
                "current"
            } else {
                continue;
            };
            // A current that is written twice as large halves the response.
            let has_more = (ln_factor > 0.0) == (what == "signal");
            let (more, less) = if has_more { (x, y) } else { (y, x) };
            let cause = if ln_factor.abs() == LN_2 {
                "two sensors that are added and not averaged, or peak-to-peak beside peak"
            } else {
                "RMS beside peak values"
            };
            return Some(Check {
                name: "factor_between_axes",
                value: coaxial.abs().exp(),
                expected: "neither 2 nor √2".into(),
                ok: false,
                decides: false,
                words: format!(
                    "the {what} of {} stands at {:.3} times that of {}, though both see the same rotor: {cause}",
                    AXIS_NAMES[more],
                    coaxial.abs().exp(),
                    AXIS_NAMES[less]
                ),
            });
        }
    }
    None
}

/// Both signals of a plane twice or half as large as the nominal machine has them, those of the other as it has them.
fn doubled_plane(m: &MeasuredRecord<'_>) -> Option<Check> {
    let off = |output: usize, input: usize| {
        let each = |line: usize| m.measured_log(line, output, input).magnitude - m.model(line, output, input).magnitude;
        median((0..m.data.entries.len()).map(each))
    };
    for plane in 0..2 {
        for ln_factor in [LN_2, -LN_2] {
            let fits = (0..AXES).all(|output| {
                let wanted = if output / 2 == plane { ln_factor } else { 0.0 };
                [output, (output + 2) % AXES]
                    .into_iter()
                    .all(|input| off(output, input).is_some_and(|found| (found - wanted).abs() < NOMINAL))
            });
            if fits {
                let name = ["front", "rear"][plane];
                return Some(Check {
                    name: "doubled_plane",
                    value: ln_factor.exp(),
                    expected: "1".into(),
                    ok: false,
                    decides: false,
                    words: format!(
                        "both signals of the {name} plane are {} times what the nominal machine gives: a pair of \
                         sensors that is added and not averaged, or the diameter for the radius",
                        ln_factor.exp()
                    ),
                });
            }
        }
    }
    None
}

/// u against K y in the plane that has no injection: what is left over frequency is the hold, once more or once less
/// than the record says.
fn hold(m: &MeasuredRecord<'_>) -> Option<Check> {
    let controller = m.controller?;
    let period_s = m.machine.spindle.electronics.sample_period_s();
    let mut pairs = vec![];
    for (line, hz) in m.lines.iter().zip(&m.data.frequency_hz) {
        let k = controller.held_at(TAU * hz);
        if k.nrows() != AXES || k.ncols() != AXES {
            return None;
        }
        let each = (0..AXES).filter_map(|experiment| {
            let other = (experiment + 2) % AXES;
            let predicted = (0..AXES).map(|j| k[(other, j)] * m.frf.signal[(*line, j, experiment)]).sum::<c64>();
            let ratio = (m.frf.current[(*line, other, experiment)].norm() / predicted.norm()).ln();
            ratio.is_finite().then_some(ratio)
        });
        pairs.push((hold_magnitude(TAU * hz, period_s).ln(), median(each)?));
    }
    let shows = pairs.iter().any(|(hold, _)| hold.abs() > HOLD_SHOWS);
    let squares: f64 = pairs.iter().map(|(hold, _)| hold * hold).sum();
    let holds = pairs.iter().map(|(hold, ratio)| hold * ratio).sum::<f64>() / squares;
    let rest: f64 = pairs.iter().map(|(hold, ratio)| (ratio - holds * hold).powi(2)).sum();
    // What one hold explains has to be more than what it leaves.
    if !shows || (holds.abs() - 1.0).abs() > ONE_HOLD || rest > 0.1 * squares {
        return None;
    }
    let words = if holds > 0.0 {
        "the currents are smaller than what the named controller commands by one hold more than they should be: leave \
         out hold: true, they were logged behind the hold"
    } else {
        "the currents are larger than what the named controller commands by the hold: write hold: true, they were \
         logged before it"
    };
    Some(Check { name: "hold", value: holds, expected: "0".into(), ok: false, decides: false, words: words.to_owned() })
}
