//! A rotor as ROSS saves and loads it (`ross.Rotor.load`): shaft elements and discs of spindle and tool, from the tip
//! of the tool to the tail. ROSS has one material for the stiffness and the mass of an element: where the diameters
//! for mass are others, a second layer without stiffness carries the mass. ROSS interpolates its motion with the shear
//! of that layer: on the reference spindle this moves frequencies below 6 kHz by up to 7e-6.

use crate::rotor::{Disc, Material, PlanarModes, Rotor, Section, Shear};
use crate::spindle::{Machine, SpindleError};
use serde_json::{Map, Value, json};

/// Version of ROSS whose files these are; a newer one warns and loads them.
const VERSION: &str = "2.3.0";
/// Share of modulus or density that a layer without stiffness or without mass keeps: ROSS divides by both.
const NOTHING: f64 = 1e-9;

/// A shaft from the tip of the tool to the tail.
pub(crate) struct RossShaft {
    /// Where it begins, m from the nose face: negative by the length of the tool.
    pub origin_m: f64,
    pub sections: Vec<Section>,
    /// Its discs, positions from the nose face.
    pub discs: Vec<Disc>,
}

/// Bending modes whose frequencies must not be changed by the effects of a machine.
const COMPARED: usize = 4;

/// The shaft of spindle and tool as their elements say; none where an effect changes it, which no element tells.
pub(crate) fn shaft_without_effects(machine: &Machine) -> Result<Option<RossShaft>, SpindleError> {
    let (spindle, tool) = (&machine.spindle, &machine.tool);
    let front = tool.sections.iter().rev().map(Section::reverse_ends);
    let sections: Vec<Section> = front.chain(spindle.sections.iter().cloned()).collect();
    let outer = tool.discs.iter().map(Disc::mirror_ends);
    let discs: Vec<Disc> = outer.chain(spindle.discs.iter().copied()).collect();
    let origin_m = -tool.length_m();
    let plain = Rotor::new(origin_m, sections.clone(), &discs)?;
    let own = PlanarModes::new(&machine.rotor()?)?.flexible_hz();
    let same = PlanarModes::new(&plain)?.flexible_hz();
    let mut pairs = own.into_iter().zip(same).take(COMPARED);
    // An effect that changes the shaft changes its frequencies; rounding of the eigenvalues is five decades below.
    let changed = pairs.any(|(a, b)| (a / b - 1.0).abs() > 1e-6);
    Ok((!changed).then_some(RossShaft { origin_m, sections, discs }))
}

/// The file as a JSON object; `discs` have positions in the coordinate in which the shaft begins at `origin_m`.
pub(crate) fn ross_rotor(origin_m: f64, sections: &[Section], discs: &[Disc]) -> Value {
    let mut top = Map::new();
    top.insert("ross_version".to_owned(), json!(VERSION));
    top.insert("parameters".to_owned(), json!({}));
    let mut position_m = vec![origin_m];
    for (n, section) in sections.iter().enumerate() {
        position_m.push(position_m[n] + section.length_m);
        for (k, layer) in layers(section).iter().enumerate() {
            let tag = match k {
                0 => format!("Shaft Element {n}"),
                _ => format!("Shaft Element {n} mass"),
            };
            top.insert(format!("ShaftElement_{tag}"), element(layer, n, &tag));
        }
    }
    for (k, disc) in discs.iter().enumerate() {
        let off = |z: &f64| (z - disc.position_m).abs();
        let nearest = (0..position_m.len()).min_by(|a, b| off(&position_m[*a]).total_cmp(&off(&position_m[*b])));
        let tag = format!("Disk {k}");
        let table = json!({
            "n": nearest.unwrap_or_default(),
            "m": disc.mass_kg,
            "Id": disc.diametral_inertia_kg_m2,
            "Ip": disc.polar_inertia_kg_m2,
            "tag": tag,
            "scale_factor": 1.0,
            "color": "Firebrick",
        });
        top.insert(format!("DiskElement_{tag}"), table);
    }
    Value::Object(top)
}

/// The section as layers of one material each.
fn layers(section: &Section) -> Vec<Section> {
    let scaled = |m: &Material, modulus: f64, density: f64| Material {
        name: if modulus == 1.0 && density == 1.0 {
            m.name.clone()
        } else {
            format!("{}_{modulus:e}_{density:e}", m.name)
        },
        youngs_modulus_pa: m.youngs_modulus_pa * modulus,
        shear_modulus_pa: m.shear_modulus_pa * modulus,
        density_kg_m3: m.density_kg_m3 * density,
        ..m.clone()
    };
    let material = &section.material;
    let own = |outer: [f64; 2], bore: [f64; 2], material: Material| Section {
        outer_diameter_m: outer,
        inner_diameter_m: bore,
        material,
        ..section.clone()
    };
    let (outer, bore) = (section.outer_diameter_m, section.inner_diameter_m);
    let (heavy_outer, heavy_bore) = (section.mass_outer_diameter_m, section.mass_inner_diameter_m);
    let stiffness = section.modulus_scale;
    if (heavy_outer, heavy_bore) == (outer, bore) {
        return vec![own(outer, bore, scaled(material, stiffness, 1.0))];
    }
    let around = heavy_bore == bore && (0..2).all(|k| heavy_outer[k] > outer[k]);
    if around {
        return vec![
            own(outer, bore, scaled(material, stiffness, 1.0)),
            own(heavy_outer, outer, scaled(material, NOTHING, 1.0)),
        ];
    }
    vec![
        own(outer, bore, scaled(material, stiffness, NOTHING)),
        own(heavy_outer, heavy_bore, scaled(material, NOTHING, 1.0)),
    ]
}

fn element(section: &Section, n: usize, tag: &str) -> Value {
    let material = &section.material;
    // ROSS takes no spaces in the name of a material.
    let name = material.name.replace(char::is_whitespace, "_");
    json!({
        "L": section.length_m,
        "idl": section.inner_diameter_m[0],
        "odl": section.outer_diameter_m[0],
        "idr": section.inner_diameter_m[1],
        "odr": section.outer_diameter_m[1],
        "n": n,
        "axial_force": 0,
        "torque": 0,
        "shear_effects": section.shear != Shear::Rigid,
        "rotary_inertia": section.rotary_inertia,
        "gyroscopic": section.gyroscopic,
        "shear_method_calc": match section.shear {
            Shear::Hutchinson => "hutchinson",
            _ => "cowper",
        },
        "tag": tag,
        "alpha": 0.0,
        "beta": 0.0,
        "material": {
            "name": name,
            "rho": material.density_kg_m3,
            "E": material.youngs_modulus_pa,
            "G_s": material.shear_modulus_pa,
            "color": "#525252",
        },
    })
}
