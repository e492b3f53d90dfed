//! One integration binary: less linking of heavy dependencies.
mod augment;
mod connections;
