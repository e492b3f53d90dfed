//! Guides: how files look and how a job is done. Each page is plain Markdown in `src/guide/` as well.

#[doc = include_str!("formats.md")]
pub mod formats {}
