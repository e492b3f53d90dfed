//! Conical Timoshenko beam element with two nodes, planar dofs (w₁, ψ₁, w₂, ψ₂), free of shear locking.
//!
//! With s = z/L and φ = 12 E I_m/(κ G A_m L²) at mid-length (φ = 0 without shear flexibility):
//! N_w = [1−3s²+2s³+φ(1−s), L(s−2s²+s³+φ(s−s²)/2), 3s²−2s³+φs, L(−s²+s³−φ(s−s²)/2)]/(1+φ),
//! N_ψ = [6(s²−s)/L, 1−4s+3s²+φ(1−s), 6(s−s²)/L, 3s²−2s+φs]/(1+φ);
//! M = ∫ρA N_w N_wᵀ + ∫ρI N_ψ N_ψᵀ,  G = 2∫ρI N_ψ N_ψᵀ,  K = ∫EI N_ψ′N_ψ′ᵀ + κG(∫A) g gᵀ,
//! g = φ/(1+φ)·[−1/L, −1/2, 1/L, −1/2]. A(z), I(z) follow linearly varying diameters; six Gauss points are exact.
//! Source: Genta, Dynamics of Rotating Systems (2005), ch. 4. M and G use the mass diameters, K and φ the stiffness
//! ones.

use super::section::Section;
use nalgebra::{Matrix4, Vector4};
use std::f64::consts::PI;

/// Planar 4×4 element matrix, rows and columns (w₁, ψ₁, w₂, ψ₂).
pub type Matrix = Matrix4<f64>;

/// The matrices of one element.
#[derive(Clone, Debug)]
pub struct ElementMatrices {
    /// Consistent mass with rotary inertia.
    pub mass: Matrix,
    /// Stiffness with the section's modulus scale.
    pub stiffness: Matrix,
    /// Gyroscopic matrix per rad/s.
    pub gyroscopic: Matrix,
    /// Moment of inertia about the axis of rotation, kg m² (also where `gyroscopic` is switched off).
    pub polar_inertia_kg_m2: f64,
}

/// Abscissae and weights of the six-point Gauss–Legendre rule on [−1, 1] (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 6] = [
    (-0.932_469_514_203_152, 0.171_324_492_379_170_34),
    (-0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (-0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_34),
];

/// Mass, stiffness and gyroscopic matrix of a section.
pub fn matrices(section: &Section) -> ElementMatrices {
    let l = section.length_m;
    let e = section.material.youngs_modulus_pa * section.modulus_scale;
    let g = section.material.shear_modulus_pa * section.modulus_scale;
    let rho = section.material.density_kg_m3;
    let at = |d: [f64; 2], s: f64| d[0] + (d[1] - d[0]) * s;
    let stiff = |s| Ring { outer_m: at(section.outer_diameter_m, s), inner_m: at(section.inner_diameter_m, s) };
    let heavy =
        |s| Ring { outer_m: at(section.mass_outer_diameter_m, s), inner_m: at(section.mass_inner_diameter_m, s) };
    let kappa = section.shear_coefficient();
    let phi = shear_parameter(section);
    let mut mass = Matrix::zeros();
    let mut rotary = Matrix::zeros();
    let mut stiffness = Matrix::zeros();
    let mut area_integral = 0.0;
    let mut polar = 0.0;
    for (x, weight) in GAUSS {
        let (s, h) = (0.5 * (1.0 + x), 0.5 * weight * l);
        let (nw, npsi, slope) = shapes(s, l, phi);
        mass += nw * nw.transpose() * (rho * heavy(s).area_m2() * h);
        rotary += npsi * npsi.transpose() * (rho * heavy(s).second_moment_m4() * h);
        stiffness += slope * slope.transpose() * (e * stiff(s).second_moment_m4() * h);
        area_integral += stiff(s).area_m2() * h;
        polar += 2.0 * rho * heavy(s).second_moment_m4() * h;
    }
    if let Some(kappa) = kappa {
        let strain = Vector4::from(shear(section));
        stiffness += strain * strain.transpose() * (kappa * g * area_integral);
    }
    if section.rotary_inertia {
        mass += rotary;
    }
    ElementMatrices {
        mass,
        stiffness,
        gyroscopic: if section.gyroscopic { rotary * 2.0 } else { Matrix::zeros() },
        polar_inertia_kg_m2: polar,
    }
}

