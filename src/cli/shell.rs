//! `muspin` alone, `muspin completions SHELL` and `muspin man`: the help, and what packages install beside the program.

use super::console::CommandEnd;
use super::{Cli, Failure};
use clap::CommandFactory;
use clap_complete::{Shell, generate};

/// Arguments of `muspin completions`.
#[derive(clap::Args, Debug)]
pub(super) struct Completions {
    /// Shell
    #[arg(value_enum)]
    shell: Shell,
}

pub(super) fn completions(arguments: &Completions) -> CommandEnd {
    let mut text = vec![];
    generate(arguments.shell, &mut Cli::command(), "muspin", &mut text);
    CommandEnd::always(String::from_utf8_lossy(&text).into_owned())
}

/// The help of the program, with the ways in.
pub(super) fn help() -> CommandEnd {
    CommandEnd::always(Cli::command().render_help().to_string())
}

/// The manual page: the program, then every command.
pub(super) fn manual() -> Result<CommandEnd, Failure> {
    let mut command = Cli::command();
    command.build();
    let mut text = vec![];
    let failed = |e: std::io::Error| Failure::new(format!("manual page: {e}"));
    clap_mangen::Man::new(command.clone()).render(&mut text).map_err(failed)?;
    for each in command.get_subcommands() {
        let page = clap_mangen::Man::new(each.clone());
        let heading = format!(".SH \"MUSPIN {}\"\n", each.get_name().to_uppercase());
        text.extend_from_slice(heading.as_bytes());
        page.render_description_section(&mut text).map_err(failed)?;
        page.render_options_section(&mut text).map_err(failed)?;
    }
    Ok(CommandEnd::always(String::from_utf8_lossy(&text).into_owned()))
}
