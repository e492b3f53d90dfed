//! The solvers on arrays. Every function returns its certificate beside its answer.

use super::compute::compute;
use super::convert::{
    Matrices, Real, RealOut, SystemOut, array, complex, complex_array, continuous, matrix, system, to_value_error,
};
use crate::augment::{Block, GeneralizedPlant};
use crate::input::problem::ProblemFields;
use crate::input::problem_schema::ProblemKind;
use crate::linalg::riccati::care;
use crate::lti::balance::Balancing;
use crate::lti::connect::lower_lft;
use crate::lti::norm::{hinf_norm, hinf_norm_discrete};
use crate::lti::sample::{inverse_tustin, tustin};
use crate::lti::{Discrete, StateSpace};
use crate::robust::dk::posed::iterate_mixed;
use crate::robust::dk::{DkError, DkSettings};
use crate::robust::hinf::regularise::{Regularisation, regularise_plant};
use crate::robust::riccati_cause::find_cause;
use crate::robust::{HinfSettings, SynthesisError, mu, synthesise};
use crate::workflow::Failure;
use crate::workflow::solve::answer_problem;
use numpy::{Complex64, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use std::path::Path;

/// Relative tolerance of norms.
const NORM_TOLERANCE: f64 = 1e-10;

/// Adds the functions to the module.
pub(super) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(care_of, module)?)?;
    module.add_function(wrap_pyfunction!(hinfnorm, module)?)?;
    module.add_function(wrap_pyfunction!(hinfsyn, module)?)?;
    module.add_function(wrap_pyfunction!(musyn, module)?)?;
    module.add_function(wrap_pyfunction!(mussv, module)?)?;
    module.add_function(wrap_pyfunction!(balred, module)?)?;
    module.add_function(wrap_pyfunction!(solve, module)?)?;
    module.add_function(wrap_pyfunction!(to_w_plane, module)?)?;
    module.add_function(wrap_pyfunction!(from_w_plane, module)?)
}

/// X, relative residual and growth rate of the stabilising solution of A'X + XA − XGX + Q = 0.
#[pyfunction(name = "care")]
fn care_of<'py>(python: Python<'py>, a: Real<'py>, g: Real<'py>, q: Real<'py>) -> PyResult<(RealOut<'py>, f64, f64)> {
    let (a, g, q) = (matrix(&a, "A")?, matrix(&g, "G")?, matrix(&q, "Q")?);
    let found = compute(python, move |_| {
        care(&a, &g, &q).map_err(|e| {
            let failure = Failure::new(format!("Riccati equation: {e}"));
            match find_cause(&a, &g, &q) {
                Ok(Some(cause)) => failure.with_hint(cause),
                _ => failure,
            }
        })
    })?;
    Ok((array(python, &found.x), found.residual, found.closed_loop_max_real))
}

/// Norm, its frequency and a certified upper bound; `period` 0 is continuous time.
#[pyfunction]
fn hinfnorm(python: Python<'_>, p: Matrices<'_>, period: f64) -> PyResult<(f64, f64, f64)> {
    let s = continuous(&p)?;
    if !(period.is_finite() && period >= 0.0) {
        return Err(to_value_error(format!("dt = {period} must be a time in seconds")));
    }
    let found = compute(python, move |_| {
        Ok(if period > 0.0 {
            let time = Discrete { period_s: period };
            let sampled = StateSpace { a: s.a, b: s.b, c: s.c, d: s.d, time };
            hinf_norm_discrete(&sampled, NORM_TOLERANCE)?
        } else {
            hinf_norm(&s, NORM_TOLERANCE)?
        })
    })?;
    Ok((found.norm, found.peak_omega_rad_s, found.upper))
}

fn plant(p: &Matrices<'_>, measurements: usize, controls: usize, blocks: Vec<Block>) -> PyResult<GeneralizedPlant> {
    let system = continuous(p)?;
    let lacks = [
        (system.inputs() == controls, "no disturbance inputs w"),
        (system.outputs() == measurements, "no error outputs z"),
    ];
    let lacks: Vec<&str> = lacks.iter().filter(|(is_so, _)| *is_so).map(|(_, words)| *words).collect();
    if !lacks.is_empty() {
        let words = lacks.join(" and ");
        return Err(to_value_error(format!("the plant has {words}: the gain from w to z is what is made small")));
    }
    let fits = |name: &str, part: usize, whole: usize| {
        if part > 0 && part < whole {
            Ok(())
        } else {
            Err(to_value_error(format!(
                "{name} = {part} must lie between 1 and {}: the plant has {whole} channels there, errors or \
             disturbances included",
                whole.saturating_sub(1)
            )))
        }
    };
    fits("nmeas", measurements, system.outputs())?;
    fits("ncon", controls, system.inputs())?;
    Ok(GeneralizedPlant { system, controls, measurements, blocks })
}