/// Shear angle of a section, g above: coefficients of (w₁, ψ₁, w₂, ψ₂); zero without shear flexibility.
pub fn shear(section: &Section) -> [f64; 4] {
    let l = section.length_m;
    let phi = shear_parameter(section);
    let c = phi / (1.0 + phi);
    [-1.0 / l * c, -0.5 * c, 1.0 / l * c, -0.5 * c]
}

/// φ of a section.
fn shear_parameter(section: &Section) -> f64 {
    let l = section.length_m;
    let middle = |d: [f64; 2]| d[0] + (d[1] - d[0]) * 0.5;
    let ring = Ring { outer_m: middle(section.outer_diameter_m), inner_m: middle(section.inner_diameter_m) };
    let e = section.material.youngs_modulus_pa * section.modulus_scale;
    let g = section.material.shear_modulus_pa * section.modulus_scale;
    section.shear_coefficient().map_or(0.0, |k| 12.0 * e * ring.second_moment_m4() / (k * g * ring.area_m2() * l * l))
}

/// Deflection at s = z/L of an element of length L read with cubic Hermite functions: coefficients of (w₁, ψ₁, w₂, ψ₂).
pub fn hermite(s: f64, length_m: f64) -> [f64; 4] {
    let (s2, s3) = (s * s, s * s * s);
    [1.0 - 3.0 * s2 + 2.0 * s3, length_m * (s - 2.0 * s2 + s3), 3.0 * s2 - 2.0 * s3, length_m * (s3 - s2)]
}

/// Slope of the deflection that [`hermite`] reads, d/dz: coefficients of (w₁, ψ₁, w₂, ψ₂).
pub(crate) fn hermite_slope(s: f64, length_m: f64) -> [f64; 4] {
    let s2 = s * s;
    let across = 6.0 * (s - s2) / length_m;
    [-across, 1.0 - 4.0 * s + 3.0 * s2, across, 3.0 * s2 - 2.0 * s]
}

/// Curvature of the deflection that [`hermite`] reads, d²/dz²: coefficients of (w₁, ψ₁, w₂, ψ₂).
pub(crate) fn hermite_curvature(s: f64, length_m: f64) -> [f64; 4] {
    let across = (6.0 - 12.0 * s) / (length_m * length_m);
    let turning = |at: f64| (6.0 * s - at) / length_m;
    [-across, turning(4.0), across, turning(2.0)]
}

/// Rotation ψ of the section at s = z/L, and its derivative d/dz: coefficients of (w₁, ψ₁, w₂, ψ₂) each.
pub(crate) fn rotation(section: &Section, s: f64) -> [[f64; 4]; 2] {
    let (_, rotation, along) = shapes(s, section.length_m, shear_parameter(section));
    [rotation.into(), along.into()]
}

/// Deflection and rotation functions and the derivative of the latter, dN_ψ/dz.
fn shapes(s: f64, l: f64, phi: f64) -> (Vector4<f64>, Vector4<f64>, Vector4<f64>) {
    let (s2, s3) = (s * s, s * s * s);
    let c = 1.0 / (1.0 + phi);
    let nw = Vector4::new(
        1.0 - 3.0 * s2 + 2.0 * s3 + phi * (1.0 - s),
        l * (s - 2.0 * s2 + s3 + 0.5 * phi * (s - s2)),
        3.0 * s2 - 2.0 * s3 + phi * s,
        l * (s3 - s2 - 0.5 * phi * (s - s2)),
    );
    let npsi = Vector4::new(
        6.0 * (s2 - s) / l,
        1.0 - 4.0 * s + 3.0 * s2 + phi * (1.0 - s),
        6.0 * (s - s2) / l,
        3.0 * s2 - 2.0 * s + phi * s,
    );
    let slope =
        Vector4::new(6.0 * (2.0 * s - 1.0) / l, 6.0 * s - 4.0 - phi, 6.0 * (1.0 - 2.0 * s) / l, 6.0 * s - 2.0 + phi);
    (nw * c, npsi * c, slope * (c / l))
}

/// A cross-section between two diameters.
struct Ring {
    outer_m: f64,
    inner_m: f64,
}

impl Ring {
    fn area_m2(&self) -> f64 {
        0.25 * PI * (self.outer_m * self.outer_m - self.inner_m * self.inner_m)
    }

    fn second_moment_m4(&self) -> f64 {
        PI / 64.0 * (self.outer_m.powi(4) - self.inner_m.powi(4))
    }
}
