//! What a shaft is made of: materials, beam sections (cylinders and cones), rigid discs, with the rules they must keep.
//!
//! Shear coefficients of a hollow circular section, m = inner/outer diameter at mid-length, q = (1 + m²)²:
//! Cowper (1966)      κ = 6(1+ν)q / [(7+6ν)q + (20+12ν)m²];
//! Hutchinson (2001)  κ = 6(1+ν)q / [(7+12ν+4ν²)q + 4(5+6ν+2ν²)m²].

use super::RotorError;

/// An isotropic material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Shear modulus G, Pa; E/(2(1+ν)) unless measured apart.
    pub shear_modulus_pa: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Poisson's ratio ν, enters the shear coefficient.
    pub poisson_ratio: f64,
}

impl Material {
    /// A material whose shear modulus follows from E and ν.
    pub fn isotropic(name: &str, youngs_modulus_pa: f64, density_kg_m3: f64, poisson_ratio: f64) -> Self {
        Self {
            name: name.to_owned(),
            youngs_modulus_pa,
            shear_modulus_pa: youngs_modulus_pa / (2.0 * (1.0 + poisson_ratio)),
            density_kg_m3,
            poisson_ratio,
        }
    }
}

/// Shear theory of a beam element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shear {
    /// No shear flexibility (Euler–Bernoulli, or Rayleigh with rotary inertia).
    Rigid,
    /// Cowper's coefficient.
    #[default]
    Cowper,
    /// Hutchinson's coefficient.
    Hutchinson,
}

/// One beam element: a cylinder or a cone, possibly hollow. Pairs are (tool end, tail end).
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Length, m.
    pub length_m: f64,
    /// Outer diameters that count for stiffness, m.
    pub outer_diameter_m: [f64; 2],
    /// Inner diameters that count for stiffness, m.
    pub inner_diameter_m: [f64; 2],
    /// Outer diameters that count for mass (laminations), m.
    pub mass_outer_diameter_m: [f64; 2],
    /// Inner diameters that count for mass, m.
    pub mass_inner_diameter_m: [f64; 2],
    /// Material.
    pub material: Material,
    /// Factor on E and G.
    pub modulus_scale: f64,
    /// Update region, shared by all elements with the same name.
    pub region: Option<String>,
    /// Shear theory.
    pub shear: Shear,
    /// Whether the section resists angular acceleration about a diameter.
    pub rotary_inertia: bool,
    /// Whether the section has a gyroscopic moment.
    pub gyroscopic: bool,
}

impl Section {
    /// A cylinder with equal stiffness and mass diameters, Cowper shear, rotary inertia and gyroscopic moment.
    pub fn cylinder(length_m: f64, outer_diameter_m: f64, inner_diameter_m: f64, material: Material) -> Self {
        Self {
            length_m,
            outer_diameter_m: [outer_diameter_m; 2],
            inner_diameter_m: [inner_diameter_m; 2],
            mass_outer_diameter_m: [outer_diameter_m; 2],
            mass_inner_diameter_m: [inner_diameter_m; 2],
            material,
            modulus_scale: 1.0,
            region: None,
            shear: Shear::Cowper,
            rotary_inertia: true,
            gyroscopic: true,
        }
    }

    /// The same section seen from the other end.
    pub(crate) fn reverse_ends(&self) -> Self {
        let flip = |d: [f64; 2]| [d[1], d[0]];
        Self {
            outer_diameter_m: flip(self.outer_diameter_m),
            inner_diameter_m: flip(self.inner_diameter_m),
            mass_outer_diameter_m: flip(self.mass_outer_diameter_m),
            mass_inner_diameter_m: flip(self.mass_inner_diameter_m),
            ..self.clone()
        }
    }

