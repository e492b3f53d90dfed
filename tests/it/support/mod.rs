//! A second road to every figure of a design: the machine as its files state it, in code that shares nothing with the
//! program.
//!
//! The shaft is one complex coordinate r = x + jy per degree of freedom: M r̈ + C ṙ − jΩG ṙ + K r = f, with own
//! element matrices (numerical integration of the shape functions), every mode of the mesh, the magnets, first-order
//! amplifiers and sensors, the hold and the rest of the delay exact. Dense algebra is faer's; nothing of `muspin` is
//! used here but the types of the inputs that several tests share (`inputs`).

pub mod beam;
pub mod controller;
pub mod figures;
pub mod files;
pub mod folder;
pub mod inputs;
pub mod robustness;
pub mod rotor;
pub mod sampled;
