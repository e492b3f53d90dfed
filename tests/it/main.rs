//! One integration binary: less linking of heavy dependencies.
mod connections;
mod plots;
