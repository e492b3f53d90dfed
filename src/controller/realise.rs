//! A realisation: the controller as the list of sums of products that one sample takes, in order of computation.
//! Values are states x (n), inputs y (m), intermediate signals t (s, for cascades), outputs u (p):
//!   tₖ = Σ cⱼ vⱼ   (may use earlier t),   uᵢ = Σ cⱼ vⱼ,   xᵢ⁺ = Σ cⱼ vⱼ   with v = [x; y; t].
//! Modal form has no signals; a cascade of second-order sections hands its values on through them. Firmware,
//! its simulation and its verification all read this one list, so they cannot disagree.

use super::modal::{LARGEST_CHANGE, block_diagonalise};
use super::{ControllerError, in_step};
use crate::linalg::Mat;
use crate::lti::{Discrete, StateSpace};

named! {
    /// How the controller is arranged.
    pub enum Form {
        /// Real modal form: 1×1 and 2×2 blocks, larger ones for poles that repeat.
        Modal = "real modal form",
        /// Cascades of second-order sections, one per axis.
        SecondOrderSections = "second-order sections, transposed direct form II",
    }
}

/// One product of a sum: `coefficient` times value number `source` of v = [x; y; t].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProductTerm {
    /// Index into [x; y; t].
    pub source: usize,
    /// Factor.
    pub coefficient: f64,
}

/// One sum of products, in order of computation.
pub type Row = Vec<ProductTerm>;

/// A controller in the form in which firmware computes it.
#[derive(Clone, Debug)]
pub struct Realisation {
    /// Arrangement.
    pub form: Form,
    /// Number of inputs m.
    pub inputs: usize,
    /// Rows of the intermediate signals, in order; row k may use signals before k.
    pub signals: Vec<Row>,
    /// Rows of the outputs.
    pub outputs: Vec<Row>,
    /// Rows of the next states.
    pub states: Vec<Row>,
    /// Sample period, s.
    pub sample_time_s: f64,
    /// Sizes of the diagonal blocks of A.
    pub blocks: Vec<usize>,
    /// Condition number of the transform that led here; 1 when there was none.
    pub condition: f64,
    /// What a reader should know about the form, for instance merged blocks.
    pub notes: Vec<String>,
}

/// Real modal form of a sampled controller, states not yet scaled ([`super::scaling::scale_realisation`] does that).
///
/// # Errors
/// [`ControllerError::Numeric`] when an eigenvalue iteration fails, [`ControllerError::Inaccurate`] when no block form
/// reproduces the transfer matrix.
pub fn modal_form(system: &StateSpace<Discrete>) -> Result<Realisation, ControllerError> {
    let modal = block_diagonalise(system)?;
    let merged: Vec<String> = modal.merged_blocks().map(|n| format!("{n}x{n}")).collect();
    let mut notes = Vec::new();
    if !merged.is_empty() {
        notes.push(format!(
            "blocks of {} hold poles that (nearly) repeat and cannot be separated accurately",
            merged.join(", ")
        ));
    }
    if modal.transfer_error > LARGEST_CHANGE {
        notes.push(format!(
            "the transfer matrix changed by {:.1e} of its peak: the states as given hold the controller no better; \
             give it as modal blocks",
            modal.transfer_error
        ));
    }
    let mut realisation = Realisation {
        blocks: modal.blocks,
        condition: modal.condition,
        notes,
        ..from_state_space(&modal.system, Form::Modal)
    };
    for (i, row) in realisation.states.iter_mut().enumerate() {
        in_increments(i, row);
    }
    Ok(realisation)
}

/// Writes a·x with a near one as (a − 1)·x + 1·x, the exact one last: single precision then holds the distance of a
/// slow pole from one, on which its time constant depends, to full precision (the idea of the delta form).
fn in_increments(state: usize, row: &mut Row) {
    // Beyond a quarter the split gains less than two bits and costs a product all the same.
    let near_one = |t: &ProductTerm| t.source == state && (t.coefficient - 1.0).abs() < 0.25;
    if let Some(own) = row.iter_mut().find(|t| near_one(t)) {
        own.coefficient -= 1.0;
        row.retain(|t| t.coefficient != 0.0);
        row.push(ProductTerm { source: state, coefficient: 1.0 });
    }
}

