//! Branch and bound for the largest |f| at one frequency over a box of stiffness changes κ_k.
//!
//! f(κ) is the mean of N₂₂ + N₂₁ D (I − N₁₁D)⁻¹ N₁₂ over its parts, one or two. A part has both planes with
//! D = diag(κ_k I₂), or, where the planes are equal and coupled as by a turning frame, one direction of whirl with
//! D = diag(κ_k): on r = x + jy a matrix [[P, −Q], [Q, P]] is P + jQ forwards and P − jQ backwards, and what x does to
//! x is the mean of both.
//!
//! max |f| over the box: a box is halved until the bounds meet. Below, f at a point of the box; above, in coordinates
//! κ = c + ρδ, |δ| ≤ 1, of a box,
//!   |f| ≤ max over the corners of |mean of N₂₂ + N₂₁ρδN₁₂| + mean of |N₂₁|ρ A (I − A)⁻¹ |N₁₂|,
//!   A = |N₁₁|ρ with spectral radius below one, the means over the parts,
//! the first order exactly and the rest by moduli (Neumann series), so that the gap closes with the square of the box.

use crate::linalg::small::{eliminate, eliminate_real};
use crate::linalg::{Mat, c64};

/// Both bounds of max |f| at a frequency, the nominal value, and a κ that attains the lower bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Extreme {
    /// |f(0)|.
    pub nominal: f64,
    /// Attained.
    pub lower: f64,
    /// Never exceeded; infinite when the search ended before the loop was seen to stay regular.
    pub upper: f64,
    /// Frequency factors √(1 + κ) of the point that attains `lower`.
    pub factors: Vec<f64>,
}

/// A bound is settled when upper and lower differ by less than this fraction.
pub const SETTLED: f64 = 2e-3;
/// Boxes at most at one frequency and channel; two dozen are usual.
const MOST_BOXES: usize = 3000;

/// One channel at one frequency.
pub(super) struct ChannelSearch(Vec<SearchPart>);

/// A part of f; matrices are row-major.
#[derive(Clone, Debug, PartialEq)]
struct SearchPart {
    /// Coordinates of each mode.
    planes: usize,
    n11: Vec<c64>,
    n12: Vec<c64>,
    n21: Vec<c64>,
    n22: c64,
}

/// A part with its share of the mean, in the coordinates of a box: A, |N₁₂| and |N₂₁|ρ, the slopes by δ, and the value
/// at the centre.
struct Centred {
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    slope: Vec<c64>,
    value: c64,
}

/// A box with its upper bound.
struct Branch {
    centre: Vec<f64>,
    half: Vec<f64>,
    upper: f64,
    split: usize,
}

impl ChannelSearch {
    /// Channel `channel` of N, whose first `m` rows and columns are the modal coordinates, x and y in turn.
    pub(super) fn new(n: &Mat<c64>, m: usize, channel: usize) -> Self {
        let own: Vec<usize> = (0..m).chain([m + channel]).collect();
        Self(vec![SearchPart::new(2, m, |i, j| n[(own[i], own[j])])])
    }

    /// The same where the planes are equal; `channel` is one of x, behind which that of y follows.
    pub(super) fn of_equal_planes(n: &Mat<c64>, m: usize, channel: usize) -> Self {
        let x = |k: usize| if 2 * k < m { 2 * k } else { m + channel };
        let direction =
            |sign: f64| SearchPart::new(1, m / 2, |i, j| n[(x(i), x(j))] + c64::new(0.0, sign) * n[(x(i) + 1, x(j))]);
        let mut directions = vec![direction(1.0), direction(-1.0)];
        // At rest both are one.
        directions.dedup();
        Self(directions)
    }

