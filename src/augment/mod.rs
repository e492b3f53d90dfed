//! Plant → generalized plant: weights, uncertainty blocks, the augmented system for synthesis.

pub mod assembly;
pub mod channels;
pub(crate) mod exposure;
pub mod generalized;
pub mod hardware;
mod machine_defaults;
pub mod mixed_sensitivity;
pub mod plane;
pub mod root;
pub mod second_order;
mod second_order_warp;
pub mod shape;
pub mod split;
pub mod uncertainty;
pub mod warp;
pub mod weight_plane;
mod weight_shapes;
pub mod weighting;
pub mod weights;

pub use generalized::GeneralizedPlant;
pub use uncertainty::Block;
