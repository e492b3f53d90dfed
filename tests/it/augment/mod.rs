//! Weights and the w plane.

mod further_uncertainty;
mod weights;
