//! The sections of the page: a stage of the run each, with its key in the summary.

/// The sections in the order of the page: variant, key at the top of the summary, title, what the reader looks at.
macro_rules! sections {
    ($($section:ident $key:literal $title:literal $lead:literal,)*) => {
        named! {
            /// A stage of the run as a section of the page, in the order of the page, by its key at the top of the
            /// summary, which is its anchor.
            pub enum PageSection { $($section = $key,)* }
        }

        impl PageSection {
            pub(crate) fn title(self) -> &'static str {
                match self { $(Self::$section => $title,)* }
            }

            /// What the reader looks at.
            pub(crate) fn lead(self) -> &'static str {
                match self { $(Self::$section => $lead,)* }
            }
        }
    };
}

sections! {
    Model "model" "Rotor model"
        "Finite-element model of the rotor with its tool, free in space.",
    Identification "identification" "Identification"
        "What the measured sweeps say about resonances and antiresonances.",
    Updating "updating" "Updating"
        "Moduli moved until the model has the measured resonances and antiresonances.",
    Design "design" "Controller"
        "Where µ is below 1, every specification holds for every plant within the stated uncertainty.",
    Table "table" "Tools"
        "A design and a tuned PID for each tool, side by side.",
    Statements "statements" "At the tool plane"
        "The statements of the paper's figure 9 as numbers; worst: not undercut by any rotor within the uncertainty.",
    Tightening "tightening" "Tighter at the tool"
        "What the slack of the specification gives when it goes into the tool's displacement limits.",
    Routes "routes" "Sampled design and emulation"
        "Both routes, each judged on the sampled loop: synthesis on the sampled plant, and continuous synthesis with a \
         Padé delay followed by Tustin's rule.",
    Stiffness "stiffness" "Dynamic stiffness at the tool"
        "Force over displacement at the tool plane; higher is stiffer.",
    Sensitivity "sensitivity" "Sensitivity"
        "Robustness of each control axis in the zones of ISO 14839-3: A up to 9.5 dB, B to 12, C to 14.",
    Damping "damping_ratio" "Damping"
        "Flexible modes in the closed loop at rest: damping ratio of the least damped pole that shows in each.",
    Margins "margins" "Margins"
        "Gain and phase that each channel may change by alone, and all at once, each for itself (discs).",
    Pid "pid" "Tuned PID"
        "The rival: what it was tuned for, and what it reaches.",
    Thrust "thrust" "Thrust axis"
        "The fifth axis: the shaft along its length on a magnet of its own, not coupled to the others.",
    Simulation "simulation" "Time responses"
        "True bearing force law, limits of current and voltage, backup bearings.",
    Machining "machining" "Machining"
        "Stable depth of cut from the closed-loop response at the tool.",
    Diagnosis "diagnosis" "Diagnosis"
        "Where model and measurement disagree, and which effect explains it.",
}
