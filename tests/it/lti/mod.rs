//! State space: responses, norms, sampling, reduction.

mod companion;
mod connections;
mod hold;
mod sampling_rules;
mod solve_discretise;
mod solve_hinfnorm;
mod solve_reduce;
