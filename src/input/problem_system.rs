//! Systems in a problem file: state space, also with a descriptor E, generalized plants, and single systems as transfer
//! functions, as zeros, poles and gain, or as constant gains.

use super::error::{InputError, nearest};
use super::problem::ProblemFields;
use super::problem_matrix::ROW_OR_COLUMN;
use crate::augment::{Block, GeneralizedPlant};
use crate::linalg::{Mat, c64, solve, svd};
use crate::lti::matched::{chain, companion};
use crate::lti::{Continuous, StateSpace};
use serde_json::Value;

/// Smallest reciprocal condition of a descriptor with rows and columns of unit size: half the digits stay.
const LEAST_CONDITION: f64 = 1e-8;

/// Keys of a system that is a field: state space, transfer function, zeros with poles and gain.
const SYSTEM_KEYS: [&str; 12] = ["A", "B", "C", "D", "E", "n", "m", "num", "den", "z", "p", "k"];

impl ProblemFields {
    /// Numbers of outputs and inputs of a system of `order` states: those of D, of which a list of numbers is a row
    /// or a column as B and C say.
    fn channels(&self, order: usize) -> Result<[usize; 2], InputError> {
        let d = self.entries("D")?;
        let sizes = d.sizes();
        if let [one] = sizes[..] {
            return Ok(one);
        }
        let (b, c) = (self.entries("B")?, self.entries("C")?);
        let fits = |[p, m]: &&[usize; 2]| b.with_size(order, *m).is_some() && c.with_size(*p, order).is_some();
        let mut fitting = sizes.iter().filter(fits);
        match (fitting.next(), fitting.next()) {
            (Some(one), None) => Ok(*one),
            _ => Err(self
                .failure("D", format!("{} is a row or a column, and B and C do not tell which", d.words()))
                .with_hint(ROW_OR_COLUMN)),
        }
    }

    /// The system A, B, C, D, read as one in continuous time.
    ///
    /// # Errors
    /// Missing fields and shapes that do not fit.
    pub fn system(&self) -> Result<StateSpace<Continuous>, InputError> {
        let a = self.square("A")?;
        let n = a.nrows();
        let [p, m] = self.channels(n)?;
        let b = self.matrix_of("B", n, m)?;
        let c = self.matrix_of("C", p, n)?;
        let d = self.matrix_of("D", p, m)?;
        for (field, expected) in [("n", n), ("m", m), ("p", p)] {
            self.agrees(field, expected)?;
        }
        let (a, b) = self.without_descriptor(a, b)?;
        StateSpace::new(a, b, c, d, Continuous).map_err(|e| self.failure("A, B, C, D", e))
    }

    /// The generalized plant A, B = [B1 B2], C = [C1; C2], D with m1, m2, p1, p2, and its blocks if given.
    ///
    /// # Errors
    /// Missing fields, shapes and block sizes that do not fit.
    pub fn generalized_plant(&self) -> Result<GeneralizedPlant, InputError> {
        let (m1, m2) = (self.count("m1")?, self.count("m2")?);
        let (p1, p2) = (self.count("p1")?, self.count("p2")?);
        for (field, value) in [("m2", m2), ("p2", p2)] {
            if value == 0 {
                return Err(self.failure(field, "must be at least 1"));
            }
        }
        let lacks = [("m1", m1, "no disturbance inputs w"), ("p1", p1, "no error outputs z")];
        let lacks: Vec<_> = lacks.into_iter().filter(|(_, size, _)| *size == 0).collect();
        if let Some((field, _, _)) = lacks.first() {
            let words: Vec<&str> = lacks.iter().map(|(_, _, words)| *words).collect();
            return Err(self.failure(field, format!("the plant has {}", words.join(" and "))).with_hint(
                "the gain from w to z is what is made small: add the disturbances before the controls in B and D, the \
                 errors before the measurements in C and D, and count them in m1 and p1",
            ));
        }
        let a = self.square("A")?;
        let n = a.nrows();
        self.agrees("n", n)?;
        let b = self.matrix_of("B", n, m1 + m2)?;
        let c = self.matrix_of("C", p1 + p2, n)?;
        let d = self.matrix_of("D", p1 + p2, m1 + m2)?;
        let (a, b) = self.without_descriptor(a, b)?;
        let blocks = if self.has("blocks") {
            let blocks = self.blocks()?;
            let rows: usize = blocks.iter().map(Block::rows).sum();
            let cols: usize = blocks.iter().map(Block::cols).sum();
            if (rows, cols) != (m1, p1) {
                return Err(self.failure(
                    "blocks",
                    format!("rows and cols sum to {rows} and {cols}, expected m1 = {m1} and p1 = {p1}"),
                ));
            }
            blocks
        } else {
            vec![]
        };
        Ok(GeneralizedPlant {
            system: StateSpace::new(a, b, c, d, Continuous).map_err(|e| self.failure("A, B, C, D", e))?,
            controls: m2,
            measurements: p2,
            blocks,
        })
    }

