//! A measurement folder (formats.md, section 4): `measurement.yaml` and the records it lists, every file read and
//! checked.
//!
//! `spindle` and `tool` are looked for beside `measurement.yaml` (the name as a path, `<name>.yaml`, then
//! `spindle.yaml` or `tool.yaml`) and after that among shipped names and paths.

use super::error::{InputError, nearest};
use super::error_list::ErrorList;
use super::file::Watch;
use super::hammer::{HammerKeys, is_universal, load_hammer, load_mode_shapes};
use super::keys;
use super::response_unit::ResponseUnit;
use super::shipped;
use super::spindle::load_spindle;
use super::sweep::load_sweep;
use super::yaml;
use super::{NO_TOOL, load_machine};
use crate::identify::{HammerFrf, SweepRecord};
use crate::spindle::Machine;
use crate::update::MeasuredShape;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A sweep and how it was taken.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Its Fourier coefficients.
    pub record: SweepRecord,
    /// Path of the controller that levitated the rotor.
    pub controller: Option<String>,
}

/// A hammer test and how it was taken.
#[derive(Clone, Debug)]
pub struct Hammer {
    /// File, for messages.
    pub name: String,
    /// The FRF.
    pub frf: HammerFrf,
    /// Axis of force and displacement: 0 for x, 1 for y.
    pub axis: usize,
    /// Path of the controller that levitated the rotor.
    pub controller: Option<String>,
    /// Where the displacement is read and where the force acts, m from the nose face; none: at the tool plane.
    pub places_m: Option<[f64; 2]>,
    /// What its file does not say and was taken for granted, one sentence each.
    pub notes: Vec<String>,
}

/// Frequencies that a person has read off a plot; `None` is a peak that could not be identified.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOff {
    /// Resonances, Hz.
    pub resonances_hz: Vec<Option<f64>>,
    /// Antiresonances of the coaxial front FRF, Hz.
    pub front_hz: Vec<Option<f64>>,
    /// Antiresonances of the coaxial rear FRF, Hz.
    pub rear_hz: Vec<Option<f64>>,
}

/// All records of a folder.
#[derive(Clone, Debug, Default)]
pub struct Measurement {
    /// The folder.
    pub folder: PathBuf,
    /// Name or path of the spindle as resolved.
    pub spindle: String,
    /// Name or path of the tool as resolved.
    pub tool: String,
    /// Sweeps in file order.
    pub sweeps: Vec<Sweep>,
    /// Hammer tests in file order.
    pub hammers: Vec<Hammer>,
    /// Mode shapes of all records.
    pub mode_shapes: Vec<MeasuredShape>,
    /// Frequencies in file order.
    pub frequencies: Vec<ReadOff>,
}

impl Measurement {
    /// The machine of the measurement; a spindle or tool given on the command line wins.
    ///
    /// # Errors
    /// [`InputError`] of whichever file is wrong.
    pub fn machine(&self, spindle: Option<&str>, tool: Option<&str>) -> Result<Machine, InputError> {
        load_machine(spindle.unwrap_or(&self.spindle), tool.unwrap_or(&self.tool))
    }
}

/// The list of a measurement folder.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MeasurementFile {
    /// Spindle: a path from this folder, a name beside this file, or a shipped name.
    spindle: String,
    /// Tool, found like the spindle; `none` in a rotor without magnets that has none.
    tool: String,
    /// Files of the measurement.
    records: Vec<RecordFile>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RecordFile {
    /// `sweep`, `hammer`, `mode_shapes` or `frequencies`.
    kind: String,
    /// File of the record, from this folder.
    file: String,
    /// Speed of the rotor; sweeps and hammer tests must say it.
    speed_rpm: Option<f64>,
    /// Controller (JSON) that levitated the rotor.
    controller: Option<String>,
    /// Axis of a hammer test: `x` or `y`; left out: that of the universal file, else `x`.
    axis: Option<String>,
    /// Which function of a universal file is the hammer test, from 1; left out: the only one that can be.
    function: Option<usize>,
    /// Where a hammer test reads the displacement, from the nose face; at the tool plane unless given.
    response_m: Option<f64>,
    /// Where the hammer hits; at the tool plane unless given.
    force_m: Option<f64>,
    /// Unit of the responses in a table, such as `m/s²`, `mm/s²` or `g` of accelerometers; m unless given.
    unit: Option<String>,
    /// True for a sweep whose currents were logged as samples in the controller, before the hold.
    #[schemars(extend("default" = false))]
    hold: Option<bool>,
}

