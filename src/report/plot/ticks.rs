//! Where an axis has its labelled ticks and its minor grid, and how numbers are written there.
//!
//! Linear: steps of 1, 2, 2.5, 5 × 10ⁿ. Logarithmic: decades, with 2 and 5 where there is room, minor lines at every
//! digit; less than half a decade is ticked like a linear axis. The decades are found with a tolerance, so that a range
//! that starts or ends exactly on a power of ten has its label there.

use super::figure::Scale;

/// Relative slack when a tick is compared with the end of its axis: rounding of powers of ten, far below a pixel.
const EDGE: f64 = 1e-9;

/// Ticks of one axis, ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ticks {
    /// Labelled positions with their text.
    pub major: Vec<(f64, String)>,
    /// Unlabelled grid lines.
    pub minor: Vec<f64>,
}

/// Ticks for `[low, high]` with at most about `room` labels; `step` fixes the distance on a linear axis.
pub(super) fn ticks(scale: Scale, [low, high]: [f64; 2], room: usize, step: Option<f64>) -> Ticks {
    match scale {
        Scale::Linear => linear(low, high, room, step),
        Scale::Log => logarithmic(low, high, room),
    }
}

/// The smallest range of round numbers round `[low, high]`: what a data range is widened to.
pub(super) fn round_range(scale: Scale, [low, high]: [f64; 2]) -> [f64; 2] {
    match scale {
        Scale::Linear => {
            let step = nice_step(high - low, 10);
            let snap = |x: f64| if x.abs() < EDGE * step { 0.0 } else { x };
            [snap((low / step + EDGE).floor() * step), snap((high / step - EDGE).ceil() * step)]
        }
        Scale::Log => {
            let decade = |x: f64| 10f64.powf((x.log10() + EDGE).floor());
            let down = |x: f64| {
                let digit = x / decade(x) * (1.0 + EDGE);
                decade(x) * [5.0, 2.0].into_iter().find(|d| digit >= *d).unwrap_or(1.0)
            };
            let up = |x: f64| {
                let digit = x / decade(x) * (1.0 - EDGE);
                decade(x) * [1.0, 2.0, 5.0].into_iter().find(|d| digit <= *d).unwrap_or(10.0)
            };
            [down(low), up(high)]
        }
    }
}

/// A step of 1, 2, 2.5 or 5 × 10ⁿ that divides `span` into at most `parts`.
fn nice_step(span: f64, parts: usize) -> f64 {
    let raw = span / parts.max(1) as f64;
    if !(raw.is_finite() && raw > 0.0) {
        return 1.0;
    }
    let decade = 10f64.powf(raw.log10().floor());
    let digit = raw / decade * (1.0 - EDGE);
    decade * [1.0, 2.0, 2.5, 5.0].into_iter().find(|d| *d >= digit).unwrap_or(10.0)
}

fn linear(low: f64, high: f64, room: usize, step: Option<f64>) -> Ticks {
    let span = high - low;
    let step = match step {
        // A fixed step that would crowd the axis is doubled until it fits.
        Some(s) if s > 0.0 => {
            let mut s = s;
            while span / s > room.max(2) as f64 {
                s *= 2.0;
            }
            s
        }
        _ => nice_step(span, room),
    };
    let digit = step / 10f64.powf(step.log10().floor());
    let parts = if (digit - 2.0).abs() < 0.1 { 4.0 } else { 5.0 };
    let slack = EDGE * span;
    let positions = |step: f64| {
        let first = ((low - slack) / step).ceil() as i64;
        let last = ((high + slack) / step).floor() as i64;
        // A thousand lines are more than any axis shows; the bound only guards against a degenerate range.
        (first..=last.min(first.saturating_add(1000))).map(move |k| k as f64 * step)
    };
    let major: Vec<f64> = positions(step).collect();
    let largest = low.abs().max(high.abs());
    Ticks {
        minor: positions(step / parts).filter(|x| major.iter().all(|m| (m - x).abs() > 0.01 * step)).collect(),
        major: major.iter().map(|x| (*x, linear_label(*x, step, largest))).collect(),
    }
}

fn logarithmic(low: f64, high: f64, room: usize) -> Ticks {
    let decades = (high / low).log10();
    if decades < 0.5 {
        return linear(low, high, room, None);
    }
    let within = |x: &f64| *x >= low * (1.0 - EDGE) && *x <= high * (1.0 + EDGE);
    let first = (low.log10() - EDGE).floor() as i32;
    let last = (high.log10() + EDGE).ceil() as i32;
    let digits_of = |digits: &'static [i32]| {
        (first..=last).flat_map(move |e| digits.iter().map(move |d| power(*d, e))).filter(within)
    };
    const ALL: &[i32] = &[1, 2, 3, 4, 5, 6, 7, 8, 9];
    let mut labelled: Vec<f64> = [ALL, &[1, 2, 5], &[1, 3]]
        .into_iter()
        .map(|digits| digits_of(digits).collect::<Vec<f64>>())
        .find(|candidate| candidate.len() <= room)
        .unwrap_or_default();
    if labelled.is_empty() {
        let every = (decades / room.max(2) as f64).ceil().max(1.0) as i32;
        labelled = (first..=last).filter(|e| e.rem_euclid(every) == 0).map(|e| power(1, e)).filter(within).collect();
    }
    // Beyond a dozen decades the single digits would be a grey area.
    let minor = if decades <= 12.0 { digits_of(ALL).collect() } else { Vec::new() };
    Ticks {
        minor: minor.into_iter().filter(|x: &f64| !labelled.contains(x)).collect(),
        major: labelled.iter().map(|x| (*x, log_label(*x))).collect(),
    }
}

/// d · 10ᵉ, correctly rounded by the decimal parser.
fn power(digit: i32, exponent: i32) -> f64 {
    format!("{digit}e{exponent}").parse().unwrap_or(f64::NAN)
}

fn linear_label(x: f64, step: f64, largest: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if largest >= 1e5 || step < 1e-4 {
        return scientific(x);
    }
    let decimals = (0..=6).find(|d| {
        let scaled = step * 10f64.powi(*d);
        (scaled - scaled.round()).abs() < 1e-6 * scaled
    });
    write_sign(format!("{x:.*}", decimals.unwrap_or(6) as usize))
}

fn log_label(x: f64) -> String {
    if (0.0099..=20_001.0).contains(&x) { format!("{x}") } else { scientific(x) }
}

/// `2.5×10⁻⁷`, `10⁶`.
fn scientific(x: f64) -> String {
    let text = format!("{x:.2e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    let superscript: String = exponent.chars().map(raised).collect();
    match mantissa {
        "1" => format!("10{superscript}"),
        "-1" => format!("−10{superscript}"),
        m => write_sign(format!("{m}×10{superscript}")),
    }
}

/// A true minus sign instead of the hyphen; no negative zero.
fn write_sign(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}
