//! JSON Schemas of the problems of `muspin solve`, from a table of the fields that each kind takes.
//! The reader is `Problem`; a test holds both to the same files.

use serde_json::{Map, Value, json};

/// A kind of problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemKind {
    /// Riccati equation.
    Care,
    /// H∞ norm.
    Hinfnorm,
    /// H∞ synthesis.
    Hinfsyn,
    /// Structured singular value of a matrix.
    Mu,
    /// Peak of μ of a system.
    Musys,
    /// Fit of magnitudes.
    Dfit,
    /// D-K iteration.
    Dksyn,
    /// Model reduction.
    Reduce,
    /// Sampling.
    Discretise,
}

/// Field, shape, meaning. A shape that ends in `?` may be left out.
type Field = (&'static str, &'static str, &'static str);

/// Keys that describe a problem and carry no number of it; those of MATLAB's `ss` among them.
pub(super) const NOTES: [&str; 26] = [
    "id",
    "title",
    "name",
    "class",
    "source",
    "reference",
    "description",
    "comment",
    "note",
    "notes",
    "inputs",
    "outputs",
    "Name",
    "Notes",
    "UserData",
    "Scaled",
    "StateName",
    "StatePath",
    "StateUnit",
    "InputName",
    "InputUnit",
    "InputGroup",
    "OutputName",
    "OutputUnit",
    "OutputGroup",
    "SamplingGrid",
];

const SYSTEM: [Field; 7] = [
    ("A", "matrix", "n x n; 0 x 0 for a static gain"),
    ("B", "matrix", "n x m"),
    ("C", "matrix", "p x n"),
    ("D", "matrix", "p x m"),
    ("n", "count?", "number of states, checked against A"),
    ("m", "count?", "number of inputs, checked against D"),
    ("p", "count?", "number of outputs, checked against D"),
];

const SAMPLED: [Field; 2] = [
    ("Ts", "number?", "sample time, s; left out or 0: continuous time"),
    ("sample_time_s", "number?", "the same, as controller files name it"),
];

const PLANT: [Field; 9] = [
    ("A", "matrix", "n x n"),
    ("B", "matrix", "n x (m1 + m2), disturbances first, controls last"),
    ("C", "matrix", "(p1 + p2) x n, errors first, measurements last"),
    ("D", "matrix", "(p1 + p2) x (m1 + m2)"),
    ("m1", "count", "number of disturbances"),
    ("m2", "count", "number of controls, at least 1"),
    ("p1", "count", "number of errors"),
    ("p2", "count", "number of measurements, at least 1"),
    ("n", "count?", "number of states, checked against A"),
];

const BLOCKS: Field =
    ("blocks", "blocks", "structure of Δ in the order of the channels: Σ rows inputs, Σ cols outputs");

const PLANT_BLOCKS: Field =
    ("blocks", "blocks?", "structure of Δ, performance block last: Σ rows = m1, Σ cols = p1; left out: one full block");

impl ProblemKind {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Care,
        Self::Hinfnorm,
        Self::Hinfsyn,
        Self::Mu,
        Self::Musys,
        Self::Dfit,
        Self::Dksyn,
        Self::Reduce,
        Self::Discretise,
    ];

    /// Its name after `muspin solve`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Care => "care",
            Self::Hinfnorm => "hinfnorm",
            Self::Hinfsyn => "hinfsyn",
            Self::Mu => "mu",
            Self::Musys => "musys",
            Self::Dfit => "dfit",
            Self::Dksyn => "dksyn",
            Self::Reduce => "reduce",
            Self::Discretise => "discretise",
        }
    }

    /// What it is, in words.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Care => "Riccati equation A'X + XA − XGX + Q = 0",
            Self::Hinfnorm => "H∞ norm of a stable system",
            Self::Hinfsyn => "H∞ synthesis for a generalized plant, u = K y",
            Self::Mu => "Structured singular value of a complex matrix",
            Self::Musys => "Peak of μ of a stable system over all frequencies",
            Self::Dfit => "Stable minimum-phase systems that follow magnitudes",
            Self::Dksyn => "D-K iteration for a generalized plant, u = K y",
            Self::Reduce => "Reduction by balancing",
            Self::Discretise => "Sampling by hold and by Tustin's rule",
        }
    }

    pub(super) fn field_names(self) -> Vec<&'static str> {
        self.fields().into_iter().map(|(name, _, _)| name).collect()
    }

    /// The fields: those of the kind, then those of its system.
    fn fields(self) -> Vec<Field> {
        let (own, shared): (&[Field], &[Field]) = match self {
            Self::Care => (
                &[
                    ("A", "matrix", "n x n"),
                    ("G", "matrix", "n x n, symmetric: B R⁻¹ B'"),
                    ("Q", "matrix", "n x n, symmetric"),
                    ("n", "count?", "size of A, checked"),
                ],
                &[],
            ),
            Self::Hinfnorm => (&SAMPLED, &SYSTEM),
            Self::Hinfsyn => (
                &[
                    ("gamma", "number?", "level of the central controller; left out: the optimum is searched for"),
                    PLANT_BLOCKS,
                ],
                &PLANT,
            ),
            Self::Mu => (&[("M", "complex", "Σ cols x Σ rows of the blocks"), BLOCKS], &[]),
            Self::Musys => (
                &[
                    BLOCKS,
                    ("w_range", "numbers?", "a range of interest, rad/s; the peak is over all frequencies anyhow"),
                ],
                &SYSTEM,
            ),
            Self::Dfit => (
                &[
                    ("omega", "numbers", "frequencies, rad/s, rising"),
                    ("magnitude", "numbers", "magnitudes there, positive"),
                    ("weight", "numbers?", "weights of the errors in the answer; left out: 1"),
                    ("orders", "counts", "orders to fit, at most 20"),
                ],
                &[],
            ),
            Self::Dksyn => (
                &[
                    (
                        "omega",
                        "numbers?",
                        "its smallest and largest entry bound the frequencies, rad/s, that D follows",
                    ),
                    ("max_d_order", "count?", "largest order of a D-scale"),
                    PLANT_BLOCKS,
                ],
                &PLANT,
            ),
            Self::Reduce => (
                &[
                    ("orders", "counts?", "orders to reduce to; without them the answer has the Hankel values alone"),
                    ("max_error", "number?", "L∞ norm of the error: the smallest order within it is given, too"),
                    ("match_dc", "flag?", "true: singular perturbation alone, which keeps the DC gain"),
                ],
                &SYSTEM,
            ),
            Self::Discretise => (
                &[
                    ("Ts", "number", "sample time, s, positive"),
                    ("w_prewarp", "number?", "frequency, rad/s, below π/Ts, at which Tustin's rule is exact"),
                    ("input_delay_s", "number?", "delay of all inputs, s; any for zoh, whole samples for other rules"),
                ],
                &SYSTEM,
            ),
        };
        own.iter().chain(shared).copied().collect()
    }
}

