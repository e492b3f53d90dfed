//! `muspin schema`: the JSON Schema of a kind of file, or the page of all keys.

use super::Failure;
use super::console::CommandEnd;
use crate::input::problem_schema::{ProblemKind, problem_schema};
use crate::input::schema::{SchemaKind, page, schema};

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Kind of file: spindle, rotor, tool, weights, measurement, frequencies, controller or pid; for a problem of
    /// `muspin solve` solve-care, solve-hinfnorm, solve-hinfsyn, solve-mu, solve-musys, solve-dfit, solve-dksyn,
    /// solve-reduce or solve-discretise
    #[arg(required_unless_present = "page")]
    kind: Option<String>,
    /// Print the page of all keys with unit, default and ranges instead (Markdown)
    #[arg(long, conflicts_with = "kind")]
    page: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<CommandEnd, Failure> {
    let text = match &arguments.kind {
        None => page(),
        Some(name) => match problem(name) {
            Some(kind) => format!("{:#}\n", problem_schema(kind)),
            None => text(kind(name)?),
        },
    };
    Ok(CommandEnd::always(text))
}

pub(super) fn text(kind: SchemaKind) -> String {
    format!("{:#}\n", schema(kind))
}

/// The kind of problem of `solve-KIND`.
fn problem(name: &str) -> Option<ProblemKind> {
    ProblemKind::from_name(name.strip_prefix("solve-")?)
}

fn kind(name: &str) -> Result<SchemaKind, Failure> {
    SchemaKind::from_name(name).ok_or_else(|| {
        let names = SchemaKind::ALL.map(SchemaKind::name).join(", ");
        let problems = ProblemKind::ALL.map(|k| format!("solve-{}", k.name()));
        Failure::new(format!("{name}: there is no schema of this name"))
            .with_hint(format!("take one of {names}, {}", problems.join(", ")))
    })
}