/// The plant as it is posed: enlarged by a share of the gains of its channels where one is given.
fn pose_problem(plant: &GeneralizedPlant, share: Option<f64>) -> Result<(GeneralizedPlant, Regularisation), Failure> {
    match share {
        None => Ok((plant.clone(), Regularisation::default())),
        Some(share) if share > 0.0 && share < 1.0 => regularise_plant(plant, share).ok_or_else(|| {
            Failure::new("regularise: a control reaches no error, or no disturbance reaches a measurement")
        }),
        Some(share) => {
            Err(Failure::new(format!("regularise = {share} must be True or a share of the gains between 0 and 1")))
        }
    }
}

/// The sizes of what was added to D12 and to D21.
type Added = (Vec<f64>, Vec<f64>);

/// Controller, γ of it, optimal γ, norm of the loop of the plant as given with its frequency, that of the loop as
/// posed, the certificate as pairs, what was added.
type Hinf<'py> = (SystemOut<'py>, f64, f64, (f64, f64), f64, Vec<(&'static str, f64)>, Added);

/// H∞ synthesis; `gamma` asks for the central controller at that level, `share` for a regularisation.
#[pyfunction]
fn hinfsyn<'py>(
    python: Python<'py>,
    p: Matrices<'py>,
    measurements: usize,
    controls: usize,
    gamma: Option<f64>,
    share: Option<f64>,
) -> PyResult<Hinf<'py>> {
    let given = plant(&p, measurements, controls, vec![])?;
    let settings = HinfSettings { gamma, ..HinfSettings::default() };
    let (found, norm, added) = compute(python, move |_| {
        let (plant, added) = pose_problem(&given, share)?;
        let found = synthesise(&plant, &settings).map_err(|e| explain_error(&e))?;
        let norm = if added == Regularisation::default() {
            (found.closed_loop_norm, found.closed_loop_peak_rad_s)
        } else {
            let closed = lower_lft(&given.system, &found.controller)?;
            let norm = hinf_norm(&closed, NORM_TOLERANCE)?;
            (norm.norm, norm.peak_omega_rad_s)
        };
        Ok((found, norm, added))
    })?;
    let c = &found.certificate;
    let certificate = vec![
        ("x_residual", c.x_residual),
        ("y_residual", c.y_residual),
        ("x_min_relative", c.x_min),
        ("y_min_relative", c.y_min),
        ("coupling", c.coupling),
        ("closed_loop_max_real", c.growth_rate),
    ];
    Ok((
        system(python, &found.controller),
        found.gamma,
        found.gamma_opt,
        norm,
        found.closed_loop_norm,
        certificate,
        (added.d12, added.d21),
    ))
}

/// A failed synthesis with what to do.
fn explain_error(error: &SynthesisError) -> Failure {
    let hair = matches!(
        error,
        SynthesisError::ControlCost { .. }
            | SynthesisError::MeasurementNoise { .. }
            | SynthesisError::WeakFeedthrough { .. }
    );
    let regularise = if hair { "; or pass regularise=True, which adds what is missing and reports it" } else { "" };
    Failure::new(format!("H-infinity synthesis: {error}")).with_hint(format!("{}{regularise}", error.advice()))
}

/// A block as (kind, rows or size, columns).
type BlockIn = (String, usize, usize);

fn blocks(list: &[BlockIn]) -> PyResult<Vec<Block>> {
    let one = |(kind, rows, cols): &BlockIn| match kind.as_str() {
        "complex_full" => Ok(Block::ComplexFull { rows: *rows, cols: *cols }),
        "complex_scalar" => Ok(Block::ComplexScalar { n: *rows }),
        "real_scalar" => Ok(Block::RealScalar { n: *rows }),
        other => Err(to_value_error(format!("block kind {other:?}: complex_full, complex_scalar or real_scalar"))),
    };
    list.iter().map(one).collect()
}

/// Controller, certified upper bound, lower bound, frequency of the peak, and (γ, μ, order) of every iteration, what
/// was added.
type Mu<'py> = (SystemOut<'py>, f64, f64, f64, Vec<(f64, f64, usize)>, Added);

