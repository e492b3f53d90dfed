//! μ of constant matrices: reference cases, closed forms, invariants, and the fast road against the matrix inequality.

use crate::robust::control_cases::{Case, block_list, complex_matrix};
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
        assert!(
            found.upper >= reference("lower_bound") * (1.0 - 1e-9),
            "{}: upper {} below the reference lower bound",
            case.id,
            found.upper
        );
        let absolute = case.tolerance["upper_abs"].as_f64().unwrap();
        let limit = reference("upper_bound") * (1.0 + 1e-4) + absolute;
        assert!(found.upper <= limit, "{}: {} > {limit}", case.id, found.upper);
        assert!(found.upper <= sigma_max(&m) * (1.0 + 1e-12) + 1e-300);
        assert!((found.scaling.bound_at(&m) - found.upper).abs() <= 1e-9 * found.upper + 1e-12);
        assert!(found.lower <= found.upper * (1.0 + 1e-9) + 1e-12, "{}", case.id);
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
    let difference = Mat::from_fn(n, n, |i, j| c64::new(f64::from(u8::from(i == j)), 0.0) - gain[(i, j)]);
    let smallest = muspin::linalg::hermitian::min_singular_value(&difference);
    assert!(smallest < 1e-8 * (1.0 + sigma_max(&gain)), "{smallest}");
}

fn random(seed: u64, rows: usize, cols: usize) -> Mat<c64> {
    use rand::{Rng, SeedableRng};
    let mut source = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || 2.0 * source.random::<f64>() - 1.0;
    Mat::from_fn(rows, cols, |_, _| c64::new(draw(), draw()))
}

/// Structures with nothing but complex blocks, of four channels.
fn complex_structures() -> Vec<Vec<Block>> {
    let scalar = Block::ComplexScalar { n: 1 };
    let full = |k| Block::ComplexFull { rows: k, cols: k };
    vec![
        vec![full(4)],
        vec![full(2), full(2)],
        vec![scalar, scalar, full(2)],
        vec![scalar; 4],
        vec![Block::ComplexScalar { n: 2 }, full(2)],
        vec![Block::ComplexScalar { n: 4 }],
    ]
}

#[test]
fn the_spectral_radius_and_the_largest_gain_enclose_mu_and_the_bounds_meet() {
    for seed in 0..10 {
        let m = random(seed, 4, 4);
        let radius = muspin::linalg::eigenvalues_complex(&m).unwrap().last().map_or(0.0, |v| v.norm());
        for blocks in complex_structures() {
            let found = mu::bounds(&m, &blocks).unwrap();
            assert!(found.upper >= radius * (1.0 - 1e-6), "{blocks:?}");
            assert!(found.upper <= sigma_max(&m) * (1.0 + 1e-12));
            assert!(found.lower <= found.upper * (1.0 + 1e-9));
            assert!(found.lower >= 0.95 * found.upper, "{blocks:?} {}", found.lower / found.upper);
            check_worst_case(&m, &blocks, &found);
        }
    }
}

#[test]
fn refining_a_block_never_raises_the_bound_and_one_repeated_scalar_is_the_spectral_radius() {
    for seed in 20..26 {
        let m = random(seed, 4, 4);
        let upper: Vec<f64> = complex_structures().iter().map(|b| mu::upper_bound(&m, b).unwrap().0).collect();
        for k in 1..4 {
            assert!(upper[k] <= upper[k - 1] * (1.0 + 1e-7), "{upper:?}");
        }
        let radius = muspin::linalg::eigenvalues_complex(&m).unwrap().last().map_or(0.0, |v| v.norm());
        assert!((upper[5] / radius - 1.0).abs() < 1e-4, "{} {radius}", upper[5]);
    }
}

#[test]
fn a_diagonal_scale_changes_neither_bound() {
    let d: [f64; 4] = [1.0, 1e4, 1e-3, 1e7];
    let blocks = vec![Block::ComplexScalar { n: 1 }; 4];
    for seed in 40..45 {
        let m = random(seed, 4, 4);
        let scaled = Mat::from_fn(4, 4, |i, j| m[(i, j)] * (d[i] / d[j]));
        let (plain, badly) = (mu::upper_bound(&m, &blocks).unwrap().0, mu::upper_bound(&scaled, &blocks).unwrap().0);
        assert!((plain / badly - 1.0).abs() < 1e-6, "{plain} {badly}");
    }
}