/// Frequencies that a person has read off a plot.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FrequenciesFile {
    /// Resonances of the free-free rotor; `null` for a peak that could not be identified.
    resonances_hz: Vec<Option<f64>>,
    /// Antiresonances of the coaxial responses of the bearings.
    #[serde(default)]
    antiresonances_hz: AntiresonancesFile,
}

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AntiresonancesFile {
    /// Of the front bearing.
    #[serde(default)]
    front: Vec<Option<f64>>,
    /// Of the rear bearing.
    #[serde(default)]
    rear: Vec<Option<f64>>,
}

/// Reads a measurement folder with all its records. A YAML file of frequencies serves as well: it is a measurement of
/// the reference spindle that consists of nothing else.
///
/// # Errors
/// [`InputError`] that says which file, line or key is wrong.
pub fn load_measurement(folder: &str) -> Result<Measurement, InputError> {
    load_measurement_watched(folder, &|_| ())
}

/// As [`load_measurement`]; `watch` hears how far the reading of the records has come.
///
/// # Errors
/// As [`load_measurement`].
pub fn load_measurement_watched(folder: &str, watch: Watch<'_>) -> Result<Measurement, InputError> {
    let path = Path::new(folder);
    if !path.is_dir() {
        return frequencies_alone(folder);
    }
    let list = path.join("measurement.yaml");
    let name = list.display().to_string();
    if !list.exists() {
        return Err(InputError::new(folder, "has no measurement.yaml")
            .with_hint("a measurement is a folder with measurement.yaml that names spindle, tool and records"));
    }
    let text = shipped::text(&name, "measurement", &[])?;
    let mut errors = ErrorList::new(&name, &text);
    let measurement = yaml::read(&mut errors, keys::MEASUREMENT).map(|read| records(&mut errors, path, read, watch));
    errors.finish(measurement)
}

/// The records of a list; what is wrong with it or with one of them is added to the errors.
fn records(errors: &mut ErrorList<'_>, folder: &Path, read: MeasurementFile, watch: Watch<'_>) -> Measurement {
    let mut measurement = Measurement {
        folder: folder.to_owned(),
        spindle: resolve(folder, &read.spindle, "spindle.yaml"),
        tool: if read.tool == NO_TOOL { read.tool } else { resolve(folder, &read.tool, "tool.yaml") },
        ..Measurement::default()
    };
    let list = errors.file;
    if read.records.is_empty() {
        errors.add(
            InputError::new(list, "records: the list is empty")
                .with_hint("list at least one record of kind sweep, hammer, mode_shapes or frequencies"),
        );
    }
    for (k, record) in read.records.iter().enumerate() {
        let broken = |key: &str, message: String| {
            InputError::new(list, format!("records[{k}].{key}: {message}"))
                .with_hint("correct the record in measurement.yaml")
        };
        errors.take_rule(read_record(&mut measurement, record, &broken, watch));
    }
    measurement
}

/// Reads the text of a `measurement.yaml` without the records that it lists.
///
/// # Errors
/// [`InputError`] with line or key path.
pub fn read_list(file: &str, text: &str) -> Result<(), InputError> {
    let mut errors = ErrorList::new(file, text);
    let read = yaml::read::<MeasurementFile>(&mut errors, keys::MEASUREMENT).map(drop);
    errors.finish(read)
}

fn frequencies_alone(source: &str) -> Result<Measurement, InputError> {
    let text = shipped::text(source, "measurement", shipped::FREQUENCIES)?;
    Ok(Measurement {
        spindle: "reference".into(),
        tool: "paper-tool".into(),
        frequencies: vec![read_frequencies(source, &text)?],
        ..Measurement::default()
    })
}

