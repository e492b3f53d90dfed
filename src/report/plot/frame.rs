//! From values to pixels: the range an axis gets from its data, the rectangle of a panel, clipping of lines to it.

use super::PlotError;
use super::figure::{Axis, Panel, Scale, SeriesShape};
use super::ticks::round_range;

/// Rectangle of a panel's plot area, px, y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

/// Map from the values of two axes to the pixels of a rectangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlotFrame {
    pub rect: Rect,
    /// Scale and range of x.
    pub x: (Scale, [f64; 2]),
    /// Scale and range of y.
    pub y: (Scale, [f64; 2]),
}

impl PlotFrame {
    /// Pixel of a value on x.
    pub(super) fn px(&self, x: f64) -> f64 {
        self.rect.left + fraction(self.x.0, self.x.1, x) * (self.rect.right - self.rect.left)
    }

    /// Pixel of a value on y.
    pub(super) fn py(&self, y: f64) -> f64 {
        self.rect.bottom - fraction(self.y.0, self.y.1, y) * (self.rect.bottom - self.rect.top)
    }

    /// Pixel of a point; `None` where an axis cannot show it.
    pub(super) fn point(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let (px, py) = (self.px(x), self.py(y));
        (px.is_finite() && py.is_finite()).then_some((px, py))
    }

    /// True for a pixel in the plot area, edges included with a pixel of slack.
    pub(super) fn contains(&self, x: f64, y: f64) -> bool {
        let r = &self.rect;
        x >= r.left - 1.0 && x <= r.right + 1.0 && y >= r.top - 1.0 && y <= r.bottom + 1.0
    }

    /// The pixel moved onto the nearest point of the plot area.
    pub(super) fn clamp(&self, x: f64, y: f64) -> (f64, f64) {
        let r = &self.rect;
        (x.clamp(r.left, r.right), y.clamp(r.top, r.bottom))
    }

    /// The pieces of the polyline through `points` that lie in the plot area. `None` is a gap.
    pub(super) fn clip_points(&self, points: impl IntoIterator<Item = Option<(f64, f64)>>) -> Vec<Vec<(f64, f64)>> {
        let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
        let mut previous: Option<(f64, f64)> = None;
        for point in points {
            if let (Some(a), Some(b)) = (previous, point)
                && let Some((start, end)) = clip_segment(self.rect, a, b)
            {
                match pieces.last_mut() {
                    Some(piece) if piece.last() == Some(&start) => piece.push(end),
                    _ => pieces.push(vec![start, end]),
                }
            }
            previous = point;
        }
        pieces
    }
}

fn fraction(scale: Scale, [low, high]: [f64; 2], value: f64) -> f64 {
    match scale {
        Scale::Linear => (value - low) / (high - low),
        Scale::Log if value > 0.0 => (value / low).ln() / (high / low).ln(),
        Scale::Log => f64::NAN,
    }
}

/// Liang and Barsky's parametric clipping.
fn clip_segment(r: Rect, a: (f64, f64), b: (f64, f64)) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut t0, mut t1) = (0.0f64, 1.0f64);
    let sides = [(-dx, a.0 - r.left), (dx, r.right - a.0), (-dy, a.1 - r.top), (dy, r.bottom - a.1)];
    for (p, q) in sides {
        if p == 0.0 {
            if q < 0.0 {
                return None;
            }
        } else if p < 0.0 {
            t0 = t0.max(q / p);
        } else {
            t1 = t1.min(q / p);
        }
    }
    let at = |t: f64| {
        if t == 0.0 {
            a
        } else if t == 1.0 {
            b
        } else {
            (a.0 + t * dx, a.1 + t * dy)
        }
    };
    (t0 <= t1).then(|| (at(t0), at(t1)))
}

/// Which axis of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Across,
    Up,
}

