//! A disc of a file: mass and moments of inertia, or the dimensions and the material that they follow from.

use super::error::InputError;
use super::error_list::ErrorList;
use crate::rotor::{Disc, Material};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// A disc as files write it: with mass and both moments of inertia, or with thickness, outer diameter and material.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DiscFile {
    /// Distance from the nose face; must coincide with the end of an element.
    position_m: f64,
    /// Mass.
    mass_kg: Option<f64>,
    /// Moment of inertia about the axis.
    polar_inertia_kg_m2: Option<f64>,
    /// Moment of inertia about a diameter.
    diametral_inertia_kg_m2: Option<f64>,
    /// Thickness, in the place of mass and inertia.
    thickness_m: Option<f64>,
    /// Outer diameter.
    outer_diameter_m: Option<f64>,
    /// Bore.
    inner_diameter_m: Option<f64>,
    /// Name of its material.
    material: Option<String>,
}

impl DiscFile {
    /// The disc; a rule in words where keys are missing or do not go together.
    fn disc(&self, materials: &[Material]) -> Result<Disc, String> {
        let position_m = self.position_m;
        let given = [self.mass_kg, self.polar_inertia_kg_m2, self.diametral_inertia_kg_m2];
        let own = [self.thickness_m, self.outer_diameter_m];
        match (given, own, &self.material) {
            ([Some(mass_kg), Some(polar_inertia_kg_m2), Some(diametral_inertia_kg_m2)], [None, None], None)
                if self.inner_diameter_m.is_none() =>
            {
                Ok(Disc { position_m, mass_kg, polar_inertia_kg_m2, diametral_inertia_kg_m2 })
            }
            ([None, None, None], [Some(thickness_m), Some(outer_m)], Some(name)) => {
                let material = materials.iter().find(|m| m.name == *name);
                let material = material.ok_or_else(|| format!("there is no material {name:?} under `materials:`"))?;
                let inner_m = self.inner_diameter_m.unwrap_or(0.0);
                if !(thickness_m > 0.0 && inner_m >= 0.0 && outer_m > inner_m) {
                    return Err("must have a thickness, and an outer diameter larger than its bore".into());
                }
                let squares = outer_m * outer_m + inner_m * inner_m;
                let area_m2 = 0.25 * PI * (outer_m * outer_m - inner_m * inner_m);
                let mass_kg = material.density_kg_m3 * area_m2 * thickness_m;
                Ok(Disc {
                    position_m,
                    mass_kg,
                    polar_inertia_kg_m2: mass_kg * squares / 8.0,
                    diametral_inertia_kg_m2: mass_kg * (squares / 16.0 + thickness_m * thickness_m / 12.0),
                })
            }
            _ => Err("needs mass_kg, polar_inertia_kg_m2 and diametral_inertia_kg_m2, or thickness_m, \
                 outer_diameter_m and material"
                .into()),
        }
    }
}

/// The discs of a list under `path`; what is wrong is added to the errors.
pub(super) fn discs(
    errors: &mut ErrorList<'_>,
    path: &str,
    read: Option<Vec<DiscFile>>,
    materials: &[Material],
) -> Vec<Disc> {
    let mut discs = vec![];
    for (i, disc) in read.unwrap_or_default().iter().enumerate() {
        match disc.disc(materials) {
            Ok(disc) => discs.push(disc),
            Err(rule) => errors.add_rule(InputError::new(errors.file, format!("{path}[{i}]: {rule}"))),
        }
    }
    discs
}
