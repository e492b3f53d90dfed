//! What the fuzz targets share with the tests of the crate.

#[path = "../../it/damage/formats.rs"]
pub mod formats;
