//! The largest upper bound of μ over frequency, by branch and bound on the grid and a line search between its points.
//!
//! Every scaling bounds μ at every frequency. A few points are optimised first; at the others the scaling of the
//! nearest optimised ones is evaluated, which costs a hundredth of an optimum, and only points whose bound is above the
//! largest optimum met are optimised, in falling order of that bound. The largest value on the grid is that of a full
//! sweep.

use super::system::{MuPoint, MuSystem};
use crate::linalg::{Mat, c64};
use crate::lti::line_maximum::LineMaximum;
use crate::robust::structure::{MuError, Scaling};
use rayon::prelude::*;

/// What a search has met.
pub(super) struct Found {
    /// The largest bound, optimised.
    pub best: MuPoint,
    /// Every point of the grid with a bound and the scaling that proves it, ascending.
    pub points: Vec<MuPoint>,
    /// Those whose scaling is optimal for the point itself, ascending.
    pub optimised: Vec<MuPoint>,
}

/// Stride that leaves most of the grid to the scalings of neighbours.
pub(super) const STRIDE: usize = 12;
/// Points optimised between two prunings; fixed, so that the answer does not depend on the number of threads.
const BATCH: usize = 4;
/// Frequencies between two neighbours at which a frozen scaling is asked whether a line search may pay.
const LOOKS: usize = 6;
/// Local maxima below this share of the largest are no candidates: a peak between two points of this density rises by a
/// few percent at most.
const HIGH: f64 = 0.9;
/// Share of the largest below which a bound needs not be sharp.
const FAR: f64 = 0.8;
/// The place of a peak is sought to this share of the distance of its neighbours: a smooth peak is then known to 1e-8
/// of its height.
const PLACE: f64 = 1e-4;

/// Searches the grid of the system and between its points; every `stride`-th point is optimised whatever its value.
pub(super) fn search(system: &MuSystem, stride: usize) -> Result<Found, MuError> {
    let grid = system.grid();
    let responses: Vec<Mat<c64>> = grid.par_iter().map(|w| system.response(*w)).collect();
    for (omega_rad_s, response) in grid.iter().zip(&responses) {
        if !response.is_all_finite() {
            return Err(MuError::NotFinite { omega_rad_s: *omega_rad_s });
        }
    }
    let mut sweep = PeakSweep {
        system,
        grid: &grid,
        responses: &responses,
        points: vec![None; grid.len()],
        exact: vec![false; grid.len()],
    };
    let guides: Vec<usize> = (0..grid.len()).step_by(stride.max(1)).collect();
    sweep.optimise(&guides)?;
    let all: Vec<usize> = (0..grid.len()).collect();
    sweep.freeze(&all, &guides);
    loop {
        let largest = sweep.largest();
        let mut open: Vec<usize> = (0..grid.len()).filter(|k| !sweep.exact[*k] && sweep.upper(*k) > largest).collect();
        if open.is_empty() {
            break;
        }
        open.sort_by(|a, b| sweep.upper(*b).total_cmp(&sweep.upper(*a)));
        let rest = open.split_off(BATCH.min(open.len()));
        sweep.optimise(&open)?;
        sweep.freeze(&rest, &open);
    }
    sweep.refine_peaks()
}

struct PeakSweep<'a> {
    system: &'a MuSystem,
    grid: &'a [f64],
    responses: &'a [Mat<c64>],
    /// The lowest bound met of each point.
    points: Vec<Option<MuPoint>>,
    /// Whether it is the optimum.
    exact: Vec<bool>,
}

