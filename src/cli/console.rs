//! What a command says at its end: the machine-readable answer in a pipe or with `--json`, a few lines for a person on
//! a terminal or with `--text`, nothing with `--quiet`.

use super::interrupt::Writing;
use super::{Failure, stdout};
use crate::input::quote::{printable, printable_lines};
use crate::report::results;
use serde_json::Value;
use std::borrow::Cow;
use std::io::IsTerminal;
use std::num::NonZero;
use std::path::Path;

/// Files that every command with a report writes.
pub(super) const REPORT: [&str; 2] = ["summary.json", "report.html"];

/// Options that every command takes.
#[derive(clap::Args, Clone, Debug, Default)]
pub(crate) struct ConsoleArguments {
    /// Print the machine-readable answer (JSON) to standard output
    #[arg(long, global = true, conflicts_with_all = ["text", "quiet"], help_heading = "Output")]
    json: bool,
    /// Print the summary for people, also where standard output is no terminal
    #[arg(long, global = true, conflicts_with = "quiet", help_heading = "Output")]
    text: bool,
    /// Print neither answer nor progress; errors and warnings only
    #[arg(long, global = true, help_heading = "Output")]
    quiet: bool,
    /// Threads of the computation; the results do not depend on it [default: one a processor]
    #[arg(long, global = true, value_name = "N", help_heading = "Output")]
    threads: Option<usize>,
}

/// What goes to standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OutputForm {
    Json,
    Text,
    /// The data of the command as other programs read them: JSON, CSV or lines.
    Data,
    Nothing,
}

/// The terminal as the options and the environment make it.
#[derive(Clone, Debug)]
pub(crate) struct Console {
    form: OutputForm,
    colours: bool,
    writing: Writing,
    /// The input files that were named on the command line.
    given: Vec<String>,
}

/// Most threads that can be asked for: more than any machine has.
const MOST_THREADS: usize = 1024;
/// Most threads that are started a processor: more wait for each other, and a thousand stall for seconds.
const MOST_A_PROCESSOR: usize = 2;

/// Stack of a thread, bytes: commands run on the threads of the pool, as deep as on the main thread.
const STACK: usize = 8 << 20;

impl Console {
    /// The console of a run that was given these files, with `writing` for its own; sets the number of threads.
    pub(crate) fn open(arguments: &ConsoleArguments, given: Vec<String>, writing: Writing) -> Result<Self, Failure> {
        if let Some(threads) = arguments.threads
            && !(1..=MOST_THREADS).contains(&threads)
        {
            let rule = format!("--threads {threads}: 1 to {MOST_THREADS} are possible");
            return Err(Failure::new(rule).with_hint("leave it out for one a processor"));
        }
        let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
        // Rayon would take as many as the environment says.
        let of_environment = || std::env::var("RAYON_NUM_THREADS").ok()?.trim().parse().ok();
        let asked: Option<usize> = arguments.threads.or_else(of_environment);
        let threads = asked.map(|threads| threads.min(MOST_A_PROCESSOR * processors));
        if let (Some(asked), Some(taken)) = (asked, threads)
            && taken < asked
        {
            eprintln!("warning: {asked} threads are too many: {taken} are started, {MOST_A_PROCESSOR} a processor");
        }
        // A process that runs a second command has its threads already.
        let built = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).stack_size(STACK).build_global();
        if let (Some(threads), Err(error)) = (arguments.threads, built) {
            return Err(Failure::new(format!("--threads {threads}: {error}")));
        }
        let terminal = std::io::stdout().is_terminal();
        let form = match () {
            () if arguments.json => OutputForm::Json,
            () if arguments.text => OutputForm::Text,
            () if arguments.quiet => OutputForm::Nothing,
            () if terminal => OutputForm::Text,
            () => OutputForm::Data,
        };
        let plain = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty())
            || std::env::var_os("TERM").is_some_and(|v| v == "dumb");
        Ok(Self { form, colours: terminal && !plain, writing, given })
    }

    /// The input files that were named on the command line.
    pub(crate) fn given_files(&self) -> &[String] {
        &self.given
    }

    /// Checks, before anything is computed, that the output folder may be written and that nothing would be replaced
    /// which the command reads: what was named on the command line, and `also`.
    pub(crate) fn claim(&self, out: &str, names: &[&str], also: &[&str]) -> Result<(), Failure> {
        let inputs: Vec<&str> = self.given.iter().map(String::as_str).chain(also.iter().copied()).collect();
        Ok(results::claim(Path::new(out), names, &inputs)?)
    }

    /// Writes files; an interruption waits until they are whole.
    pub(crate) fn writing<T, E>(&self, write: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        self.writing.hold_interrupts(write)
    }

    /// Whether the data of the command go to standard output as other programs read them.
    pub(crate) fn writes_data(&self) -> bool {
        self.form == OutputForm::Data
    }

    /// Whether the command ends with a few lines for a person.
    pub(crate) fn writes_text(&self) -> bool {
        self.form == OutputForm::Text
    }

    /// Whether progress may be shown.
    pub(crate) fn shows_progress(&self) -> bool {
        self.form != OutputForm::Nothing
    }

    /// Ends a command: its answer in the form that was asked for, then what is said behind it on standard error. True
    /// when its targets are met.
    pub(crate) fn end(&self, end: &CommandEnd) -> Result<bool, Failure> {
        let text: Cow<'_, str> = match (&end.answer, self.form) {
            (AnswerText::Written, _) => "".into(),
            (AnswerText::Always(text), _) | (AnswerText::Json(text), OutputForm::Json | OutputForm::Data) => {
                text.into()
            }
            (AnswerText::Data { data, .. }, OutputForm::Data) => data.into(),
            (AnswerText::Data { value, .. }, OutputForm::Json) => format!("{value:#}\n").into(),
            (_, OutputForm::Text) => end.text(self.colours).into(),
            (_, OutputForm::Nothing) => "".into(),
        };
        stdout::data(|out| out.write_all(text.as_bytes()))?;
        end.said.iter().for_each(|line| eprintln!("{line}"));
        Ok(!end.missed)
    }
}

