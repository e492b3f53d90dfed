//! Rotor files of ROSS (rotordynamics in Python) as `Rotor.save` writes them, TOML or JSON: one table for every
//! element, named after its class and tag, nodes counted from the left end.
//!
//! Shaft elements and discs become sections and discs; the beam is the same (Timoshenko, Cowper's or Hutchinson's
//! coefficient, consistent mass). Bearings keep their node, those of active magnets what the file says of the magnet.
//! What a spindle has no place for (axial force, proportional damping, seals, axial bearings, masses of supports) is
//! told in `left_out`.

use super::error::InputError;
use super::json;
use super::ross_magnet::read_magnet;
pub use super::ross_magnet::{RossMagnet, RossPid};
use super::ross_notes::GroupedNotes;
use super::ross_table::RossTable;
use crate::rotor::{Disc, Material, Section, Shear};
use serde_json::{Map, Value};

/// A rotor of a ROSS file, from its left end.
#[derive(Clone, Debug)]
pub struct RossRotor {
    /// Sections from node 0 on; cones are kept.
    pub sections: Vec<Section>,
    /// Discs and point masses, positions from node 0.
    pub discs: Vec<Disc>,
    /// Bearings in the order of their nodes.
    pub bearings: Vec<RossBearing>,
    /// Largest or rated speed that the file states, rad/s.
    pub speed_rad_s: Option<f64>,
    /// What the file has and a spindle has not, one sentence each.
    pub left_out: Vec<String>,
}

/// A bearing of a ROSS file.
#[derive(Clone, Debug, PartialEq)]
pub struct RossBearing {
    /// Its tag.
    pub tag: String,
    /// Position from node 0, m.
    pub position_m: f64,
    /// What the file says of an active magnet.
    pub magnet: Option<RossMagnet>,
}

/// Cylinders that a cone becomes: with eight the frequencies are closer to those of the cone than with one conical
/// element, whose mesh is coarser.
const SLICES: usize = 8;

impl RossRotor {
    /// The sections as a spindle file has them: cones in slices of the same volume, shear and rotary inertia as in
    /// every element there. What this changes is told as sentences. Materials of one name and other values get names
    /// of their own.
    pub fn cylinders(&self) -> (Vec<Section>, Vec<String>) {
        let (mut list, mut told): (Vec<Section>, GroupedNotes) = (vec![], GroupedNotes::default());
        let mut materials: Vec<Material> = vec![];
        for (k, section) in self.sections.iter().enumerate() {
            if section.shear != Shear::Cowper || !section.rotary_inertia || !section.gyroscopic {
                told.add(
                    format!("element {k}"),
                    "shear after Cowper, rotary inertia and gyroscopic moment, as in every element of a spindle file",
                );
            }
            let section = Section {
                material: name_material(&section.material, &mut materials),
                shear: Shear::Cowper,
                rotary_inertia: true,
                gyroscopic: true,
                ..section.clone()
            };
            let pairs = [section.outer_diameter_m, section.inner_diameter_m];
            if pairs.iter().all(|d| d[0] == d[1]) {
                list.push(section);
                continue;
            }
            told.add(format!("element {k}"), format!("a cone, written as {SLICES} cylinders of the same volume"));
            for slice in 0..SLICES {
                let at = |d: [f64; 2], x: usize| d[0] + (d[1] - d[0]) * x as f64 / SLICES as f64;
                let mean = |d: [f64; 2]| {
                    let (a, b) = (at(d, slice), at(d, slice + 1));
                    [((a * a + a * b + b * b) / 3.0).sqrt(); 2]
                };
                list.push(Section {
                    length_m: section.length_m / SLICES as f64,
                    outer_diameter_m: mean(section.outer_diameter_m),
                    inner_diameter_m: mean(section.inner_diameter_m),
                    mass_outer_diameter_m: mean(section.mass_outer_diameter_m),
                    mass_inner_diameter_m: mean(section.mass_inner_diameter_m),
                    ..section.clone()
                });
            }
        }
        (list, told.sentences())
    }

