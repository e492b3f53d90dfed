//! Co-simulation units of the Functional Mock-up Interface, versions 2.0 and 3.0: the exported controller, called at
//! its sample time, and the machine with the limits of its magnets and its backup bearings. A unit holds its sources; a
//! binary for this platform is given by whoever has a compiler.

use super::firmware::sha256_hex;
use super::zip::zip;
use crate::predict::time::{LOADS, SampledShaft, TimeError, TimeSettings};
use crate::predict::time_force::{FRICTION_SPEED_M_S, LARGEST_XI};
use crate::spindle::Machine;
use crate::spindle::plant::AXES;
use std::fmt::Write as _;

const INTERFACE: &str = include_str!("templates/fmi.c");
const UNIT: &str = include_str!("templates/unit.h");
const CONTROLLER: &str = include_str!("templates/unit_controller.c");
const MACHINE: &str = include_str!("templates/unit_machine.c");

/// Axes of sensors and magnets, and places of forces and displacements.
const AXIS_NAMES: [&str; AXES] = ["front_x", "front_y", "rear_x", "rear_y"];
const PLACES: [&str; LOADS] =
    ["tool_x", "tool_y", "front_actuator_x", "front_actuator_y", "rear_actuator_x", "rear_actuator_y"];

named! {
    /// A version of the interface.
    pub enum FmiVersion {
        Two = "fmi2",
        Three = "fmi3",
    }
}

/// A unit without its binary.
#[derive(Clone, Debug)]
pub struct FmuUnit {
    /// Model identifier, a C identifier.
    pub name: &'static str,
    /// Name and text of every source; `.c` files are compiled.
    pub sources: Vec<(String, Vec<u8>)>,
    description: String,
    inputs: Vec<Variable>,
    outputs: Vec<Variable>,
    step_s: f64,
    token: String,
}

#[derive(Clone, Debug)]
struct Variable {
    name: String,
    unit: &'static str,
}

fn variables(kind: &str, places: &[&str], unit: &'static str) -> Vec<Variable> {
    places.iter().map(|place| Variable { name: format!("{kind}_{place}"), unit }).collect()
}

/// The unit of a controller from its exported `controller.h` and `controller.c`.
pub fn controller_unit(description: &str, c_files: &[(String, Vec<u8>)], sample_time_s: f64) -> FmuUnit {
    let needed = c_files.iter().filter(|(name, _)| name == "controller.h" || name == "controller.c");
    let mut sources: Vec<(String, Vec<u8>)> = needed.cloned().collect();
    sources.push(("unit_controller.c".to_owned(), CONTROLLER.into()));
    let signals = [variables("sensor", &AXIS_NAMES, "m"), variables("current", &AXIS_NAMES, "A")];
    unit("muspin_controller", description, sources, signals, sample_time_s)
}

/// The unit of a machine at a speed: commands (A) and forces (N) to sensor signals, displacements, currents, voltages,
/// magnetic and contact forces.
///
/// # Errors
/// [`TimeError`] when the shaft cannot be prepared.
pub fn machine_unit(machine: &Machine, speed_rad_s: f64, settings: &TimeSettings) -> Result<FmuUnit, TimeError> {
    let period_s = machine.spindle.electronics.sample_period_s();
    let step_s = period_s / settings.substeps as f64;
    let shaft = SampledShaft::new(machine, speed_rad_s, settings, step_s)?;
    if shaft.has_command_laws() {
        return Err(TimeError::NoUnit);
    }
    let data = machine_data(&shaft, period_s, settings.quantum_m);
    let sources = vec![("machine_data.h".to_owned(), data.into_bytes()), ("unit_machine.c".to_owned(), MACHINE.into())];
    let inputs = [variables("command", &AXIS_NAMES, "A"), variables("load", &PLACES, "N")].concat();
    let outputs = [
        variables("sensor", &AXIS_NAMES, "m"),
        variables("displacement", &PLACES, "m"),
        variables("current", &AXIS_NAMES, "A"),
        variables("voltage", &AXIS_NAMES, "V"),
        variables("force", &AXIS_NAMES, "N"),
        variables("contact", &AXIS_NAMES, "N"),
    ];
    let rpm = speed_rad_s * 60.0 / std::f64::consts::TAU;
    let description = format!("{} with {} at {rpm:.0} rpm", machine.spindle.name, machine.tool.name);
    Ok(unit("muspin_machine", &description, sources, [inputs, outputs.concat()], period_s))
}