/// The rows of a state-space system as it stands; zero coefficients are left out.
pub(crate) fn from_state_space(system: &StateSpace<Discrete>, form: Form) -> Realisation {
    let (n, m) = (system.order(), system.inputs());
    let row = |states: &Mat<f64>, inputs: &Mat<f64>, i: usize| -> Row {
        (0..n)
            .map(|j| (j, states[(i, j)]))
            .chain((0..m).map(|j| (n + j, inputs[(i, j)])))
            .filter(|(_, coefficient)| *coefficient != 0.0)
            .map(|(source, coefficient)| ProductTerm { source, coefficient })
            .collect()
    };
    Realisation {
        form,
        inputs: m,
        signals: Vec::new(),
        outputs: (0..system.outputs()).map(|i| row(&system.c, &system.d, i)).collect(),
        states: (0..n).map(|i| row(&system.a, &system.b, i)).collect(),
        sample_time_s: system.time.period_s,
        blocks: vec![n],
        condition: 1.0,
        notes: Vec::new(),
    }
}

impl Realisation {
    /// Number of states n.
    pub fn order(&self) -> usize {
        self.states.len()
    }

    /// All rows in the order of computation: signals, outputs, states.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &Row> {
        self.signals.iter().chain(&self.outputs).chain(&self.states)
    }

    /// Multiplications (equal to additions) per sample.
    pub(crate) fn multiplications(&self) -> usize {
        self.rows().map(Vec::len).sum()
    }

    /// The same rows with every coefficient passed through `change`.
    pub(crate) fn map_coefficients(&self, change: impl Fn(f64) -> f64) -> Self {
        let rows = |list: &[Row]| -> Vec<Row> {
            list.iter()
                .map(|row| {
                    row.iter()
                        .map(|term| ProductTerm { source: term.source, coefficient: change(term.coefficient) })
                        .collect()
                })
                .collect()
        };
        Self {
            signals: rows(&self.signals),
            outputs: rows(&self.outputs),
            states: rows(&self.states),
            blocks: self.blocks.clone(),
            notes: self.notes.clone(),
            ..*self
        }
    }

    /// The system with its coefficients rounded to single precision: what float32 firmware realises, for
    /// verification. Rounding of the sums themselves is left out; it acts as noise.
    ///
    /// # Errors
    /// [`ControllerError::Numeric`] when a coefficient overflows single precision.
    pub fn rounded_f32(&self) -> Result<StateSpace<Discrete>, ControllerError> {
        self.map_coefficients(|c| f64::from(c as f32)).to_state_space()
    }

    /// The linear system that the rows compute, signals eliminated.
    ///
    /// # Errors
    /// [`ControllerError::Numeric`] when a coefficient is not finite.
    pub fn to_state_space(&self) -> Result<StateSpace<Discrete>, ControllerError> {
        let (n, m) = (self.order(), self.inputs);
        let signals = self.signal_maps();
        let (outputs, states) = (self.expand(&self.outputs, &signals), self.expand(&self.states, &signals));
        StateSpace::new(
            Mat::from_fn(n, n, |i, j| states[i][j]),
            Mat::from_fn(n, m, |i, j| states[i][n + j]),
            Mat::from_fn(outputs.len(), n, |i, j| outputs[i][j]),
            Mat::from_fn(outputs.len(), m, |i, j| outputs[i][n + j]),
            Discrete { period_s: self.sample_time_s },
        )
        .map_err(in_step("realisation"))
    }

    /// Each signal as a dense row over [x; y].
    pub(super) fn signal_maps(&self) -> Vec<Vec<f64>> {
        let mut known: Vec<Vec<f64>> = Vec::new();
        for row in &self.signals {
            let dense = self.dense(row, &known);
            known.push(dense);
        }
        known
    }

    fn expand(&self, rows: &[Row], signals: &[Vec<f64>]) -> Vec<Vec<f64>> {
        rows.iter().map(|row| self.dense(row, signals)).collect()
    }

    fn dense(&self, row: &Row, signals: &[Vec<f64>]) -> Vec<f64> {
        let width = self.order() + self.inputs;
        let mut sum = vec![0.0; width];
        for term in row {
            if term.source < width {
                sum[term.source] += term.coefficient;
            } else if let Some(map) = signals.get(term.source - width) {
                for (total, c) in sum.iter_mut().zip(map) {
                    *total += term.coefficient * c;
                }
            }
        }
        sum
    }
}
