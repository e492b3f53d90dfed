//! Results folder, page and pictures.

mod diagnosis_page;
mod foreign_folders;
mod interrupted_writes;
mod picture_formats;
mod plots;
mod reference_run;
mod results_folder;