/// Kind of a record, and that it has only the keys of its kind; `broken` makes the error of a key.
fn check_keys(record: &RecordFile, broken: &dyn Fn(&str, String) -> InputError) -> Result<(), InputError> {
    let known = ["sweep", "hammer", "mode_shapes", "frequencies"];
    if !known.contains(&record.kind.as_str()) {
        let near = nearest(&record.kind, known.into_iter()).unwrap_or_default();
        let rule = format!("{:?} is none of {}", record.kind, known.join(", "));
        return Err(broken("kind", rule).with_hint(format!("did you mean `{near}`?")));
    }
    let has_place = record.response_m.is_some() || record.force_m.is_some();
    let at_speed: &[&str] = &["sweep", "hammer"];
    // Keys of some kinds only: whether they are given, the kinds, what to do with them elsewhere.
    let keys: [(&str, bool, &[&str], &str); 7] = [
        (
            "hold",
            record.hold.is_some(),
            &["sweep"],
            "only a sweep has currents that may have been logged before the hold; remove the key",
        ),
        (
            "function",
            record.function.is_some(),
            &["hammer"],
            "only a hammer test chooses from a universal file; remove the key",
        ),
        ("unit", record.unit.is_some(), at_speed, "only sweeps and hammer tests have responses; remove the key"),
        ("response_m", has_place, &["hammer"], "only a hammer test has a place; remove the key"),
        ("speed_rpm", record.speed_rpm.is_some(), at_speed, "remove the key"),
        ("controller", record.controller.is_some(), at_speed, "remove the key"),
        ("axis", record.axis.is_some(), at_speed, "remove the key"),
    ];
    match keys.iter().find(|(_, given, kinds, _)| *given && !kinds.contains(&record.kind.as_str())) {
        None => Ok(()),
        Some((key, .., hint)) => {
            Err(broken(key, format!("a record of kind {} has no such key", record.kind)).with_hint(*hint))
        }
    }
}

/// Where a hammer test was taken.
fn places(record: &RecordFile, broken: &dyn Fn(&str, String) -> InputError) -> Result<Option<[f64; 2]>, InputError> {
    let missing = |key: &str| {
        let rule = "is missing: a hammer test away from the tool plane has two places".to_owned();
        Err(broken(key, rule).with_hint("write response_m and force_m, the same for a drive point"))
    };
    match (record.response_m, record.force_m) {
        (None, None) => Ok(None),
        (Some(response), Some(force)) if record.controller.is_none() => Ok(Some([response, force])),
        (Some(_), Some(_)) => Err(broken("response_m", "a levitated spindle is hit at its tool plane".to_owned())),
        (None, _) => missing("response_m"),
        (_, None) => missing("force_m"),
    }
}

/// Unit of the responses where the list says one.
fn response_unit(
    record: &RecordFile,
    broken: &dyn Fn(&str, String) -> InputError,
) -> Result<Option<ResponseUnit>, InputError> {
    let Some(label) = &record.unit else {
        return Ok(None);
    };
    if is_universal(&record.file) {
        let rule = "a universal file states its units itself".to_owned();
        return Err(broken("unit", rule).with_hint("remove the key, or correct the labels of the file"));
    }
    let unit = ResponseUnit::read(label, record.kind == "hammer");
    let hint = "write m, m/s or m/s² with a prefix, such as mm/s², or g";
    unit.map(Some).map_err(|rule| broken("unit", rule).with_hint(hint))
}

fn resolve(folder: &Path, name: &str, usual: &str) -> String {
    let beside = [name.to_owned(), format!("{name}.yaml"), usual.to_owned()];
    beside
        .iter()
        .map(|n| folder.join(n))
        .find(|p| p.exists() && !p.is_dir())
        .map_or_else(|| name.to_owned(), |p| p.display().to_string())
}

