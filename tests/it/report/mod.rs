//! Results folder, page and pictures.

mod interrupted_writes;
mod plots;
mod reference_run;
mod results_folder;