/// The JSON Schema (draft 2020-12) of a problem file: the fields in `data`, or at the top level.
pub fn problem_schema(kind: ProblemKind) -> Value {
    let (mut properties, mut required) = (Map::new(), vec![]);
    for (name, shape, meaning) in kind.fields() {
        properties.insert(name.to_owned(), describe_shape(shape, meaning));
        if !shape.ends_with('?') {
            required.push(name);
        }
    }
    for name in NOTES {
        properties.insert(name.to_owned(), json!({ "description": "A description; not read" }));
    }
    let fields = json!({
        "type": "object", "required": required, "properties": properties, "additionalProperties": false,
    });
    let mut inside = fields.clone();
    inside["description"] = json!("The problem; what stands beside it (title, source, expected answer) is not read");
    let mut top = fields;
    // Without `data`: a file that has it is read from there alone.
    top["properties"]["data"] = json!({ "enum": [] });
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("muspin solve {}", kind.name()),
        "description": kind.title(),
        "anyOf": [
            { "type": "object", "required": ["data"], "properties": { "data": inside } },
            top,
        ],
    })
}

/// The schema of a field; one that may be left out may be `null` as well.
fn describe_shape(shape: &str, meaning: &str) -> Value {
    let number = json!({ "type": "number" });
    let numbers = json!({ "type": "array", "items": number });
    let rows = json!({ "type": "array", "items": numbers });
    // A number is 1 x 1, a list of numbers a row or a column.
    let matrix = json!({ "anyOf": [rows, numbers, number] });
    let mut schema = match shape.trim_end_matches('?') {
        "matrix" => matrix,
        "complex" => {
            let parts = json!({
                "type": "object", "required": ["re", "im"], "properties": { "re": matrix, "im": matrix },
            });
            json!({ "anyOf": [matrix, parts] })
        }
        "number" => number,
        "flag" => json!({ "type": "boolean" }),
        "count" => count(),
        "numbers" => one_or_more(&number),
        "counts" => one_or_more(&count()),
        _ => one_or_more(&json!({ "oneOf": blocks() })),
    };
    match (shape.ends_with('?'), schema.get_mut("anyOf").and_then(Value::as_array_mut)) {
        (true, Some(kinds)) => kinds.push(json!({ "type": "null" })),
        (true, None) => schema["type"] = json!([schema["type"], "null"]),
        (false, _) => {}
    }
    schema["description"] = json!(meaning);
    schema
}

fn count() -> Value {
    json!({ "type": "integer", "minimum": 0 })
}

/// A list, or its only entry.
fn one_or_more(item: &Value) -> Value {
    json!({ "anyOf": [{ "type": "array", "items": item }, item] })
}

fn blocks() -> Value {
    let size = json!({ "type": "integer", "minimum": 1 });
    let block = |name: &str, sizes: &[&str]| {
        let mut properties = Map::new();
        properties.insert("type".to_owned(), json!({ "const": name }));
        for key in sizes {
            properties.insert((*key).to_owned(), size.clone());
        }
        let required: Vec<&str> = std::iter::once("type").chain(sizes.iter().copied()).collect();
        json!({ "type": "object", "required": required, "properties": properties })
    };
    json!([block("complex_full", &["rows", "cols"]), block("complex_scalar", &["n"]), block("real_scalar", &["n"]),])
}
