//! The spindle, tool and weights files, read for their numbers alone.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

#[derive(Clone, Deserialize)]
pub struct SpindleFile {
    pub rotor: Rotor,
    #[serde(default = "yes")]
    pub gyroscopics: bool,
    pub planes: Planes,
    pub bearings: Bearings,
    pub electronics: Electronics,
    pub speed: Speed,
    #[serde(default)]
    pub effects: Vec<serde_yaml::Value>,
}

fn yes() -> bool {
    true
}

#[derive(Clone, Deserialize)]
pub struct Rotor {
    pub materials: HashMap<String, Material>,
    pub elements: Vec<Element>,
    #[serde(default)]
    pub discs: Vec<Disc>,
    pub damping_ratio: Vec<f64>,
    pub flexible_modes: usize,
}

#[derive(Clone, Copy, Deserialize)]
pub struct Material {
    pub youngs_modulus_pa: f64,
    pub density_kg_m3: f64,
    pub poisson_ratio: f64,
}

#[derive(Clone, Deserialize)]
pub struct Element {
    pub length_m: f64,
    pub outer_diameter_m: f64,
    #[serde(default)]
    pub inner_diameter_m: f64,
    pub mass_outer_diameter_m: Option<f64>,
    pub mass_inner_diameter_m: Option<f64>,
    pub modulus_scale: Option<f64>,
    pub material: String,
}

#[derive(Clone, Copy, Deserialize)]
pub struct Disc {
    pub position_m: f64,
    pub mass_kg: f64,
    pub polar_inertia_kg_m2: f64,
    pub diametral_inertia_kg_m2: f64,
}

#[derive(Clone, Copy, Deserialize)]
pub struct Planes {
    pub front_sensor_m: f64,
    pub front_actuator_m: f64,
    pub rear_actuator_m: f64,
    pub rear_sensor_m: f64,
}

#[derive(Clone, Copy, Deserialize)]
pub struct Bearings {
    pub front: Bearing,
    pub rear: Bearing,
}

#[derive(Clone, Copy, Deserialize)]
pub struct Bearing {
    pub ki_n_per_a: f64,
    pub ks_n_per_m: f64,
    pub sensor_gain: Option<f64>,
}

#[derive(Clone, Copy, Deserialize)]
pub struct Electronics {
    pub amplifier_bandwidth_hz: f64,
    pub sensor_bandwidth_hz: f64,
    pub delay_s: f64,
    pub sample_rate_hz: f64,
}

#[derive(Clone, Copy, Deserialize)]
pub struct Speed {
    pub max_rpm: f64,
}

#[derive(Clone, Deserialize)]
pub struct ToolFile {
    #[serde(default)]
    pub materials: HashMap<String, Material>,
    #[serde(default)]
    pub elements: Vec<Element>,
    #[serde(default)]
    pub discs: Vec<Disc>,
    pub tool_plane_m: f64,
}

#[derive(Clone, Deserialize)]
pub struct WeightsFile {
    pub tool: Limits,
    pub front: Limits,
    pub rear: Limits,
    pub mode_uncertainty: Vec<f64>,
}

#[derive(Clone, Copy, Deserialize)]
pub struct Limits {
    pub max_dc_load_n: f64,
    pub max_hf_load_n: f64,
    pub max_dc_displacement_m: f64,
    pub max_hf_displacement_m: f64,
}

/// A file below the repository's root.
pub fn below_root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A YAML file as a value of one of the types above.
pub fn read_yaml<T: DeserializeOwned>(path: &Path) -> T {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_yaml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
