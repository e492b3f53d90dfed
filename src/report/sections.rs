//! The sections of the page: a stage of the run each, with its key in the summary.

/// A stage of the run as a section of the page, in the order of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum PageSection {
    Model,
    Identification,
    Updating,
    Design,
    Table,
    Statements,
    Tightening,
    Routes,
    Stiffness,
    Sensitivity,
    Damping,
    Margins,
    Pid,
    Simulation,
    Machining,
    Diagnosis,
}

impl PageSection {
    /// All sections in the order of the page.
    pub const ALL: [Self; 16] = [
        Self::Model,
        Self::Identification,
        Self::Updating,
        Self::Design,
        Self::Table,
        Self::Statements,
        Self::Tightening,
        Self::Routes,
        Self::Stiffness,
        Self::Sensitivity,
        Self::Damping,
        Self::Margins,
        Self::Pid,
        Self::Simulation,
        Self::Machining,
        Self::Diagnosis,
    ];

    /// Key at the top of the summary, and anchor.
    pub(crate) fn key(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Identification => "identification",
            Self::Updating => "updating",
            Self::Design => "design",
            Self::Table => "table",
            Self::Statements => "statements",
            Self::Tightening => "tightening",
            Self::Routes => "routes",
            Self::Stiffness => "stiffness",
            Self::Sensitivity => "sensitivity",
            Self::Damping => "damping_ratio",
            Self::Margins => "margins",
            Self::Pid => "pid",
            Self::Simulation => "simulation",
            Self::Machining => "machining",
            Self::Diagnosis => "diagnosis",
        }
    }

    /// Heading.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Model => "Rotor model",
            Self::Identification => "Identification",
            Self::Updating => "Updating",
            Self::Design => "Controller",
            Self::Table => "Tools",
            Self::Statements => "At the tool plane",
            Self::Tightening => "Tighter at the tool",
            Self::Routes => "Sampled design and emulation",
            Self::Stiffness => "Dynamic stiffness at the tool",
            Self::Sensitivity => "Sensitivity",
            Self::Damping => "Damping",
            Self::Margins => "Margins",
            Self::Pid => "Tuned PID",
            Self::Simulation => "Time responses",
            Self::Machining => "Machining",
            Self::Diagnosis => "Diagnosis",
        }
    }

    /// What the reader looks at.
    pub(crate) fn lead(self) -> &'static str {
        match self {
            Self::Model => "Finite-element model of the rotor with its tool, free in space.",
            Self::Identification => "What the measured sweeps say about resonances and antiresonances.",
            Self::Updating => "Moduli moved until the model has the measured resonances and antiresonances.",
            Self::Design => {
                "Where µ is below 1, every specification holds for every plant within the stated uncertainty."
            }
            Self::Table => "A design and a tuned PID for each tool, side by side.",
            Self::Statements => {
                "The statements of the paper's figure 9 as numbers; worst: not undercut by any rotor within the \
                 uncertainty."
            }
            Self::Tightening => {
                "What the slack of the specification gives when it goes into the tool's displacement limits."
            }
            Self::Routes => {
                "Both routes, each judged on the sampled loop: synthesis on the sampled plant, and continuous \
                 synthesis with a Padé delay followed by Tustin's rule."
            }
            Self::Stiffness => "Force over displacement at the tool plane; higher is stiffer.",
            Self::Sensitivity => {
                "Robustness of each control axis in the zones of ISO 14839-3: A up to 9.5 dB, B to 12, C to 14."
            }
            Self::Damping => {
                "Flexible modes in the closed loop at rest: damping ratio of the least damped pole that shows in each."
            }
            Self::Pid => "The rival: what it was tuned for, and what it reaches.",
            Self::Margins => {
                "Gain and phase that each channel may change by alone, and all at once, each for itself (discs)."
            }
            Self::Simulation => "True bearing force law, limits of current and voltage, backup bearings.",
            Self::Machining => "Stable depth of cut from the closed-loop response at the tool.",
            Self::Diagnosis => "Where model and measurement disagree, and which effect explains it.",
        }
    }
}
