//! Between numpy arrays and matrices.

use crate::linalg::{Mat, c64};
use crate::lti::{Continuous, StateSpace, TimeBase};
use numpy::{Complex64, PyArray2, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A real matrix of Python.
pub(super) type Real<'py> = PyReadonlyArray2<'py, f64>;
/// A real matrix for Python.
pub(super) type RealOut<'py> = Bound<'py, PyArray2<f64>>;
/// A, B, C, D of Python.
pub(super) type Matrices<'py> = (Real<'py>, Real<'py>, Real<'py>, Real<'py>);
/// A, B, C, D for Python.
pub(super) type SystemOut<'py> = (RealOut<'py>, RealOut<'py>, RealOut<'py>, RealOut<'py>);

/// An error as `ValueError` with its words.
pub(super) fn to_value_error(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A matrix from an array; refused when it holds NaN or infinity.
pub(super) fn matrix(array: &Real<'_>, name: &str) -> PyResult<Mat<f64>> {
    let view = array.as_array();
    let (rows, columns) = view.dim();
    if view.iter().any(|x| !x.is_finite()) {
        return Err(to_value_error(format!("{name} holds NaN or infinity")));
    }
    Ok(Mat::from_fn(rows, columns, |i, j| view[[i, j]]))
}

/// A complex matrix from an array; refused when it holds NaN or infinity.
pub(super) fn complex(array: &PyReadonlyArray2<'_, Complex64>, name: &str) -> PyResult<Mat<c64>> {
    let view = array.as_array();
    let (rows, columns) = view.dim();
    if view.iter().any(|x| !(x.re.is_finite() && x.im.is_finite())) {
        return Err(to_value_error(format!("{name} holds NaN or infinity")));
    }
    Ok(Mat::from_fn(rows, columns, |i, j| c64::new(view[[i, j]].re, view[[i, j]].im)))
}

/// An array from a matrix.
pub(super) fn array<'py>(python: Python<'py>, m: &Mat<f64>) -> RealOut<'py> {
    ndarray::Array2::from_shape_fn((m.nrows(), m.ncols()), |(i, j)| m[(i, j)]).to_pyarray(python)
}

/// A complex array from a matrix.
pub(super) fn complex_array<'py>(python: Python<'py>, m: &Mat<c64>) -> Bound<'py, PyArray2<Complex64>> {
    let at = |(i, j)| Complex64::new(m[(i, j)].re, m[(i, j)].im);
    ndarray::Array2::from_shape_fn((m.nrows(), m.ncols()), at).to_pyarray(python)
}

/// The four matrices of a system.
pub(super) fn system<'py, T: TimeBase>(python: Python<'py>, s: &StateSpace<T>) -> SystemOut<'py> {
    let out = |m: &Mat<f64>| array(python, m);
    (out(&s.a), out(&s.b), out(&s.c), out(&s.d))
}

/// A continuous system from its four matrices.
pub(super) fn continuous(p: &Matrices<'_>) -> PyResult<StateSpace<Continuous>> {
    let (a, b) = (matrix(&p.0, "A")?, matrix(&p.1, "B")?);
    let (c, d) = (matrix(&p.2, "C")?, matrix(&p.3, "D")?);
    StateSpace::new(a, b, c, d, Continuous).map_err(to_value_error)
}
