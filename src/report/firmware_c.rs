//! C99 header and source of a controller, no dependencies: float32 and Q31, one table of sums of products each.
//! The arithmetic is that of [`crate::controller::arithmetic`]; test vectors computed there must come out bit for bit.

use crate::controller::arithmetic::{FixedRow, Float32Program, Q31Program};
use crate::controller::realise::Row;
use crate::controller::scaling::ScaledRealisation;
use crate::controller::verification::Verification;
use std::fmt::Write;

/// What the C files say besides the coefficients.
#[derive(Clone, Debug)]
pub struct FirmwareLabels {
    /// Controller name.
    pub name: String,
    /// Spindle and tool, for the reader.
    pub machine: String,
    /// SHA-256 of the controller JSON, hex.
    pub input_sha256: String,
}

/// Memory of the tables and of one instance, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Constant tables.
    pub tables: usize,
    /// State of one instance.
    pub state: usize,
}

/// `controller.h`.
pub fn header(
    scaled: &ScaledRealisation,
    verification: &Verification,
    labels: &FirmwareLabels,
) -> String {
    let rows = &scaled.rows;
    let products = rows.multiplications();
    let (f32_memory, q31_memory) = (memory(scaled, 0), memory(scaled, 1));
    let verified = if verification.is_proven() { "1" } else { "0" };
    let mut text = String::new();
    let notes: String = rows
        .notes
        .iter()
        .map(|note| format!(" * Note: {}.\n", comment(note)))
        .collect();
    let _ = write!(
        text,
        "/* Magnetic-bearing controller: u = K y, written by muspin.
 *
 * Controller: {name}
 * Machine:    {machine}
 * SHA-256 of the controller JSON: {hash}
 * Stability:  {stability}
 *
 * Form: {form}; {n} states, {s} signals, {m} inputs, {p} outputs.
{notes} * Sample time {ts:e} s. Inputs: displacements front_x, front_y, rear_x, rear_y, m. Outputs: currents, A.
 * Per sample: {products} multiplications, {products} additions, plus clamps of {m} inputs, {p} outputs, {n} states.
 * Memory: float32 {ft} bytes of tables, {fs} bytes of state; Q31 {qt} and {qs}.
 *
 * Limits: inputs beyond +-{ylim:e} m and outputs beyond +-{ulim:e} A are clamped. States are scaled so that +-1
 * is their range for inputs within the limit and are clamped there; for slow real poles +-1 is the output limit, so
 * the clamp is the anti-windup. Within the limits no clamp acts and the controller is linear.
 *
 * float32: compile with -ffp-contract=off (no fused multiply-add); then the test vectors come out bit for bit.
 * Q31: y and u are fractions of MUSPIN_INPUT_LIMIT_M and MUSPIN_OUTPUT_LIMIT_A times 2^31; 64-bit sums, rounded to
 * nearest, saturated. MUSPIN_NO_F32 or MUSPIN_NO_Q31 leaves one of the two out.
 * Self test: cc -std=c99 -ffp-contract=off -DMUSPIN_SELF_TEST controller.c -o selftest && ./selftest test_vectors.csv
 */
#ifndef MUSPIN_CONTROLLER_H
#define MUSPIN_CONTROLLER_H

#include <stdint.h>

#define MUSPIN_INPUTS {m}
#define MUSPIN_OUTPUTS {p}
#define MUSPIN_STATES {n}
#define MUSPIN_SIGNALS {s}
#define MUSPIN_SAMPLE_TIME_S {ts:e}
#define MUSPIN_INPUT_LIMIT_M {ylim:e}
#define MUSPIN_OUTPUT_LIMIT_A {ulim:e}
/* 1: the closed loop is proven stable at every speed of the range; 0: it is not, see above. */
#define MUSPIN_VERIFIED {verified}
#define MUSPIN_INPUT_SHA256 \"{hash}\"

#ifndef MUSPIN_NO_F32
typedef struct {{ float state[{room}]; }} muspin_f32;
/* Sets the states to zero. */
void muspin_f32_init(muspin_f32 *c);
/* One sample: currents (A) from displacements (m). Inputs must be numbers. */
void muspin_f32_step(muspin_f32 *c, const float y_m[MUSPIN_INPUTS], float u_a[MUSPIN_OUTPUTS]);
#endif

#ifndef MUSPIN_NO_Q31
typedef struct {{ int32_t state[{room}]; }} muspin_q31;
/* Sets the states to zero. */
void muspin_q31_init(muspin_q31 *c);
/* One sample: currents from displacements, both as Q31 fractions of full scale. */
void muspin_q31_step(muspin_q31 *c, const int32_t y[MUSPIN_INPUTS], int32_t u[MUSPIN_OUTPUTS]);
#endif

#endif
",
        name = comment(&labels.name),
        machine = comment(&labels.machine),
        hash = labels.input_sha256,
        stability = comment(&stability_words(verification)),
        form = rows.form.name(),
        n = rows.order(),
        s = rows.signals.len(),
        m = rows.inputs,
        p = rows.outputs.len(),
        ts = rows.sample_time_s,
        ylim = scaled.limits.input_m,
        ulim = scaled.limits.output_a,
        room = rows.order().max(1),
        ft = f32_memory.tables,
        fs = f32_memory.state,
        qt = q31_memory.tables,
        qs = q31_memory.state,
    );
    text
}

