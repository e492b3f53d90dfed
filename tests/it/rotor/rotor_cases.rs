//! Readers of the reference cases in tests/data/rotor.

use muspin::rotor::{Damping, Disc, Material, Rotor, Section, Shear, Support};
use serde_json::Value;

pub fn load(name: &str) -> Value {
    let path = format!("{}/tests/data/rotor/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

pub fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or(0.0)
}

pub fn material(value: &Value) -> Material {
    Material {
        name: "steel".into(),
        youngs_modulus_pa: number(value, "E"),
        shear_modulus_pa: number(value, "G"),
        density_kg_m3: number(value, "rho"),
        poisson_ratio: number(value, "nu"),
    }
}

pub fn shear(value: &Value) -> Shear {
    match value.as_str() {
        None => Shear::Rigid,
        Some("cowper") => Shear::Cowper,
        Some("hutchinson") => Shear::Hutchinson,
        Some(other) => panic!("shear {other}"),
    }
}

pub fn rotor(model: &Value) -> Rotor {
    let nodes = numbers(&model["node_z_m"]);
    let sections = model["elements"].as_array().unwrap().iter().map(|e| {
        let outer = [number(e, "od_l"), number(e, "od_r")];
        let inner = [number(e, "id_l"), number(e, "id_r")];
        Section {
            length_m: number(e, "L"),
            outer_diameter_m: outer,
            inner_diameter_m: inner,
            mass_outer_diameter_m: outer,
            mass_inner_diameter_m: inner,
            material: material(&model["materials"][e["material"].as_str().unwrap()]),
            modulus_scale: e["E_mult"].as_f64().unwrap_or(1.0),
            region: None,
            shear: shear(&e["shear"]),
            rotary_inertia: e["rotary_inertia"].as_bool().unwrap(),
            gyroscopic: e["gyroscopic"].as_bool().unwrap(),
        }
    });
    let discs: Vec<Disc> = model["discs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| Disc {
            position_m: nodes[d["node"].as_u64().unwrap() as usize],
            mass_kg: number(d, "m"),
            polar_inertia_kg_m2: number(d, "Ip"),
            diametral_inertia_kg_m2: number(d, "Id"),
        })
        .collect();
    Rotor::new(nodes[0], sections.collect(), &discs).unwrap()
}

pub fn supports(model: &Value) -> Vec<Support> {
    let nodes = numbers(&model["node_z_m"]);
    let list = model["bearings"].as_array().unwrap();
    list.iter()
        .map(|b| {
            let n = |k| number(b, k);
            Support {
                position_m: nodes[b["node"].as_u64().unwrap() as usize],
                stiffness_n_per_m: [[n("kxx"), n("kxy")], [n("kyx"), n("kyy")]],
                damping_n_s_per_m: [[n("cxx"), n("cxy")], [n("cyx"), n("cyy")]],
            }
        })
        .collect()
}

pub fn damping(model: &Value) -> Damping {
    let d = &model["damping"];
    match d["type"].as_str().unwrap() {
        "none" => Damping::None,
        "proportional" => Damping::Proportional { alpha: number(d, "alpha"), beta: number(d, "beta") },
        "modal" => Damping::Modal(numbers(&d["zeta"])),
        other => panic!("damping {other}"),
    }
}