fn unit(
    name: &'static str,
    description: &str,
    mut sources: Vec<(String, Vec<u8>)>,
    [inputs, outputs]: [Vec<Variable>; 2],
    step_s: f64,
) -> FmuUnit {
    let all: Vec<u8> = sources.iter().flat_map(|(_, bytes)| bytes.iter().copied()).collect();
    let hash = sha256_hex(&all);
    let parts = [&hash[..8], &hash[8..12], &hash[12..16], &hash[16..20], &hash[20..32]];
    let token = format!("{{{}}}", parts.join("-"));
    let sizes =
        format!("#define UNIT_INPUTS {}\n#define UNIT_VARIABLES {}\n", inputs.len(), 1 + inputs.len() + outputs.len());
    sources.push(("unit_sizes.h".to_owned(), sizes.into_bytes()));
    sources.push(("unit.h".to_owned(), UNIT.into()));
    let text = format!("#include \"unit.h\"\n\nconst char unit_token[] = \"{token}\";\n");
    sources.push(("unit_token.c".to_owned(), text.into_bytes()));
    sources.push(("fmi.c".to_owned(), INTERFACE.into()));
    FmuUnit { name, sources, description: description.to_owned(), inputs, outputs, step_s, token }
}

impl FmuUnit {
    /// The archive of a unit; `binary` is the platform in the words of FMI 3.0 (`x86_64-linux`), the ending of its
    /// libraries, and the library.
    ///
    /// `None` for an archive beyond the limits of the format.
    pub fn archive(&self, version: FmiVersion, binary: Option<(&str, &str, Vec<u8>)>) -> Option<Vec<u8>> {
        let mut files = vec![("modelDescription.xml".to_owned(), self.model_description(version).into_bytes())];
        files.extend(self.sources.iter().map(|(name, bytes)| (format!("sources/{name}"), bytes.clone())));
        if version == FmiVersion::Three {
            files.push(("sources/buildDescription.xml".to_owned(), self.build_description().into_bytes()));
        }
        if let Some((platform, ending, bytes)) = binary {
            let folder = match (version, platform) {
                (FmiVersion::Two, "x86_64-linux") => "linux64",
                (FmiVersion::Two, "x86_64-darwin") => "darwin64",
                (FmiVersion::Two, "x86_64-windows") => "win64",
                _ => platform,
            };
            files.push((format!("binaries/{folder}/{}{ending}", self.name), bytes));
        }
        zip(&files)
    }

    /// Names of the sources that are compiled.
    pub fn compiled(&self) -> impl Iterator<Item = &str> {
        self.sources.iter().map(|(name, _)| name.as_str()).filter(|name| name.ends_with(".c"))
    }

    fn variable_lines(&self, version: FmiVersion) -> String {
        let mut text = String::new();
        let time = Variable { name: "time".to_owned(), unit: "s" };
        let listed = std::iter::once((&time, "independent"))
            .chain(self.inputs.iter().map(|v| (v, "input")))
            .chain(self.outputs.iter().map(|v| (v, "output")));
        for (k, (Variable { name, unit }, causality)) in listed.enumerate() {
            let start = if causality == "input" { " start=\"0\"" } else { "" };
            let initial = if causality == "output" { " initial=\"calculated\"" } else { "" };
            let common = format!(
                "name=\"{name}\" valueReference=\"{k}\" causality=\"{causality}\" variability=\"continuous\"{initial}"
            );
            let _ = match version {
                FmiVersion::Two => {
                    writeln!(text, "    <ScalarVariable {common}><Real unit=\"{unit}\"{start}/></ScalarVariable>")
                }
                FmiVersion::Three => writeln!(text, "    <Float64 {common} unit=\"{unit}\"{start}/>"),
            };
        }
        text
    }