/// Range of an axis: the fixed one, or that of the data, widened to round numbers where nothing dictates the end.
pub(super) fn axis_range(panel: &Panel, direction: Direction) -> Result<[f64; 2], PlotError> {
    let axis = match direction {
        Direction::Across => &panel.x,
        Direction::Up => &panel.y,
    };
    if let Some([low, high]) = axis.range {
        let positive = axis.scale == Scale::Linear || low > 0.0;
        return if low.is_finite() && high.is_finite() && low < high && positive {
            Ok([low, high])
        } else {
            Err(PlotError::Range { axis: axis.caption(), low, high })
        };
    }
    let (low, high) = extent(panel, direction, axis);
    if !(low.is_finite() && high.is_finite()) {
        // Nothing to show: an empty panel with some axis is better than no report.
        return Ok(if axis.scale == Scale::Log { [1.0, 10.0] } else { [0.0, 1.0] });
    }
    let flat = high - low <= 1e-12 * low.abs().max(high.abs());
    let (low, high) = match (flat, axis.scale) {
        (false, _) => (low, high),
        (true, Scale::Log) => (low / 2.0, high * 2.0),
        (true, Scale::Linear) => {
            let half = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
            (low - half, high + half)
        }
    };
    // Abscissae that are lines, not bars, fill the width: no white strip before the first and after the last frequency.
    let tight = direction == Direction::Across
        && !panel.equal_aspect
        && panel.series.iter().all(|s| !matches!(s.shape, SeriesShape::Bars { .. } | SeriesShape::LyingBars { .. }));
    if tight {
        return Ok([low, high]);
    }
    // A little air, so that nothing is drawn along the frame; none below bars, which stand on their axis.
    let air = 0.03 * (high - low);
    Ok(match axis.scale {
        Scale::Log => round_range(Scale::Log, [low / 1.05, high * 1.05]),
        Scale::Linear => round_range(
            Scale::Linear,
            [if low == 0.0 { 0.0 } else { low - air }, if high == 0.0 { 0.0 } else { high + air }],
        ),
    })
}

/// Smallest and largest value an axis has to show.
fn extent(panel: &Panel, direction: Direction, axis: &Axis) -> (f64, f64) {
    let mut values: Vec<f64> = Vec::new();
    for series in &panel.series {
        match direction {
            Direction::Across => values.extend(&series.x),
            Direction::Up => {
                values.extend(&series.y);
                if let Some(error) = &series.y_error {
                    let pairs = || series.y.iter().zip(error).filter(|(y, e)| y.is_finite() && e.is_finite());
                    values.extend(pairs().map(|(y, e)| y - e));
                    values.extend(pairs().map(|(y, e)| y + e));
                }
            }
        }
        match (&series.shape, direction) {
            (SeriesShape::Band { lower }, Direction::Up) => values.extend(lower),
            (SeriesShape::Bars { width }, Direction::Across) => {
                values.extend(series.x.iter().flat_map(|x| [x - 0.6 * width, x + 0.6 * width]));
            }
            (SeriesShape::LyingBars { height }, Direction::Up) => {
                values.extend(series.y.iter().flat_map(|y| [y - 0.6 * height, y + 0.6 * height]));
            }
            (SeriesShape::Bars { .. }, Direction::Up) | (SeriesShape::LyingBars { .. }, Direction::Across) => {
                values.push(0.0);
            }
            _ => {}
        }
    }
    match direction {
        Direction::Up => values.extend(panel.levels.iter().map(|l| l.value)),
        Direction::Across => {
            values.extend(panel.heat.iter().flat_map(|h| h.x_edges.iter().copied()));
        }
    }
    values
        .into_iter()
        .filter(|v| v.is_finite() && (axis.scale == Scale::Linear || *v > 0.0))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// Positions nearest to `wanted` (least squares) at which items of these `sizes` do not overlap, within `[low, high]`
/// if they fit. The order of `wanted`, which must ascend, is kept.
pub(super) fn spread(wanted: &[f64], sizes: &[f64], [low, high]: [f64; 2]) -> Vec<f64> {
    // With the summed sizes taken off, "no overlap" is "not descending": pool adjacent violators.
    let mut offset = 0.0;
    let mut offsets = Vec::with_capacity(wanted.len());
    for (k, size) in sizes.iter().enumerate() {
        if k > 0 {
            offset += 0.5 * (size + sizes.get(k - 1).copied().unwrap_or(0.0));
        }
        offsets.push(offset);
    }
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for (w, o) in wanted.iter().zip(&offsets) {
        let mut pool = (w - o, 1usize);
        while let Some(&(mean, count)) = pools.last().filter(|p| p.0 > pool.0) {
            let total = count + pool.1;
            pool = ((mean * count as f64 + pool.0 * pool.1 as f64) / total as f64, total);
            pools.pop();
        }
        pools.push(pool);
    }
    let first = low + 0.5 * sizes.first().copied().unwrap_or(0.0);
    let last = high - 0.5 * sizes.last().copied().unwrap_or(0.0) - offset;
    pools
        .iter()
        .flat_map(|(mean, count)| std::iter::repeat_n(*mean, *count))
        .zip(&offsets)
        .map(|(base, o)| base.min(last.max(first)).max(first) + o)
        .collect()
}
