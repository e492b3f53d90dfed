//! `muspin solve musys`: the certified peak of the μ upper bound of a stable system over all frequencies.

use super::clock::Clock;
use super::{Answer, Failure, ProblemFields};
use crate::robust::mu::peak::CERTIFICATE_SLACK;
use crate::robust::mu::system::MuSystem;

pub(super) fn solve(problem: &ProblemFields) -> Result<Answer, Failure> {
    if problem.has("w_range") {
        // The peak is over all frequencies; the range must be one all the same.
        problem.numbers("w_range")?;
    }
    let clock = Clock::of(problem)?;
    let system = MuSystem::new(&clock.plane_system(problem)?, &problem.blocks()?)?;
    let peak = system.peak(CERTIFICATE_SLACK)?;
    Ok(Answer::new()
        .with_number("peak_upper", peak.upper)
        .with_number("peak_lower", peak.bounds.lower)
        .with_number("lower_freq_rad_s", clock.true_frequency(peak.lower_omega_rad_s))
        .with_number("peak_freq_rad_s", clock.true_frequency(peak.omega_rad_s))
        .with_number("attained_upper", peak.attained))
}
