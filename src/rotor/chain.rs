//! One plane of the free-free rotor as a chain of nodes: block-tridiagonal pencil K(θ) − λM with 2×2 blocks (w, ψ).
//!
//! Factorisation  S₀ = A₀,  Sᵢ = Aᵢ − Oᵢ₋₁ᵀ Sᵢ₋₁⁻¹ Oᵢ₋₁  with A = K − λM; the inertia of the Sᵢ is that of A
//! (Sylvester), so the number of eigenvalues below λ is known at every λ; receptances are cᵀA⁻¹b = Σ yc,ᵢᵀ Sᵢ⁻¹ yb,ᵢ
//! with forward sweeps y only.
//! Symbols: λ = ω²; θ = modulus factor per region; K(θ) = K₀ + Σ θᵣKᵣ exactly, because a factor scales E and G
//! together. Limits: beam elements in series with two dofs a node, undamped, at rest. Cost about a microsecond a
//! factorisation.

/// A symmetric block-tridiagonal matrix with 2×2 blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    /// Diagonal blocks (11, 12, 22), one a node.
    pub diagonal: Vec<[f64; 3]>,
    /// Blocks from node i to node i + 1 (11, 12, 21, 22).
    pub off: Vec<[f64; 4]>,
}

impl Blocks {
    /// Zero matrix for a number of nodes.
    pub(crate) fn zeros(nodes: usize) -> Self {
        Self { diagonal: vec![[0.0; 3]; nodes], off: vec![[0.0; 4]; nodes.saturating_sub(1)] }
    }

    /// Adds `scale` times a symmetric 4×4 element matrix between nodes `node` and `node + 1`.
    pub(crate) fn add_element(&mut self, node: usize, matrix: &[[f64; 4]; 4], scale: f64) {
        let m = matrix;
        for (at, s) in [(node, 0), (node + 1, 2)] {
            let d = &mut self.diagonal[at];
            d[0] += scale * m[s][s];
            d[1] += scale * m[s][s + 1];
            d[2] += scale * m[s + 1][s + 1];
        }
        let o = &mut self.off[node];
        o[0] += scale * m[0][2];
        o[1] += scale * m[0][3];
        o[2] += scale * m[1][2];
        o[3] += scale * m[1][3];
    }

    /// xᵀ·self·y for two nodal vectors.
    pub(crate) fn quadratic(&self, x: &[[f64; 2]], y: &[[f64; 2]]) -> f64 {
        let mut sum = 0.0;
        for ((d, x), y) in self.diagonal.iter().zip(x).zip(y) {
            sum += x[0] * (d[0] * y[0] + d[1] * y[1]) + x[1] * (d[1] * y[0] + d[2] * y[1]);
        }
        for (o, (x, y)) in self.off.iter().zip(x.windows(2).zip(y.windows(2))) {
            sum += x[0][0] * (o[0] * y[1][0] + o[1] * y[1][1])
                + x[0][1] * (o[2] * y[1][0] + o[3] * y[1][1])
                + y[0][0] * (o[0] * x[1][0] + o[1] * x[1][1])
                + y[0][1] * (o[2] * x[1][0] + o[3] * x[1][1]);
        }
        sum
    }

    pub(crate) fn times(&self, x: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut y: Vec<[f64; 2]> =
            self.diagonal.iter().zip(x).map(|(d, x)| [d[0] * x[0] + d[1] * x[1], d[1] * x[0] + d[2] * x[1]]).collect();
        for (i, o) in self.off.iter().enumerate() {
            let (a, b) = (x[i], x[i + 1]);
            y[i][0] += o[0] * b[0] + o[1] * b[1];
            y[i][1] += o[2] * b[0] + o[3] * b[1];
            y[i + 1][0] += o[0] * a[0] + o[2] * a[1];
            y[i + 1][1] += o[1] * a[0] + o[3] * a[1];
        }
        y
    }
}

/// The elements that share one modulus factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Name in the spindle or tool file.
    pub name: String,
    /// Axial centre of the region, m from the nose face (tool side negative).
    pub position_m: f64,
    /// First node and stiffness at factor 1 of every element.
    pub elements: Vec<(usize, [[f64; 4]; 4])>,
}

