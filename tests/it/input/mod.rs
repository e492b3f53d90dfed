//! Files in.

mod damage;
mod input_files;
mod mutated_files;
mod plausible_values;
mod ross;
mod uff;
