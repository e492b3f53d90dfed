//! Keys of a problem file that `muspin solve` does not read: an error with what is meant, never a silent default.

use super::error::{InputError, nearest};
use super::problem::ProblemFields;
use super::problem_schema::{NOTES, ProblemKind};
use serde_json::Value;

/// What a key of another program means there, and when it changes nothing.
struct Foreign {
    names: &'static [&'static str],
    /// Kinds of problem that the hint is for.
    kinds: fn(ProblemKind) -> bool,
    is_neutral: fn(&Value) -> bool,
    hint: &'static str,
}

/// Kinds with a generalized plant.
fn is_partitioned(kind: ProblemKind) -> bool {
    matches!(kind, ProblemKind::Hinfsyn | ProblemKind::H2syn | ProblemKind::Dksyn)
}

/// Kinds whose systems may be sampled, and the one that samples them.
fn has_sample_time(kind: ProblemKind) -> bool {
    !matches!(kind, ProblemKind::Care | ProblemKind::Dare | ProblemKind::Mu)
}

const FOREIGN: [Foreign; 11] = [
    Foreign {
        names: &["E"],
        kinds: |_| true,
        is_neutral: is_identity,
        hint: "a descriptor belongs to a system: A, B, C, D, E",
    },
    Foreign {
        names: &["sample_time", "sampling_time", "dt", "fs", "sample_time_s"],
        kinds: has_sample_time,
        is_neutral: |_| false,
        hint: "the sample time in s is `Ts`; `solve discretise` takes a system in continuous time",
    },
    Foreign {
        names: &["Ts", "sample_time_s", "sample_time", "sampling_time", "dt", "fs"],
        kinds: |kind| kind == ProblemKind::Care,
        is_neutral: |v| v.as_f64() == Some(0.0),
        hint: "the Riccati equation of sampled time is `solve dare`",
    },
    Foreign {
        names: &["Ts", "sample_time_s", "sample_time", "sampling_time", "dt", "fs"],
        kinds: |kind| matches!(kind, ProblemKind::Dare | ProblemKind::Mu),
        is_neutral: |_| true,
        hint: "",
    },
    Foreign {
        names: &["InputDelay", "OutputDelay", "IODelay", "ioDelay", "InternalDelay", "delay", "delay_s"],
        kinds: |_| true,
        is_neutral: is_zero,
        hint: "delays are not taken; add a Pade approximation to the system",
    },
    Foreign {
        names: &["G"],
        kinds: |kind| kind == ProblemKind::Dare,
        is_neutral: |_| false,
        hint: "give B and R in place of G = B inv(R) B'",
    },
    Foreign {
        names: &["nmeas", "ny", "nmeasurements", "measurements"],
        kinds: is_partitioned,
        is_neutral: |_| false,
        hint: "the number of measurements is `p2`, that of errors `p1`",
    },
    Foreign {
        names: &["ncon", "ncont", "nu", "ncontrols", "controls"],
        kinds: is_partitioned,
        is_neutral: |_| false,
        hint: "the number of controls is `m2`, that of disturbances `m1`",
    },
    Foreign {
        names: &["B1", "B2", "C1", "C2", "D11", "D12", "D21", "D22"],
        kinds: is_partitioned,
        is_neutral: |_| false,
        hint: "the plant is given as a whole: B = [B1 B2], C = [C1; C2], D = [D11 D12; D21 D22] with m1, m2, p1, p2",
    },
    Foreign {
        names: &["TimeUnit", "FrequencyUnit"],
        kinds: |_| true,
        is_neutral: |v| matches!(v.as_str(), Some("seconds" | "s" | "rad/s" | "rad/TimeUnit")),
        hint: "times are in s and frequencies in rad/s; convert the matrices",
    },
    Foreign {
        names: &["tol", "rtol", "reltol", "tolerance"],
        kinds: |_| true,
        is_neutral: |_| false,
        hint: "there is nothing to set: answers carry their own bounds; remove the key",
    },
];

fn is_zero(value: &Value) -> bool {
    match value {
        Value::Array(list) => list.iter().all(is_zero),
        other => other.as_f64() == Some(0.0),
    }
}

fn is_identity(value: &Value) -> bool {
    let entry = |i: usize, j: usize, v: &Value| v.as_f64() == Some(if i == j { 1.0 } else { 0.0 });
    let Some(rows) = value.as_array() else {
        return entry(0, 0, value);
    };
    rows.iter().enumerate().all(|(i, row)| match row.as_array() {
        Some(row) => row.len() == rows.len() && row.iter().enumerate().all(|(j, v)| entry(i, j, v)),
        None => rows.len() == 1 && entry(0, 0, row),
    })
}

impl Foreign {
    fn find_foreign(key: &str, kind: ProblemKind) -> Option<&'static Self> {
        let is_named = |f: &&Self| f.names.iter().any(|name| name.eq_ignore_ascii_case(key));
        FOREIGN.iter().filter(|f| (f.kinds)(kind)).find(is_named)
    }

    fn changes(&self, value: &Value) -> bool {
        !(value.is_null() || (self.is_neutral)(value))
    }
}

/// Checks that every key is one that this kind of problem has, or only describes it. Beside `data`, where descriptions
/// and references stand, no key that belongs into the problem is passed over.
///
/// # Errors
/// A key that the kind does not have, with the nearest one or with what it means in other programs.
pub fn check_keys(problem: &ProblemFields, kind: ProblemKind) -> Result<(), InputError> {
    let names = kind.field_names();
    for (key, value) in problem.fields() {
        if names.contains(&key.as_str()) || is_note(key) {
            continue;
        }
        let error = problem.failure_at_key(key, format!("unknown key `{key}`: `solve {}` has none", kind.name()));
        let exact = names.iter().find(|name| name.eq_ignore_ascii_case(key));
        match (exact, Foreign::find_foreign(key, kind)) {
            (None, Some(foreign)) if !foreign.changes(value) => {}
            (None, Some(foreign)) => return Err(error.with_hint(foreign.hint)),
            _ => {
                let best = nearest(key, names.iter().copied()).unwrap_or_default();
                return Err(error.with_hint(format!("did you mean `{best}`? its keys are {}", names.join(", "))));
            }
        }
    }
    for (key, value) in problem.beside() {
        let belongs = match Foreign::find_foreign(key, kind) {
            _ if names.contains(&key.as_str()) => true,
            // A reference case has a tolerance of its own.
            Some(foreign) => foreign.names[0] != "tol" && foreign.changes(value),
            None => false,
        };
        if belongs {
            return Err(problem
                .failure_at_key(key, format!("`{key}` stands beside `data`, where it is not read"))
                .with_hint(format!("move `{key}` into `data`")));
        }
    }
    Ok(())
}

/// Whether a key only describes.
fn is_note(key: &str) -> bool {
    NOTES.contains(&key)
}
