//! What a design tells while it runs: finished steps and finished stages.

use crate::robust::dk::DkStep;

/// Something that has just ended or begins.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A part of a run begins; its stages follow.
    Begins(&'static str),
    /// What a part of a run found, in a sentence.
    Found(&'a str),
    /// A step of the D-K iteration.
    Step(&'a DkStep),
    /// A stage of the design; one that is repeated ends more than once.
    Stage(&'static str),
}

/// Stages of a design in their order; the first four are repeated when the whole machine asks for another synthesis.
pub const STAGES: [&str; 11] = [
    "problems and constant scales",
    "D-K iteration",
    "stable controller",
    "μ of the whole machine",
    "D-scales over frequency",
    "certificates of full order",
    "reduction",
    "certificates of reduced order",
    "realisation and its proofs",
    "polish",
    "scale of the specification",
];

/// The stage that begins when `ended` has ended, with the number of those done; none after the last.
pub fn next_stage(ended: &str) -> Option<(usize, &'static str)> {
    let done = STAGES.iter().position(|stage| *stage == ended)? + 1;
    STAGES.get(done).map(|stage| (done, *stage))
}

/// Where events go. The caller may keep a clock; no figure depends on it.
pub type Listener<'a> = dyn FnMut(Event) + 'a;