/// How far a proof that does not reach the largest speed goes.
fn unproven_words(verification: &Verification) -> String {
    match (&verification.proof_failure, &verification.proof) {
        (Some(failure), _) => format!("it could not be proven: {failure}"),
        (None, Some(proof)) => format!("proven only to {:.0} rpm", proof.proven_to_rpm()),
        (None, None) => "not proven".to_owned(),
    }
}

/// One sentence on what is known about the closed loop.
pub fn stability_words(verification: &Verification) -> String {
    let range = || {
        let first = verification.speeds.first().map_or(0.0, |s| s.speed_rpm);
        let last = verification.speeds.last().map_or(0.0, |s| s.speed_rpm);
        format!(
            "{} speeds from {first} to {last} rpm ({})",
            verification.speeds.len(),
            verification.conditions
        )
    };
    let mu = verification
        .mu_peak
        .map_or(String::new(), |mu| format!("; peak of mu {mu:.4}"));
    let proven = verification.is_proven();
    let mut words = match (
        verification.unstable(),
        verification.worst_growth_rate_per_s(),
    ) {
        (None, Some(worst)) if proven => format!(
            "verified, closed loop proven stable at every speed from 0 to {} rpm and computed at {}; slowest decay {:.2} 1/s{mu}",
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
            "UNSTABLE: closed loop grows by {:.2} 1/s at {} rpm; checked at {}",
            bad.growth_rate_per_s,
            bad.speed_rpm,
            range()
        ),
        (None, None) => "NOT VERIFIED: the closed loop was not checked".to_owned(),
    };
    if verification.forced && !proven {
        words.push_str(". Forced by the user");
    }
    words
}

/// `controller.c`; `error_bound_a` is the bound on Q31 against exact arithmetic over the test vectors.
pub fn source(
    scaled: &ScaledRealisation,
    float: &Float32Program,
    fixed: &Q31Program,
    error_bound_a: f64,
) -> String {
    let rows = &scaled.rows;
    let (n, m, s, p) = (
        rows.order(),
        rows.inputs,
        rows.signals.len(),
        rows.outputs.len(),
    );
    let index = if n + m + s <= 256 {
        "uint8_t"
    } else {
        "uint16_t"
    };
    let mut text = String::from(
        "/* Written by muspin; see controller.h. Every value is a sum of products: coefficient k times value source[k] of\n \
         * v = [states; inputs; signals]. Rows in order: signals, outputs, next states; row r ends before row_end[r]. */\n\
         #include \"controller.h\"\n\n",
    );
    let labels: Vec<String> = (0..s)
        .map(|i| format!("signal {i}"))
        .chain((0..p).map(|i| format!("output {i}")))
        .chain((0..n).map(|i| format!("state {i}")))
        .collect();
    let all: Vec<&Row> = rows.rows().collect();
    let count = rows.multiplications().max(1);
    table(
        &mut text,
        &format!("static const {index} source[{count}]"),
        &labels,
        all.iter()
            .map(|row| row.iter().map(|t| t.source.to_string()).collect()),
    );
    let mut end = 0;
    table(
        &mut text,
        &format!("static const uint16_t row_end[{}]", all.len().max(1)),
        &["rows".to_owned()],
        std::iter::once(
            all.iter()
                .map(|row| {
                    end += row.len();
                    end.to_string()
                })
                .collect(),
        ),
    );
    text.push_str("\n#ifndef MUSPIN_NO_F32\n#include <float.h>\n");
    text.push_str(
        "#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && !defined(MUSPIN_ALLOW_EXCESS_PRECISION)\n\
         #error \"float expressions are evaluated with excess precision: test vectors will not match\"\n#endif\n\
         #if defined(__clang__)\n#pragma STDC FP_CONTRACT OFF\n#endif\n\n",
    );
    table(
        &mut text,
        &format!("static const float f32_coefficient[{count}]"),
        &labels,
        float.rows.rows().map(|row| {
            row.iter()
                .map(|t| hex_float(t.coefficient as f32))
                .collect()
        }),
    );
    let _ = writeln!(
        text,
        "\nstatic const float f32_input_limit = {};\nstatic const float f32_output_limit = {};",
        hex_float(float.input_limit_m),
        hex_float(float.output_limit_a)
    );
    text.push_str(F32_STEP);
    text.push_str("#endif\n\n#ifndef MUSPIN_NO_Q31\n");
    let _ = writeln!(
        text,
        "/* Over the test vectors Q31 stays within {error_bound_a:.3e} A of exact arithmetic (bound from rounding and \
         coefficients). */"
    );
    let fixed_rows = || {
        fixed
            .signals
            .iter()
            .chain(&fixed.outputs)
            .chain(&fixed.states)
    };
    table(
        &mut text,
        &format!("static const int32_t q31_coefficient[{count}]"),
        &labels,
        fixed_rows().map(|row: &FixedRow| row.terms.iter().map(|t| t.1.to_string()).collect()),
    );
    table(
        &mut text,
        &format!("static const uint8_t q31_shift[{}]", all.len().max(1)),
        &["rows".to_owned()],
        std::iter::once(fixed_rows().map(|row| row.shift.to_string()).collect()),
    );
    text.push_str(Q31_STEP);
    text.push_str("#endif\n\n");
    text.push_str(SELF_TEST);
    text
}

