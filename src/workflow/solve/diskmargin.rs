//! `muspin solve diskmargin`: the disc margins of a loop transfer, of each channel and of all at once, for the skews of
//! S, T and S − T, or for those asked.

use super::answer::number;
use super::clock::Clock;
use super::{Answer, Failure, ProblemFields};
use crate::linalg::Mat;
use crate::robust::disc_margin::{DiscMargin, channel_margin, multiloop_margin, sensitivity};
use serde_json::{Value, json};

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    let clock = Clock::of(problem)?;
    let sign = if problem.has("sign") { problem.number("sign")? } else { -1.0 };
    if sign.abs() != 1.0 {
        return Err(problem.failure("sign", format!("must be -1 or 1, found {sign}")).into());
    }
    let skews = if problem.has("skew") { problem.numbers("skew")? } else { vec![1.0, -1.0, 0.0] };
    let given = clock.plane_system(problem)?;
    let n = given.outputs();
    let l = given.scale_outputs(&Mat::from_fn(n, n, |i, j| if i == j { -sign } else { 0.0 }));
    let s = sensitivity(&l)?;
    let stated = |margin: &DiscMargin| {
        let (least, most) = margin.gain_margin();
        Answer::new()
            .with_number("skew", margin.skew)
            .with_number("alpha", margin.alpha)
            .with_number("alpha_upper", margin.alpha_upper)
            .with("gain_margin", vec![number(least), number(most)])
            .with_number("phase_margin_deg", margin.phase_margin_rad().to_degrees())
            .with_number("freq_rad_s", clock.true_frequency(margin.omega_rad_s))
    };
    let mut channels: Vec<Value> = vec![];
    for channel in 0..s.outputs() {
        let margins: Result<Vec<Value>, Failure> =
            skews.iter().map(|skew| Ok(stated(&channel_margin(&s, channel, *skew)?).into())).collect();
        channels.push(json!(margins?));
    }
    let together: Result<Vec<Value>, Failure> =
        skews.iter().map(|skew| Ok(stated(&multiloop_margin(&s, *skew)?).into())).collect();
    Ok(Answer::new().with("channels", channels).with("multiloop", together?))
}