/// The answer of a command to a program.
#[derive(Clone, Debug, Default)]
enum AnswerText {
    /// None, or one that was written on the way.
    #[default]
    Written,
    /// A text that programs read, on a terminal too.
    Always(String),
    Json(String),
    /// What is no JSON in a pipe, with the value for `--json`.
    Data {
        data: String,
        value: Value,
    },
}

/// The end of a command: its answer to a program, and for a person verdict, figures, where the files are, what to do
/// next.
#[must_use]
#[derive(Clone, Debug, Default)]
pub(crate) struct CommandEnd {
    answer: AnswerText,
    /// Sentences on standard error behind the answer.
    said: Vec<String>,
    verdict: String,
    missed: bool,
    table: Vec<Vec<String>>,
    files: Vec<String>,
    next: Vec<String>,
}

impl CommandEnd {
    /// A command that has written its answer, if there is one, and what there is to say.
    pub(crate) fn without_answer(met: bool) -> Self {
        Self { missed: !met, ..Self::default() }
    }

    /// A command whose answer is a text for programs, on a terminal too.
    pub(crate) fn always(text: String) -> Self {
        Self { answer: AnswerText::Always(text), ..Self::default() }
    }

    /// A command that has done what it was asked.
    pub(crate) fn done(verdict: impl Into<String>) -> Self {
        Self { verdict: verdict.into(), ..Self::default() }
    }

    /// A command whose targets are met or missed.
    pub(crate) fn met(met: bool, verdict: impl Into<String>) -> Self {
        Self { missed: !met, ..Self::done(verdict) }
    }

    /// The same with an answer in JSON.
    pub(crate) fn answer(self, value: &Value) -> Self {
        self.json(format!("{value:#}\n"))
    }

    /// The same with the text of an answer in JSON.
    pub(crate) fn json(self, text: String) -> Self {
        Self { answer: AnswerText::Json(text), ..self }
    }

    /// The same with an answer that is no JSON: `data` for a pipe, `value` for `--json`.
    pub(crate) fn data(self, data: String, value: Value) -> Self {
        Self { answer: AnswerText::Data { data, value }, ..self }
    }

    /// Adds a sentence on standard error behind the answer.
    pub(crate) fn say(mut self, line: impl Into<String>) -> Self {
        self.said.push(line.into());
        self
    }

    /// Adds a row of the table; the first column is left-aligned, the others right-aligned.
    pub(crate) fn row<const N: usize>(mut self, cells: [impl Into<String>; N]) -> Self {
        self.table.push(cells.into_iter().map(Into::into).collect());
        self
    }

    /// Adds rows of the table.
    pub(crate) fn rows(mut self, rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        self.table.extend(rows);
        self
    }

    /// Names a file or folder that was written.
    pub(crate) fn file(mut self, path: impl Into<String>) -> Self {
        self.files.push(path.into());
        self
    }

    pub(crate) fn next(mut self, command: impl Into<String>) -> Self {
        self.next.push(command.into());
        self
    }

    fn text(&self, colours: bool) -> String {
        let paint =
            |code: &str, text: &str| if colours { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_owned() };
        let word = if self.missed { paint("1;33", "target missed") } else { paint("1;32", "done") };
        let mut text = format!("{word}: {}\n", printable_lines(&self.verdict));
        if !self.table.is_empty() {
            text.push('\n');
            text.push_str(&printable_lines(&align_columns(&self.table)));
        }
        let lists = [("files", &self.files), ("next", &self.next)];
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            text.push('\n');
            for (k, line) in list.iter().enumerate() {
                let head = if k == 0 { name } else { "" };
                let line = printable(line);
                text.push_str(&format!("{}  {line}\n", paint("2", &format!("{head:<5}"))));
            }
        }
        text
    }
}

/// The rows as columns that stand below each other.
fn align_columns(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |k: usize| {
        let cells = rows.iter().filter_map(|row| row.get(k));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (k, cell) in row.iter().enumerate() {
            let fill = " ".repeat(widths[k].saturating_sub(cell.chars().count()));
            line.push_str("  ");
            line.push_str(&if k == 0 { format!("{cell}{fill}") } else { format!("{fill}{cell}") });
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}
