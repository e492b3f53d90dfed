//! JSON Schemas of the problems of `muspin solve`, from a table of the fields that each kind takes.
//! The reader is `Problem`; a test holds both to the same files.

use serde_json::{Map, Value, json};

/// The kinds: variant, name after `muspin solve`, title.
macro_rules! kinds {
    ($($kind:ident $name:literal $title:literal,)*) => {
        named! {
            /// A kind of problem, by its name after `muspin solve`.
            pub enum ProblemKind { $(#[doc = $title] $kind = $name,)* }
        }

        impl ProblemKind {
            pub(crate) fn title(self) -> &'static str {
                match self { $(Self::$kind => $title,)* }
            }
        }
    };
}

kinds! {
    Care "care" "Riccati equation A'X + XA − XGX + Q = 0, or of A, B, Q, R, S",
    Dare "dare" "Riccati equation A'XA − X − (A'XB + S)(R + B'XB)⁻¹(B'XA + S') + Q = 0",
    H2norm "h2norm" "H2 norm of a stable system",
    Hinfnorm "hinfnorm" "H∞ norm of a stable system",
    Hinfsyn "hinfsyn" "H∞ synthesis for a generalized plant, u = K y",
    Augw "augw" "Generalized plant of mixed sensitivity, e = w − G u",
    Mixsyn "mixsyn" "H∞ synthesis for mixed sensitivity, u = K e",
    H2syn "h2syn" "H2 synthesis for a generalized plant, u = K y",
    Lqg "lqg" "Linear-quadratic-Gaussian control, u = K y",
    Ncfsyn "ncfsyn" "Loop shaping by normalised coprime factors, u = K y",
    Diskmargin "diskmargin" "Disc margins of a loop, per channel and of all channels at once",
    Mu "mu" "Structured singular value of a complex matrix",
    Musys "musys" "Peak of μ of a stable system over all frequencies",
    Dfit "dfit" "Stable minimum-phase systems that follow magnitudes",
    Dksyn "dksyn" "D-K iteration for a generalized plant, u = K y",
    Reduce "reduce" "Reduction by balancing",
    Discretise "discretise" "Sampling by holds, by Tustin's rule, by impulse and by matched roots",
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

const DESCRIPTOR: Field = ("E", "matrix?", "n x n, E x' = A x + B u, with an inverse; left out: the identity");

const SYSTEM: [Field; 8] = [
    DESCRIPTOR,
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

/// A plant and what it is weighted with: gains, A with B, C, D, num with den, z with p and k.
const WEIGHTED: [Field; 3] = [
    ("G", "system", "the plant: a gain, or A, B, C, D, or num and den from the highest power, or z, p and k"),
    ("W1", "system?", "weight of e; of one channel: the same in every channel"),
    ("W2", "system?", "weight of u"),
];

/// The cost x'Qx + 2x'Su + u'Ru.
const COST: [Field; 4] = [
    ("Q", "matrix", "n x n, symmetric"),
    ("R", "matrix?", "m x m, symmetric; left out: the identity"),
    ("S", "matrix?", "n x m, cross term; left out: zero"),
    ("N", "matrix?", "the same by its other name"),
];

const LEVEL: Field =
    ("gamma", "number?", "level of the controller; left out: just above the optimum, which is searched for");

const PLANT: [Field; 10] = [
    DESCRIPTOR,
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

/// The noises of an LQG problem.
const COVARIANCES: [Field; 3] = [
    ("W", "matrix", "n x n, covariance (intensity) of the noise on the states"),
    ("V", "matrix", "p x p, covariance (intensity) of the noise on the measurements"),
    ("WV", "matrix?", "n x p, cross covariance; left out: zero"),
];

/// A plant with the weights that shape its loop.
const SHAPED: [Field; 4] = [
    ("G", "system", "the plant: a gain, or A, B, C, D, or num and den, or z, p and k"),
    ("W1", "system?", "weight before the plant"),
    ("W2", "system?", "weight behind the plant"),
    ("gamma", "number?", "level of the controller; left out: 0.1 % above the optimum"),
];

/// How a loop is closed and judged.
const LOOP: [Field; 2] = [
    ("sign", "number?", "-1: A, B, C, D in negative feedback, 1: in positive; left out: -1"),
    ("skew", "numbers?", "skews; left out: 1 (S), -1 (T) and 0 (S − T)"),
];

/// Magnitudes and what is fitted to them.
const MAGNITUDES: [Field; 4] = [
    ("omega", "numbers", "frequencies, rad/s, rising"),
    ("magnitude", "numbers", "magnitudes there, positive"),
    ("weight", "numbers?", "weights of the errors in the answer; left out: 1"),
    ("orders", "counts", "orders to fit, at most 20"),
];

impl ProblemKind {
    pub(super) fn field_names(self) -> Vec<&'static str> {
        self.fields().into_iter().map(|(name, _, _)| name).collect()
    }

    /// The forms that a problem may have, each with its fields.
    fn forms(self) -> Vec<Vec<Field>> {
        let fields = self.fields();
        if self != Self::Care {
            return vec![fields];
        }
        let form = |own: &str, others: &[&str]| {
            let needed = |(name, shape, words): Field| (name, if name == own { "matrix" } else { shape }, words);
            fields.iter().filter(|(name, _, _)| !others.contains(name)).map(|field| needed(*field)).collect()
        };
        vec![form("G", &["B", "R", "S", "N", "E"]), form("B", &["G"])]
    }

    /// The fields: those of the kind, then those of its system.
    fn fields(self) -> Vec<Field> {
        let parts: &[&[Field]] = match self {
            Self::Care => &[
                &[
                    ("A", "matrix", "n x n"),
                    ("G", "matrix?", "n x n, symmetric: B R⁻¹ B'; or B with R"),
                    ("B", "matrix?", "n x m, in place of G"),
                    DESCRIPTOR,
                    ("n", "count?", "size of A, checked"),
                ],
                &COST,
            ],
            Self::Dare => &[
                &[
                    ("A", "matrix", "n x n"),
                    ("B", "matrix", "n x m"),
                    DESCRIPTOR,
                    ("n", "count?", "size of A, checked"),
                ],
                &COST,
            ],
            Self::H2norm | Self::Hinfnorm => &[&SAMPLED, &SYSTEM],
            Self::Hinfsyn => &[&[LEVEL, PLANT_BLOCKS], &PLANT, &SAMPLED],
            Self::Augw => &[&WEIGHTED, &[("W3", "system?", "weight of G u")], &SAMPLED],
            Self::Mixsyn => &[&WEIGHTED, &[("W3", "system?", "weight of G u"), LEVEL], &SAMPLED],
            Self::H2syn => &[&PLANT, &SAMPLED],
            Self::Lqg => &[&COVARIANCES, &COST, &SYSTEM, &SAMPLED],
            Self::Ncfsyn => &[&SHAPED, &SAMPLED],
            Self::Diskmargin => &[&LOOP, &SYSTEM, &SAMPLED],
            Self::Mu => &[&[("M", "complex", "Σ cols x Σ rows of the blocks"), BLOCKS]],
            Self::Musys => &[
                &[
                    BLOCKS,
                    ("w_range", "numbers?", "a range of interest, rad/s; the peak is over all frequencies anyhow"),
                ],
                &SYSTEM,
                &SAMPLED,
            ],
            Self::Dfit => &[&MAGNITUDES, &SAMPLED],
            Self::Dksyn => &[
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
                &SAMPLED,
            ],
            Self::Reduce => &[
                &[
                    ("orders", "counts?", "orders to reduce to; without them the answer has the Hankel values alone"),
                    ("max_error", "number?", "L∞ norm of the error: the smallest order within it is given, too"),
                    ("match_dc", "flag?", "true: singular perturbation alone, which keeps the DC gain"),
                    ("Wi", "system?", "weight at the input: the error is that of Wo (G − Gr) Wi"),
                    ("Wo", "system?", "weight at the output"),
                    (
                        "coprime",
                        "flag?",
                        "true: normalised coprime factors, which reduce poles that are not stable too",
                    ),
                ],
                &SYSTEM,
                &SAMPLED,
            ],
            Self::Discretise => &[
                &[
                    ("Ts", "number", "sample time, s, positive"),
                    ("w_prewarp", "number?", "frequency, rad/s, below π/Ts, at which Tustin's rule is exact"),
                    ("input_delay_s", "number?", "delay of all inputs, s; any for zoh, whole samples for other rules"),
                ],
                &SYSTEM,
            ],
        };
        parts.concat()
    }
}

/// The JSON Schema (draft 2020-12) of a problem file: the fields in `data`, or at the top level, in each form.
pub fn problem_schema(kind: ProblemKind) -> Value {
    let places = kind.forms().into_iter().flat_map(|form| {
        let mut inside = object(&form);
        for name in NOTES {
            inside["properties"][name] = json!({ "description": "A description; not read" });
        }
        let mut top = inside.clone();
        // Without `data`: a file that has it is read from there alone.
        top["properties"]["data"] = json!({ "enum": [] });
        inside["description"] =
            json!("The problem; what stands beside it (title, source, expected answer) is not read");
        [json!({ "type": "object", "required": ["data"], "properties": { "data": inside } }), top]
    });
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("muspin solve {}", kind.name()),
        "description": kind.title(),
        "anyOf": places.collect::<Vec<Value>>(),
    })
}

/// The schema of an object that has these fields and no others.
fn object(fields: &[Field]) -> Value {
    let required = fields.iter().filter(|(_, shape, _)| !shape.ends_with('?')).map(|(name, _, _)| *name);
    let properties = fields.iter().map(|(name, shape, meaning)| ((*name).to_owned(), describe_shape(shape, meaning)));
    json!({
        "type": "object",
        "required": required.collect::<Vec<&str>>(),
        "properties": properties.collect::<Map<String, Value>>(),
        "additionalProperties": false,
    })
}

/// The schema of a system that is one field.
fn system_field(gain: &Value) -> Value {
    let transfer = [("num", "numbers", "from the highest power"), ("den", "numbers", "from the highest power")];
    let roots = [("z", "roots?", "zeros"), ("p", "roots?", "poles"), ("k", "number", "gain")];
    json!({ "anyOf": [gain, object(&SYSTEM), object(&transfer), object(&roots)] })
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
        "system" => system_field(&json!({ "anyOf": [rows, one_or_more(&number)] })),
        "roots" => json!({ "anyOf": [one_or_more(&number), object(&[("re", "numbers", ""), ("im", "numbers", "")])] }),
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
