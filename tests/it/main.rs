//! One integration binary: less linking of heavy dependencies.
mod connections;
mod control_cases;
mod mu_constant;
