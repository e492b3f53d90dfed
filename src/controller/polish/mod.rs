//! Fixed-structure polish of a controller of one plane: its parameters are moved, with exact derivatives, to raise the
//! smallest dynamic stiffness of the tool, with every limit as a constraint of its own.
//!
//! In μ-synthesis with one full performance block all rows of a specification share one scalar, and slack in one row
//! cannot be used in another. The polish starts from its reduced controller and maximises the smallest tool stiffness
//! over the machine at rest, at top speed and over rotors with shifted modes, subject to: sensitivity of both loops,
//! gain above the band, current from sensor noise, and the D-scaled μ bound of the specification itself at rest, at top
//! speed and beyond, and at speeds between where a certificate finds it exceeded there. All of it on
//! the sampled machine with every mode below Nyquist and the static flexibility of the rest, with hold and delay,
//! weights in true Hz.

mod derivatives;
pub(crate) mod descent;
mod gathered;
pub(crate) mod limits;
pub(crate) mod line_scales;
pub(crate) mod line_state;
pub(crate) mod lines;
pub(crate) mod loop_poles;
mod loop_state;
pub(crate) mod loss;
mod loss_gradient;
pub(crate) mod matrix2;
pub(crate) mod modal_law;
mod packed_loops;
pub(crate) mod phase_count;
mod problem;
pub(crate) mod responses;
mod rotor_groups;
mod specification_bound;
mod specification_norm;
mod stage;
pub(crate) mod structure;
pub(crate) mod values;

pub use derivatives::derivative_errors;
pub use limits::LoopLimits;
pub use problem::PolishTask;
pub(crate) use stage::SPEEDS_BETWEEN;
pub use stage::{PolishRound, Polisher};