#[test]
fn reducible_and_zero_matrices() {
    let scalars = vec![Block::ComplexScalar { n: 1 }; 4];
    let triangular = Mat::from_fn(4, 4, |i, j| {
        let value = if i > j { 0.0 } else { [0.3, -0.7, 0.2, 0.5][i] + 5.0 * (j - i) as f64 };
        c64::new(value, 0.0)
    });
    let found = mu::bounds(&triangular, &scalars).unwrap();
    assert!((found.upper - 0.7).abs() < 1e-8, "{}", found.upper);
    assert!((found.lower - 0.7).abs() < 1e-8, "{}", found.lower);
    let strictly = Mat::from_fn(4, 4, |i, j| c64::new(f64::from(u8::from(j > i)), 0.0));
    assert!(mu::upper_bound(&strictly, &scalars).unwrap().0 < 1e-9);
    let zero = mu::bounds(&Mat::zeros(4, 4), &scalars).unwrap();
    assert_eq!((zero.upper, zero.lower), (0.0, 0.0));
}

/// The largest t for which λX_R − MᴴX_L M − j(GM − MᴴGᴴ) ⪰ t I has a solution with 0 ⪯ X, tr X = 1: clarabel on the
/// real image [[Re, −Im], [Im, Re]] of the matrices. No scaling proves a bound below √λ where it is negative.
fn room_below(m: &Mat<c64>, structure: &Structure, level: f64) -> f64 {
    use clarabel::algebra::CscMatrix;
    use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SupportedConeT};
    let q = m.ncols();
    let pack = |h: &Mat<c64>| -> Vec<f64> {
        let n = h.nrows();
        let real = |i: usize, j: usize| {
            let z = h[(i % n, j % n)];
            if i < n && j >= n { -z.im } else { z.re }
        };
        let upper = (0..2 * n).flat_map(|j| (0..=j).map(move |i| (i, j)));
        upper.map(|(i, j)| real(i, j) * if i == j { 1.0 } else { 2f64.sqrt() }).collect()
    };
    // Columns of −F for (variables, rows of S, then of each X), the trace first.
    let mut columns = vec![(0.0, pack(&Mat::identity(q, q)), vec![])];
    for (k, span) in structure.spans.iter().enumerate() {
        let single = !span.is_scalar() || (span.w.len() == 1 && !span.is_real());
        let n = if single { 1 } else { span.w.len() };
        for col in 0..n {
            for (row, value) in (0..=col).flat_map(|r| [(r, c64::new(1.0, 0.0)), (r, c64::new(0.0, 1.0))]) {
                if row == col && value.im != 0.0 {
                    continue;
                }
                let element = Mat::from_fn(n, n, |i, j| {
                    let upper = if (i, j) == (row, col) { value } else { c64::new(0.0, 0.0) };
                    if (j, i) == (row, col) { value.conj() } else { upper }
                });
                let on = |range: &std::ops::Range<usize>, size: usize| {
                    Mat::from_fn(size, size, |i, j| match (range.contains(&i), range.contains(&j)) {
                        (true, true) if single => c64::new(f64::from(u8::from(i == j)), 0.0),
                        (true, true) => element[(i - range.start, j - range.start)],
                        _ => c64::new(0.0, 0.0),
                    })
                };
                let left = on(&span.z, m.nrows());
                let s = -(m.adjoint() * left * m) + on(&span.w, q) * faer::Scale(c64::new(level, 0.0));
                columns.push((if row == col { 1.0 } else { 0.0 }, pack(&-s), vec![(k, pack(&-&element))]));
                if span.is_real() {
                    let g = Mat::from_fn(q, m.nrows(), |i, j| match (span.w.contains(&i), span.z.contains(&j)) {
                        (true, true) => element[(i - span.w.start, j - span.z.start)],
                        _ => c64::new(0.0, 0.0),
                    });
                    let gm = g * m;
                    let j = faer::Scale(c64::new(0.0, 1.0));
                    columns.push((0.0, pack(&((&gm - gm.adjoint()) * j)), vec![]));
                }
            }
        }
    }
    let sizes: Vec<usize> = (structure.spans.iter())
        .map(|s| if !s.is_scalar() || (s.w.len() == 1 && !s.is_real()) { 1 } else { s.w.len() })
        .collect();
    let packed = |n: usize| n * (2 * n + 1);
    let starts: Vec<usize> =
        sizes.iter().scan(1 + packed(q), |at, n| Some(std::mem::replace(at, *at + packed(*n)))).collect();
    let rows = 1 + packed(q) + sizes.iter().map(|n| packed(*n)).sum::<usize>();
    let dense: Vec<Vec<f64>> = columns
        .iter()
        .map(|(trace, s, blocks)| {
            let mut column = vec![0.0; rows];
            column[0] = *trace;
            column[1..1 + s.len()].copy_from_slice(s);
            for (k, x) in blocks {
                column[starts[*k]..starts[*k] + x.len()].copy_from_slice(x);
            }
            column
        })
        .collect();
    let by_row: Vec<Vec<f64>> = (0..rows).map(|i| dense.iter().map(|c| c[i]).collect()).collect();
    let mut b = vec![0.0; rows];
    b[0] = 1.0;
    let mut objective = vec![0.0; columns.len()];
    objective[0] = -1.0;
    let mut cones = vec![SupportedConeT::ZeroConeT(1), SupportedConeT::PSDTriangleConeT(2 * q)];
    cones.extend(sizes.iter().map(|n| SupportedConeT::PSDTriangleConeT(2 * n)));
    let settings = DefaultSettingsBuilder::default().verbose(false).build().unwrap();
    let p = CscMatrix::zeros((columns.len(), columns.len()));
    let mut solver = DefaultSolver::new(&p, &objective, &CscMatrix::from(&by_row), &b, &cones, settings).unwrap();
    solver.solve();
    solver.solution.x[0]
}

