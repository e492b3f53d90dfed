//! Poles, mode shapes and zeros of the full finite-element chain, without a reduced basis.
//!
//! Poles: the inertia of K − λM on a coarse grid brackets every eigenvalue, Rayleigh-quotient iteration finishes it.
//! Zeros: roots of cᵀ(K − λM)⁻¹b, equivalently of the pencil [[K − λM, b], [cᵀ, 0]]; the receptance times Π(1 − λ/λₖ)
//! over the poles found is smooth, so sign changes and touching minima on the grid bracket its roots; a safeguarded
//! secant finishes them. Symbols: λ = ω². Limits: real zeros with λ > 0 (antiresonances); complex and negative ones do
//! not show in a Bode plot.

use super::chain::{Blocks, Chain, ChainFactor, ChainPort};
use super::modes::PlanarModes;
use super::{Rotor, RotorError};
use std::f64::consts::TAU;

/// Ratio of neighbouring grid frequencies. Two zeros of one FRF closer than this are still found when they leave a
/// local minimum of the smooth function; bending modes of a spindle lie more than 10 % apart.
const GRID_RATIO: f64 = 1.06;
/// Relative accuracy of λ at which an iteration stops; rounding of xᵀKx for a free-free rotor is about 1e-11.
const LAMBDA_TOLERANCE: f64 = 1e-11;

/// What to look for.
#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    /// FRFs whose zeros are wanted: displacement port, force port.
    pub frfs: Vec<(ChainPort, ChainPort)>,
    /// Lowest frequency, Hz; rigid-body poles lie below.
    pub from_hz: f64,
    /// Highest frequency, Hz.
    pub to_hz: f64,
}

/// Poles, shapes and zeros between the limits of a [`Query`].
#[derive(Clone, Debug, PartialEq)]
pub struct ModalSpectrum {
    /// Number of poles below the lower limit: rigid modes, and what negative springs make unstable.
    pub below: usize,
    /// Natural frequencies, Hz, ascending.
    pub poles_hz: Vec<f64>,
    /// Mass-normalised shapes (w, ψ) at every node.
    pub shapes: Vec<Vec<[f64; 2]>>,
    /// Antiresonances, Hz, ascending, one list per FRF.
    pub zeros_hz: Vec<Vec<f64>>,
}

/// λ of a frequency.
pub fn lambda(frequency_hz: f64) -> f64 {
    (TAU * frequency_hz).powi(2)
}

/// Frequency of a λ.
pub(crate) fn hz(lambda: f64) -> f64 {
    lambda.max(0.0).sqrt() / TAU
}

/// Share of the first bending frequency from which on peaks are counted: below lie the rigid modes, which magnets make
/// unstable or which a suspension holds, and their zeros.
const LOWEST_SHARE: f64 = 0.1;

/// Where the peaks of the free-free rotor begin, Hz.
pub(crate) fn lowest_hz(rotor: &Rotor) -> Result<f64, RotorError> {
    let flexible = PlanarModes::new(rotor)?.flexible_hz();
    Ok(LOWEST_SHARE * flexible.first().copied().unwrap_or_default())
}

/// Computes the spectrum of the chain with the given modulus factors.
pub fn spectrum(chain: &Chain, factors: &[f64], query: &Query) -> ModalSpectrum {
    let stiffness = chain.stiffness(factors);
    let mut search = Search::new(&stiffness, &chain.mass, query);
    let grid = search.scan(query);
    let (poles, shapes) = search.poles(&grid);
    let zeros_hz = (0..query.frfs.len()).map(|k| search.zeros(&grid, &poles, k)).collect();
    ModalSpectrum {
        below: grid.first().map_or(0, |point| point.below),
        poles_hz: poles.iter().map(|l| hz(*l)).collect(),
        shapes,
        zeros_hz,
    }
}

struct GridPoint {
    lambda: f64,
    below: usize,
    receptance: Vec<f64>,
}

struct Search<'a> {
    stiffness: &'a Blocks,
    mass: &'a Blocks,
    factor: ChainFactor,
    /// Distinct ports and, per FRF, the indices of its two ports.
    ports: Vec<ChainPort>,
    frfs: Vec<(usize, usize)>,
    sweeps: Vec<Vec<[f64; 2]>>,
}

