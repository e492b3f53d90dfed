//! Types of the domain that an option of the command line chooses from: name of each variant, and help where the name
//! does not say it.

use crate::controller::realise::Form;
use crate::export::firmware::Format;
use crate::identify::spectra::{Estimator, Motion, SpectralWindow};
use crate::pipeline::simulation::SimulationCase;
use clap::ValueEnum;
use clap::builder::PossibleValue;

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
choices! { Format: C "c"; Csv "csv"; Mat "mat"; Json "json"; }
choices! { Form:
    Modal "modal" "Real modal form";
    SecondOrderSections "sections" "Second-order sections, for decentralised controllers";
}
choices! { SimulationCase:
    Impulse "impulse" "Half-sine push at the tool";
    Step "step" "Constant force at the tool";
    Unbalance "unbalance" "Unbalance of a balance grade at speed";
    LiftOff "lift-off" "Lift-off from the backup bearings";
    Contact "contact" "Half-sine push at the tool that throws the rotor into its backup bearings";
}
