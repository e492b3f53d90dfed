//! The faces of a figure's typography.

use super::canvas::{Ink, Type};

/// A face of the figure's typography.
pub(super) fn face(size_px: f64, bold: bool, level: u8) -> Type {
    Type { size_px, bold, upright: false, ink: Ink::grey(level) }
}
