//! The free shaft: Timoshenko elements by numerical integration of their static shape functions, discs, and the row
//! of a plane.

use super::files::{Element, Material, SpindleFile, ToolFile};
use faer::Mat;
use std::f64::consts::PI;

/// Nodes of a Gauss–Legendre rule on [0, 1], exact to degree 9: the integrands have degree 6.
const NODES: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_55),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_45),
    (0.769_234_655_052_841_6, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_55),
];

/// Matrices of the free shaft in r = x + jy: two rows a node, displacement (m) and rotation of the section (rad).
pub struct Shaft {
    /// Positions of the nodes from the nose face, tool side negative, m.
    pub position_m: Vec<f64>,
    pub mass: Mat<f64>,
    pub stiffness: Mat<f64>,
    /// G of −jΩG ṙ.
    pub gyroscopic: Mat<f64>,
}

impl Shaft {
    /// Spindle with its tool.
    pub fn new(spindle: &SpindleFile, tool: &ToolFile) -> Self {
        let own = &spindle.rotor.materials;
        let outer = tool.elements.iter().rev().map(|e| {
            let material = tool.materials.get(&e.material).or(own.get(&e.material));
            (e, *material.expect("material of a tool element"))
        });
        let inner = spindle.rotor.elements.iter();
        let inner = inner.map(|e| (e, own[&e.material]));
        let elements: Vec<(&Element, Material)> = outer.chain(inner).collect();
        let overhang: f64 = tool.elements.iter().map(|e| e.length_m).sum();
        let mut position_m = vec![-overhang];
        for (element, _) in &elements {
            position_m.push(position_m[position_m.len() - 1] + element.length_m);
        }
        let size = 2 * position_m.len();
        let zeros = || Mat::<f64>::zeros(size, size);
        let mut shaft = Self { position_m, mass: zeros(), stiffness: zeros(), gyroscopic: zeros() };
        for (at, (element, material)) in elements.iter().enumerate() {
            shaft.add_element(2 * at, element, material);
        }
        for disc in &spindle.rotor.discs {
            let inertia = [disc.mass_kg, disc.diametral_inertia_kg_m2, disc.polar_inertia_kg_m2];
            shaft.add_disc(disc.position_m, inertia);
        }
        for disc in &tool.discs {
            let inertia = [disc.mass_kg, disc.diametral_inertia_kg_m2, disc.polar_inertia_kg_m2];
            shaft.add_disc(-disc.position_m, inertia);
        }
        shaft
    }

    fn add_element(&mut self, at: usize, e: &Element, material: &Material) {
        let (l, outer, inner) = (e.length_m, e.outer_diameter_m, e.inner_diameter_m);
        let mass_outer = e.mass_outer_diameter_m.unwrap_or(outer);
        let mass_inner = e.mass_inner_diameter_m.unwrap_or(inner);
        let area = |o: f64, i: f64| PI / 4.0 * (o * o - i * i);
        let second = |o: f64, i: f64| PI / 64.0 * (o.powi(4) - i.powi(4));
        let nu = material.poisson_ratio;
        let modulus = material.youngs_modulus_pa * e.modulus_scale.unwrap_or(1.0);
        let m2 = (inner / outer).powi(2);
        let q = (1.0 + m2).powi(2);
        let kappa = 6.0 * (1.0 + nu) * q / ((7.0 + 6.0 * nu) * q + (20.0 + 12.0 * nu) * m2);
        let bending = modulus * second(outer, inner);
        let shear = kappa * modulus / (2.0 * (1.0 + nu)) * area(outer, inner);
        let line = material.density_kg_m3 * area(mass_outer, mass_inner);
        let rotary = material.density_kg_m3 * second(mass_outer, mass_inner);
        for (x, weight) in NODES {
            let s = Shapes::at(x, l, 12.0 * bending / (shear * l * l));
            let w = weight * l;
            for i in 0..4 {
                for j in 0..4 {
                    let moment = bending * s.curvature[i] * s.curvature[j];
                    let sheared = shear * s.shear[i] * s.shear[j];
                    let turned = rotary * s.rotation[i] * s.rotation[j];
                    let moved = line * s.displacement[i] * s.displacement[j];
                    self.stiffness[(at + i, at + j)] += w * (moment + sheared);
                    self.mass[(at + i, at + j)] += w * (moved + turned);
                    self.gyroscopic[(at + i, at + j)] += w * 2.0 * turned;
                }
            }
        }
    }

