//! Formats of pictures, and types of the domain that an option of the command line chooses from: name of each
//! variant, and help where the name does not say it.

use super::Failure;
use crate::controller::realise::Form;
use crate::export::firmware::Format;
use crate::identify::spectra::{Estimator, Motion, SpectralWindow};
use crate::pipeline::simulation::SimulationCase;
use crate::report::plot::PictureFormat;
use crate::update::Method;
use clap::ValueEnum;
use clap::builder::PossibleValue;

/// Option of the commands that write pictures.
#[derive(clap::Args, Clone, Debug, Default)]
pub(super) struct PictureArguments {
    /// Formats of the pictures, separated by commas; SVG is always written, for the page is made of it, and what moves
    /// is SVG only
    #[arg(long = "format", value_name = "FORMAT", value_delimiter = ',', default_value = "svg")]
    pub formats: Vec<PictureFormat>,
}

impl PictureArguments {
    /// The folder that the pictures go to, where one is given.
    pub(super) fn folder<'a>(&self, out: &'a Option<String>) -> Result<Option<&'a str>, Failure> {
        match out {
            None if !self.further().is_empty() => {
                Err(Failure::new("--format: no pictures are written without --out")
                    .with_hint("name a folder with --out"))
            }
            out => Ok(out.as_deref()),
        }
    }

    /// The option as it is written on a command line, with a space before it; empty without formats beside SVG.
    pub(super) fn further(&self) -> String {
        let further = self.formats.iter().filter(|format| **format != PictureFormat::Svg);
        let endings: Vec<&str> = further.map(|format| format.name()).collect();
        if endings.is_empty() { String::new() } else { format!(" --format {}", endings.join(",")) }
    }
}

macro_rules! choices {
    ($type:ty: $($variant:ident $name:literal $($help:literal)?;)*) => {
        impl ValueEnum for $type {
            fn value_variants<'a>() -> &'a [Self] {
                &[$(Self::$variant),*]
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                Some(match self { $(Self::$variant => PossibleValue::new($name)$(.help($help))?,)* })
            }
        }
    };
}

choices! { Motion: Displacement "displacement"; Velocity "velocity"; Acceleration "acceleration"; }
choices! { Estimator: H1 "h1"; H2 "h2"; Hv "hv"; }
choices! { SpectralWindow: Hann "hann"; Rectangular "rectangular"; Exponential "exponential"; }
choices! { PictureFormat: Svg "svg"; Png "png"; Pdf "pdf"; }
choices! { Format: C "c"; Csv "csv"; Mat "mat"; Json "json"; }
choices! { Form:
    Modal "modal" "Real modal form";
    SecondOrderSections "sections" "Second-order sections, for decentralised controllers";
}
choices! { Method:
    GaussNewton "gauss-newton" "Sensitivities, prior, noise";
    NelderMead "nelder-mead" "The search of the reference method, Eq. (7)";
}
choices! { SimulationCase:
    Impulse "impulse" "Half-sine push at the tool";
    Step "step" "Constant force at the tool";
    Unbalance "unbalance" "Unbalance of a balance grade at speed";
    LiftOff "lift-off" "Lift-off from the backup bearings";
    Contact "contact" "Half-sine push at the tool that throws the rotor into its backup bearings";
}
