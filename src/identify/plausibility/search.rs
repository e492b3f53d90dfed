//! Which mistakes explain a record that the model contradicts.
//!
//! For a fault h on top of a base (the record with other faults undone) let d₀ be the distance to the model without
//! and d₁ with h undone, and Δ the distance that h alone puts between a faultless record and the model, all over the
//! pairs of line and entry with Δ above half a neper. The score
//!   s = Σ(d₀ − d₁) / ΣΔ
//! is 1 when h is all there is. Without h the triangle inequality gives s ≤ 2ε/Δ − 1, ε the mean deviation of the
//! machine from its model: s > ½ asks for a machine that deviates by three quarters of a gross mistake, half a decade
//! or more than a quarter turn over most lines. Errors of a few per cent in ki, ks, gains and moduli move s by
//! hundredths. A set of faults is accepted when each of them is needed given the others, the set given none, and what
//! is left is nearer to the model than to the next power of ten.

use super::faults::RecordFault;
use super::hypotheses::undone;
use super::spectrum::{Spectrum, median};

/// ln √10: a median beyond it is nearer to the next power of ten, or to the opposite sign, than to the model.
pub(crate) const HALF_A_DECADE: f64 = 1.151_292_546_497_023;
/// Pairs of line and entry on which a fault changes less than this, in nepers or radians, do not count for or against
/// it: differences of this size come from moved resonances as well.
const DISTINCT: f64 = 0.5;
/// Share of pairs of line and entry that have to be distinct for a fault to be told from none.
const ENOUGH: f64 = 0.05;
/// Score that a fault needs; see above.
const NEEDED: f64 = 0.5;
/// Mean distance below which frequencies are right: a factor of 2π and more moves every line.
const CLOCK_IS_RIGHT: f64 = 0.25;
/// Faults of one record that are named together.
const MOST: usize = 3;

/// A record and the model that it is compared with.
pub(crate) struct Comparison<'a> {
    pub data: &'a Spectrum,
    /// Rows of the response.
    pub outputs: usize,
    /// Entries that are compared: [output + outputs · input].
    pub compared: &'a [usize],
    /// The model's response on given lines, Hz.
    pub model: &'a dyn Fn(&[f64]) -> Spectrum,
}

/// How well the model meets a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Agreement {
    /// Mean distance over lines and compared entries.
    pub mean: f64,
    /// Largest median distance of a row or column.
    pub worst: f64,
}

impl Agreement {
    fn plausible(self) -> bool {
        self.worst <= HALF_A_DECADE
    }
}

/// Distances [line][compared entry].
type Distances = Vec<Vec<Option<f64>>>;

/// Models per factor on the frequencies.
struct Models {
    list: Vec<(f64, Spectrum)>,
}

impl Models {
    fn of(&self, faults: &[RecordFault]) -> &Spectrum {
        let factor = clock(faults);
        let at = self.list.iter().position(|(f, _)| *f == factor);
        &self.list[at.unwrap_or(0)].1
    }
}

fn clock(faults: &[RecordFault]) -> f64 {
    let factors = faults.iter().filter_map(|f| match f {
        RecordFault::Clock { factor } => Some(*factor),
        _ => None,
    });
    factors.product()
}

