//! Second-order sections: every axis of a decentralised controller as a cascade of biquads in transposed direct
//! form II,  t = b₀e + x₁,  x₁⁺ = b₁e − a₁t + x₂,  x₂⁺ = b₂e − a₂t,  e the output of the section before.
//! `roots` finds poles, zeros and gain of an axis, `arrangement` couples them to sections, `rows` makes the rows that
//! firmware computes of them, `table` the tables for filters of other libraries, with coefficients that `rounding`
//! chooses and a transfer function that `band` compares with the axis.

mod arrangement;
#[cfg(feature = "cli")]
mod band;
mod roots;
#[cfg(feature = "cli")]
mod rounding;
mod rows;
mod section;
#[cfg(feature = "cli")]
mod table;

pub use rows::second_order_sections;
pub use section::SectionBiquad;
#[cfg(feature = "cli")]
pub(crate) use table::{AxisTable, Precision, axis_tables};