impl<'a> Search<'a> {
    fn new(stiffness: &'a Blocks, mass: &'a Blocks, query: &Query) -> Self {
        let mut ports: Vec<ChainPort> = vec![];
        let mut index = |p: &ChainPort| match ports.iter().position(|q| q == p) {
            Some(i) => i,
            None => {
                ports.push(*p);
                ports.len() - 1
            }
        };
        let frfs = query.frfs.iter().map(|(c, b)| (index(c), index(b))).collect();
        let nodes = mass.diagonal.len();
        Self {
            stiffness,
            mass,
            factor: ChainFactor::new(nodes),
            sweeps: vec![vec![[0.0; 2]; nodes]; ports.len()],
            ports,
            frfs,
        }
    }

    fn factorise(&mut self, lambda: f64) {
        self.factor.compute(self.stiffness, self.mass, lambda);
    }

    fn receptance(&mut self, frf: usize, sweep: bool) -> f64 {
        let (c, b) = self.frfs[frf];
        if sweep {
            for i in [c, b] {
                self.factor.forward(&self.ports[i], &mut self.sweeps[i]);
            }
        }
        self.factor.receptance((&self.ports[c], &self.sweeps[c]), (&self.ports[b], &self.sweeps[b]))
    }

    fn scan(&mut self, query: &Query) -> Vec<GridPoint> {
        let decades = (query.to_hz / query.from_hz).max(1.0).ln();
        let points = (decades / GRID_RATIO.ln()).ceil() as usize + 1;
        let step = (decades / (points.max(2) - 1) as f64).exp();
        let mut f = query.from_hz;
        (0..points.max(2))
            .map(|_| {
                let at = lambda(f);
                f *= step;
                self.factorise(at);
                for (port, sweep) in self.ports.iter().zip(&mut self.sweeps) {
                    self.factor.forward(port, sweep);
                }
                GridPoint {
                    lambda: at,
                    below: self.factor.below,
                    receptance: (0..self.frfs.len()).map(|k| self.receptance(k, false)).collect(),
                }
            })
            .collect()
    }

    fn poles(&mut self, grid: &[GridPoint]) -> (Vec<f64>, Vec<Vec<[f64; 2]>>) {
        let (mut values, mut shapes) = (vec![], vec![]);
        for pair in grid.windows(2) {
            let mut stack = vec![(pair[0].lambda, pair[0].below, pair[1].lambda, pair[1].below, 0)];
            while let Some((lo, n_lo, hi, n_hi, depth)) = stack.pop() {
                if n_hi <= n_lo {
                    continue;
                }
                if n_hi - n_lo == 1
                    && let Some((value, shape)) = self.rayleigh(lo, hi)
                {
                    values.push(value);
                    shapes.push(shape);
                    continue;
                }
                let mid = 0.5 * (lo + hi);
                // Fifty halvings reach the last bit of λ: what is left is one eigenvalue of that multiplicity.
                if depth >= 50 {
                    continue;
                }
                self.factorise(mid);
                let n_mid = self.factor.below.clamp(n_lo, n_hi);
                stack.push((mid, n_mid, hi, n_hi, depth + 1));
                stack.push((lo, n_lo, mid, n_mid, depth + 1));
            }
        }
        (values, shapes)
    }

    /// Rayleigh-quotient iteration from the middle of a bracket with one eigenvalue; `None` when it leaves the bracket.
    fn rayleigh(&mut self, lo: f64, hi: f64) -> Option<(f64, Vec<[f64; 2]>)> {
        let nodes = self.mass.diagonal.len();
        // A start vector with every bending shape in it: an arbitrary irrational sequence.
        let mut x: Vec<[f64; 2]> = (0..nodes).map(|i| [(0.5 + i as f64 * 0.618_034).fract() - 0.4, 0.3]).collect();
        let mut shift = 0.5 * (lo + hi);
        let mut last = f64::NAN;
        for iteration in 0..12 {
            self.factorise(shift);
            let mut y = self.mass.times(&x);
            self.factor.solve(&mut y);
            let norm = self.mass.quadratic(&y, &y);
            if norm.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) || !norm.is_finite() {
                return None;
            }
            let scale = norm.sqrt().recip();
            for v in &mut y {
                v[0] *= scale;
                v[1] *= scale;
            }
            x = y;
            let value = self.stiffness.quadratic(&x, &x);
            if (value - last).abs() <= LAMBDA_TOLERANCE * value.abs() {
                return (value > lo && value < hi).then(|| (value, orient_shape(x)));
            }
            last = value;
            // Two steps at the fixed shift purify the vector; then the quotient takes over, cubically.
            if iteration >= 1 {
                if value <= lo || value >= hi {
                    return None;
                }
                shift = value;
            }
        }
        None
    }

    fn zeros(&mut self, grid: &[GridPoint], poles: &[f64], frf: usize) -> Vec<f64> {
        let smooth = |at: f64, h: f64| poles.iter().fold(h * at, |n, p| n * (1.0 - at / p));
        let values: Vec<f64> = grid.iter().map(|g| smooth(g.lambda, g.receptance[frf])).collect();
        let mut eval = |at: f64| {
            self.factorise(at);
            smooth(at, self.receptance(frf, true))
        };
        let mut found = vec![];
        for i in 1..grid.len() {
            let (a, b) = (grid[i - 1].lambda, grid[i].lambda);
            let (fa, fb) = (values[i - 1], values[i]);
            if fa * fb <= 0.0 {
                found.push(root(a, fa, b, fb, &mut eval));
            } else if let (Some(next), Some(fc)) = (grid.get(i + 1), values.get(i + 1)) {
                let touches = fb.abs() < fa.abs() && fb.abs() < fc.abs() && fb * fc > 0.0;
                if touches && let Some((m, fm)) = crossing((a, fa), (b, fb), (next.lambda, *fc), &mut eval) {
                    found.push(root(a, fa, m, fm, &mut eval));
                    found.push(root(m, fm, next.lambda, *fc, &mut eval));
                }
            }
        }
        found.sort_by(f64::total_cmp);
        found.into_iter().map(hz).collect()
    }
}

