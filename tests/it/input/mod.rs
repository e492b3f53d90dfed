//! Files in.

mod all_errors;
mod consistent_values;
mod damage;
mod foreign_files;
mod input_files;
mod machine_defaults;
mod mutated_files;
mod plausible_values;
mod response_units;
mod ross;
mod uff;
mod uff_units;
