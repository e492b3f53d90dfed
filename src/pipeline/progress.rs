//! Events of a running design: finished steps and stages.

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

/// Stages of a design in their order, with the usual share of each in the time of all, per cent: the first four are
/// repeated when the whole machine asks for another synthesis. Shares are rounded means over three machines; they
/// serve an estimate on a terminal and nothing else.
pub const STAGES: [(&str, f64); 6] = [
    ("problems and constant scales", 8.0),
    ("D-K iteration", 1.0),
    ("stable controller", 1.0),
    ("μ of the whole machine", 0.5),
    ("reduction, polish and certificates", 86.5),
    ("scale of the specification", 0.0),
];

/// The stage that begins when `ended` has ended, with the number of those done; none after the last.
pub fn next_stage(ended: &str) -> Option<(usize, &'static str)> {
    let done = STAGES.iter().position(|(stage, _)| *stage == ended)? + 1;
    STAGES.get(done).map(|(stage, _)| (done, *stage))
}

/// Usual share of the time that the first `done` stages take, between zero and one.
pub(crate) fn usual_share(done: usize) -> f64 {
    let sum = |list: &[(&str, f64)]| list.iter().map(|(_, share)| share).sum::<f64>();
    sum(&STAGES[..done.min(STAGES.len())]) / sum(&STAGES)
}

/// Where events go. The caller may keep a clock; no figure depends on it.
pub(crate) type Listener<'a> = dyn FnMut(Event) + 'a;