/// A displacement or force at an axial position: weights on (w, ψ) of `node` and of `node + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainPort {
    /// First node.
    pub node: usize,
    /// Shape functions of the element at the position; the last two are zero at the last node.
    pub weights: [f64; 4],
}

impl ChainPort {
    /// Value of a nodal vector at the port.
    pub fn read(&self, x: &[[f64; 2]]) -> f64 {
        let w = &self.weights;
        let here = x.get(self.node).map_or(0.0, |v| w[0] * v[0] + w[1] * v[1]);
        let next = x.get(self.node + 1).map_or(0.0, |v| w[2] * v[0] + w[3] * v[1]);
        here + next
    }
}

/// One plane of a rotor whose stiffness depends on the modulus factors of its regions.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Axial position of every node, m from the nose face.
    pub position_m: Vec<f64>,
    /// Mass matrix, discs included.
    pub mass: Blocks,
    /// Stiffness of everything that belongs to no region.
    pub fixed: Blocks,
    /// Update regions.
    pub regions: Vec<Region>,
}

impl Chain {
    pub(crate) fn nodes(&self) -> usize {
        self.position_m.len()
    }

    /// Stiffness K₀ + Σ θᵣKᵣ.
    pub(crate) fn stiffness(&self, factors: &[f64]) -> Blocks {
        let mut k = self.fixed.clone();
        for (region, factor) in self.regions.iter().zip(factors) {
            for (node, element) in &region.elements {
                k.add_element(*node, element, *factor);
            }
        }
        k
    }

    /// The chain with a spring to ground at a port; a negative stiffness is the pull of a magnet.
    pub(crate) fn with_spring(&self, port: &ChainPort, stiffness_n_per_m: f64) -> Self {
        let w = &port.weights;
        let mut chain = self.clone();
        if port.node + 1 < chain.nodes() {
            let k = std::array::from_fn(|i| std::array::from_fn(|j| stiffness_n_per_m * w[i] * w[j]));
            chain.fixed.add_element(port.node, &k, 1.0);
        } else if let Some(d) = chain.fixed.diagonal.get_mut(port.node) {
            d[0] += stiffness_n_per_m * w[0] * w[0];
            d[1] += stiffness_n_per_m * w[0] * w[1];
            d[2] += stiffness_n_per_m * w[1] * w[1];
        }
        chain
    }

    /// xᵀ Kᵣ y of a region at factor 1.
    pub(crate) fn region_energy(&self, region: &Region, x: &[[f64; 2]], y: &[[f64; 2]]) -> f64 {
        let mut sum = 0.0;
        for (node, k) in &region.elements {
            let local = |v: &[[f64; 2]]| [v[*node][0], v[*node][1], v[node + 1][0], v[node + 1][1]];
            let (a, b) = (local(x), local(y));
            for (row, a) in k.iter().zip(a) {
                sum += a * row.iter().zip(b).map(|(k, b)| k * b).sum::<f64>();
            }
        }
        sum
    }
}

/// Scratch for repeated factorisations of K − λM.
#[derive(Clone, Debug)]
pub(crate) struct ChainFactor {
    /// Sᵢ⁻¹ (11, 12, 22).
    inverse: Vec<[f64; 3]>,
    /// Oᵢ of the matrix that was factorised.
    off: Vec<[f64; 4]>,
    /// Number of negative eigenvalues: modes below λ.
    pub below: usize,
}

impl ChainFactor {
    /// Scratch for a number of nodes.
    pub(crate) fn new(nodes: usize) -> Self {
        Self { inverse: vec![[0.0; 3]; nodes], off: vec![[0.0; 4]; nodes.saturating_sub(1)], below: 0 }
    }

