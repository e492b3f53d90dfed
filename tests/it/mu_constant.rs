//! μ of constant matrices: reference cases, closed forms, invariants, and the fast road against the matrix inequality.

use crate::control_cases::{Case, block_list, complex_matrix};
use muspin::augment::Block;
use muspin::linalg::{Mat, c64};
use muspin::robust::{mu, structure::Structure};

fn sigma_max(m: &Mat<c64>) -> f64 {
    muspin::linalg::max_singular_value_complex(m)
}

#[test]
fn reference_cases_lie_between_the_bounds() {
    for case in Case::all("mu") {
        let m = complex_matrix(&case.data["M"]);
        let blocks = block_list(&case.data["blocks"]);
        let reference = |key: &str| case.reference[key].as_f64().unwrap();
        let found = mu::bounds(&m, &blocks).unwrap();
        eprintln!(
            "{:24} upper {:.9} ref {:.9} lower {:.9} ref {:.9}",
            case.id,
            found.upper,
            reference("upper_bound"),
            found.lower,
            reference("lower_bound")
        );
        assert!(
            found.upper >= reference("lower_bound") * (1.0 - 1e-9),
            "{}: upper {} below the reference lower bound",
            case.id,
            found.upper
        );
        let absolute = case.tolerance["upper_abs"].as_f64().unwrap();
        let limit = reference("upper_bound") * (1.0 + 1e-4) + absolute;
        assert!(
            found.upper <= limit,
            "{}: {} > {limit}",
            case.id,
            found.upper
        );
        assert!(found.upper <= sigma_max(&m) * (1.0 + 1e-12) + 1e-300);
        assert!((found.scaling.bound(&m) - found.upper).abs() <= 1e-9 * found.upper + 1e-12);
        assert!(
            found.lower <= found.upper * (1.0 + 1e-9) + 1e-12,
            "{}",
            case.id
        );
        assert!(
            found.lower >= 0.999 * reference("lower_bound"),
            "{}: lower {} reference {}",
            case.id,
            found.lower,
            reference("lower_bound")
        );
        check_worst_case(&m, &blocks, &found);
    }
}

/// Δ has the structure, the size 1/lower, and makes I − ΔM singular.
fn check_worst_case(m: &Mat<c64>, blocks: &[Block], found: &mu::MuBounds) {
    if found.lower == 0.0 {
        return;
    }
    let size = sigma_max(&found.delta);
    assert!((size * found.lower - 1.0).abs() < 1e-9);
    for span in Structure::new(blocks).unwrap().spans {
        let first = found.delta[(span.w.start, span.z.start)];
        for i in 0..m.ncols() {
            for j in span.z.clone() {
                let inside = span.w.contains(&i);
                if !inside {
                    assert_eq!(found.delta[(i, j)].norm(), 0.0);
                } else if span.is_scalar() {
                    let diagonal = i - span.w.start == j - span.z.start;
                    let expected = if diagonal { first } else { c64::new(0.0, 0.0) };
                    assert_eq!(found.delta[(i, j)], expected);
                    assert!(!span.is_real() || expected.im == 0.0);
                }
            }
        }
    }
    let gain = &found.delta * m;
    let n = gain.nrows();
    let difference = Mat::from_fn(n, n, |i, j| {
        c64::new(f64::from(u8::from(i == j)), 0.0) - gain[(i, j)]
    });
    let smallest = muspin::linalg::hermitian::min_singular_value(&difference);
    assert!(smallest < 1e-8 * (1.0 + sigma_max(&gain)), "{smallest}");
}
