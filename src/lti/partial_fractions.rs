//! A real transfer function as polynomial and partial fractions, f(s) = Σ c_k s^k + Σ r/(s − p), and its fit to values
//! on the imaginary axis with all poles in the left half plane.
//!
//! The fit is vector fitting (Gustavsen and Semlyen, IEEE Trans. Power Delivery 14, 1999): with poles a_k,
//! f(s) σ(s) ≈ Σ c_k s^k + Σ r_k/(s − a_k), σ(s) = 1 + Σ q_k/(s − a_k), is linear in the unknowns, and the zeros of σ,
//! the eigenvalues of diag(a) − 1 qᵀ, are the next poles. A pole that leaves the half plane is reflected into it.

use super::state_space::{Continuous, StateSpace};
use crate::linalg::dense::solve_normal;
use crate::linalg::{Mat, NumericError, c64, eigenvalues};

/// Rounds of moving the poles; a resonance settles in five.
const ROUNDS: usize = 12;

/// r/(s − p), with its conjugate where p is complex.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fraction {
    pole: c64,
    residue: c64,
}

/// A real transfer function.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PartialFractions {
    /// c_k, of ascending powers of s in rad/s.
    pub polynomial: Vec<f64>,
    fractions: Vec<Fraction>,
}

/// A value to fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FitLine {
    pub omega_rad_s: f64,
    pub value: c64,
    /// 1/σ².
    pub weight: f64,
}

/// Poles in the closed upper half plane; one that is not real stands for its conjugate too.
type Poles = Vec<c64>;

impl PartialFractions {
    /// The value at jω.
    pub(crate) fn at(&self, omega_rad_s: f64) -> c64 {
        let s = c64::new(0.0, omega_rad_s);
        let whole = self.polynomial.iter().rev().fold(c64::new(0.0, 0.0), |sum, c| sum * s + *c);
        self.fractions.iter().fold(whole, |sum, own| {
            let other =
                if own.pole.im == 0.0 { c64::new(0.0, 0.0) } else { own.residue.conj() / (s - own.pole.conj()) };
            sum + own.residue / (s - own.pole) + other
        })
    }

    /// Number of poles.
    pub(crate) fn order(&self) -> usize {
        self.fractions.iter().map(|own| if own.pole.im == 0.0 { 1 } else { 2 }).sum()
    }

    /// The same without its powers of s: what has a state space.
    #[must_use]
    pub(crate) fn without_powers(&self) -> Self {
        Self { polynomial: self.polynomial.iter().take(1).copied().collect(), fractions: self.fractions.clone() }
    }

    /// As a state space, 1×1; of the polynomial the constant alone.
    pub(crate) fn state_space(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let n = self.order();
        let (mut a, mut b, mut c) = (Mat::zeros(n, n), Mat::zeros(n, 1), Mat::zeros(1, n));
        let mut k = 0;
        for Fraction { pole, residue } in &self.fractions {
            // States of the size of the input, r/(s − p) = (r/|p|) |p|/(s − p).
            let size = pole.norm();
            a[(k, k)] = pole.re;
            b[(k, 0)] = size;
            c[(0, k)] = residue.re / size;
            k += 1;
            if pole.im != 0.0 {
                // 2 Re of the complex state z' = p z + |p| u.
                a[(k, k)] = pole.re;
                a[(k - 1, k)] = -pole.im;
                a[(k, k - 1)] = pole.im;
                c[(0, k - 1)] = 2.0 * residue.re / size;
                c[(0, k)] = -2.0 * residue.im / size;
                k += 1;
            }
        }
        let direct = self.polynomial.first().copied().unwrap_or_default();
        StateSpace::new(a, b, c, Mat::from_fn(1, 1, |_, _| direct), Continuous)
    }

    /// Fits `order` stable poles and the first `powers` powers of s, from poles spread over the band of the lines.
    ///
    /// # Errors
    /// [`NumericError`] when the equations have no solution: too few lines, or more terms than the values show.
    pub(crate) fn fit(lines: &[FitLine], order: usize, powers: usize) -> Result<Self, NumericError> {
        // Frequencies of order one, so that powers stay comparable.
        let unit = lines.iter().map(|line| line.omega_rad_s).fold(f64::MIN_POSITIVE, f64::max);
        let scaled: Vec<FitLine> =
            lines.iter().map(|line| FitLine { omega_rad_s: line.omega_rad_s / unit, ..*line }).collect();
        let mut poles = spread_poles(&scaled, order);
        for _ in 0..if order == 0 { 0 } else { ROUNDS } {
            poles = move_poles(&scaled, &poles, powers)?;
        }
        let terms = real_terms(&poles);
        let count = terms.len();
        let found = solve_lines(&scaled, powers + count, |_, s, k| match k.checked_sub(powers) {
            None => s.powi(k as i32),
            Some(k) => terms[k].at(s),
        })?;
        let mut residues = found[powers..].iter();
        let mut next = || residues.next().copied().unwrap_or_default();
        let fractions = poles
            .iter()
            .map(|pole| {
                let first = next();
                let residue = if pole.im == 0.0 { c64::new(first, 0.0) } else { c64::new(first, next()) };
                Fraction { pole: pole * unit, residue: residue * unit }
            })
            .collect();
        let polynomial = found[..powers].iter().enumerate().map(|(k, c)| c / unit.powi(k as i32)).collect();
        Ok(Self { polynomial, fractions })
    }
}

