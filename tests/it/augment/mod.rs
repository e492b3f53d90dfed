//! Weights and the w plane.

mod further_uncertainty;
mod weight_curves;
mod weights;
