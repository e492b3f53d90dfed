//! A stretch of lines round a frequency, mapped to [−1, 1].

use super::channel::Channel;
use super::local::{LocalChannel, LocalData};
use crate::linalg::c64;

/// Half width of a window of an antiresonance relative to its centre, and its least number of lines on either side.
const WINDOW: f64 = 0.07;
const LINES_PER_SIDE: usize = 6;
/// Half width of a window of a pole in half bandwidths (beyond these a line tells next to nothing about it) and its
/// limits: part of the frequency, where the polynomial still follows all else, and lines on either side.
const POLE_WINDOW: f64 = 20.0;
const WIDEST_POLE_WINDOW: f64 = 0.25;
const POLE_LINES_PER_SIDE: usize = 10;

/// Lines and their map.
#[derive(Debug)]
pub(super) struct Window {
    pub(super) centre_hz: f64,
    pub(super) half_hz: f64,
    pub(super) lines: std::ops::Range<usize>,
}

impl Window {
    /// Round an antiresonance.
    pub(super) fn round(frequency_hz: &[f64], at_hz: f64, widen: f64) -> Option<Self> {
        Self::of(frequency_hz, at_hz, widen * WINDOW * at_hz, LINES_PER_SIDE)
    }

    /// Round a pole.
    pub(super) fn about(frequency_hz: &[f64], pole_hz: c64) -> Option<Self> {
        let half_hz = (POLE_WINDOW * pole_hz.im.abs()).min(WIDEST_POLE_WINDOW * pole_hz.re);
        Self::of(frequency_hz, pole_hz.re, half_hz, POLE_LINES_PER_SIDE)
    }

    fn of(frequency_hz: &[f64], at_hz: f64, half: f64, lines_per_side: usize) -> Option<Self> {
        let lo = frequency_hz.partition_point(|f| *f < at_hz - half);
        let hi = frequency_hz.partition_point(|f| *f <= at_hz + half);
        let at = frequency_hz.partition_point(|f| *f < at_hz);
        let lo = lo.min(at.saturating_sub(lines_per_side));
        let hi = hi.max(at + lines_per_side).min(frequency_hz.len());
        let (first, last) = (frequency_hz.get(lo)?, frequency_hz.get(hi.checked_sub(1)?)?);
        let half_hz = 0.5 * (last - first);
        (half_hz > 0.0).then(|| Self { centre_hz: 0.5 * (first + last), half_hz, lines: lo..hi })
    }

    pub(super) fn data(&self, frequency_hz: &[f64], channels: &[&Channel]) -> LocalData {
        let cut = |c: &&Channel| LocalChannel {
            value: c.value[self.lines.clone()].to_vec(),
            sigma: c.sigma[self.lines.clone()].to_vec(),
            with_next: c.with_next.get(self.lines.clone()).map_or(vec![], <[c64]>::to_vec),
        };
        LocalData {
            x: frequency_hz[self.lines.clone()].iter().map(|f| (f - self.centre_hz) / self.half_hz).collect(),
            channels: channels.iter().map(cut).collect(),
        }
    }

    pub(super) fn normalise(&self, hz: c64) -> c64 {
        (hz - c64::new(self.centre_hz, 0.0)) / self.half_hz
    }

    pub(super) fn hz(&self, x: c64) -> c64 {
        x * self.half_hz + c64::new(self.centre_hz, 0.0)
    }

    /// Known poles that shape the window: those within three half widths.
    pub(super) fn nearby(&self, poles_hz: &[c64]) -> Vec<c64> {
        poles_hz.iter().map(|p| self.normalise(*p)).filter(|x| x.re.abs() < 3.0).collect()
    }
}