    /// Front and rear bearing: the two magnets, or the two supports of a file without magnets; none where the file does
    /// not tell which they are.
    pub fn magnet_pair(&self) -> Option<[&RossBearing; 2]> {
        let all: Vec<&RossBearing> = self.bearings.iter().collect();
        let magnets: Vec<&RossBearing> = self.bearings.iter().filter(|b| b.magnet.is_some()).collect();
        match (magnets.as_slice(), all.as_slice()) {
            ([front, rear], _) | (_, [front, rear]) => Some([*front, *rear]),
            _ => None,
        }
    }

    /// The same rotor counted from its right end.
    pub fn reverse_ends(&self) -> Self {
        let length: f64 = self.sections.iter().map(|s| s.length_m).sum();
        let turned = |d: &Disc| Disc { position_m: length - d.position_m, ..*d };
        let moved = |b: &RossBearing| RossBearing { position_m: length - b.position_m, ..b.clone() };
        Self {
            sections: self.sections.iter().rev().map(Section::reverse_ends).collect(),
            discs: self.discs.iter().rev().map(turned).collect(),
            bearings: self.bearings.iter().rev().map(moved).collect(),
            ..self.clone()
        }
    }
}

/// The material under a name that no other material has.
fn name_material(material: &Material, known: &mut Vec<Material>) -> Material {
    let mut renamed = material.clone();
    for number in 2.. {
        match known.iter().find(|m| m.name == renamed.name) {
            Some(same) if *same == renamed => break,
            Some(_) => renamed.name = format!("{}-{number}", material.name),
            None => {
                known.push(renamed.clone());
                break;
            }
        }
    }
    renamed
}

/// Reads a file; the end of its name tells TOML from JSON.
///
/// # Errors
/// [`InputError`] with the table and the key that is missing or has no place in a spindle.
pub fn read_ross(file: &str, text: &str) -> Result<RossRotor, InputError> {
    let top: Map<String, Value> = if file.to_ascii_lowercase().ends_with(".json") {
        json::parse(text).map_err(|e| InputError::json(file, &e))?
    } else {
        toml::from_str(text).map_err(|e| {
            InputError::new(file, format!("is no TOML: {}", e.message()))
                .with_hint("give a file that ROSS has saved with `rotor.save(\"name.toml\")`")
        })?
    };
    let mut reader = Reader::of(file);
    let mut speed = None;
    for (name, value) in &top {
        let Value::Object(table) = value else {
            continue; // version and note
        };
        if name == "parameters" {
            let of = |key: &str| table.get(key).and_then(Value::as_f64).filter(|w| *w > 0.0);
            speed = of("max_w").or(of("rated_w"));
            reader.note_parameters(table);
            continue;
        }
        reader.element(&RossTable { file, name, table })?;
    }
    reader.finish(speed)
}

/// Share of a modulus or a density below which a layer has no stiffness or no mass: what it changes is below the digits
/// of a frequency.
const NOTHING: f64 = 1e-6;

/// Pairs of layers, one of which only stiffens or one of which only weighs, as one section with diameters of its own
/// for mass; all others as they are.
fn merge_layers(beams: Vec<(usize, String, Section)>) -> Vec<(usize, String, Section)> {
    let mut list: Vec<(usize, String, Section)> = vec![];
    for (node, name, section) in beams {
        let merged = match list.last() {
            Some((before, _, below)) if *before == node => {
                with_mass_of(below, &section).or_else(|| with_mass_of(&section, below))
            }
            _ => None,
        };
        match (merged, list.last_mut()) {
            (Some(merged), Some(last)) => last.2 = merged,
            _ => list.push((node, name, section)),
        }
    }
    list
}