impl PeakSweep<'_> {
    fn upper(&self, k: usize) -> f64 {
        self.points[k].as_ref().map_or(f64::INFINITY, |p| p.upper)
    }

    /// Largest optimum met.
    fn largest(&self) -> f64 {
        let exact = (0..self.grid.len()).filter(|k| self.exact[*k]);
        exact.map(|k| self.upper(k)).fold(0.0, f64::max)
    }

    fn optimise(&mut self, which: &[usize]) -> Result<(), MuError> {
        let found: Result<Vec<MuPoint>, MuError> =
            which.par_iter().map(|k| self.system.point_of(self.grid[*k], &self.responses[*k])).collect();
        for (k, point) in which.iter().zip(found?) {
            self.points[*k] = Some(point);
            self.exact[*k] = true;
        }
        Ok(())
    }

    /// Lowers the bounds of points by the scalings of the nearest of `guides` on each side.
    fn freeze(&mut self, which: &[usize], guides: &[usize]) {
        let enough = FAR * self.largest();
        let mut guides = guides.to_vec();
        guides.sort_unstable();
        let lowered: Vec<Option<MuPoint>> = which
            .par_iter()
            .map(|k| {
                if self.exact[*k] {
                    return None;
                }
                let after = guides.partition_point(|g| g < k);
                let near = [after.checked_sub(1), Some(after)];
                let mut best: Option<MuPoint> = None;
                for guide in near.into_iter().flatten().filter_map(|g| guides.get(g)) {
                    let Some(own) = &self.points[*guide] else {
                        continue;
                    };
                    let upper = own.scaling.bound_from(&self.responses[*k], enough);
                    let least = best.as_ref().map_or(self.upper(*k), |b| b.upper);
                    // A NaN bounds nothing.
                    if upper < least {
                        best = Some(MuPoint { omega_rad_s: self.grid[*k], upper, scaling: own.scaling.clone() });
                    }
                }
                best
            })
            .collect();
        for (k, point) in which.iter().zip(lowered) {
            if point.is_some() {
                self.points[*k] = point;
            }
        }
    }

    /// A line search round each of the local maxima that may be the largest.
    fn refine_peaks(self) -> Result<Found, MuError> {
        let points: Vec<MuPoint> = self.points.into_iter().flatten().collect();
        let largest = points.iter().map(|p| p.upper).fold(0.0, f64::max);
        let mut maxima: Vec<usize> = (0..points.len())
            .filter(|k| {
                let here = points[*k].upper;
                let not_below = |other: Option<&MuPoint>| other.is_none_or(|o| here >= o.upper);
                here >= HIGH * largest
                    && not_below(k.checked_sub(1).and_then(|b| points.get(b)))
                    && not_below(points.get(k + 1))
            })
            .collect();
        maxima.sort_by(|a, b| points[*b].upper.total_cmp(&points[*a].upper));
        let last = points.len() - 1;
        let beside = |k: usize| [k.saturating_sub(1), k, (k + 1).min(last)].map(|near| &points[near]);
        let Some(first) = maxima.first().copied() else {
            return Err(MuError::EmptyBlock { block: 0 });
        };
        let mut best = climb(self.system, beside(first))?;
        let may_pay = |k: &usize| {
            let [below, point, above] = beside(*k);
            let ends = (below.omega_rad_s, above.omega_rad_s);
            exceeds(self.system, &point.scaling, ends.0, ends.1, best.upper)
        };
        let open: Vec<usize> = maxima[1..].par_iter().copied().filter(may_pay).collect();
        let refined: Result<Vec<MuPoint>, MuError> = open.par_iter().map(|k| climb(self.system, beside(*k))).collect();
        for point in refined? {
            if point.upper > best.upper {
                best = point;
            }
        }
        let exact = points.iter().zip(&self.exact).filter(|(_, exact)| **exact);
        Ok(Found { best, optimised: exact.map(|(p, _)| p.clone()).collect(), points })
    }
}

/// Whether the bound of a frozen scaling exceeds a level somewhere between two frequencies, as far as a few looks tell.
fn exceeds(system: &MuSystem, scaling: &Scaling, lo: f64, hi: f64, level: f64) -> bool {
    if !hi.is_finite() {
        return true;
    }
    (0..LOOKS).any(|k| {
        let omega = lo + (hi - lo) * (k as f64 + 0.5) / LOOKS as f64;
        let bound = scaling.bound_from(&system.response(omega), level);
        // NaN: unknown.
        bound > level || bound.is_nan()
    })
}

/// The largest bound between the neighbours of a point; the point may have a bound above its optimum.
fn climb(system: &MuSystem, [below, middle, above]: [&MuPoint; 3]) -> Result<MuPoint, MuError> {
    let mut best = system.point(middle.omega_rad_s)?;
    let width = above.omega_rad_s - below.omega_rad_s;
    if !width.is_finite() || width <= 0.0 {
        return Ok(best);
    }
    // A bound of a frozen scaling may be above what is optimal here.
    let at = |point: &MuPoint| (point.omega_rad_s, point.upper.min(best.upper));
    let mut search = LineMaximum::new([at(below), at(&best), at(above)], 0.25 * PLACE * width);
    while let Some(omega) = search.next() {
        let point = system.point(omega)?;
        search.add(omega, point.upper);
        if point.upper > best.upper {
            best = point;
        }
    }
    Ok(best)
}