fn read_record(
    measurement: &mut Measurement,
    record: &RecordFile,
    broken: &dyn Fn(&str, String) -> InputError,
    watch: Watch<'_>,
) -> Result<(), InputError> {
    check_keys(record, broken)?;
    let path = measurement.folder.join(&record.file);
    let name = path.display().to_string();
    if !path.exists() {
        return Err(
            broken("file", format!("there is no {name}")).with_hint("files of records stand beside measurement.yaml")
        );
    }
    let speed = || match record.speed_rpm {
        Some(v) if v.is_finite() && v >= 0.0 => Ok(v),
        Some(v) => Err(broken("speed_rpm", format!("{v} must be zero or positive"))),
        None => Err(broken("speed_rpm", "is missing".into())
            .with_hint("write the speed at which the record was taken, 0 at standstill")),
    };
    let controller = || -> Result<Option<String>, InputError> {
        let Some(file) = &record.controller else {
            return Ok(None);
        };
        let path = measurement.folder.join(file);
        if path.exists() {
            return Ok(Some(path.display().to_string()));
        }
        Err(broken("controller", format!("there is no {}", path.display()))
            .with_hint("name the JSON file of the controller that levitated the rotor"))
    };
    match record.kind.as_str() {
        "sweep" => {
            if record.axis.is_some() {
                return Err(broken("axis", "a sweep excites all four axes".into()).with_hint("remove the key"));
            }
            let mut read = load_sweep(&path, speed()?, watch)?;
            if let Some(unit) = response_unit(record, broken)? {
                unit.to_displacements(&mut read);
            }
            if record.hold == Some(true) {
                let spindle = load_spindle(&measurement.spindle)?;
                read = read.behind_hold(spindle.electronics.sample_period_s());
            }
            let sweep = Sweep { record: read, controller: controller()? };
            measurement.sweeps.push(sweep);
        }
        "hammer" => {
            let axis = match record.axis.as_deref() {
                None => None,
                Some("x") => Some(0),
                Some("y") => Some(1),
                Some(other) => {
                    return Err(broken("axis", format!("{other:?} is neither x nor y")));
                }
            };
            let places_m = places(record, broken)?;
            let keys = HammerKeys { speed_rpm: speed()?, axis, function: record.function, places_m };
            let mut tap = load_hammer(&path, &keys, watch)?;
            if let Some(unit) = response_unit(record, broken)? {
                unit.to_compliance(&mut tap.frf);
            }
            measurement.hammers.push(Hammer {
                frf: tap.frf,
                name,
                axis: tap.axis,
                controller: controller()?,
                places_m,
                notes: tap.notes,
            });
        }
        "mode_shapes" => measurement.mode_shapes.extend(load_mode_shapes(&path, watch)?),
        "frequencies" => {
            let text = shipped::text(&name, "frequencies", &[])?;
            measurement.frequencies.push(read_frequencies(&name, &text)?);
        }
        _ => {}
    }
    Ok(())
}

/// Frequencies from the text of their YAML file.
///
/// # Errors
/// [`InputError`] with line or key path.
pub fn read_frequencies(file: &str, text: &str) -> Result<ReadOff, InputError> {
    let mut errors = ErrorList::new(file, text);
    let read = yaml::read(&mut errors, keys::FREQUENCIES).map(|read| frequencies(&mut errors, read));
    errors.finish(read)
}

/// The frequencies of a file; what its values break is added to the errors.
fn frequencies(errors: &mut ErrorList<'_>, read: FrequenciesFile) -> ReadOff {
    let lists = [
        ("resonances_hz", &read.resonances_hz),
        ("antiresonances_hz.front", &read.antiresonances_hz.front),
        ("antiresonances_hz.rear", &read.antiresonances_hz.rear),
    ];
    for (key, list) in lists {
        for (k, f) in list.iter().enumerate() {
            if let Some(f) = f.filter(|f| !(f.is_finite() && *f > 0.0)) {
                let error = InputError::new(errors.file, format!("{key}[{k}]: {f} must be positive"));
                errors.add_rule(
                    error.with_hint("frequencies are in Hz; write null for a peak that could not be identified"),
                );
            }
        }
    }
    if lists.iter().all(|(_, l)| l.iter().all(Option::is_none)) {
        let error = InputError::new(errors.file, "no frequency at all");
        errors.add(error.with_hint("list at least one resonance or antiresonance in Hz"));
    }
    ReadOff {
        resonances_hz: read.resonances_hz,
        front_hz: read.antiresonances_hz.front,
        rear_hz: read.antiresonances_hz.rear,
    }
}