    /// The inverse condition of the descriptor E of n states, and E; none where there is none.
    pub(crate) fn descriptor(&self, n: usize) -> Result<Option<(Mat<f64>, f64)>, InputError> {
        let is_empty = |value: &Value| value.as_array().is_some_and(Vec::is_empty);
        if !self.has("E") || self.value("E").is_ok_and(is_empty) {
            return Ok(None);
        }
        let e = self.matrix_of("E", n, n)?;
        // Units of equations and of states say nothing about the inverse.
        let row = |m: &Mat<f64>, i: usize| m.row(i).norm_l2();
        let even = |m: &Mat<f64>| {
            let sizes: Vec<f64> = (0..n).map(|i| row(m, i)).collect();
            Mat::from_fn(n, n, |i, j| if sizes[j] > 0.0 { m[(j, i)] / sizes[j] } else { 0.0 })
        };
        let values = svd(&even(&even(&e))).map_err(|error| self.failure("E", error))?.s;
        let condition = values.last().copied().unwrap_or(1.0) / values.first().copied().unwrap_or(1.0);
        if condition.is_nan() || condition < LEAST_CONDITION {
            return Err(self
                .failure("E", format!("is singular or nearly so (reciprocal condition {condition:.1e})"))
                .with_hint(
                    "a descriptor system E x' = A x + B u is taken where E has a well-conditioned inverse: remove its \
                     algebraic equations and its fast states by hand",
                ));
        }
        Ok(Some((e, condition)))
    }

    /// E⁻¹A and E⁻¹B.
    fn without_descriptor(&self, a: Mat<f64>, b: Mat<f64>) -> Result<(Mat<f64>, Mat<f64>), InputError> {
        let Some((e, _)) = self.descriptor(a.nrows())? else {
            return Ok((a, b));
        };
        let divide = |m: &Mat<f64>| solve(&e, m).map_err(|error| self.failure("E", error));
        Ok((divide(&a)?, divide(&b)?))
    }

    /// A system that is one field: a number or a matrix is a gain, an object holds A, B, C, D, or num and den, or z, p
    /// and k. The time base is that of the problem.
    pub(crate) fn system_in(&self, field: &str) -> Result<StateSpace<Continuous>, InputError> {
        let Value::Object(fields) = self.value(field)? else {
            let entries = self.entries(field)?;
            let [[rows, cols]] = entries.sizes()[..] else {
                return Err(self.failure(field, "a list is a row or a column").with_hint(ROW_OR_COLUMN));
            };
            let gain = entries.with_size(rows, cols).unwrap_or_else(|| Mat::zeros(rows, cols));
            return Ok(StateSpace::gain(gain, Continuous));
        };
        if let Some(key) = fields.keys().find(|key| !SYSTEM_KEYS.contains(&key.as_str())) {
            let best = nearest(key, SYSTEM_KEYS.into_iter()).unwrap_or_default();
            return Err(self
                .failure_at_key(key, format!("unknown key `{field}.{key}`"))
                .with_hint(format!("did you mean `{best}`? a system has A, B, C, D, or num and den, or z, p and k")));
        }
        let part = self.part(field, fields);
        let holds = |keys: &[&str]| fields.keys().all(|key| keys.contains(&key.as_str()));
        match [holds(&["A", "B", "C", "D", "E", "n", "m", "p"]), holds(&["num", "den"]), holds(&["z", "p", "k"])] {
            [true, ..] if fields.contains_key("A") => part.system(),
            [_, true, _] => part.transfer_function(),
            [.., true] => part.zeros_poles_gain(),
            _ => Err(self
                .failure(field, "has keys that do not go together")
                .with_hint("a system has A, B, C, D, or num and den, or z, p and k")),
        }
    }

