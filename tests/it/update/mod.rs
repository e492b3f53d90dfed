//! Model updating.

mod update_commands;
mod update_random;
mod update_reference;
mod what_else;
