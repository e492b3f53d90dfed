//! C99 header and source of a controller, no dependencies: float32 and Q31, written out sum by sum from templates.
//! The arithmetic is that of [`crate::controller::arithmetic`]; test vectors computed there must come out bit for bit.

use super::json::channel_name;
use super::rows::{float32_statements, hex_float, q31_statements};
use crate::controller::arithmetic::{Float32Program, Q31Program};
use crate::controller::hand_over::HandOver;
use crate::controller::realise::{Realisation, Row};
use crate::controller::scaling::ScaledRealisation;
use crate::controller::verification::Verification;
use crate::controller::verification::growth_words;
use crate::input::quote::is_direction_mark;
use minijinja::{Environment, Value, context};

const HEADER: &str = include_str!("templates/controller.h");
const SOURCE: &str = include_str!("templates/controller.c");

/// Names that a source file with a single controller may use in place of the prefixed ones: types and functions.
const GENERIC_NAMES: [&str; 16] = [
    "f32",
    "f32_init",
    "f32_output",
    "f32_update",
    "f32_step",
    "f32_hand_over",
    "f32_state",
    "f32_bad_samples",
    "f32_restarts",
    "q31",
    "q31_init",
    "q31_output",
    "q31_update",
    "q31_step",
    "q31_hand_over",
    "q31_state",
];
/// The same for constants.
const GENERIC_CONSTANTS: [&str; 9] = [
    "INPUTS",
    "OUTPUTS",
    "STATES",
    "SIGNALS",
    "SAMPLE_TIME_S",
    "INPUT_LIMIT_M",
    "OUTPUT_LIMIT_A",
    "VERIFIED",
    "INPUT_SHA256",
];

/// What the C files say besides the coefficients.
#[derive(Clone, Debug)]
pub struct FirmwareLabels {
    /// What every symbol, type and macro of the controller begins with.
    pub prefix: String,
    /// Controller name.
    pub name: String,
    /// Spindle and tool, for the reader.
    pub machine: String,
    /// SHA-256 of the controller JSON, hex.
    pub input_sha256: String,
}

/// A name as C identifier: lower case, other characters as underscores, a letter first.
pub fn c_identifier(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    match plain.chars().next() {
        Some(first) if first.is_ascii_lowercase() => plain,
        Some(_) => format!("tool_{}", plain.trim_start_matches('_')),
        None => "controller".to_owned(),
    }
}

/// True for what `--prefix` may be: a C identifier that begins with a letter and is not the generic name itself.
pub fn is_prefix(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !text.eq_ignore_ascii_case("muspin")
}

/// `controller.h`.
///
/// # Errors
/// When the template does not render, which is a defect of the program.
pub fn header(
    scaled: &ScaledRealisation,
    verification: &Verification,
    labels: &FirmwareLabels,
) -> Result<String, minijinja::Error> {
    let rows = &scaled.rows;
    let upper = labels.prefix.to_ascii_uppercase();
    let generics: Vec<[String; 2]> = GENERIC_NAMES
        .iter()
        .map(|n| [format!("muspin_{n}"), format!("{}_{n}", labels.prefix)])
        .chain(GENERIC_CONSTANTS.iter().map(|n| [format!("MUSPIN_{n}"), format!("{upper}_{n}")]))
        .collect();
    let count = |list: &[Row]| list.iter().map(Vec::len).sum::<usize>();
    let conditioned = is_conditioned(&scaled.conditioning);
    let mut anti_windup = String::new();
    if scaled.anti_windup.contains(&true) {
        anti_windup.push_str(
            "\n * For slow real poles +-1 is the output limit; they are clamped there, so that they do not wind up.",
        );
    }
    if conditioned {
        anti_windup.push_str(
            "\n * Anti-windup: while an output is limited, the slow states are corrected by a gain times what the \
             limit took away.",
        );
    }
    let excess = if conditioned { rows.outputs.len() + 1 } else { 0 };
    let words = rows.order() + rows.inputs + rows.signals.len() + excess;
    render(
        HEADER,
        context! {
            notes => rows.notes.iter().map(|n| comment(n)).collect::<Vec<_>>(),
            controller => comment(&labels.name),
            machine => comment(&labels.machine),
            sha256 => labels.input_sha256,
            stability => comment(&stability_words(verification)),
            form => rows.form.name(),
            sample_time => format!("{:e}", rows.sample_time_s),
            axes => (0..rows.inputs).map(|k| channel_name(k, rows.inputs)).collect::<Vec<_>>().join(", "),
            products => rows.multiplications(),
            output_products => count(&rows.signals) + count(&rows.outputs),
            bytes => 4 * (words + 1),
            q31_bytes => 4 * words,
            input_limit => format!("{:e}", scaled.limits.input_m),
            output_limit => format!("{:e}", scaled.limits.output_a),
            verified => u8::from(verification.is_proven()),
            anti_windup,
            conditioned,
            generics,
            ..shape(rows, &labels.prefix)
        },
    )
}