    fn add_disc(&mut self, position_m: f64, [mass, diametral, polar]: [f64; 3]) {
        let distance = |z: &f64| (z - position_m).abs();
        let nodes = self.position_m.iter().enumerate();
        let (node, z) = nodes.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).expect("a shaft has nodes");
        assert!(distance(z) < 1e-6, "no node at the disc at {position_m} m");
        self.mass[(2 * node, 2 * node)] += mass;
        self.mass[(2 * node + 1, 2 * node + 1)] += diametral;
        self.gyroscopic[(2 * node + 1, 2 * node + 1)] += polar;
    }

    /// Row that reads the displacement at a position: cubic Hermite shape functions of the element there.
    pub fn row(&self, position_m: f64) -> Vec<f64> {
        let last = self.position_m.len() - 2;
        let at = (0..=last).find(|k| position_m <= self.position_m[k + 1] + 1e-9).unwrap_or(last);
        let l = self.position_m[at + 1] - self.position_m[at];
        let x = (position_m - self.position_m[at]) / l;
        assert!((-1e-6..1.0 + 1e-6).contains(&x), "{position_m} m is not on the shaft");
        let mut row = vec![0.0; 2 * self.position_m.len()];
        row[2 * at..2 * at + 4].copy_from_slice(&Shapes::at(x, l, 0.0).displacement);
        row
    }
}

/// Displacement, rotation of the section, its derivative and shear angle of the four nodal freedoms at one point.
struct Shapes {
    displacement: [f64; 4],
    rotation: [f64; 4],
    curvature: [f64; 4],
    shear: [f64; 4],
}

impl Shapes {
    /// Exact static solution of a beam with shear ratio φ = 12EI/(κGA l²) at x of its length l, φ = 0: cubic Hermite.
    fn at(x: f64, l: f64, phi: f64) -> Self {
        let scale = 1.0 / (1.0 + phi);
        let of = |v: [f64; 4]| v.map(|e| e * scale);
        let (x2, x3) = (x * x, x * x * x);
        let slope = of([
            (6.0 * x2 - 6.0 * x - phi) / l,
            1.0 - 4.0 * x + 3.0 * x2 + 0.5 * phi * (1.0 - 2.0 * x),
            (6.0 * x - 6.0 * x2 + phi) / l,
            -2.0 * x + 3.0 * x2 + 0.5 * phi * (2.0 * x - 1.0),
        ]);
        let rotation = of([
            6.0 * (x2 - x) / l,
            1.0 - 4.0 * x + 3.0 * x2 + phi * (1.0 - x),
            6.0 * (x - x2) / l,
            -2.0 * x + 3.0 * x2 + phi * x,
        ]);
        Self {
            displacement: of([
                1.0 - 3.0 * x2 + 2.0 * x3 + phi * (1.0 - x),
                l * (x - 2.0 * x2 + x3 + 0.5 * phi * (x - x2)),
                3.0 * x2 - 2.0 * x3 + phi * x,
                l * (x3 - x2 + 0.5 * phi * (x2 - x)),
            ]),
            curvature: of([
                6.0 * (2.0 * x - 1.0) / (l * l),
                (6.0 * x - 4.0 - phi) / l,
                6.0 * (1.0 - 2.0 * x) / (l * l),
                (6.0 * x - 2.0 + phi) / l,
            ]),
            shear: std::array::from_fn(|k| slope[k] - rotation[k]),
            rotation,
        }
    }
}
