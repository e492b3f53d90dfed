//! Roots of polynomials whose roots are known.

use muspin::linalg::{c64, polynomial_roots};

/// Coefficients of rising powers of `lead` Π(x − r).
fn of_roots(lead: c64, roots: &[c64]) -> Vec<c64> {
    roots.iter().fold(vec![lead], |product, root| {
        let mut next = vec![c64::new(0.0, 0.0); product.len() + 1];
        for (k, c) in product.iter().enumerate() {
            next[k + 1] += c;
            next[k] -= c * root;
        }
        next
    })
}

/// Largest distance of a known root from the nearest one found, relative to its size.
fn distance(found: &[c64], known: &[c64]) -> f64 {
    let nearest = |r: &c64| {
        let each = found.iter().map(|f| (f - r).norm() / r.norm());
        each.fold(f64::INFINITY, f64::min)
    };
    known.iter().map(nearest).fold(0.0, f64::max)
}

#[test]
fn known_roots_are_found() {
    let real = |list: &[f64]| list.iter().map(|x| c64::new(*x, 0.0)).collect::<Vec<_>>();
    let pair = [c64::new(-0.3, 40.0), c64::new(-0.3, -40.0)];
    for (lead, known) in [
        (c64::new(2.0, 0.0), real(&[-1.0, -2.0, -3.0, -4.0])),
        (c64::new(-1e-3, 0.0), [real(&[-1e-4, 700.0]), pair.to_vec()].concat()),
        (c64::new(0.2, -3.0), vec![c64::new(1.0, 2.0), c64::new(-4.0, 0.5), c64::new(0.0, -30.0)]),
    ] {
        let found = polynomial_roots(&of_roots(lead, &known)).unwrap();
        assert_eq!(found.len(), known.len());
        // Coefficients known to 1e-16 and roots at distances of their own size.
        let error = distance(&found, &known);
        assert!(error < 1e-12, "{found:?}: {error:.1e}");
    }
    assert!(polynomial_roots(&[c64::new(3.0, 0.0)]).unwrap().is_empty());
    assert!(polynomial_roots(&[]).unwrap().is_empty());
}

#[test]
fn roots_of_a_real_polynomial_are_real_or_exact_pairs() {
    let known = [c64::new(-5.0, 0.0), c64::new(-1.0, 3.0), c64::new(-1.0, -3.0)];
    let found = polynomial_roots(&of_roots(c64::new(1.0, 0.0), &known)).unwrap();
    assert_eq!(found.iter().filter(|r| r.im == 0.0).count(), 1, "{found:?}");
    for root in &found {
        assert!(found.contains(&root.conj()), "{found:?}");
    }
}