    /// Bounds over a box of the κ of each mode.
    pub(super) fn run(&self, kappa: &[[f64; 2]]) -> Extreme {
        let nominal = self.mean(|part| part.n22).norm();
        let centre: Vec<f64> = kappa.iter().map(|k| 0.5 * (k[0] + k[1])).collect();
        let half: Vec<f64> = kappa.iter().map(|k| 0.5 * (k[1] - k[0])).collect();
        let mut best = (nominal, vec![0.0; kappa.len()]);
        if half.iter().all(|h| *h == 0.0) {
            return extreme(nominal, nominal, best.0, best.1);
        }
        let mut open = vec![self.bound_branch(centre, half, &mut best)];
        let mut settled = 0.0f64;
        for _ in 0..MOST_BOXES {
            // The box with the largest bound; ties fall to the first, so that the order is fixed.
            let Some(k) = (0..open.len()).reduce(|a, b| if open[b].upper > open[a].upper { b } else { a }) else {
                break;
            };
            if open[k].upper <= best.0 * (1.0 + SETTLED) {
                break;
            }
            let parent = open.swap_remove(k);
            for side in [-1.0, 1.0] {
                let (mut centre, mut half) = (parent.centre.clone(), parent.half.clone());
                half[parent.split] *= 0.5;
                centre[parent.split] += side * half[parent.split];
                let child = self.bound_branch(centre, half, &mut best);
                if child.upper > best.0 * (1.0 + SETTLED) {
                    open.push(child);
                } else {
                    settled = settled.max(child.upper);
                }
            }
        }
        let upper = open.iter().map(|b| b.upper).fold(settled.max(best.0), f64::max);
        extreme(nominal, upper, best.0, best.1)
    }

    /// Share of a part in the mean.
    fn share(&self) -> f64 {
        (self.0.len() as f64).recip()
    }

    fn mean(&self, of: impl Fn(&SearchPart) -> c64) -> c64 {
        let parts = self.0.iter().map(|part| of(part) * self.share());
        parts.sum()
    }

    /// Upper bound over a box; points met on the way raise `best`.
    fn bound_branch(&self, centre: Vec<f64>, half: Vec<f64>, best: &mut (f64, Vec<f64>)) -> Branch {
        let mut raise = |value: f64, at: &[f64]| {
            if value > best.0 {
                *best = (value, at.to_vec());
            }
        };
        let centred = |part: &SearchPart| part.centre_part(self.share(), &centre, &half);
        let parts: Vec<Centred> = self.0.iter().map(centred).collect();
        let value: c64 = parts.iter().map(|part| part.value).sum();
        raise(value.norm(), &centre);
        // First order: convex in δ, largest at a corner.
        let slope = |k: usize| -> c64 { parts.iter().map(|part| part.slope[k]).sum() };
        let free: Vec<usize> = (0..half.len()).filter(|k| half[*k] > 0.0).collect();
        let slopes: Vec<c64> = free.iter().map(|k| slope(*k)).collect();
        let sign = |signs: usize, bit: usize| match (signs >> bit) & 1 {
            0 => -1.0,
            _ => 1.0,
        };
        let (mut first, mut at) = (value.norm_sqr(), None);
        for signs in 0..1usize << free.len() {
            let steps = slopes.iter().enumerate();
            let end = steps.fold(value, |sum, (bit, slope)| sum + slope * sign(signs, bit));
            if end.norm_sqr() > first {
                (first, at) = (end.norm_sqr(), Some(signs));
            }
        }
        if let Some(signs) = at {
            let mut corner = centre.clone();
            for (bit, k) in free.iter().enumerate() {
                corner[*k] += sign(signs, bit) * half[*k];
            }
            raise(self.mean(|part| part.at(&corner)).norm(), &corner);
        }
        let rests: Vec<Option<(Vec<f64>, f64)>> = parts.iter().map(Centred::remainder).collect();
        let regular: Option<f64> = rests.iter().map(|r| r.as_ref().map(|r| r.1)).sum();
        // The parameter that feeds most of the remainder, or of A where its series does not converge, is halved.
        let weight = |k: usize| -> f64 {
            let each = parts.iter().zip(&rests).zip(&self.0);
            let of = each.map(|((part, rest), own)| match (rest, regular) {
                (Some((x, _)), Some(_)) => part.feed_mode(own, k, x),
                (None, _) => part.fed_first(own, k),
                (Some(_), None) => 0.0,
            });
            of.sum()
        };
        let split = free.iter().copied().reduce(|p, q| if weight(q) > weight(p) { q } else { p }).unwrap_or(0);
        Branch { upper: regular.map_or(f64::INFINITY, |rest| first.sqrt() + rest), centre, half, split }
    }
}

