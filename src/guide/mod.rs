//! Guides: how a job is done and how files look. Each page is plain Markdown in `src/guide/` as well; `muspin example`
//! writes the files that a guide works with.

#[doc = include_str!("start.md")]
pub mod start {}

#[doc = include_str!("updating.md")]
pub mod updating {}

#[doc = include_str!("design.md")]
pub mod design {}

#[doc = include_str!("pid.md")]
pub mod pid {}

#[doc = include_str!("weights.md")]
pub mod weights {}

#[doc = include_str!("records.md")]
pub mod records {}

#[doc = include_str!("files.md")]
pub mod files {}

#[doc = include_str!("limits.md")]
pub mod limits {}

#[doc = include_str!("comparison.md")]
pub mod comparison {}

#[doc = include_str!("diagnosis.md")]
pub mod diagnosis {}

#[doc = include_str!("firmware.md")]
pub mod firmware {}

#[doc = include_str!("solvers.md")]
pub mod solvers {}

#[doc = include_str!("python.md")]
pub mod python {}

#[doc = include_str!("formats.md")]
pub mod formats {}

#[doc = include_str!("keys.md")]
pub mod keys {}