/// The section `stiff` with the mass of the layer `heavy`; none unless `heavy` adds mass alone.
fn with_mass_of(stiff: &Section, heavy: &Section) -> Option<Section> {
    let (s, h) = (&stiff.material, &heavy.material);
    if heavy.length_m != stiff.length_m || h.youngs_modulus_pa > NOTHING * s.youngs_modulus_pa {
        return None;
    }
    if s.density_kg_m3 <= NOTHING * h.density_kg_m3 {
        return Some(Section {
            mass_outer_diameter_m: heavy.outer_diameter_m,
            mass_inner_diameter_m: heavy.inner_diameter_m,
            material: Material { density_kg_m3: h.density_kg_m3, ..s.clone() },
            ..stiff.clone()
        });
    }
    let around = heavy.inner_diameter_m == stiff.outer_diameter_m;
    (around && s.density_kg_m3 == h.density_kg_m3)
        .then(|| Section { mass_outer_diameter_m: heavy.outer_diameter_m, ..stiff.clone() })
}

/// A support before its node has a position.
struct Placed {
    node: usize,
    tag: String,
    magnet: Option<RossMagnet>,
}

/// What an element is to a spindle.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ElementRole {
    Shaft,
    Coupling,
    Disc,
    PointMass,
    Seal,
    AxialBearing,
    Support,
    Unknown,
}

/// Classes of ROSS that hold a shaft in its radial directions.
const SUPPORTS: [&str; 10] = [
    "BearingElement",
    "BearingElement6DoF",
    "BearingFluidFlow",
    "BallBearingElement",
    "RollerBearingElement",
    "MagneticBearingElement",
    "CylindricalBearing",
    "PlainJournal",
    "TiltingPad",
    "SqueezeFilmDamper",
];

impl ElementRole {
    fn of(table: &RossTable) -> Self {
        let class = table.class();
        let radial = ["kxx", "kyy", "cxx", "cyy"].iter().any(|key| table.is_nonzero(key));
        match class {
            _ if class.starts_with("Coupling") || class.starts_with("MultiRotor") => Self::Coupling,
            _ if class.starts_with("ShaftElement") => Self::Shaft,
            _ if class.starts_with("DiskElement") || class.starts_with("GearElement") => Self::Disc,
            "PointMass" => Self::PointMass,
            _ if class.contains("Seal") => Self::Seal,
            "ThrustPad" => Self::AxialBearing,
            _ if SUPPORTS.contains(&class) && !radial && table.is_nonzero("kzz") => Self::AxialBearing,
            _ if SUPPORTS.contains(&class) => Self::Support,
            _ => Self::Unknown,
        }
    }
}

/// What has been read so far.
struct Reader<'a> {
    file: &'a str,
    beams: Vec<(usize, String, Section)>,
    discs: Vec<(usize, Disc)>,
    supports: Vec<Placed>,
    /// Elements of classes that are not known and may be part of the shaft.
    unknown: GroupedNotes,
    notes: GroupedNotes,
}

impl<'a> Reader<'a> {
    fn of(file: &'a str) -> Self {
        Self {
            file,
            beams: vec![],
            discs: vec![],
            supports: vec![],
            unknown: GroupedNotes::default(),
            notes: GroupedNotes::default(),
        }
    }

    /// Notes what the parameters of the whole rotor say beside its speed.
    fn note_parameters(&mut self, parameters: &Map<String, Value>) {
        for (key, value) in parameters {
            let words = match key.as_str() {
                "min_w" | "max_w" | "rated_w" => continue,
                _ if value.is_null() => continue,
                "alpha" => format!("mass-proportional damping of {value}; damping is `damping_ratio`, by mode"),
                "beta" => format!("stiffness-proportional damping of {value}; damping is `damping_ratio`, by mode"),
                _ => format!("{value}; a spindle file has no place for it"),
            };
            self.notes.add(format!("parameters.{key}"), words);
        }
    }

