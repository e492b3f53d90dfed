//! The sums of products of a controller as straight-line C, coefficients as literals. Products stand in the order of
//! the rows, so C rounds as [`crate::controller::arithmetic`] does. Outputs that read the same values are summed side
//! by side, so that each value is loaded once; rows of states that read each other form one block of locals.

use crate::controller::arithmetic::{FixedRow, Float32Program, Q31Program};
use crate::controller::realise::Row;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::ops::Range;

const PRODUCTS_PER_LINE: usize = 4;

/// One row for C: indices into v = [x; y; t] and coefficients as C literals, what surrounds the sum, what follows it.
struct CodeRow {
    /// (source, literal); an empty literal is the factor one.
    products: Vec<(usize, String)>,
    /// Text before the sum, for instance a call.
    open: String,
    /// Text after the sum.
    close: String,
}

pub(crate) struct Statements {
    /// Signals and outputs: reads `x`, `y`, writes `t`, `u`.
    pub output: String,
    /// Next states: reads `y`, `t`, reads and writes `x`.
    pub update: String,
    /// Anti-windup: corrects `x` by the excess `e`; empty without conditioned states.
    pub conditioning: String,
    /// Clamps of states after every sample.
    pub clamps: String,
}

/// How one arithmetic is written.
struct Dialect {
    value: &'static str,
    sum: &'static str,
    /// Cast in front of a value.
    cast: &'static str,
    states: usize,
    inputs: usize,
}

/// Single precision; `prefix` is that of the controller's functions.
pub(crate) fn float32_statements(program: &Float32Program, prefix: &str) -> Statements {
    let plain = |row: &Row| CodeRow {
        products: row.iter().map(|t| (t.source, float_literal(t.coefficient as f32))).collect(),
        open: String::new(),
        close: String::new(),
    };
    let rows = &program.rows;
    let dialect = Dialect { value: "float", sum: "float", cast: "", states: rows.order(), inputs: rows.inputs };
    let signals: Vec<CodeRow> = rows.signals.iter().map(plain).collect();
    let outputs: Vec<CodeRow> = rows.outputs.iter().map(plain).collect();
    let states: Vec<CodeRow> = rows.states.iter().map(plain).collect();
    let mut statements = dialect.statements(&signals, &outputs, &states);
    for (i, row) in program.conditioning.iter().enumerate() {
        for term in row {
            let literal = float_literal(term.coefficient as f32);
            let product = times(&literal, &format!("e[{}]", term.source));
            let _ = writeln!(statements.conditioning, "        x[{i}] += {product};");
        }
        if !row.is_empty() {
            let clamp = format!(
                "        x[{i}] = {prefix}_f32_clamp(x[{i}], 1.0f);
"
            );
            statements.conditioning.push_str(&clamp);
        }
    }
    for i in (0..rows.order()).filter(|i| program.clamped[*i]) {
        let clamp = format!(
            "    x[{i}] = {prefix}_f32_clamp(x[{i}], 1.0f);
"
        );
        statements.clamps.push_str(&clamp);
    }
    statements
}

/// Q31: 64-bit sums, rounded, shifted, saturated.
pub(crate) fn q31_statements(program: &Q31Program, prefix: &str) -> Statements {
    let code = |row: &FixedRow| CodeRow {
        products: row.terms.iter().map(|(source, coefficient)| (*source, coefficient.to_string())).collect(),
        open: format!("{prefix}_q31_round("),
        close: format!(", {})", row.shift),
    };
    let dialect = Dialect {
        value: "int32_t",
        sum: "int64_t",
        cast: "(int64_t)",
        states: program.states.len(),
        inputs: program.inputs,
    };
    let signals: Vec<CodeRow> = program.signals.iter().map(code).collect();
    let conditioned = program.conditioning.iter().any(|row| !row.terms.is_empty());
    let current = |(i, row): (usize, &FixedRow)| {
        let mut row = code(row);
        if conditioned {
            row.open = format!("{prefix}_q31_current(c, {i}, ");
        }
        row
    };
    let outputs: Vec<CodeRow> = program.outputs.iter().enumerate().map(current).collect();
    let states: Vec<CodeRow> = program.states.iter().map(code).collect();
    let mut statements = dialect.statements(&signals, &outputs, &states);
    for (i, row) in program.conditioning.iter().enumerate() {
        if !row.terms.is_empty() {
            let sum = dialect.sum(&code(row), &|source| format!("e[{source}]"));
            let sum = sum.replacen("_q31_round(", "_q31_correct(x[{i}], ", 1).replace("{i}", &i.to_string());
            let _ = writeln!(statements.conditioning, "        x[{i}] = {sum};");
        }
    }
    statements
}

