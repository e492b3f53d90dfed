//! Where something is missing, without a hypothesis: the law recovered at a place, line by line.

mod basis;
pub mod correction;
mod joint;
pub mod localisation;
pub mod place;
pub(crate) mod place_law;
pub(crate) mod place_response;
mod place_slopes;
pub(crate) mod projection;
pub mod recovered_law;