/// Bytes of tables and state; index size and coefficient size are those of the source.
fn memory(scaled: &ScaledRealisation, extra_per_row: usize) -> Memory {
    let rows = &scaled.rows;
    let values = rows.order() + rows.inputs + rows.signals.len();
    let index = if values <= 256 { 1 } else { 2 };
    Memory {
        tables: rows.multiplications() * (4 + index) + rows.rows().count() * (2 + extra_per_row),
        state: 4 * rows.order(),
    }
}

/// A table with one labelled line a row; an empty table holds one zero, since C has no empty arrays.
fn table(
    text: &mut String,
    declaration: &str,
    labels: &[String],
    rows: impl Iterator<Item = Vec<String>>,
) {
    let _ = writeln!(text, "{declaration} = {{");
    let mut empty = true;
    for (label, row) in labels.iter().zip(rows) {
        if row.is_empty() {
            continue;
        }
        empty = false;
        let _ = writeln!(text, "    /* {label} */ {},", row.join(", "));
    }
    text.push_str(if empty { "    0\n};\n" } else { "};\n" });
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

/// Text that cannot end a C comment, one line.
fn comment(text: &str) -> String {
    text.replace("*/", "* /")
        .replace("/*", "/ *")
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

const F32_STEP: &str = "
static float f32_clamp(float value, float limit)
{
    if (value > limit) {
        return limit;
    }
    return value < -limit ? -limit : value;
}

static float f32_sum(const float *v, unsigned *k, unsigned end)
{
    float sum = 0.0f;
    for (; *k < end; ++*k) {
        const float product = f32_coefficient[*k] * v[source[*k]];
        sum = sum + product;
    }
    return sum;
}

void muspin_f32_init(muspin_f32 *c)
{
    unsigned i;
    for (i = 0; i < sizeof c->state / sizeof c->state[0]; ++i) {
        c->state[i] = 0.0f;
    }
}

void muspin_f32_step(muspin_f32 *c, const float y_m[MUSPIN_INPUTS], float u_a[MUSPIN_OUTPUTS])
{
    float v[MUSPIN_STATES + MUSPIN_INPUTS + MUSPIN_SIGNALS];
    int i;
    unsigned k = 0, row = 0;
    for (i = 0; i < MUSPIN_STATES; ++i) {
        v[i] = c->state[i];
    }
    for (i = 0; i < MUSPIN_INPUTS; ++i) {
        v[MUSPIN_STATES + i] = f32_clamp(y_m[i], f32_input_limit);
    }
    for (i = 0; i < MUSPIN_SIGNALS; ++i) {
        v[MUSPIN_STATES + MUSPIN_INPUTS + i] = f32_sum(v, &k, row_end[row++]);
    }
    for (i = 0; i < MUSPIN_OUTPUTS; ++i) {
        u_a[i] = f32_clamp(f32_sum(v, &k, row_end[row++]), f32_output_limit);
    }
    for (i = 0; i < MUSPIN_STATES; ++i) {
        c->state[i] = f32_clamp(f32_sum(v, &k, row_end[row++]), 1.0f);
    }
}
";

const Q31_STEP: &str = "
/* Right shifts of negative numbers must be arithmetic, as on every usual target. */
typedef char muspin_arithmetic_shift[((-1) >> 1) == -1 ? 1 : -1];

static int32_t q31_saturate(int64_t value)
{
    if (value > INT32_MAX) {
        return INT32_MAX;
    }
    return value < -INT32_MAX ? -INT32_MAX : (int32_t)value;
}

static int32_t q31_sum(const int32_t *v, unsigned *k, unsigned end, unsigned shift)
{
    int64_t sum = 0;
    for (; *k < end; ++*k) {
        sum += (int64_t)q31_coefficient[*k] * v[source[*k]];
    }
    return q31_saturate((sum + ((int64_t)1 << (shift - 1))) >> shift);
}

void muspin_q31_init(muspin_q31 *c)
{
    unsigned i;
    for (i = 0; i < sizeof c->state / sizeof c->state[0]; ++i) {
        c->state[i] = 0;
    }
}

void muspin_q31_step(muspin_q31 *c, const int32_t y[MUSPIN_INPUTS], int32_t u[MUSPIN_OUTPUTS])
{
    int32_t v[MUSPIN_STATES + MUSPIN_INPUTS + MUSPIN_SIGNALS];
    int i;
    unsigned k = 0, row = 0;
    for (i = 0; i < MUSPIN_STATES; ++i) {
        v[i] = c->state[i];
    }
    for (i = 0; i < MUSPIN_INPUTS; ++i) {
        v[MUSPIN_STATES + i] = q31_saturate(y[i]);
    }
    for (i = 0; i < MUSPIN_SIGNALS; ++i, ++row) {
        v[MUSPIN_STATES + MUSPIN_INPUTS + i] = q31_sum(v, &k, row_end[row], q31_shift[row]);
    }
    for (i = 0; i < MUSPIN_OUTPUTS; ++i, ++row) {
        u[i] = q31_sum(v, &k, row_end[row], q31_shift[row]);
    }
    for (i = 0; i < MUSPIN_STATES; ++i, ++row) {
        c->state[i] = q31_sum(v, &k, row_end[row], q31_shift[row]);
    }
}
";

const SELF_TEST: &str = r#"#ifdef MUSPIN_SELF_TEST
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reads test_vectors.csv (columns: sample, y in m, u in A, y and u in Q31) and compares bit for bit. */
int main(int argc, char **argv)
{
    static char line[4096];
    FILE *file = fopen(argc > 1 ? argv[1] : "test_vectors.csv", "r");
    muspin_f32 f;
    muspin_q31 q;
    long samples = 0, wrong_f32 = 0, wrong_q31 = 0;
    if (!file || !fgets(line, sizeof line, file)) {
        fprintf(stderr, "cannot read the test vectors\n");
        return 2;
    }
    muspin_f32_init(&f);
    muspin_q31_init(&q);
    while (fgets(line, sizeof line, file)) {
        float y[MUSPIN_INPUTS], u[MUSPIN_OUTPUTS], expected;
        int32_t yq[MUSPIN_INPUTS], uq[MUSPIN_OUTPUTS];
        char *at = strchr(line, ',');
        int i;
        float uf[MUSPIN_OUTPUTS];
        for (i = 0; i < MUSPIN_INPUTS && at; ++i) {
            y[i] = strtof(at + 1, &at);
        }
        for (i = 0; i < MUSPIN_OUTPUTS && at; ++i) {
            uf[i] = strtof(at + 1, &at);
        }
        for (i = 0; i < MUSPIN_INPUTS && at; ++i) {
            yq[i] = (int32_t)strtol(at + 1, &at, 10);
        }
        if (!at) {
            fprintf(stderr, "sample %ld: a column is missing\n", samples);
            return 2;
        }
        muspin_f32_step(&f, y, u);
        muspin_q31_step(&q, yq, uq);
        for (i = 0; i < MUSPIN_OUTPUTS; ++i) {
            expected = uf[i];
            wrong_f32 += memcmp(&u[i], &expected, sizeof expected) != 0;
            wrong_q31 += uq[i] != (int32_t)strtol(at + 1, &at, 10);
        }
        ++samples;
    }
    fclose(file);
    printf("%ld samples, float32 mismatches %ld, Q31 mismatches %ld\n", samples, wrong_f32, wrong_q31);
    return samples == 0 || wrong_f32 || wrong_q31;
}
#endif
"#;