/// Sign convention: the larger of the two end displacements is positive.
fn orient_shape(mut x: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let ends = [x.first(), x.last()].map(|e| e.map_or(0.0, |v| v[0]));
    let lead = if ends[0].abs() >= ends[1].abs() { ends[0] } else { ends[1] };
    if lead < 0.0 {
        for v in &mut x {
            *v = [-v[0], -v[1]];
        }
    }
    x
}

/// A point between the outer two where the function has the other sign, by parabolic descent of |f|; `None` when its
/// minimum stays clear of zero.
fn crossing(
    mut a: (f64, f64),
    mut b: (f64, f64),
    mut c: (f64, f64),
    eval: &mut impl FnMut(f64) -> f64,
) -> Option<(f64, f64)> {
    let sign = b.1.signum();
    // Eight parabolic steps gain two digits each near a minimum; more would only polish a miss.
    for _ in 0..8 {
        let (p, q) = (b.0 - a.0, b.0 - c.0);
        let (u, v) = (p * (b.1 - c.1), q * (b.1 - a.1));
        let at = b.0 - 0.5 * (p * u - q * v) / (u - v);
        let bottom = {
            // Value of the parabola at its vertex.
            let slope = (b.1 - a.1) / p;
            let curve = ((c.1 - b.1) / (c.0 - b.0) - slope) / (c.0 - a.0);
            a.1 + slope * (at - a.0) + curve * (at - a.0) * (at - b.0)
        };
        // A vertex at more than half the smallest sample will not reach zero.
        if !at.is_finite() || at <= a.0 || at >= c.0 || bottom * sign > 0.5 * b.1.abs() {
            return None;
        }
        let f = eval(at);
        if f * sign <= 0.0 {
            return Some((at, f));
        }
        if f.abs() >= b.1.abs() {
            return None;
        }
        if at < b.0 {
            c = b;
        } else {
            a = b;
        }
        b = (at, f);
    }
    None
}

/// Root of a function in a bracket: regula falsi with the Illinois safeguard.
fn root(mut a: f64, mut fa: f64, mut b: f64, mut fb: f64, eval: &mut impl FnMut(f64) -> f64) -> f64 {
    let mut side = 0;
    let mut x = b;
    for _ in 0..60 {
        let previous = x;
        x = if fb == fa { 0.5 * (a + b) } else { (fa * b - fb * a) / (fa - fb) };
        if !(x > a.min(b) && x < a.max(b)) {
            x = 0.5 * (a + b);
        }
        if (x - previous).abs() <= LAMBDA_TOLERANCE * x.abs() || (b - a).abs() <= LAMBDA_TOLERANCE * x.abs() {
            return x;
        }
        let f = eval(x);
        if f == 0.0 {
            return x;
        }
        if f * fb > 0.0 {
            (b, fb) = (x, f);
            if side == -1 {
                fa *= 0.5;
            }
            side = -1;
        } else {
            (a, fa) = (x, f);
            if side == 1 {
                fb *= 0.5;
            }
            side = 1;
        }
    }
    x
}
