//! Arguments of `muspin batch`.

use super::choices::PictureArguments;
use super::design_arguments::PidArguments;
use super::earlier::EarlierArgument;
use super::timings::Timings;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Spindle file, or the name of a shipped one; usually the updated model of a run
    #[arg(long, default_value = "reference")]
    pub spindle: String,
    /// Tools: files or shipped names separated by commas, a folder of tool files, or `none`
    #[arg(long, value_delimiter = ',', required_unless_present = "collect")]
    pub tools: Vec<String>,
    /// Weights file, or the name of a shipped one
    #[arg(long, default_value = "benchmark")]
    pub weights: String,
    /// A quantity and its half width, for example ki=3%: each tool once more at both ends (ki, ks, sensor_gain, delay,
    /// amplifier_bandwidth, damping, modulus)
    #[arg(long, value_name = "QUANTITY=PERCENT", value_delimiter = ',')]
    pub vary: Vec<String>,
    #[command(flatten)]
    pub pid: PidArguments,
    /// The controllers with their proofs and worst cases only: no PID to compare with, no pictures per tool
    #[arg(long)]
    pub quick: bool,
    /// Deliver the reduced controller of the D-K iteration without the polish for tool stiffness
    #[arg(long)]
    pub no_polish: bool,
    /// Also seek the largest tightening of tools that meet the specification
    #[arg(long)]
    pub tightening: bool,
    /// Compute a tool again although its folder was computed from the same inputs
    #[arg(long)]
    pub again: bool,
    /// Write the folder of each tool and no table over all: for jobs that run side by side
    #[arg(long)]
    pub no_table: bool,
    /// Compute nothing: write the files of each variant, a list of commands for GNU parallel and a Slurm job array into
    /// a folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["collect", "out", "from"])]
    pub plan: Option<String>,
    /// Compute nothing: make the table from the finished folders in a folder
    #[arg(long, value_name = "DIR")]
    pub collect: Option<String>,
    #[command(flatten)]
    pub from: EarlierArgument,
    /// Folder for the table and a folder per tool
    #[arg(long, default_value = "results/batch")]
    pub out: String,
    #[command(flatten)]
    pub pictures: PictureArguments,
    #[command(flatten)]
    pub timings: Timings,
}