    /// num/den, coefficients from the highest power down, in companion form.
    fn transfer_function(&self) -> Result<StateSpace<Continuous>, InputError> {
        let lead = |list: Vec<f64>| list.into_iter().skip_while(|c| *c == 0.0).collect::<Vec<f64>>();
        let (num, den) = (lead(self.numbers("num")?), lead(self.numbers("den")?));
        let (Some(first), n) = (den.first().copied(), den.len().saturating_sub(1)) else {
            return Err(self.failure("den", "is zero"));
        };
        if num.len() > den.len() {
            let rule = format!("has degree {}, above the degree {n} of den", num.len() - 1);
            return Err(self
                .failure("num", rule)
                .with_hint("a differentiator needs a roll-off: add a fast pole to den"));
        }
        // Of the same length as den, both over its first coefficient.
        let upper = |k: usize| k.checked_sub(den.len() - num.len()).map_or(0.0, |k| num[k] / first);
        let lower: Vec<f64> = den[1..].iter().map(|d| d / first).collect();
        companion(upper, &lower, Continuous).map_err(|e| self.failure("den", e))
    }

    /// k Π(s − z)/Π(s − p) as a chain of sections.
    fn zeros_poles_gain(&self) -> Result<StateSpace<Continuous>, InputError> {
        let (zeros, poles) = (self.roots("z")?, self.roots("p")?);
        if zeros.len() > poles.len() {
            let rule = format!("has {} entries, more than the {} poles of p", zeros.len(), poles.len());
            return Err(self.failure("z", rule).with_hint("a differentiator needs a roll-off: add a fast pole to p"));
        }
        chain(&poles, &zeros, self.number("k")?, Continuous).map_err(|e| self.failure("p", e))
    }

    /// Roots of a real polynomial: numbers, or `{"re": [..], "im": [..]}` in conjugate pairs.
    fn roots(&self, field: &str) -> Result<Vec<c64>, InputError> {
        if !self.has(field) {
            return Ok(vec![]);
        }
        let Value::Object(parts) = self.value(field)? else {
            return Ok(self.numbers(field)?.into_iter().map(|re| c64::new(re, 0.0)).collect());
        };
        if let Some(key) = parts.keys().find(|key| !["re", "im"].contains(&key.as_str())) {
            let error = self.failure_at_key(key, format!("unknown key `{field}.{key}`"));
            return Err(error.with_hint("roots are numbers, or `re` and `im`"));
        }
        let part = self.part(field, parts);
        let (re, im) = (part.numbers("re")?, part.numbers("im")?);
        if re.len() != im.len() {
            return Err(self.failure(field, "re and im differ in length"));
        }
        let roots: Vec<c64> = re.into_iter().zip(im).map(|(re, im)| c64::new(re, im)).collect();
        let count = |root: c64| roots.iter().filter(|other| **other == root).count();
        match roots.iter().find(|root| count(**root) != count(root.conj())) {
            None => Ok(roots),
            Some(lone) => Err(self.failure(field, format!("{} {:+}j has no conjugate", lone.re, lone.im))),
        }
    }
}