    /// Factorises K − λM in place.
    pub(crate) fn compute(&mut self, stiffness: &Blocks, mass: &Blocks, lambda: f64) {
        self.below = 0;
        let mut carry = [0.0f64; 3];
        for (i, (k, m)) in stiffness.diagonal.iter().zip(&mass.diagonal).enumerate() {
            let a = k[0] - lambda * m[0] - carry[0];
            let b = k[1] - lambda * m[1] - carry[1];
            let d = k[2] - lambda * m[2] - carry[2];
            let mut det = a * d - b * b;
            if det == 0.0 {
                // Exactly singular leading block: the smallest shift that keeps the sweep going.
                det = f64::EPSILON * (a * d).abs().max(f64::MIN_POSITIVE);
            }
            self.below += if det < 0.0 {
                1
            } else if a + d < 0.0 {
                2
            } else {
                0
            };
            let s = [d / det, -b / det, a / det];
            self.inverse[i] = s;
            if let (Some(ko), Some(mo)) = (stiffness.off.get(i), mass.off.get(i)) {
                let o =
                    [ko[0] - lambda * mo[0], ko[1] - lambda * mo[1], ko[2] - lambda * mo[2], ko[3] - lambda * mo[3]];
                self.off[i] = o;
                // T = S⁻¹O, carry = OᵀT.
                let t = [
                    s[0] * o[0] + s[1] * o[2],
                    s[0] * o[1] + s[1] * o[3],
                    s[1] * o[0] + s[2] * o[2],
                    s[1] * o[1] + s[2] * o[3],
                ];
                carry = [o[0] * t[0] + o[2] * t[2], o[0] * t[1] + o[2] * t[3], o[1] * t[1] + o[3] * t[3]];
            }
        }
    }

    fn apply(&self, i: usize, y: [f64; 2]) -> [f64; 2] {
        let s = &self.inverse[i];
        [s[0] * y[0] + s[1] * y[1], s[1] * y[0] + s[2] * y[1]]
    }

    /// Forward sweep of a port vector into `y`; entries before the port's node stay untouched.
    pub(crate) fn forward(&self, port: &ChainPort, y: &mut [[f64; 2]]) {
        let w = &port.weights;
        let mut current = [w[0], w[1]];
        for (i, slot) in y.iter_mut().enumerate().skip(port.node) {
            *slot = current;
            let t = self.apply(i, current);
            let mut next = if i == port.node { [w[2], w[3]] } else { [0.0, 0.0] };
            if let Some(o) = self.off.get(i) {
                next[0] -= o[0] * t[0] + o[2] * t[1];
                next[1] -= o[1] * t[0] + o[3] * t[1];
            }
            current = next;
        }
    }

    /// cᵀ(K − λM)⁻¹b from the forward sweeps of two ports.
    pub(crate) fn receptance(&self, c: (&ChainPort, &[[f64; 2]]), b: (&ChainPort, &[[f64; 2]])) -> f64 {
        let start = c.0.node.max(b.0.node);
        (start..self.inverse.len())
            .map(|i| {
                let t = self.apply(i, b.1[i]);
                c.1[i][0] * t[0] + c.1[i][1] * t[1]
            })
            .sum()
    }

    /// (K − λM)⁻¹ times a nodal vector, in place.
    pub(crate) fn solve(&self, x: &mut [[f64; 2]]) {
        let n = self.inverse.len();
        for i in 1..n {
            let t = self.apply(i - 1, x[i - 1]);
            let o = &self.off[i - 1];
            x[i][0] -= o[0] * t[0] + o[2] * t[1];
            x[i][1] -= o[1] * t[0] + o[3] * t[1];
        }
        for i in (0..n).rev() {
            let mut y = x[i];
            if i + 1 < n {
                let (o, z) = (&self.off[i], x[i + 1]);
                y[0] -= o[0] * z[0] + o[1] * z[1];
                y[1] -= o[2] * z[0] + o[3] * z[1];
            }
            x[i] = self.apply(i, y);
        }
    }

    /// (K − λM)⁻¹ times the unit vector of a port.
    pub(crate) fn solve_port(&self, port: &ChainPort) -> Vec<[f64; 2]> {
        let mut x = vec![[0.0; 2]; self.inverse.len()];
        let w = &port.weights;
        if let Some(v) = x.get_mut(port.node) {
            *v = [w[0], w[1]];
        }
        if let Some(v) = x.get_mut(port.node + 1) {
            *v = [w[2], w[3]];
        }
        self.solve(&mut x);
        x
    }
}
