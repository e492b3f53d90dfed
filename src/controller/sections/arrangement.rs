//! Roots coupled to sections. Pairing: the poles nearest the unit circle take the zeros nearest to them; sections run
//! from damped to resonant.
//! Two real roots in one section cost precision: rounding of a₁ and a₂ moves (1 − p)(1 − q) by an amount that does not
//! depend on it. Roots near ±1 may therefore stand alone.

use super::roots::AxisRoots;
use super::section::SectionBiquad;
use crate::linalg::c64;

/// Two real roots share a section where rounding of its coefficients by up to 9e-8 changes (1 ∓ p)(1 ∓ q) by less than
/// 1e-4.
pub(super) const SMALLEST_PRODUCT: f64 = 1e-3;

/// Roots of one section.
struct Plan {
    poles: Vec<c64>,
    zeros: Vec<c64>,
    delay: usize,
}

impl Plan {
    fn radius(&self) -> f64 {
        self.poles.iter().map(|p| p.norm()).fold(0.0, f64::max)
    }

    fn numerator(&self) -> usize {
        self.zeros.len() + self.delay
    }
}

/// Sections with numerators that begin with one, whose product times the gain is the axis; none for a gain. Real roots
/// p, q share a section when |(1 ∓ p)(1 ∓ q)| is at least `smallest_product`.
pub(super) fn arrange(roots: &AxisRoots, smallest_product: f64) -> Vec<SectionBiquad> {
    let plan = |poles: Vec<c64>| Plan { poles, zeros: vec![], delay: 0 };
    let mut plans: Vec<Plan> = groups(&roots.poles, smallest_product).into_iter().map(plan).collect();
    // Most resonant first, so that it chooses its zeros first; what has room for two zeros before what has not.
    plans.sort_by(|p, q| q.poles.len().cmp(&p.poles.len()).then(q.radius().total_cmp(&p.radius())));
    let mut zeros = groups(&roots.zeros, smallest_product);
    for plan in &mut plans {
        let room = plan.poles.len();
        let distance = |group: &Vec<c64>| (group[0] - plan.poles[0]).norm();
        let order = |group: &Vec<c64>| (room - group.len(), distance(group));
        let fitting = (0..zeros.len()).filter(|k| zeros[*k].len() <= room);
        let nearest = fitting.min_by(|i, j| {
            let (first, second) = (order(&zeros[*i]), order(&zeros[*j]));
            first.0.cmp(&second.0).then(first.1.total_cmp(&second.1))
        });
        if let Some(k) = nearest {
            plan.zeros = zeros.remove(k);
        }
    }
    for group in zeros {
        match plans.iter_mut().find(|p| p.zeros.is_empty()) {
            Some(free) => free.zeros = group,
            None => plans.push(Plan { poles: vec![], zeros: group, delay: 0 }),
        }
    }
    for _ in 0..roots.delay {
        let without_state = plans.iter().position(|p| p.numerator() < p.poles.len());
        match without_state.or_else(|| plans.iter().position(|p| p.numerator() < 2)) {
            Some(k) => plans[k].delay += 1,
            None => plans.push(Plan { poles: vec![], zeros: vec![], delay: 1 }),
        }
    }
    plans.sort_by(|p, q| p.radius().total_cmp(&q.radius()));
    plans.iter().map(|p| SectionBiquad::of_roots(&p.poles, &p.zeros, p.delay)).collect()
}

/// Conjugate pairs, and real roots coupled as the product allows: the one nearest to ±1 with the farthest.
fn groups(roots: &[c64], smallest_product: f64) -> Vec<Vec<c64>> {
    let mut list: Vec<Vec<c64>> = roots.iter().filter(|r| r.im > 0.0).map(|r| vec![*r, r.conj()]).collect();
    let mut real: Vec<c64> = roots.iter().filter(|r| r.im == 0.0).copied().collect();
    let distance = |r: &c64| (1.0 - r.re).abs().min((1.0 + r.re).abs());
    real.sort_by(|p, q| distance(p).total_cmp(&distance(q)));
    let product = |p: c64, q: c64| ((1.0 - p.re) * (1.0 - q.re)).abs().min(((1.0 + p.re) * (1.0 + q.re)).abs());
    while let Some(far) = real.pop() {
        match real.first().copied() {
            Some(near) if product(near, far) >= smallest_product => {
                real.remove(0);
                list.push(vec![near, far]);
            }
            Some(near) => {
                // Nothing is farther from ±1 than the last: the first stands alone.
                real.remove(0);
                real.push(far);
                list.push(vec![near]);
            }
            None => list.push(vec![far]),
        }
    }
    list
}