/// A basis function with real coefficient: 1/(s − p), of a pair 1/(s − p) + 1/(s − p̄) and j/(s − p) − j/(s − p̄).
struct RealTerm {
    pole: c64,
    /// 0 of a real pole, 1 and 2 of a pair.
    part: usize,
}

impl RealTerm {
    fn at(&self, s: c64) -> c64 {
        let (own, other) = ((s - self.pole).inv(), (s - self.pole.conj()).inv());
        match self.part {
            0 => own,
            1 => own + other,
            _ => (own - other) * c64::new(0.0, 1.0),
        }
    }
}

fn real_terms(poles: &[c64]) -> Vec<RealTerm> {
    let parts = |pole: &c64| if pole.im == 0.0 { 0..1 } else { 1..3 };
    poles.iter().flat_map(|pole| parts(pole).map(|part| RealTerm { pole: *pole, part })).collect()
}

/// Lightly damped pairs over the band, and a real pole where the order is odd.
fn spread_poles(lines: &[FitLine], order: usize) -> Poles {
    let band = lines.iter().map(|line| line.omega_rad_s).filter(|w| *w > 0.0);
    let (from, to) = band.fold((f64::INFINITY, 0.0f64), |(from, to), w| (from.min(w), to.max(w)));
    let pairs = order / 2;
    let at = |k: usize| from * (to / from).powf((k as f64 + 0.5) / pairs as f64);
    let mut poles: Poles = (0..pairs).map(|k| c64::new(-0.05, 1.0) * at(k)).collect();
    if order % 2 == 1 {
        poles.push(c64::new(-(from * to).sqrt(), 0.0));
    }
    poles
}

/// The zeros of σ for these poles, in the left half plane.
fn move_poles(lines: &[FitLine], poles: &[c64], powers: usize) -> Result<Poles, NumericError> {
    let terms = real_terms(poles);
    let n = terms.len();
    let found = solve_lines(lines, powers + 2 * n, |value, s, k| match k.checked_sub(powers) {
        None => s.powi(k as i32),
        Some(k) if k < n => terms[k].at(s),
        Some(k) => -terms[k - n].at(s) * value,
    })?;
    let q = &found[powers + n..];
    // diag(a) − b qᵀ in real form: a pair is [[Re, Im], [−Im, Re]] with b = (2, 0).
    let mut a = Mat::zeros(n, n);
    let mut b = vec![0.0; n];
    for (k, term) in terms.iter().enumerate() {
        a[(k, k)] = term.pole.re;
        match term.part {
            0 => b[k] = 1.0,
            1 => {
                b[k] = 2.0;
                a[(k, k + 1)] = term.pole.im;
                a[(k + 1, k)] = -term.pole.im;
            }
            _ => {}
        }
    }
    let zeros = eigenvalues(&Mat::from_fn(n, n, |i, j| a[(i, j)] - b[i] * q[j]))?;
    let upper = zeros.into_iter().filter(|z| z.im >= 0.0);
    // A pole on the axis, or at the origin, would be none of the half plane after its reflection.
    let inside = |z: c64| c64::new(-z.re.abs().max(1e-9 * z.norm().max(1e-9)), z.im);
    Ok(upper.map(inside).collect())
}

/// Real unknowns of weighted equations Σ_k x_k (term k of a line) = value of the line, least squares. `term` gives the
/// factor of an unknown from the value of a line and its s.
fn solve_lines(
    lines: &[FitLine],
    unknowns: usize,
    term: impl Fn(c64, c64, usize) -> c64,
) -> Result<Vec<f64>, NumericError> {
    let (mut normal, mut right) = (Mat::zeros(unknowns, unknowns), Mat::zeros(unknowns, 1));
    let mut row = vec![c64::new(0.0, 0.0); unknowns];
    for line in lines.iter().filter(|line| line.weight > 0.0) {
        let s = c64::new(0.0, line.omega_rad_s);
        for (k, entry) in row.iter_mut().enumerate() {
            *entry = term(line.value, s, k);
        }
        for i in 0..unknowns {
            for j in 0..unknowns {
                normal[(i, j)] += line.weight * (row[i].conj() * row[j]).re;
            }
            right[(i, 0)] += line.weight * (row[i].conj() * line.value).re;
        }
    }
    let found = solve_normal(&normal, &right)?;
    Ok((0..unknowns).map(|k| found[(k, 0)]).collect())
}