impl Dialect {
    fn statements(&self, signals: &[CodeRow], outputs: &[CodeRow], states: &[CodeRow]) -> Statements {
        let mut output = self.loads(signals.iter().chain(outputs), false);
        for (k, row) in signals.iter().enumerate() {
            let sum = self.sum(row, &|source| self.store_state(source));
            let _ = writeln!(output, "    const {} t{k} = {sum};\n    t[{k}] = t{k};", self.value);
        }
        for cluster in clusters(outputs) {
            self.side_by_side(&mut output, outputs, &cluster);
        }
        let mut update = self.loads(states.iter(), true);
        for group in groups(states) {
            update.push_str("    {\n");
            let read: BTreeSet<usize> = states[group.clone()]
                .iter()
                .flat_map(|row| row.products.iter().map(|p| p.0))
                .filter(|k| *k < self.states)
                .collect();
            for k in read {
                let _ = writeln!(update, "        const {} x{k} = x[{k}];", self.value);
            }
            for i in group {
                let sum = self.sum(&states[i], &|source| self.local(source));
                let _ = writeln!(update, "        x[{i}] = {sum};");
            }
            update.push_str("    }\n");
        }
        Statements { output, update, conditioning: String::new(), clamps: String::new() }
    }

    /// Locals of the inputs that any of the rows reads, and of the stored signals when `signals`.
    fn loads<'a>(&self, rows: impl Iterator<Item = &'a CodeRow>, signals: bool) -> String {
        let end = self.states + self.inputs;
        let used: BTreeSet<usize> = rows
            .flat_map(|row| row.products.iter().map(|p| p.0))
            .filter(|k| *k >= self.states && (signals || *k < end))
            .collect();
        used.into_iter().fold(String::new(), |mut text, source| {
            let (array, index) = if source < end { ("y", source - self.states) } else { ("t", source - end) };
            let name = self.local(source);
            let _ = writeln!(text, "    const {} {name} = {array}[{index}];", self.value);
            text
        })
    }

    /// Outputs that read the same values in the same order, one value after the other.
    fn side_by_side(&self, text: &mut String, outputs: &[CodeRow], cluster: &[usize]) {
        let Some(first) = cluster.first().map(|i| &outputs[*i]) else {
            return;
        };
        let list = |join: &str, term: &dyn Fn(usize) -> String| -> String {
            let terms: Vec<String> = cluster.iter().map(|i| term(*i)).collect();
            terms.join(join)
        };
        text.push_str("    {\n");
        if first.products.is_empty() {
            let _ = writeln!(text, "        const {} {};", self.sum, list(", ", &|i| format!("u{i} = 0")));
        } else {
            let _ = writeln!(text, "        {} v = {};", self.value, self.store_state(first.products[0].0));
        }
        for (k, product) in first.products.iter().enumerate() {
            let value = format!("{}v", self.cast);
            let factor = |i: usize| times(&outputs[i].products[k].1, &value);
            if k == 0 {
                let sums = list(", ", &|i| format!("u{i} = {}", factor(i)));
                let _ = writeln!(text, "        {} {sums};", self.sum);
            } else {
                let sums = list("; ", &|i| format!("u{i} += {}", factor(i)));
                let _ = writeln!(text, "        v = {}; {sums};", self.store_state(product.0));
            }
        }
        for i in cluster {
            let row = &outputs[*i];
            let _ = writeln!(text, "        u[{i}] = {}u{i}{};", row.open, row.close);
        }
        text.push_str("    }\n");
    }

    /// The sum of a row, with its rounding; `name` says where a value stands.
    fn sum(&self, row: &CodeRow, name: &dyn Fn(usize) -> String) -> String {
        let mut text = row.open.clone();
        for (k, (source, literal)) in row.products.iter().enumerate() {
            let product = times(literal, &format!("{}{}", self.cast, name(*source)));
            match product.strip_prefix('-') {
                Some(positive) if k > 0 => {
                    let _ = write!(text, " - {positive}");
                }
                _ if k > 0 => {
                    let _ = write!(text, " + {product}");
                }
                _ => text.push_str(&product),
            }
            if k % PRODUCTS_PER_LINE == PRODUCTS_PER_LINE - 1 && k + 1 < row.products.len() {
                text.push_str("\n           ");
            }
        }
        if row.products.is_empty() {
            text.push('0');
        }
        text.push_str(&row.close);
        text
    }

    /// The local variable of a value.
    fn local(&self, source: usize) -> String {
        let inputs = self.states + self.inputs;
        if source < self.states {
            format!("x{source}")
        } else if source < inputs {
            format!("y{}", source - self.states)
        } else {
            format!("t{}", source - inputs)
        }
    }

    /// As [`Self::local`], but states where the instance keeps them.
    fn store_state(&self, source: usize) -> String {
        if source < self.states { format!("x[{source}]") } else { self.local(source) }
    }
}

