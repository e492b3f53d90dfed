//! The response of the machine at a line, with its derivatives: the one place where electronics, ports, feedback,
//! gyroscopics, masses and springs are written down.
//!
//! [`super::plant`] evaluates the machine as given in modal coordinates; `reduced` keeps the shaft in Ritz
//! coordinates, in which moduli, joint and ports move without a new FE assembly. Both use the same `electronics`, the
//! same laws at ports (`feedback`) and the same `damping`.
//!
//! The response F is 6×6: sensor signals and tool displacement (x, y) from commanded currents and tool force (x, y).
//! With L = I + H_c κ the derivative to a stiffness is −(XLᵀ)ᵀ dK (XLᵀ).

pub(crate) mod adjoint;
pub(crate) mod assembled;
pub(crate) mod assembly;
pub(crate) mod channels;
mod condensation;
pub(crate) mod damping;
mod derivatives;
mod effect_terms;
pub(crate) mod electronics;
pub(crate) mod electronics_change;
pub(crate) mod feedback;
mod finer_mesh;
mod gyroscopic;
pub(crate) mod line;
mod line_in_planes;
mod mesh_correction;
mod moved_shaft;
pub(crate) mod pairs;
pub(crate) mod parameters;
pub(crate) mod ported;
pub(crate) mod probe;
pub(crate) mod reduced;
pub mod ritz;
mod ritz_basis;
mod sensitivity;
mod shaft_modes;
mod strain;
pub mod term;

pub use assembled::{Assembled, Receptance};
pub use assembly::Assembly;
pub use channels::{SIDE, Square, ZERO};
pub use line::Line;
pub(crate) use line::LineSlopes;
pub use reduced::ReducedMachine;
