//! One integration binary: less linking of heavy dependencies.
mod connections;
mod solve_care;
mod solve_cases;
mod solve_discretise;
mod solve_hinfnorm;
mod solve_hinfsyn;
mod solve_reduce;
