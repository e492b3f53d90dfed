//! Coefficients of a cascade in single precision. Of the neighbours of a denominator those that move the response
//! least; numerators share the gain of the axis among them as suits their rounding: the factor of each is free but for
//! one, and among some hundred factors one lets b₀ + b₁ + b₂ come out hundred times closer than rounding alone does.

use super::band::Band;
use super::section::SectionBiquad;
use crate::controller::fidelity::count_growing;

/// Factors of a numerator that are tried, from one to two.
const FACTORS: usize = 256;
/// A cascade whose gain costs more than this, relative to the response, gets a section for the gain alone.
const COSTLY_GAIN: f64 = 1e-4;

/// A numerator as held, and what its rounding does.
struct RoundedNumerator {
    b: [f64; 3],
    factor: f64,
    change: f64,
}

/// The cascade with a gain, every coefficient a single-precision number. Coefficients that overflow are infinite.
pub(super) fn round_cascade(sections: &[SectionBiquad], gain: f64, band: &Band) -> Vec<SectionBiquad> {
    let numerators: Vec<RoundedNumerator> = sections.iter().map(|s| free_numerator(s, band)).collect();
    let product: f64 = numerators.iter().map(|n| n.factor).product();
    // The section that takes the rest of the gain: the one that loses least by it.
    let with_rest = |k: usize| {
        let factor = gain / product * numerators[k].factor;
        numerator_times(&sections[k], factor, band)
    };
    let cheapest = (0..sections.len()).map(|k| (k, with_rest(k))).min_by(|x, y| x.1.change.total_cmp(&y.1.change));
    let mut held: Vec<SectionBiquad> = sections
        .iter()
        .zip(&numerators)
        .map(|(s, n)| SectionBiquad { a: rounded_denominator(s, band), ..s.with_numerator(n.b) })
        .collect();
    match cheapest.filter(|(_, numerator)| numerator.change <= COSTLY_GAIN) {
        Some((k, numerator)) => held[k] = held[k].with_numerator(numerator.b),
        None => held.push(SectionBiquad::of_gain(single(gain / product))),
    }
    held
}

fn single(value: f64) -> f64 {
    f64::from(value as f32)
}

fn numerator_times(section: &SectionBiquad, factor: f64, band: &Band) -> RoundedNumerator {
    let exact = section.b.map(|b| b * factor);
    let b = exact.map(single);
    RoundedNumerator { b, factor, change: band.polynomial_change(exact, b) }
}

/// The numerator with the factor that suits it best, of those that bring the gain in the middle of the band near one.
fn free_numerator(section: &SectionBiquad, band: &Band) -> RoundedNumerator {
    let level = section.levelling_factor();
    let mut best = numerator_times(section, level, band);
    for k in 1..FACTORS {
        // Rounding of what is within the last digits of single precision is not worth a search.
        if best.change <= f64::from(f32::EPSILON) {
            break;
        }
        let found = numerator_times(section, level * (k as f64 / FACTORS as f64).exp2(), band);
        if found.change < best.change {
            best = found;
        }
    }
    best
}

/// The neighbours of a₁ and a₂ that change the response least; as many poles grow as before.
fn rounded_denominator(section: &SectionBiquad, band: &Band) -> [f64; 2] {
    let exact = section.denominator();
    let [first, second] = section.a.map(neighbours);
    let growing = |a: [f64; 2]| count_growing(&SectionBiquad { a, ..*section }.poles());
    let all = first.iter().flat_map(|a1| second.iter().map(move |a2| [*a1, *a2]));
    let kept = all.filter(|a| growing(*a) == growing(section.a));
    let judged = kept.map(|a| (a, band.polynomial_change(exact, [1.0, a[0], a[1]])));
    let best = judged.min_by(|x, y| x.1.total_cmp(&y.1));
    best.map_or_else(|| section.a.map(single), |(a, _)| a)
}

/// The nearest single-precision number and two on either side; zero alone for zero, and a number that it holds.
fn neighbours(value: f64) -> Vec<f64> {
    let nearest = value as f32;
    if f64::from(nearest) == value {
        return vec![value];
    }
    let (up, down) = (nearest.next_up(), nearest.next_down());
    [nearest, up, down, up.next_up(), down.next_down()].map(f64::from).to_vec()
}
