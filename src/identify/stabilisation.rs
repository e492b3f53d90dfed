//! Which poles of the least squares of many orders (`lscf`) come back from order to order: the stabilisation diagram.
//!
//! Bands of several widths overlap by half: narrow ones resolve lightly damped modes of zoomed lines, wide ones hold
//! the whole peak of a damped one. A pole is stable where the order before has one beside it. Clusters of stable poles
//! are candidates of modes; the noise makes clusters as well, which the likelihood (`selection`) tells.

use super::lscf::Responses;
use crate::linalg::c64;
use std::ops::Range;

/// A pole of the diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagramPole {
    /// Band of the fit, Hz.
    pub band_hz: (f64, f64),
    /// Order of the denominator.
    pub order: usize,
    /// Damped frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// The order before has the same pole.
    pub stable: bool,
}

impl DiagramPole {
    /// On the frequency axis: damped frequency + jζf.
    fn pole_hz(&self) -> c64 {
        let z = self.damping_ratio;
        c64::new(1.0, z / (1.0 - z * z).sqrt()) * self.frequency_hz
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PoleCluster {
    /// Mean, Hz.
    pub(super) pole_hz: c64,
    /// Root of the mean squared distance from it, Hz.
    pub(super) spread_hz: f64,
    pub(super) count: usize,
}

/// Lines of a band and the orders tried in it: up to some six lines an order, from one that has room for the modes of a
/// band of that width.
const BANDS: [(usize, Range<usize>, usize); 3] = [(160, 8..29, 4), (640, 12..41, 4), (usize::MAX, 16..45, 4)];
/// Lines an order needs.
const LINES_PER_ORDER: usize = 3;
/// Damping ratios of candidates: the weakest mode may come out slightly negative.
const DAMPING_RATIOS: Range<f64> = -2e-4..0.12;
/// A pole is the same within this part of its damping and this part of its frequency.
const SAME_DAMPING: f64 = 0.3;
const SAME_FREQUENCY: f64 = 3e-5;
/// Poles of a cluster, apart by no more than somewhat above twice that, and the least number that is one.
const CLUSTER_DAMPING: f64 = 0.4;
const CLUSTER_FREQUENCY: f64 = 1e-4;
const LEAST_COUNT: usize = 3;

/// Poles of all bands and orders.
pub(super) fn stabilisation_diagram(responses: &Responses) -> Vec<DiagramPole> {
    let frequency_hz = responses.frequency_hz;
    let mut bands: Vec<(Range<usize>, Vec<usize>)> = vec![];
    for (lines, orders, step) in BANDS {
        for band in half_overlapping_ranges(frequency_hz.len(), lines) {
            let room = |order: &usize| LINES_PER_ORDER * order <= band.len();
            let orders: Vec<usize> = orders.clone().step_by(step).filter(room).collect();
            if !bands.iter().any(|(other, _)| *other == band) {
                bands.push((band, orders));
            }
        }
    }
    let mut diagram = vec![];
    for (lines, orders) in bands {
        let mut before: Vec<c64> = vec![];
        let band_hz = (frequency_hz[lines.start], frequency_hz[lines.end - 1]);
        for (order, poles) in orders.iter().zip(responses.poles(&lines, &orders)) {
            let poles: Vec<c64> = poles.into_iter().filter(|p| DAMPING_RATIOS.contains(&(p.im / p.re))).collect();
            diagram.extend(poles.iter().map(|p| DiagramPole {
                band_hz,
                order: *order,
                frequency_hz: p.re,
                damping_ratio: p.im / p.norm(),
                stable: before.iter().any(|q| is_same(*p, *q)),
            }));
            before = poles;
        }
    }
    diagram
}

/// Ranges of `size` of `lines`, each half over the one before, the last one whole.
fn half_overlapping_ranges(lines: usize, size: usize) -> Vec<Range<usize>> {
    let size = size.min(lines);
    let last = lines - size;
    let starts = (0..last).step_by((size / 2).max(1)).chain([last]);
    if size == 0 { vec![] } else { starts.map(|k| k..k + size).collect() }
}

fn is_same(p: c64, q: c64) -> bool {
    let apart = SAME_DAMPING * p.im.abs() + SAME_FREQUENCY * p.re;
    (p.re - q.re).abs() < apart && (p.im - q.im).abs() < apart
}

/// Clusters of the stable poles, the largest first.
pub(super) fn pole_clusters(diagram: &[DiagramPole]) -> Vec<PoleCluster> {
    let stable = diagram.iter().filter(|p| p.stable);
    let mut poles: Vec<c64> = stable.map(DiagramPole::pole_hz).collect();
    poles.sort_by(|p, q| p.re.total_cmp(&q.re).then(p.im.total_cmp(&q.im)));
    let reach = |p: c64| (CLUSTER_DAMPING * p.im.abs()).max(CLUSTER_FREQUENCY * p.re);
    let near = |p: c64| {
        let from = poles.partition_point(|q| q.re < p.re - reach(p));
        let to = poles.partition_point(|q| q.re <= p.re + reach(p));
        (from..to).filter(|k| (poles[*k] - p).norm() < reach(p)).collect::<Vec<usize>>()
    };
    let mut order: Vec<(usize, usize)> = poles.iter().enumerate().map(|(k, p)| (k, near(*p).len())).collect();
    order.sort_by_key(|(k, count)| (std::cmp::Reverse(*count), *k));
    let mut used = vec![false; poles.len()];
    let mut clusters = vec![];
    for (k, _) in order {
        if used[k] {
            continue;
        }
        let members: Vec<usize> = near(poles[k]).into_iter().filter(|m| !used[*m]).collect();
        let count = members.len();
        if count < LEAST_COUNT {
            continue;
        }
        let mean = members.iter().map(|m| poles[*m]).sum::<c64>() / count as f64;
        let spread = members.iter().map(|m| (poles[*m] - mean).norm_sqr()).sum::<f64>() / count as f64;
        members.iter().for_each(|m| used[*m] = true);
        clusters.push(PoleCluster { pole_hz: mean, spread_hz: spread.sqrt(), count });
    }
    clusters
}