/// D-K iteration; `share` asks for a regularisation.
#[pyfunction]
fn musyn<'py>(
    python: Python<'py>,
    p: Matrices<'py>,
    channels: (usize, usize),
    structure: Vec<BlockIn>,
    max_iterations: Option<usize>,
    share: Option<f64>,
) -> PyResult<Mu<'py>> {
    let given = plant(&p, channels.0, channels.1, blocks(&structure)?)?;
    let mut settings = DkSettings::default();
    match max_iterations {
        Some(0) => return Err(to_value_error("max_iterations must be at least 1")),
        Some(most) => settings.max_iterations = most,
        None => {}
    }
    let (found, added) = compute(python, move |stop| {
        let (plant, added) = pose_problem(&given, share)?;
        let found = iterate_mixed(&plant, &settings, &mut |_| stop.here());
        let found = found.map_err(|e| match e {
            DkError::Synthesis(cause) => explain_error(&cause),
            other => other.into(),
        })?;
        Ok((found, added))
    })?;
    let steps = found.steps.iter();
    Ok((
        system(python, &found.controller),
        found.mu_peak,
        found.mu_lower_peak,
        found.peak_omega_rad_s,
        steps.map(|s| (s.gamma, s.mu_peak, s.controller_order)).collect(),
        (added.d12, added.d21),
    ))
}

/// Upper bound, lower bound and the Δ that attains it, of a complex matrix.
#[pyfunction]
fn mussv<'py>(
    python: Python<'py>,
    m: PyReadonlyArray2<'py, Complex64>,
    structure: Vec<BlockIn>,
) -> PyResult<(f64, f64, Bound<'py, PyArray2<Complex64>>)> {
    let (m, structure) = (complex(&m, "M")?, blocks(&structure)?);
    let rows: usize = structure.iter().map(Block::rows).sum();
    let cols: usize = structure.iter().map(Block::cols).sum();
    if (m.nrows(), m.ncols()) != (cols, rows) {
        return Err(to_value_error(format!(
            "M is {} x {}, but the blocks [r, c] sum to r = {rows} and c = {cols}: M must be {cols} x {rows}",
            m.nrows(),
            m.ncols()
        )));
    }
    let found = compute(python, move |_| Ok(mu::bounds(&m, &structure)?))?;
    Ok((found.upper, found.lower, complex_array(python, &found.delta)))
}

/// The best reduction to `order` states with its H∞ error and method, and the Hankel singular values.
#[pyfunction]
fn balred<'py>(
    python: Python<'py>,
    p: Matrices<'py>,
    order: usize,
    method: Option<String>,
) -> PyResult<(SystemOut<'py>, f64, String, Vec<f64>)> {
    let full = continuous(&p)?;
    if order > full.order() {
        return Err(to_value_error(format!("order {order}, but the system has {} states", full.order())));
    }
    let (best, hankel) = compute(python, move |_| {
        let balancing = Balancing::with_check(&full)?;
        let reductions = balancing.reductions(order)?;
        let names: Vec<&str> = reductions.iter().map(|r| r.method).collect();
        let names = names.join(", ");
        let wanted = |name: &str| method.as_deref().is_none_or(|m| m == name);
        match reductions.into_iter().find(|r| wanted(r.method)) {
            Some(best) => Ok((best, balancing.hankel)),
            None => Err(Failure::new(format!("no reduction of that kind to {order} states; there are: {names}"))),
        }
    })?;
    Ok((system(python, &best.system), best.error_hinf, best.method.to_owned(), hankel))
}

/// The answer of `muspin solve` to a problem, both as JSON.
#[pyfunction]
fn solve(python: Python<'_>, kind: &str, problem: String) -> PyResult<String> {
    let Some(kind) = ProblemKind::from_name(kind) else {
        let names = ProblemKind::ALL.map(ProblemKind::name);
        return Err(to_value_error(format!("kind {kind:?}: {}", names.join(", "))));
    };
    compute(python, move |_| Ok(answer_problem(&ProblemFields::parse(Path::new("problem"), &problem)?, kind)?.text()))
}

/// A sampled system in the w plane.
#[pyfunction]
fn to_w_plane<'py>(python: Python<'py>, p: Matrices<'py>, period: f64) -> PyResult<SystemOut<'py>> {
    let sampled = continuous(&p)?.with_time(Discrete { period_s: period });
    Ok(system(python, &inverse_tustin(&sampled).map_err(to_value_error)?))
}

/// A system of the w plane as a sampled one.
#[pyfunction]
fn from_w_plane<'py>(python: Python<'py>, p: Matrices<'py>, period: f64) -> PyResult<SystemOut<'py>> {
    Ok(system(python, &tustin(&continuous(&p)?, period).map_err(to_value_error)?))
}