    /// Checks every rule; `index` is the element's place in its list.
    pub(crate) fn validate(&self, index: usize) -> Result<(), RotorError> {
        let broken = |field, value: f64, rule: String| Err(RotorError::Element { index, field, value, rule });
        let positive: [(&'static str, f64); 5] = [
            ("length_m", self.length_m),
            ("modulus_scale", self.modulus_scale),
            ("material.youngs_modulus_pa", self.material.youngs_modulus_pa),
            ("material.shear_modulus_pa", self.material.shear_modulus_pa),
            ("material.density_kg_m3", self.material.density_kg_m3),
        ];
        for (field, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return broken(field, value, "must be a positive number".into());
            }
        }
        let nu = self.material.poisson_ratio;
        if !(nu > -1.0 && nu <= 0.5) {
            let rule = "must lie between -1 and 0.5".into();
            return broken("material.poisson_ratio", nu, rule);
        }
        let pairs = [
            ("outer_diameter_m", self.outer_diameter_m, "inner_diameter_m", self.inner_diameter_m),
            ("mass_outer_diameter_m", self.mass_outer_diameter_m, "mass_inner_diameter_m", self.mass_inner_diameter_m),
        ];
        for (outer_name, outer, inner_name, inner) in pairs {
            for end in 0..2 {
                if !(outer[end].is_finite() && outer[end] > 0.0) {
                    return broken(outer_name, outer[end], "must be a positive number".into());
                }
                if !(inner[end].is_finite() && inner[end] >= 0.0) {
                    let rule = "must be zero or a positive number".into();
                    return broken(inner_name, inner[end], rule);
                }
                if inner[end] >= outer[end] {
                    let rule = format!("must be smaller than {outer_name} {}", outer[end]);
                    return broken(inner_name, inner[end], rule);
                }
            }
        }
        Ok(())
    }

    /// Shear coefficient κ; `None` for a section that does not shear.
    pub(crate) fn shear_coefficient(&self) -> Option<f64> {
        let mean = |d: [f64; 2]| 0.5 * (d[0] + d[1]);
        let nu = self.material.poisson_ratio;
        let m2 = (mean(self.inner_diameter_m) / mean(self.outer_diameter_m)).powi(2);
        let q = (1.0 + m2).powi(2);
        match self.shear {
            Shear::Rigid => None,
            Shear::Cowper => Some(6.0 * (1.0 + nu) * q / ((7.0 + 6.0 * nu) * q + (20.0 + 12.0 * nu) * m2)),
            Shear::Hutchinson => {
                let (a, b) = (7.0 + 12.0 * nu + 4.0 * nu * nu, 4.0 * (5.0 + 6.0 * nu + 2.0 * nu * nu));
                Some(6.0 * (1.0 + nu) * q / (a * q + b * m2))
            }
        }
    }
}

/// A rigid disc on a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Position, m from the nose face (negative on the tool).
    pub position_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Moment of inertia about the axis of rotation, kg m².
    pub polar_inertia_kg_m2: f64,
    /// Moment of inertia about a diameter through the disc's centre, kg m².
    pub diametral_inertia_kg_m2: f64,
}

impl Disc {
    /// The disc in the coordinate that counts the other way from the nose face.
    pub(crate) fn mirror_ends(&self) -> Self {
        Self { position_m: -self.position_m, ..*self }
    }

    /// Checks every rule; `index` is the disc's place in its list.
    pub(crate) fn validate(&self, index: usize) -> Result<(), RotorError> {
        let values = [
            ("mass_kg", self.mass_kg),
            ("polar_inertia_kg_m2", self.polar_inertia_kg_m2),
            ("diametral_inertia_kg_m2", self.diametral_inertia_kg_m2),
        ];
        for (field, value) in values {
            if !(value.is_finite() && value >= 0.0) {
                return Err(RotorError::Disc { index, field, value, rule: "must be zero or a positive number".into() });
            }
        }
        // A body's moments obey Ix + Iy ≥ Iz; 1e-6 leaves room for printed figures.
        if self.polar_inertia_kg_m2 > 2.0 * self.diametral_inertia_kg_m2 * (1.0 + 1e-6) {
            return Err(RotorError::Disc {
                index,
                field: "polar_inertia_kg_m2",
                value: self.polar_inertia_kg_m2,
                rule: format!(
                    "must not exceed twice diametral_inertia_kg_m2 {}, as for every rigid body",
                    self.diametral_inertia_kg_m2
                ),
            });
        }
        Ok(())
    }
}