    fn element(&mut self, table: &RossTable) -> Result<(), InputError> {
        match ElementRole::of(table) {
            ElementRole::Coupling => {
                return Err(table
                    .wrong("a spindle is one shaft without couplings")
                    .with_hint("save the shaft between the couplings as a rotor of its own"));
            }
            ElementRole::Shaft => {
                let section = self.section(table)?;
                self.beams.push((table.node()?, table.name.to_owned(), section));
            }
            ElementRole::Disc => self.disc(table)?,
            ElementRole::PointMass => self.point_mass(table)?,
            ElementRole::Seal => self.notes.add(
                table.name,
                format!(
                    "a seal ({}), no support; `cross_coupling` and `added_stiffness` of the effects are its place",
                    table.class()
                ),
            ),
            ElementRole::AxialBearing => self.notes.add(
                table.name,
                format!("an axial bearing ({}), no radial support; a spindle file has no axial motion", table.class()),
            ),
            ElementRole::Support => self.support(table)?,
            ElementRole::Unknown => {
                let words = format!("the class {} is not known", table.class());
                if table.has("kxx") {
                    self.notes.add(table.name, words + "; it has stiffness, and is not taken as a support");
                } else {
                    self.unknown.add(table.name, words);
                }
            }
        }
        Ok(())
    }

    fn disc(&mut self, table: &RossTable) -> Result<(), InputError> {
        if table.class().starts_with("Gear") {
            self.notes.add(table.name, "a gear, read as a disc; its mesh has no place in a spindle file");
        }
        let disc = Disc {
            position_m: 0.0,
            mass_kg: table.number("m")?,
            polar_inertia_kg_m2: table.number("Ip")?,
            diametral_inertia_kg_m2: table.number("Id")?,
        };
        self.discs.push((table.node()?, disc));
        Ok(())
    }

    fn point_mass(&mut self, table: &RossTable) -> Result<(), InputError> {
        let key = if table.has("m") { "m" } else { "mx" };
        let mass_kg = table.number(key)?;
        if key == "mx" && table.has("my") && table.number("my")? != mass_kg {
            return Err(table.wrong("mx and my differ: a mass on a shaft is the same in both"));
        }
        let disc = Disc { position_m: 0.0, mass_kg, polar_inertia_kg_m2: 0.0, diametral_inertia_kg_m2: 0.0 };
        self.discs.push((table.node()?, disc));
        Ok(())
    }

    fn support(&mut self, table: &RossTable) -> Result<(), InputError> {
        if table.has("n_link") {
            let words = "n_link: it stands on a node of its own; magnets and sensors of a spindle file stand on ground";
            self.notes.add(table.name, words);
        }
        if ["mxx", "myy"].iter().any(|key| table.is_nonzero(key)) {
            self.notes.add(table.name, "mxx, myy: a support with mass, which has no place in a spindle file");
        }
        let magnet = read_magnet(table, &mut self.notes)?;
        self.supports.push(Placed { node: table.node()?, tag: table.tag().to_owned(), magnet });
        Ok(())
    }

    /// Notes supports that are neither front nor rear magnet.
    fn note_supports(&mut self, rotor: &RossRotor) {
        let Some(pair) = rotor.magnet_pair() else {
            if !rotor.bearings.is_empty() {
                let tags: Vec<&str> = rotor.bearings.iter().map(|b| b.tag.as_str()).collect();
                let words = "these do not tell front and rear magnetic bearing, whose planes are to be given";
                self.notes.add(format!("supports ({})", tags.join(", ")), words);
            }
            return;
        };
        for other in rotor.bearings.iter().filter(|b| !pair.contains(b)) {
            self.notes.add(other.tag.clone(), "a support that is no magnet, beside the two magnets");
        }
    }

    /// Refuses classes that may be part of the shaft or carry mass.
    fn check_unknown(&self) -> Result<(), InputError> {
        match self.unknown.sentences().as_slice() {
            [] => Ok(()),
            words => Err(InputError::new(self.file, words.join("; "))
                .with_hint("ShaftElement, DiskElement, GearElement, PointMass, bearings and seals are read")),
        }
    }

