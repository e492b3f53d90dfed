//! Speeds on the command line, in rpm: `0:1000:5000` (start:step:end), `0,1000,2000`, and mixtures of both.

use std::str::FromStr;

/// Largest speed that is read, rpm: no shaft of a tool spindle or a turbine turns faster.
const LARGEST_RPM: f64 = 1e6;
/// Most speeds of one call: each costs the modes or the loops of a machine.
const MOST_SPEEDS: usize = 1000;
/// Share of a step by which the end of a range may be missed: the decimal digits of the step.
const END_TOLERANCE: f64 = 1e-9;

/// Speeds in the order in which they are given, rpm; at least one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SpeedList(pub Vec<f64>);

impl FromStr for SpeedList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut speeds_rpm = vec![];
        for part in text.split(',') {
            let numbers = part.split(':').map(parse_speed).collect::<Result<Vec<f64>, String>>()?;
            match numbers[..] {
                [rpm] => speeds_rpm.push(rpm),
                [start, step, end] => speeds_rpm.extend(list_range(start, step, end)?),
                _ => return Err(format!("`{part}` is no range; write start:step:end, for example 0:1000:5000")),
            }
            if speeds_rpm.len() > MOST_SPEEDS {
                return Err(format!("more than {MOST_SPEEDS} speeds; take a larger step"));
            }
        }
        Ok(Self(speeds_rpm))
    }
}

fn parse_speed(text: &str) -> Result<f64, String> {
    let rpm = text.trim().parse::<f64>().ok().filter(|rpm| (0.0..=LARGEST_RPM).contains(rpm));
    rpm.ok_or_else(|| {
        format!("`{text}` is no speed in rpm from 0 to {LARGEST_RPM}; write for example 0,20000 or 0:1000:5000")
    })
}

/// From `start` in steps to the last speed that `end` does not exclude.
fn list_range(start: f64, step: f64, end: f64) -> Result<Vec<f64>, String> {
    if step <= 0.0 || end < start {
        return Err(format!(
            "{start}:{step}:{end} leads from no start to an end; the step is above zero, the end not below the start"
        ));
    }
    let steps = ((end - start) / step + END_TOLERANCE).floor();
    if steps >= MOST_SPEEDS as f64 {
        return Err(format!("{start}:{step}:{end} has more than {MOST_SPEEDS} speeds; take a larger step"));
    }
    Ok((0..=steps as usize).map(|k| (start + k as f64 * step).min(end)).collect())
}

/// The value of `--speeds` of a command that computes at one speed, rpm.
pub(super) fn parse_one_speed(text: &str) -> Result<f64, String> {
    match text.parse::<SpeedList>()?.0[..] {
        [rpm] => Ok(rpm),
        ref several => Err(format!("{} speeds are given; this command computes at one speed", several.len())),
    }
}