/// The bound is that of the matrix inequality to 1e-5: just below it the inequality has no solution, just above one.
fn check_against_inequality(m: &Mat<c64>, blocks: &[Block], upper: f64) {
    let structure = Structure::new(blocks).unwrap();
    for (factor, has_room) in [(1.0 - 1e-5, false), (1.0 + 1e-5, true)] {
        let room = room_below(m, &structure, (upper * factor).powi(2));
        assert_eq!(room > 0.0, has_room, "{blocks:?}: {room:e} at {factor} of {upper}");
    }
}

#[test]
fn the_scale_is_that_of_the_matrix_inequality_for_blocks_of_all_shapes() {
    use muspin::robust::mu::dscale;
    let (one, full) = (Block::ComplexScalar { n: 1 }, |rows, cols| Block::ComplexFull { rows, cols });
    for (seed, blocks) in [
        vec![one; 4],
        vec![one, one, one, full(2, 3)],
        vec![full(3, 1), one, full(1, 2)],
        vec![one, one, one, one, full(5, 7)],
        vec![one; 7],
    ]
    .into_iter()
    .enumerate()
    {
        let structure = Structure::new(&blocks).unwrap();
        let m = random(seed as u64, structure.outputs(), structure.inputs());
        let fast = dscale::optimal(&m, &structure);
        assert!(fast.at_least <= fast.bound && fast.at_least > fast.bound * (1.0 - 1e-6));
        check_against_inequality(&m, &blocks, fast.bound);
    }
}

#[test]
fn the_bound_with_real_and_repeated_parameters_is_that_of_the_matrix_inequality() {
    let full = |rows, cols| Block::ComplexFull { rows, cols };
    let (real, repeated) = (|n| Block::RealScalar { n }, |n| Block::ComplexScalar { n });
    for (seed, blocks) in [
        vec![real(1), real(1), full(2, 2)],
        vec![real(2), repeated(2), full(1, 2)],
        vec![repeated(3), full(2, 1)],
        vec![real(1), real(1), real(1), real(1), real(1), full(5, 7)],
        vec![real(3), repeated(1), full(2, 2)],
    ]
    .into_iter()
    .enumerate()
    {
        let structure = Structure::new(&blocks).unwrap();
        for round in 0..4 {
            let m = random((10 * seed + round) as u64, structure.outputs(), structure.inputs());
            let (upper, scaling) = mu::upper_bound(&m, &blocks).unwrap();
            assert!((scaling.bound_at(&m) / upper - 1.0).abs() < 1e-12);
            check_against_inequality(&m, &blocks, upper);
        }
    }
}

#[test]
fn a_scale_is_proven_optimal_to_a_tenth_of_a_percent_and_no_other_reaches_below_its_certificate() {
    // What a bound of μ may be off by.
    certificates_are_within(1e-3);
}

#[test]
#[ignore = "open: with channel sizes over six decades rounding ends the method of centres with a lower bound up to \
    2e-4 below the upper one"]
fn a_scale_is_proven_optimal_to_a_hundredth_of_what_a_bound_may_be_off_by() {
    certificates_are_within(1e-5);
}

fn certificates_are_within(gap: f64) {
    use muspin::robust::mu::dscale;
    use rand::{Rng, SeedableRng};
    let mut source = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    for n in 2..=18 {
        let structure = Structure::new(&vec![Block::ComplexScalar { n: 1 }; n]).unwrap();
        for seed in 0..4 {
            // Channels whose sizes differ by decades.
            let size = |k: usize| 10f64.powf(3.0 * ((7 * k + 3 * seed) as f64).sin());
            let plain = random((100 * n + seed) as u64, n, n);
            let m = Mat::from_fn(n, n, |i, j| plain[(i, j)] * size(i));
            let found = dscale::optimal(&m, &structure);
            assert!(found.at_least <= found.bound * (1.0 + 1e-12));
            assert!(found.at_least >= found.bound * (1.0 - gap), "{n} {seed} {found:?}");
            for spread in [1e-3, 0.1, 1.0] {
                let mut factor = || (spread * (2.0 * source.random::<f64>() - 1.0)).exp();
                let other: Vec<f64> = found.d.iter().map(|d| d * factor()).collect();
                let bound = dscale::bound_scaled(&m, &structure, &other);
                assert!(bound >= found.at_least * (1.0 - 1e-12), "{n} {seed} {bound}");
            }
        }
    }
}

