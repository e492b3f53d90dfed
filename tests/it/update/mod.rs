//! Model updating.

mod update_commands;
mod update_reference;