    fn section(&mut self, table: &RossTable) -> Result<Section, InputError> {
        let Some(Value::Object(material)) = table.table.get("material") else {
            return Err(table.wrong("material: missing"));
        };
        let inner = format!("{}.material", table.name);
        let material = RossTable { file: self.file, name: &inner, table: material };
        let (e, g) = (material.number("E")?, material.number("G_s")?);
        let name = material.table.get("name").and_then(Value::as_str);
        for (key, what) in [
            ("axial_force", "an axial force"),
            ("torque", "a torque"),
            ("alpha", "mass-proportional damping; damping is `damping_ratio`, by mode"),
            ("beta", "stiffness-proportional damping; damping is `damping_ratio`, by mode"),
        ] {
            if table.is_nonzero(key) {
                self.notes.add(table.name, format!("{key}: {what}"));
            }
        }
        let method = table.table.get("shear_method_calc").and_then(Value::as_str);
        let shear = match (table.flag("shear_effects"), method) {
            (false, _) => Shear::Rigid,
            (true, Some("hutchinson")) => Shear::Hutchinson,
            (true, _) => Shear::Cowper,
        };
        let outer = [table.number("odl")?, table.number("odr")?];
        let bore = [table.number("idl")?, table.number("idr")?];
        Ok(Section {
            outer_diameter_m: outer,
            inner_diameter_m: bore,
            mass_outer_diameter_m: outer,
            mass_inner_diameter_m: bore,
            shear,
            rotary_inertia: table.flag("rotary_inertia"),
            gyroscopic: table.flag("gyroscopic"),
            ..Section::cylinder(
                table.number("L")?,
                outer[0],
                bore[0],
                Material {
                    name: name.unwrap_or("material").to_lowercase(),
                    youngs_modulus_pa: e,
                    shear_modulus_pa: g,
                    density_kg_m3: material.number("rho")?,
                    poisson_ratio: e / (2.0 * g) - 1.0,
                },
            )
        })
    }

    /// Elements in the order of their nodes, and what stands on the nodes with its position.
    fn finish(mut self, speed_rad_s: Option<f64>) -> Result<RossRotor, InputError> {
        self.check_unknown()?;
        self.beams.sort_by_key(|(node, _, _)| *node);
        let mut position_m = vec![0.0];
        let mut sections = vec![];
        for (k, (node, name, section)) in merge_layers(std::mem::take(&mut self.beams)).into_iter().enumerate() {
            if node != k {
                let rule = if node < k {
                    format!("{name}: another element begins at node {node} as well")
                } else {
                    format!("{name}: begins at node {node}, but no element leads there")
                };
                return Err(InputError::new(self.file, rule).with_hint(
                    "a shaft is one element after the other; a layer is read as mass alone where its modulus is less \
                     than a millionth of that below it",
                ));
            }
            section.validate(k).map_err(|e| InputError::new(self.file, format!("{name}: {e}")))?;
            position_m.push(position_m[k] + section.length_m);
            sections.push(section);
        }
        if sections.is_empty() {
            return Err(InputError::new(self.file, "has no ShaftElement")
                .with_hint("give a file that ROSS has saved with `rotor.save(\"name.toml\")`"));
        }
        let mut discs = vec![];
        for (node, disc) in std::mem::take(&mut self.discs) {
            match position_m.get(node) {
                Some(z) => discs.push(Disc { position_m: *z, ..disc }),
                None => {
                    let words = format!("a mass of {} kg that is not on the shaft, as of a support", disc.mass_kg);
                    self.notes.add(format!("node {node}"), words);
                }
            }
        }
        discs.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
        let mut bearings = vec![];
        for Placed { node, tag, magnet } in std::mem::take(&mut self.supports) {
            match position_m.get(node) {
                Some(z) => bearings.push(RossBearing { tag, position_m: *z, magnet }),
                None => self.notes.add(tag, format!("a support of node {node}, which is not on the shaft")),
            }
        }
        bearings.sort_by(|a, b| a.position_m.total_cmp(&b.position_m));
        let rotor = RossRotor { sections, discs, bearings, speed_rad_s, left_out: vec![] };
        self.note_supports(&rotor);
        Ok(RossRotor { left_out: self.notes.sentences(), ..rotor })
    }
}