#[test]
fn the_largest_singular_value_is_that_of_the_general_decomposition() {
    for (rows, cols) in [(1, 1), (1, 5), (4, 4), (11, 9), (9, 11), (24, 30)] {
        for scale in [1e-290, 1e-160, 1.0, 1e160, 1e290] {
            let plain = random((rows + 100 * cols) as u64, rows, cols);
            let m = Mat::from_fn(rows, cols, |i, j| plain[(i, j)] * scale);
            let general = plain.singular_values().unwrap()[0] * scale;
            assert!((sigma_max(&m) / general - 1.0).abs() < 1e-13, "{rows}x{cols} {scale}");
        }
    }
    // Repeated values, rank one, zero.
    assert!((sigma_max(&Mat::identity(6, 6)) - 1.0).abs() < 1e-15);
    let ones = Mat::from_fn(5, 7, |_, _| c64::new(0.0, 2.0));
    assert!((sigma_max(&ones) - 2.0 * 35f64.sqrt()).abs() < 1e-13);
    assert_eq!(sigma_max(&Mat::zeros(3, 4)), 0.0);
    let mut bad = random(3, 3, 3);
    bad[(1, 2)] = c64::new(0.0, f64::NAN);
    assert!(sigma_max(&bad).is_nan());
}

#[test]
fn wrong_shapes_and_bad_numbers_are_named() {
    use muspin::robust::MuError;
    let blocks = [Block::ComplexFull { rows: 2, cols: 3 }];
    let wrong = mu::bounds(&random(1, 2, 2), &blocks);
    assert!(matches!(wrong, Err(MuError::Shape { rows: 3, cols: 2, .. })));
    assert!(matches!(mu::bounds(&random(1, 2, 2), &[]), Err(MuError::EmptyBlock { .. })));
    let mut bad = random(1, 3, 2);
    bad[(0, 0)] = c64::new(f64::NAN, 0.0);
    assert!(matches!(mu::bounds(&bad, &blocks), Err(MuError::NotFinite { .. })));
}

#[test]
fn a_settled_scale_is_as_good_as_a_proven_one_to_what_it_says() {
    use muspin::robust::mu::dscale;
    for n in 2..=14 {
        let structure = Structure::new(&vec![Block::ComplexScalar { n: 1 }; n]).unwrap();
        for seed in 0..6 {
            // Channels of like size, and of sizes that differ by decades.
            let spread = f64::from(u8::from(seed % 2 == 1)) * 2.0;
            let plain = random((1000 * n + seed) as u64, n, n);
            let size = |k: usize| 10f64.powf(spread * ((5 * k + 3 * seed) as f64).sin());
            let m = Mat::from_fn(n, n, |i, j| plain[(i, j)] * size(i));
            let (proven, settled) = (dscale::optimal(&m, &structure), dscale::settle_scaling(&m, &structure));
            let gap = settled.bound / proven.bound - 1.0;
            assert!(gap < 5e-7, "{n} {seed}: {gap:e} above");
            assert!(settled.bound >= proven.at_least * (1.0 - 1e-12));
            assert!(settled.steps <= proven.steps, "{n} {seed}: no steps are saved");
        }
    }
}

#[test]
fn mu_of_one_real_parameter_is_its_largest_real_eigenvalue() {
    let real = |rows: &[&[f64]]| Mat::from_fn(rows.len(), rows.len(), |i, j| c64::new(rows[i][j], 0.0));
    for (m, exact) in [
        (real(&[&[3.0, 1.0], &[0.0, -4.0]]), 4.0),
        // A double eigenvalue without a second eigenvector.
        (real(&[&[2.0, 1e3], &[0.0, 2.0]]), 2.0),
        // Eigenvalues ±2j and 1/2: only the last is real.
        (real(&[&[0.0, 2.0, 0.0], &[-2.0, 0.0, 0.0], &[1.0, 1.0, 0.5]]), 0.5),
        (real(&[&[0.0, 2.0], &[-2.0, 0.0]]), 0.0),
    ] {
        let found = mu::bounds(&m, &[Block::RealScalar { n: m.nrows() }]).unwrap();
        assert!((found.lower - exact).abs() < 1e-6, "{} {exact}", found.lower);
        assert!(found.upper >= exact * (1.0 - 1e-9), "{} {exact}", found.upper);
    }
}
