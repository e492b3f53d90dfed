//! Mistakes in the records: tried before anything is said about the machine.

pub(crate) mod clipped;
pub(crate) mod finding;
pub(crate) mod folded;
pub(crate) mod gross;
pub(crate) mod search;
pub(crate) mod suspect;
pub(crate) mod trial;
