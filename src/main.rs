//! The command-line program: parse, run, exit with the documented code.

fn main() -> std::process::ExitCode {
    muspin::cli::main()
}
