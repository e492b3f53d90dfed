//! The machine that `init` and the examples start from: its files, its measurement, its PID.

use super::Failure;
use super::schema;
use crate::identify::Rehearsal;
use crate::input::schema::SchemaKind;
use crate::input::{read_controller, read_spindle, read_tool};
use crate::report::rehearsed::RehearsedRig;
use crate::report::results::ResultsFolder;
use crate::spindle::{Bearings, Effect, EffectKind, Location, Machine};

const SPINDLE: &str = include_str!("start/spindle.yaml");
const TOOL: &str = include_str!("start/tool.yaml");
/// A PID that floats the machine, found by `muspin rehearse`.
pub(super) const PID: &str = include_str!("start/pid.json");
pub(super) const MACHINE: [(&str, &str); 3] =
    [("spindle.yaml", SPINDLE), ("tool.yaml", TOOL), ("weights.yaml", include_str!("start/weights.yaml"))];
/// List of the measurement with another stiffness.
pub(super) const UPDATE_LIST: &str = include_str!("start/measurement.yaml");
/// List of the measurement with eddy currents.
pub(super) const DIAGNOSE_LIST: &str = include_str!("examples/measurement-diagnose.yaml");

/// What differs between the machine that is measured and its files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Truth {
    /// Motor region 6 % softer, taper 8 % stiffer: what `start/measurement.yaml` says.
    OtherModuli,
    /// Eddy currents in the rear bearing: what `examples/measurement-diagnose.yaml` says.
    EddyCurrents,
}

impl Truth {
    fn of(self, model: &Machine) -> Result<Machine, Failure> {
        let region = |name: &str| Location::Region(name.to_owned());
        let effects = match self {
            Self::OtherModuli => vec![
                (EffectKind::RegionStiffness, region("motor"), 0.94),
                (EffectKind::RegionStiffness, region("taper"), 1.08),
            ],
            Self::EddyCurrents => {
                let rear = Location::Bearing(Bearings::Rear);
                vec![(EffectKind::EddyCurrents, rear, 3000.0)]
            }
        };
        let mut truth = model.clone();
        for (kind, place, size) in effects {
            truth = truth.with_effect(Effect::new(kind, place, vec![size])?);
        }
        Ok(truth)
    }
}

/// The machine as its files have it.
pub(super) fn machine() -> Result<Machine, Failure> {
    let spindle = read_spindle("spindle.yaml", SPINDLE)?;
    let tool = read_tool("tool.yaml", TOOL, &spindle)?;
    Ok(Machine::new(spindle, tool)?)
}

/// Adds the files of the machine and the schemas that their first lines name.
pub(super) fn add_machine(folder: &mut ResultsFolder) -> Result<(), Failure> {
    for (name, text) in MACHINE {
        folder.add(name, text)?;
    }
    for kind in SchemaKind::ALL {
        let path = format!("schemas/{}.schema.json", kind.name());
        folder.add(&path, schema::text(kind))?;
    }
    Ok(())
}

pub(super) fn add_measurement(folder: &mut ResultsFolder, list: &str, truth: Truth) -> Result<(), Failure> {
    let model = machine()?;
    let controller = read_controller("pid.json", PID)?;
    let truth = truth.of(&model)?;
    let rehearsal = Rehearsal::usual(&truth)?;
    folder.add("measurement/measurement.yaml", list)?;
    let (controller, rehearsal) = (&controller, &rehearsal);
    let rig = RehearsedRig { truth: &truth, controller, rehearsal, speeds_rpm: &[0.0], watch: &|| {} };
    rig.add_records(folder, "measurement/")?;
    Ok(())
}
