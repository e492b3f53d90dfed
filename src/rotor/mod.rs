//! The flexible shaft: sections, Timoshenko elements, assembly, modes, reduction with static correction.
//!
//! Coordinates: z along the shaft, m, the nose face at z = 0, the tool at z < 0, the tail at the largest z. In each
//! plane a node has a deflection w (m) and a rotation ψ (rad, ψ = +dw/dz for a slender beam). Both planes are the same;
//! in the complex coordinate r = x + jy the equation of motion is  M r̈ + C ṙ − jΩG ṙ + K r = f.

pub(crate) mod assembly;
pub mod basis;
pub mod chain;
pub mod chain_assembly;
pub mod element;
pub mod modes;
pub mod section;
pub mod spectrum;
pub mod supported;
pub mod tilt;
pub mod whirl;
pub mod zeros;

pub use assembly::{Joint, MassProperties, PlaneMatrices, Rotor};
pub use basis::Basis;
pub use modes::PlanarModes;
pub use section::{Disc, Material, Section, Shear};
pub use whirl::{Damping, Support, WhirlMode, WhirlShape};

use crate::linalg::NumericError;
use thiserror::Error;

/// Most elements and most discs of a file. The eigenvalue problems are dense: time grows with the cube, and at this
/// number the modes at one speed take about a minute. Elements of a tenth of the shortest wavelength of interest are
/// ample.
pub(crate) const MOST_LISTED: usize = 300;
/// Most elements of a shaft: the same with every element halved twice, as a finer mesh has it.
const MOST_ELEMENTS: usize = 4 * MOST_LISTED;

/// Checks that the lists of a file are short enough.
pub(crate) fn check_lists(sections: &[Section], discs: &[Disc]) -> Result<(), RotorError> {
    check_lengths([sections.len(), discs.len()], MOST_LISTED)
}

/// Checks the numbers of elements and of discs.
fn check_lengths(counts: [usize; 2], most: usize) -> Result<(), RotorError> {
    for (list, count) in ["elements", "discs"].into_iter().zip(counts) {
        if count > most {
            return Err(RotorError::TooMany { list, count, most });
        }
    }
    Ok(())
}

/// What can be wrong with a shaft.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RotorError {
    /// A value of one element breaks a rule.
    #[error("elements[{index}].{field}: {value} {rule}")]
    Element {
        /// Element, in list order, from 0.
        index: usize,
        /// Name of the value.
        field: &'static str,
        /// The value.
        value: f64,
        /// The rule it breaks, as the end of a sentence.
        rule: String,
    },
    /// A value of one disc breaks a rule.
    #[error("discs[{index}].{field}: {value} {rule}")]
    Disc {
        /// Disc, in list order, from 0.
        index: usize,
        /// Name of the value.
        field: &'static str,
        /// The value.
        value: f64,
        /// The rule it breaks.
        rule: String,
    },
    /// A shaft without elements.
    #[error("elements: the list is empty, a shaft needs at least one element")]
    NoElements,
    /// More elements than the dense eigenvalue problems can take.
    #[error("{list}: has {count} entries, at most {most} are computed")]
    TooMany {
        /// The list.
        list: &'static str,
        /// Its length.
        count: usize,
        /// The longest that is computed.
        most: usize,
    },
    /// A position that is not on the shaft.
    #[error("{what}: {position_m} m is not on the shaft, which reaches from {from_m} m to {to_m} m")]
    OffShaft {
        /// What sits there.
        what: String,
        /// Position, m from the nose face.
        position_m: f64,
        /// Tool end of the shaft, m.
        from_m: f64,
        /// Tail end, m.
        to_m: f64,
    },
    /// A parameter of an attached part that makes no sense.
    #[error("{what}: {value} {rule}")]
    Part {
        /// The parameter.
        what: String,
        /// Its value.
        value: f64,
        /// The rule it breaks.
        rule: String,
    },
    /// A matrix computation failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}
