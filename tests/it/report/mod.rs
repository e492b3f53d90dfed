//! Results folder, page and pictures.

mod diagnosis_page;
mod interrupted_writes;
mod plots;
mod reference_run;
mod results_folder;
