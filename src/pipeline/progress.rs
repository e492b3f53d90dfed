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

/// Where events go. The caller may keep a clock; no figure depends on it.
pub type Listener<'a> = dyn FnMut(Event) + 'a;