impl SearchPart {
    /// With the entries of N: `size` modal coordinates, then the channel.
    fn new(planes: usize, size: usize, at: impl Fn(usize, usize) -> c64) -> Self {
        Self {
            planes,
            n11: (0..size * size).map(|k| at(k / size, k % size)).collect(),
            n12: (0..size).map(|i| at(i, size)).collect(),
            n21: (0..size).map(|j| at(size, j)).collect(),
            n22: at(size, size),
        }
    }

    /// Coordinates of a mode.
    fn own_range(&self, mode: usize) -> std::ops::Range<usize> {
        self.planes * mode..self.planes * (mode + 1)
    }

    /// I − N₁₁C at κ = c.
    fn difference(&self, centre: &[f64]) -> Vec<c64> {
        let m = self.n12.len();
        let entry = |k: usize| {
            let (i, j) = (k / m, k % m);
            let unit = c64::new(f64::from(u8::from(i == j)), 0.0);
            unit - self.n11[k] * centre[j / self.planes]
        };
        (0..m * m).map(entry).collect()
    }

    /// The part of f at a point.
    fn at(&self, kappa: &[f64]) -> c64 {
        let mut moved = self.n12.clone();
        eliminate(&mut self.difference(kappa), &mut moved, self.n12.len(), 1);
        let each = self.n21.iter().zip(&moved).enumerate();
        each.fold(self.n22, |sum, (i, (read, moved))| sum + read * kappa[i / self.planes] * moved)
    }

    /// With its share of the mean, recentred at κ = c: (I − N₁₁C)⁻¹ applied to N₁₁ and N₁₂, N₂₁ and N₂₂ to fit.
    fn centre_part(&self, share: f64, centre: &[f64], half: &[f64]) -> Centred {
        let m = self.n12.len();
        let columns = m + 1;
        let mut both: Vec<c64> = (0..m)
            .flat_map(|i| {
                let row = self.n11[i * m..(i + 1) * m].iter();
                row.chain([&self.n12[i]]).copied()
            })
            .collect();
        eliminate(&mut self.difference(centre), &mut both, m, columns);
        let through = |first: c64, j: usize| {
            (0..m).fold(first, |sum, i| sum + self.n21[i] * centre[i / self.planes] * both[i * columns + j])
        };
        let width = |j: usize| half[j / self.planes];
        let read: Vec<c64> = (0..m).map(|j| through(self.n21[j], j)).collect();
        let drive = |i: usize| both[i * columns + m];
        Centred {
            a: (0..m * m).map(|k| modulus(both[k / m * columns + k % m]) * width(k % m)).collect(),
            b: (0..m).map(|i| modulus(drive(i))).collect(),
            c: (0..m).map(|j| share * modulus(read[j]) * width(j)).collect(),
            slope: (0..half.len())
                .map(|k| {
                    let own = self.own_range(k).map(|j| read[j] * drive(j));
                    own.sum::<c64>() * (half[k] * share)
                })
                .collect(),
            value: through(self.n22, m) * share,
        }
    }
}

/// |z| of a number whose square neither overflows nor underflows.
fn modulus(z: c64) -> f64 {
    z.norm_sqr().sqrt()
}

impl Centred {
    /// x = (I − A)⁻¹b for A with spectral radius below one, and c A x; `None` when the radius is not seen to be.
    fn remainder(&self) -> Option<(Vec<f64>, f64)> {
        let m = self.b.len();
        // A positive right-hand side makes x > A x a proof of the radius (Collatz and Wielandt); its size is below
        // rounding.
        let largest = self.b.iter().copied().fold(0.0, f64::max);
        let floor = 1e-14 * largest + f64::MIN_POSITIVE;
        let unit = |k: usize| f64::from(u8::from(k / m == k % m));
        let mut difference: Vec<f64> = (0..m * m).map(|k| unit(k) - self.a[k]).collect();
        let mut x: Vec<f64> = self.b.iter().map(|b| b + floor).collect();
        eliminate_real(&mut difference, &mut x, m);
        let mut rest = 0.0;
        for (i, row) in self.a.chunks_exact(m).enumerate() {
            let moved: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            // What is not a number proves nothing.
            if !(x[i] > 0.0 && moved < x[i]) {
                return None;
            }
            rest += self.c[i] * moved;
        }
        Some((x, rest))
    }