/// Literal times value; a factor of one is left out, which rounds the same.
fn times(literal: &str, value: &str) -> String {
    if literal.is_empty() { value.to_owned() } else { format!("{literal} * {value}") }
}

/// Indices of rows that read the same values in the same order, by first appearance.
fn clusters(rows: &[CodeRow]) -> Vec<Vec<usize>> {
    let sources = |i: usize| rows[i].products.iter().map(|p| p.0);
    let mut found: Vec<Vec<usize>> = Vec::new();
    for i in 0..rows.len() {
        match found.iter_mut().find(|c| sources(c[0]).eq(sources(i))) {
            Some(cluster) => cluster.push(i),
            None => found.push(vec![i]),
        }
    }
    found
}

/// Smallest runs of consecutive state rows such that no row reads a state that an earlier run has overwritten.
fn groups(states: &[CodeRow]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (i, row) in states.iter().enumerate() {
        let lowest = row.products.iter().map(|p| p.0).min().unwrap_or(i).min(i);
        let mut start = i;
        while let Some(last) = runs.pop_if(|last| last.end > lowest) {
            start = last.start;
        }
        runs.push(start..i + 1);
    }
    runs
}

/// A float as C literal; empty for one.
fn float_literal(value: f32) -> String {
    if value == 1.0 { String::new() } else { hex_float(value) }
}

/// A float as C99 hexadecimal constant: exact.
pub fn hex_float(value: f32) -> String {
    let bits = value.to_bits();
    let sign = if bits >> 31 == 1 { "-" } else { "" };
    let (exponent, mantissa) = (((bits >> 23) & 0xff) as i32, (bits & 0x7f_ffff) << 1);
    match (exponent, mantissa) {
        (0, 0) => format!("{sign}0.0f"),
        (0, _) => format!("{sign}0x0.{mantissa:06x}p-126f"),
        _ => format!("{sign}0x1.{mantissa:06x}p{}f", exponent - 127),
    }
}

/// A double as C99 hexadecimal constant: exact.
pub(super) fn hex_double(value: f64) -> String {
    let bits = value.to_bits();
    let sign = if bits >> 63 == 1 { "-" } else { "" };
    let (exponent, mantissa) = (((bits >> 52) & 0x7ff) as i32, bits & 0xf_ffff_ffff_ffff);
    match (exponent, mantissa) {
        (0, 0) => format!("{sign}0.0"),
        (0, _) => format!("{sign}0x0.{mantissa:013x}p-1022"),
        _ => format!("{sign}0x1.{mantissa:013x}p{}", exponent - 1023),
    }
}
