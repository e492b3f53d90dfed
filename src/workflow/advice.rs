//! What a user can do about an error of each folder.

use super::failure::Failure;
use crate::controller::ControllerError;
use crate::controller::verification_error::VerificationError;
use crate::diagnose::DiagnoseError;
use crate::export::error::FirmwareError;
use crate::identify::IdentifyError;
use crate::linalg::NumericError;
use crate::pid::given::GivenPidError;
use crate::pipeline::PipelineError;
use crate::predict::time::TimeError;
use crate::report::rehearsed::RehearsalError;
use crate::report::results::ResultsError;
use crate::report::whole::ReportError;
use crate::rotor::RotorError;
use crate::update::UpdateError;

/// Errors whose words say all.
macro_rules! plain {
    ($($error:ty),*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::new(error.to_string())
            }
        })*
    };
}
plain!(ControllerError, FirmwareError, NumericError, RotorError);

impl From<ResultsError> for Failure {
    fn from(error: ResultsError) -> Self {
        let hint = match &error {
            ResultsError::Foreign { .. } | ResultsError::Edited { .. } => {
                "muspin replaces only unchanged files that its muspin-manifest.json lists: move the file away, delete \
                 it, or choose another folder with --out"
            }
            ResultsError::Manifest { .. } => {
                "delete the manifest if the folder is yours, or choose another folder with --out"
            }
            _ => "choose another folder with --out",
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        match error {
            ReportError::Results(inner) => inner.into(),
            ReportError::Pipeline(inner) => inner.into(),
            ReportError::Machine(inner) => inner.into(),
            other => Self::new(other.to_string()),
        }
    }
}

impl From<PipelineError> for Failure {
    fn from(error: PipelineError) -> Self {
        let hint = match &error {
            PipelineError::Synthesis(inner) => inner.advice().to_owned(),
            PipelineError::Plant(_) => "`muspin check` on the spindle and tool files shows more".to_owned(),
            PipelineError::SampleTime { .. } => {
                "give the spindle that the controller was made for with --spindle".to_owned()
            }
            PipelineError::Emulated { .. } => "use --route direct, or a higher sample rate".to_owned(),
            _ => "loosen the weights, or check the spindle's data".to_owned(),
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

impl From<GivenPidError> for Failure {
    fn from(error: GivenPidError) -> Self {
        Self::new(error.to_string()).with_hint("`muspin check` on the spindle, tool and PID files shows more")
    }
}

impl From<VerificationError> for Failure {
    fn from(error: VerificationError) -> Self {
        match error {
            VerificationError::Plant(e) => e.into(),
            VerificationError::Loop(e) => e.into(),
        }
    }
}

impl From<TimeError> for Failure {
    fn from(error: TimeError) -> Self {
        match error {
            TimeError::Plant(e) => e.into(),
            other => Self::new(other.to_string()),
        }
    }
}

impl From<RehearsalError> for Failure {
    fn from(error: RehearsalError) -> Self {
        match error {
            RehearsalError::Unstable(words) => Self::new(words)
                .with_hint("a sweep needs a controller that floats the rotor: give one with --controller"),
            RehearsalError::Pipeline(error) => error.into(),
            RehearsalError::Results(error) => error.into(),
            RehearsalError::Record(error) => error.into(),
        }
    }
}

impl From<IdentifyError> for Failure {
    fn from(error: IdentifyError) -> Self {
        let hint = match &error {
            IdentifyError::Singular { .. } => "the four injections must differ: one axis each, at every line",
            IdentifyError::NotAtRest { .. } => "add a sweep taken at 0 rpm to the measurement",
            IdentifyError::NoResonance { .. } => "check frequency range, line spacing and excitation of the sweep",
            _ => "check the record",
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

impl From<UpdateError> for Failure {
    fn from(error: UpdateError) -> Self {
        let hint = match &error {
            UpdateError::NoRegions => "give elements of spindle or tool a `region`: those share one modulus factor",
            UpdateError::NoTargets { .. } => "add a sweep at 0 rpm or a record of kind frequencies to the measurement",
            UpdateError::NoMatch { .. } => "check that spindle and tool are those that were measured",
            _ => "check spindle, tool and measurement",
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

impl From<DiagnoseError> for Failure {
    fn from(error: DiagnoseError) -> Self {
        if let DiagnoseError::Record(record) = error {
            return record.into();
        }
        Self::new(error.to_string()).with_hint("check spindle, tool and measurement")
    }
}