impl Comparison<'_> {
    /// How well the model meets the record as it is.
    pub(crate) fn agreement(&self) -> Agreement {
        let model = (self.model)(&self.data.frequency_hz);
        self.rate_agreement(&self.distances(self.data, &model))
    }

    /// The faults that explain the record, in the order in which they are undone; empty when the record needs none or
    /// none is known.
    pub(crate) fn faults(&self, candidates: &[RecordFault]) -> Vec<RecordFault> {
        let lines = &self.data.frequency_hz;
        let mut models = Models { list: vec![(1.0, (self.model)(lines))] };
        let now = self.rate_agreement(&self.distances(self.data, &models.list[0].1));
        let clock_is_right = now.mean < CLOCK_IS_RIGHT;
        let known: Vec<RecordFault> = candidates
            .iter()
            .filter(|c| !(clock_is_right && matches!(c, RecordFault::Clock { .. })))
            .copied()
            .collect();
        for factor in known.iter().map(|c| clock(std::slice::from_ref(c))) {
            if models.list.iter().all(|(f, _)| *f != factor) {
                let true_hz: Vec<f64> = lines.iter().map(|f| f / factor).collect();
                models.list.push((factor, (self.model)(&true_hz)));
            }
        }
        let mut found = self.best(&models, known.iter().map(|c| vec![*c]));
        if found.is_empty() && !now.plausible() {
            let pairs = (0..known.len()).flat_map(|a| (a + 1..known.len()).map(move |b| (a, b)));
            found = self.best(&models, pairs.map(|(a, b)| vec![known[a], known[b]]));
        }
        while !found.is_empty() && found.len() < MOST {
            let larger = known.iter().enumerate().filter(|(_, c)| !found.contains(c));
            let larger = larger.map(|(_, c)| {
                let both = |k: &&RecordFault| found.contains(k) || *k == c;
                known.iter().filter(both).copied().collect::<Vec<_>>()
            });
            let next = self.best(&models, larger);
            if next.is_empty() {
                break;
            }
            found = next;
        }
        found
    }

    /// Of the sets that are accepted the one that leaves least; empty without any.
    fn best(&self, models: &Models, sets: impl Iterator<Item = Vec<RecordFault>>) -> Vec<RecordFault> {
        let mut best = (f64::INFINITY, vec![]);
        for set in sets {
            let clocks = set.iter().filter(|f| matches!(f, RecordFault::Clock { .. }));
            if clocks.count() > 1 {
                continue;
            }
            let corrected = undone(self.data, self.outputs, &set);
            let left = self.distances(&corrected, models.of(&set));
            let rated = self.rate_agreement(&left);
            // Equal but for rounding: the earlier one stands.
            if !rated.plausible() || rated.mean > best.0 - 1e-9 {
                continue;
            }
            let needed =
                |rest: &[RecordFault], members: &[RecordFault]| self.score(models, &set, rest, members, &left) > NEEDED;
            let each = (0..set.len()).all(|k| {
                let mut rest = set.clone();
                let member = rest.remove(k);
                needed(&rest, &[member])
            });
            if each && needed(&[], &set) {
                best = (rated.mean, set);
            }
        }
        best.1
    }

    /// s of the `members` of a set on top of its `rest`, `left` the distances with the whole set undone.
    fn score(
        &self,
        models: &Models,
        set: &[RecordFault],
        rest: &[RecordFault],
        members: &[RecordFault],
        left: &Distances,
    ) -> f64 {
        let base = undone(self.data, self.outputs, rest);
        let before = self.distances(&base, models.of(rest));
        let moved = undone(models.of(set), self.outputs, members);
        let alone = self.distances(&moved, models.of(rest));
        let (mut gain, mut full, mut pairs) = (0.0, 0.0, 0usize);
        for ((before, left), alone) in before.iter().zip(left).zip(&alone) {
            for ((b, l), a) in before.iter().zip(left).zip(alone) {
                if let (Some(b), Some(l), Some(a)) = (b, l, a)
                    && *a > DISTINCT
                {
                    gain += b - l;
                    full += a;
                    pairs += 1;
                }
            }
        }
        let all = left.len() * self.compared.len();
        if (pairs as f64) < ENOUGH * all as f64 {
            return 0.0;
        }
        gain / full
    }

    fn distances(&self, data: &Spectrum, model: &Spectrum) -> Distances {
        let line = |(d, m): (&Vec<_>, &Vec<_>)| self.compared.iter().map(|k| distance(d, m, *k)).collect();
        data.entries.iter().zip(&model.entries).map(line).collect()
    }

    fn rate_agreement(&self, distances: &Distances) -> Agreement {
        let (mut sum, mut count) = (0.0, 0usize);
        for d in distances.iter().flatten().flatten() {
            sum += d;
            count += 1;
        }
        let of = |belongs: &dyn Fn(usize) -> bool| {
            median(distances.iter().flat_map(|line| {
                let pairs = line.iter().zip(self.compared);
                pairs.filter(|(_, k)| belongs(**k)).filter_map(|(d, _)| *d)
            }))
        };
        let rows = (0..self.outputs).filter_map(|i| of(&|k| k % self.outputs == i));
        let inputs = self.compared.iter().map(|k| k / self.outputs).max().unwrap_or(0);
        let columns = (0..=inputs).filter_map(|j| of(&|k| k / self.outputs == j));
        Agreement {
            mean: if count == 0 { 0.0 } else { sum / count as f64 },
            worst: rows.chain(columns).fold(0.0, f64::max),
        }
    }
}

fn distance(data: &[super::spectrum::LogValue], model: &[super::spectrum::LogValue], k: usize) -> Option<f64> {
    data.get(k)?.distance(model.get(k)?)
}
