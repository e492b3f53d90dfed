//! Descent on a largest value with exact derivatives: the step of the prox-linear method, its proximal weight, and the
//! curvature that the steps teach.

mod active_set;
pub(crate) mod curvature;
pub(crate) mod proximal;
pub mod step;
