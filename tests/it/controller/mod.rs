//! From K(s) to the rows that a processor computes.

mod anti_windup;
mod hand_over;
mod modal_form;
mod polish;
mod speed_proof;
