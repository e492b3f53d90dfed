//! Plant → generalized plant: weights, uncertainty blocks, the augmented system for synthesis.

pub mod generalized;
pub mod uncertainty;
pub mod weighting;

pub use generalized::GeneralizedPlant;
pub use uncertainty::Block;
