//! The sections of the page: a stage of the run each, with its key in the summary and its pictures.

/// A stage of the run as a section of the page.
pub(super) struct Stage {
    /// Key at the top of the summary, and anchor.
    pub key: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What the reader looks at.
    pub lead: &'static str,
    /// Stems of its pictures start like one of these, in the order in which they are shown.
    pub stems: &'static [&'static str],
}

pub(super) const STAGES: [Stage; 15] = [
    Stage {
        key: "model",
        title: "Rotor model",
        lead: "Finite-element model of the rotor with its tool, free in space.",
        stems: &["campbell", "modes", "rotor"],
    },
    Stage {
        key: "identification",
        title: "Identification",
        lead: "What the measured sweeps say about resonances and antiresonances.",
        stems: &["identif", "frf", "coherence"],
    },
    Stage {
        key: "updating",
        title: "Updating",
        lead: "Moduli moved until the model has the measured resonances and antiresonances.",
        stems: &[
            "bode",
            "open_loop",
            "mode_shape",
            "modul",
            "determin",
            "errors",
            "updat",
            "frequenc",
        ],
    },
    Stage {
        key: "design",
        title: "Controller",
        lead: "µ below 1: every specification holds for every plant within the stated uncertainty.",
        stems: &[
            "mu",
            "speed",
            "d_fit",
            "d_scale",
            "order",
            "reduction",
            "controller",
        ],
    },
    Stage {
        key: "table",
        title: "Tools",
        lead: "A design and a tuned PID for each tool, side by side.",
        stems: &["tools"],
    },
    Stage {
        key: "statements",
        title: "At the tool plane",
        lead: "The statements of the paper's figure 9 as numbers; worst: not undercut by any rotor within the \
            uncertainty.",
        stems: &[],
    },
    Stage {
        key: "tightening",
        title: "Tighter at the tool",
        lead: "What the slack of the specification gives when it goes into the tool's displacement limits.",
        stems: &[],
    },
    Stage {
        key: "routes",
        title: "Sampled design and emulation",
        lead: "Both routes, each judged on the sampled loop: synthesis on the sampled plant, and continuous synthesis \
            with a Padé delay followed by Tustin's rule.",
        stems: &[],
    },
    Stage {
        key: "stiffness",
        title: "Dynamic stiffness at the tool",
        lead: "Force over displacement at the tool plane; higher is stiffer.",
        stems: &["stiffness", "compliance"],
    },
    Stage {
        key: "sensitivity",
        title: "Sensitivity",
        lead: "Robustness of each control axis in the zones of ISO 14839-3: A up to 9.5 dB, B to 12, C to 14.",
        stems: &["sensitivity", "nyquist", "poles"],
    },
    Stage {
        key: "margins",
        title: "Margins",
        lead: "What every sensor channel may change by at once: gain and phase of the disc round the critical point.",
        stems: &[],
    },
    Stage {
        key: "simulation",
        title: "Time responses",
        lead: "True bearing force law, limits of current and voltage, backup bearings.",
        stems: &[
            "animation",
            "response",
            "time",
            "orbit",
            "impulse",
            "step",
            "unbalance",
            "lift",
            "contact",
        ],
    },
    Stage {
        key: "machining",
        title: "Machining",
        lead: "Stable depth of cut from the closed-loop response at the tool.",
        stems: &["lobes", "chatter"],
    },
    Stage {
        key: "diagnosis",
        title: "Diagnosis",
        lead: "Where model and measurement disagree, and which effect explains it.",
        stems: &[
            "locali",
            "impedance",
            "ranking",
            "coverage",
            "residual",
            "hammer",
            "channel",
            "diagnosis",
        ],
    },
    Stage {
        key: "tools",
        title: "Tools",
        lead: "One design for each tool.",
        stems: &["tools", "batch"],
    },
];
