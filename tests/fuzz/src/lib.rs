//! What the fuzz targets share with the tests of the crate.

#[path = "../../it/input/damage/formats.rs"]
pub mod formats;