    fn model_description(&self, version: FmiVersion) -> String {
        let Self { name, token, step_s, .. } = self;
        let escaped = self.description.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let first = 1 + self.inputs.len();
        let outputs = first..first + self.outputs.len();
        let units = ["s", "m", "A", "N", "V"];
        let units: String = units.iter().map(|u| format!("<Unit name=\"{u}\"/>")).collect();
        let variables = self.variable_lines(version);
        let head = format!(
            "modelName=\"{name}\" description=\"{escaped}\" generationTool=\"muspin {}\"",
            env!("CARGO_PKG_VERSION")
        );
        let experiment = format!("<DefaultExperiment startTime=\"0\" stopTime=\"0.1\" stepSize=\"{step_s:e}\"/>");
        match version {
            FmiVersion::Two => {
                let files: String = self.compiled().map(|f| format!("<File name=\"{f}\"/>")).collect();
                // Version 2.0 counts variables from one.
                let listed: String = outputs.map(|k| format!("<Unknown index=\"{}\"/>", k + 1)).collect();
                format!(
                    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" {head} \
                     guid=\"{token}\" variableNamingConvention=\"flat\">\n  <CoSimulation modelIdentifier=\"{name}\" \
                     canHandleVariableCommunicationStepSize=\"true\">\n    <SourceFiles>{files}</SourceFiles>\n  \
                     </CoSimulation>\n  <UnitDefinitions>{units}</UnitDefinitions>\n  {experiment}\n  \
                     <ModelVariables>\n{variables}  </ModelVariables>\n  <ModelStructure>\n    \
                     <Outputs>{listed}</Outputs>\n    <InitialUnknowns>{listed}</InitialUnknowns>\n  \
                     </ModelStructure>\n</fmiModelDescription>\n"
                )
            }
            FmiVersion::Three => {
                let list = |tag: &str| -> String {
                    outputs.clone().map(|k| format!("<{tag} valueReference=\"{k}\"/>")).collect()
                };
                format!(
                    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" {head} \
                     instantiationToken=\"{token}\" variableNamingConvention=\"flat\">\n  <CoSimulation \
                     modelIdentifier=\"{name}\" canHandleVariableCommunicationStepSize=\"true\"/>\n  \
                     <UnitDefinitions>{units}</UnitDefinitions>\n  {experiment}\n  \
                     <ModelVariables>\n{variables}  </ModelVariables>\n  \
                     <ModelStructure>{}{}</ModelStructure>\n</fmiModelDescription>\n",
                    list("Output"),
                    list("InitialUnknown")
                )
            }
        }
    }

    fn build_description(&self) -> String {
        let files: String = self.compiled().map(|f| format!("<SourceFile name=\"{f}\"/>")).collect();
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  \
             <BuildConfiguration modelIdentifier=\"{}\">\n    <SourceFileSet \
             language=\"C99\">{files}</SourceFileSet>\n  </BuildConfiguration>\n</fmiBuildDescription>\n",
            self.name
        )
    }
}

/// The constants of a machine as C.
fn machine_data(shaft: &SampledShaft, period_s: f64, quantum_m: f64) -> String {
    let mut text = String::from("/* Written by muspin: the constants of the machine. */\n");
    let late = shaft.late_substeps(period_s);
    let counts = [("AXES", AXES), ("LOADS", LOADS), ("STATES", shaft.phi.nrows()), ("LATE", late)];
    for (name, count) in counts {
        let _ = writeln!(text, "#define {name} {count}");
    }
    let backup = &shaft.backup;
    let numbers = [
        ("STEP_S", shaft.step_s),
        ("SPEED_RAD_S", shaft.speed_rad_s),
        ("QUANTUM_M", quantum_m),
        ("LARGEST_XI", LARGEST_XI),
        ("FRICTION_SPEED_M_S", FRICTION_SPEED_M_S),
        ("CLEARANCE_M", backup.clearance_m),
        ("CONTACT_N_PER_M", backup.stiffness_n_per_m),
        ("CONTACT_N_S_PER_M", backup.damping_n_s_per_m),
        ("FRICTION", backup.friction),
        ("CONTACT_RADIUS_M", backup.radius_m),
    ];
    for (name, value) in numbers {
        let _ = writeln!(text, "#define {name} {value:e}");
    }
    text += "struct magnet {\n    double ki_n_per_a, kappa_per_m, bias_a, max_a, max_n, corner_rad_s, slew_a_per_s, \
        inductance_h;\n};\nstatic const struct magnet magnets[AXES] = {\n";
    for m in &shaft.magnets {
        let values =
            [m.ki_n_per_a, m.kappa_per_m, m.bias_a, m.max_a, m.max_n, m.corner_rad_s, m.slew_a_per_s, m.inductance_h];
        let _ = writeln!(text, "    {{{}}},", c_list(values.into_iter()));
    }
    let ratios = c_list(shaft.coupling_ratios.into_iter());
    let _ = writeln!(text, "}};\nstatic const double coupling_ratios[2] = {{{ratios}}};");
    let [gamma_0, gamma_1] = &shaft.gamma;
    let matrices = [
        ("phi", &shaft.phi),
        ("gamma_0", gamma_0),
        ("gamma_1", gamma_1),
        ("outputs", &shaft.outputs),
        ("direct", &shaft.direct),
        ("velocities", &shaft.velocities),
    ];
    for (name, matrix) in matrices {
        let _ = writeln!(text, "static const double {name}[{}][{}] = {{", matrix.nrows(), matrix.ncols());
        for i in 0..matrix.nrows() {
            let _ = writeln!(text, "    {{{}}},", c_list((0..matrix.ncols()).map(|j| matrix[(i, j)])));
        }
        text += "};\n";
    }
    text
}

fn c_list(values: impl Iterator<Item = f64>) -> String {
    values.map(|x| format!("{x:e}")).collect::<Vec<_>>().join(", ")
}
