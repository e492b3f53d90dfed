//! Mistakes in the records: tried before anything is said about the machine.

pub mod clipped;
pub mod finding;
pub mod folded;
pub mod gross;
pub mod search;
pub mod suspect;
pub mod trial;
