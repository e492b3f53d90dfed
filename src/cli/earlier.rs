//! `--from`: an earlier design from whose controller and scales the next one starts.

use super::Failure;
use crate::augment::plane::x_plane;
use crate::controller::ControlLaw;
use crate::input::file;
use crate::input::json::parse;
use crate::input::load_controller;
use crate::pipeline::settings::EarlierDesign;
use crate::spindle::Machine;
use serde_json::Value;
use std::path::Path;

/// Arguments of the commands that design.
#[derive(clap::Args, Debug, Clone, Default)]
pub(super) struct EarlierArgument {
    /// Start from an earlier design (its folder of results), for example of the previous tool
    #[arg(long, value_name = "DIR")]
    from: Option<String>,
}

impl EarlierArgument {
    /// The earlier design for a machine; none when none was named.
    pub(super) fn design(&self, machine: &Machine) -> Result<Option<EarlierDesign>, Failure> {
        let Some(folder) = &self.from else {
            return Ok(None);
        };
        // The folder of a tool of a batch holds the files of the controller itself.
        let places = ["controller/discrete.json", "discrete.json"].map(|f| Path::new(folder).join(f));
        let path = places.iter().find(|f| f.exists()).unwrap_or(&places[0]);
        let name = path.to_string_lossy();
        let controller = load_controller(&name)?;
        let ControlLaw::Discrete(law) = &controller.law else {
            let words = format!("{name}: the controller must be sampled");
            return Err(Failure::new(words).with_hint("name the folder of a run, design or tool of a batch"));
        };
        let (own, other) = (machine.spindle.electronics.sample_period_s(), law.time.period_s);
        // Rates as files write them.
        if (own / other - 1.0).abs() > 1e-9 {
            return Err(Failure::new(format!(
                "{name}: the controller is sampled at {:.6} Hz, the machine at {:.6} Hz",
                other.recip(),
                own.recip()
            ))
            .with_hint("start from a design for the same sample rate, or leave --from out"));
        }
        Ok(Some(EarlierDesign { plane: x_plane(law), scales: scales(folder), suffices: true }))
    }
}

/// Constant scales of the earlier design; none where the summary does not hold them: they only shorten a search.
fn scales(folder: &str) -> Vec<f64> {
    let text = file::read_text(&Path::new(folder).join("summary.json"), file::RESULT).unwrap_or_default();
    let summary: Value = parse(&text).unwrap_or_default();
    let list = summary["design"]["constant_scales"].as_array();
    let numbers = list.into_iter().flatten().filter_map(Value::as_f64);
    numbers.filter(|s| s.is_finite() && *s > 0.0).collect()
}