    /// What a mode feeds into the remainder.
    fn feed_mode(&self, part: &SearchPart, mode: usize, x: &[f64]) -> f64 {
        let m = self.b.len();
        let of = |j: usize| {
            let through: f64 = (0..m).map(|i| self.c[i] * self.a[i * m + j]).sum();
            through * x[j] + self.c[j] * x[j] * 1e-3
        };
        part.own_range(mode).map(of).sum()
    }

    /// What a mode feeds into A.
    fn fed_first(&self, part: &SearchPart, mode: usize) -> f64 {
        let m = self.b.len();
        let of = |j: usize| (0..m).map(|i| self.a[i * m + j]).sum::<f64>();
        part.own_range(mode).map(of).sum()
    }
}

fn extreme(nominal: f64, upper: f64, lower: f64, at: Vec<f64>) -> Extreme {
    Extreme { nominal, lower, upper, factors: at.iter().map(|k| (1.0 + k).max(0.0).sqrt()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// N of two equal planes with three modes and one channel, coupled by `turn`.
    fn equal_planes(turn: f64) -> Mat<c64> {
        let part = |k: usize, l: usize, phase: f64| {
            let angle = (7 * k + 3 * l) as f64 + phase;
            c64::from_polar(1.5 + 0.5 * (angle + 1.0).sin(), 2.0 * angle)
        };
        Mat::from_fn(8, 8, |i, j| {
            let (p, q) = (part(i / 2, j / 2, 0.0), part(i / 2, j / 2, 0.4) * turn);
            match (i % 2, j % 2) {
                (0, 0) | (1, 1) => p,
                (1, 0) => q,
                _ => -q,
            }
        })
    }

    #[test]
    fn directions_of_whirl_have_the_bounds_of_both_planes() {
        let kappa = [[-0.06, 0.06], [0.0, 0.0], [-0.03, 0.09]];
        for turn in [0.0, 0.7] {
            let n = equal_planes(turn);
            let whole = ChannelSearch::new(&n, 6, 0);
            let whirl = ChannelSearch::of_equal_planes(&n, 6, 0);
            assert_eq!(whirl.0.len(), if turn == 0.0 { 1 } else { 2 });
            for point in [[0.0; 3], [0.05, 0.0, -0.02]] {
                let values = [&whole, &whirl].map(|s| s.mean(|part| part.at(&point)));
                assert!((values[0] - values[1]).norm() < 1e-13 * values[0].norm());
            }
            let (whole, whirl) = (whole.run(&kappa), whirl.run(&kappa));
            assert!((whole.nominal / whirl.nominal - 1.0).abs() < 1e-13);
            for found in [&whole, &whirl] {
                assert!(found.lower > 1.05 * found.nominal, "{found:?}");
                assert!(found.upper <= found.lower * (1.0 + SETTLED), "{found:?}");
            }
            assert!(whole.lower <= whirl.upper && whirl.lower <= whole.upper);
        }
    }

    #[test]
    fn no_point_of_the_box_exceeds_the_bound() {
        let n = equal_planes(0.7);
        let search = ChannelSearch::of_equal_planes(&n, 6, 0);
        let found = search.run(&[[-0.1, 0.2]; 3]);
        let at = |k: usize| -0.1 + 0.3 * k as f64 / 20.0;
        let points = (0..21 * 21 * 21).map(|k| [at(k % 21), at(k / 21 % 21), at(k / 441)]);
        let largest = points.map(|point| search.mean(|part| part.at(&point)).norm()).fold(0.0, f64::max);
        assert!(largest <= found.upper && largest >= found.lower * 0.98, "{largest} {found:?}");
    }
}