/// `controller.c`; `error_bound_a` is the bound on Q31 against exact arithmetic over the test vectors.
///
/// # Errors
/// When the template does not render, which is a defect of the program.
pub fn source(
    prefix: &str,
    float: &Float32Program,
    fixed: &Q31Program,
    hand_over: &HandOver,
    error_bound_a: f64,
) -> Result<String, minijinja::Error> {
    let rows = &float.rows;
    let (n, m) = (rows.order(), rows.inputs);
    let reads = |list: &mut dyn Iterator<Item = &Row>, from: usize, to: usize| {
        list.flatten().any(|t| (from..to).contains(&t.source))
    };
    let mut leaving = rows.signals.iter().chain(&rows.outputs);
    let output_reads_states = reads(&mut leaving.clone(), 0, n);
    let output_reads_inputs = reads(&mut leaving, n, n + m);
    let (single, integer) = (float32_statements(float, prefix), q31_statements(fixed, prefix));
    render(
        SOURCE,
        context! {
            input_limit_f32 => hex_float(float.input_limit_m),
            output_limit_f32 => hex_float(float.output_limit_a),
            output_guard_f32 => hex_float(float.output_guard_a),
            error_bound => format!("{error_bound_a:.3e}"),
            output_reads_states,
            output_reads_inputs,
            outputs_unused => !output_reads_states && !output_reads_inputs,
            update_reads_inputs => reads(&mut rows.states.iter(), n, n + m),
            f32_output => single.output,
            f32_update => single.update,
            f32_conditioning => single.conditioning,
            f32_clamps => single.clamps,
            conditioned => is_conditioned(&float.conditioning),
            excess_shift => fixed.excess_shift,
            q31_conditioning => integer.conditioning,
            q31_output => integer.output,
            q31_update => integer.update,
            f32_hand_over => table(hand_over.float32.iter().map(|row| {
                row.iter().map(|t| hex_float(t.coefficient as f32)).collect()
            })),
            q31_hand_over => table(hand_over.q31.iter().map(|row| {
                row.terms.iter().map(|t| t.1.to_string()).collect()
            })),
            q31_hand_over_shifts => hand_over.q31.iter().map(|r| r.shift.to_string()).collect::<Vec<_>>().join(", "),
            ..shape(rows, prefix)
        },
    )
}

/// Names and sizes that both files use. C has no empty arrays: `_room` is at least one.
fn shape(rows: &Realisation, prefix: &str) -> Value {
    context! {
        name => prefix,
        NAME => prefix.to_ascii_uppercase(),
        states => rows.order(),
        signals => rows.signals.len(),
        inputs => rows.inputs,
        outputs => rows.outputs.len(),
        state_room => rows.order().max(1),
        input_room => rows.inputs.max(1),
        output_room => rows.outputs.len().max(1),
    }
}

/// True when some state is corrected while an output is limited.
fn is_conditioned(rows: &[Row]) -> bool {
    rows.iter().any(|row| !row.is_empty())
}

/// Rows of a two-dimensional C array.
fn table(rows: impl Iterator<Item = Vec<String>>) -> String {
    rows.map(|row| format!("        {{{}}},\n", row.join(", "))).collect()
}

pub(super) fn render(template: &str, values: Value) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_keep_trailing_newline(true);
    environment.set_undefined_behavior(minijinja::UndefinedBehavior::Strict);
    environment.render_str(template, values)
}

/// One sentence on what is known about the closed loop.
pub(crate) fn stability_words(verification: &Verification) -> String {
    let range = || {
        let first = verification.speeds.first().map_or(0.0, |s| s.speed_rpm);
        let last = verification.speeds.last().map_or(0.0, |s| s.speed_rpm);
        format!("{} speeds from {first} to {last} rpm ({})", verification.speeds.len(), verification.conditions)
    };
    let mu = verification.mu_peak.map_or(String::new(), |mu| format!("; peak of mu {mu:.4}"));
    let proven = verification.is_proven();
    let mut words = match (verification.unstable(), verification.worst_growth_rate_per_s()) {
        (None, Some(worst)) if proven => format!(
            "verified, closed loop proven stable at every speed from 0 to {} rpm and computed at {}; slowest decay \
             {:.2} 1/s{mu}",
            verification.top_rpm,
            range(),
            -worst
        ),
        (None, Some(worst)) => format!(
            "NOT VERIFIED: the closed loop is stable at {}, slowest decay {:.2} 1/s, but between them {}",
            range(),
            -worst,
            unproven_words(verification)
        ),
        (Some(bad), _) => format!(
            "UNSTABLE: closed loop {}; checked at {}",
            growth_words(bad.growth_rate_per_s, bad.speed_rpm),
            range()
        ),
        (None, None) => "NOT VERIFIED: the closed loop was not checked".to_owned(),
    };
    if verification.forced && !proven {
        words.push_str(". Forced by the user");
    }
    words
}

/// How far a proof that does not reach the largest speed goes.
fn unproven_words(verification: &Verification) -> String {
    match (&verification.proof_failure, &verification.proof) {
        (Some(failure), _) => format!("it could not be proven: {failure}"),
        (None, Some(proof)) => format!("proven only to {:.0} rpm", proof.proven_to_rpm()),
        (None, None) => "not proven".to_owned(),
    }
}

/// Text that cannot end a C comment, one line.
pub(super) fn comment(text: &str) -> String {
    // Marks of direction would let a reader see other code than the compiler does.
    let acts = |c: char| c.is_control() || is_direction_mark(c) || matches!(c, '\u{2028}' | '\u{2029}');
    text.replace("*/", "* /").replace("/*", "/ *").chars().map(|c| if acts(c) { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::comment;

    #[test]
    fn a_comment_is_one_line_that_reads_as_it_stands() {
        let text = comment("a*/ \u{202e}b\u{2066}c\u{200f}\nd\u{2028}e \u{e4}\u{5d0}");
        assert_eq!(text, "a* /  b c  d e \u{e4}\u{5d0}");
    }
}
