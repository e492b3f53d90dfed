//! Weights and the w plane.

mod weights;
