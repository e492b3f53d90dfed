//! Reducible problems: strongly connected components of the signal graph of M.
//!
//! Atoms are full blocks and the single entries of repeated scalars; atom a leads to atom b where M[z_a, w_b] ≠ 0.
//! Ordered by component, M is block triangular, det(I − ΔM) is the product over the components, so μ(M) is the largest
//! of theirs.
//! The D of the whole diverges there (the bound is an infimum, a nilpotent M has μ = 0): it is built from the D of the
//! components with a ratio between them that makes the coupling negligible.

use crate::augment::Block;
use crate::linalg::{Mat, c64, max_singular_value_complex};
use crate::robust::structure::{Scaling, Span, Structure};
use std::ops::Range;

/// One strongly connected part of a problem.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    /// Its own structure.
    pub structure: Structure,
    /// Entries of w of the whole, in the order of the part.
    pub w: Vec<usize>,
    /// Entries of z of the whole, in the order of the part.
    pub z: Vec<usize>,
    /// Block of the whole that each span of the part belongs to.
    pub origin: Vec<usize>,
}

impl Component {
    /// The part of M that belongs to the component.
    pub(crate) fn part_of(&self, m: &Mat<c64>) -> Mat<c64> {
        Mat::from_fn(self.z.len(), self.w.len(), |i, j| m[(self.z[i], self.w[j])])
    }
}

struct Atom {
    span: usize,
    w: Range<usize>,
    z: Range<usize>,
}

fn atoms(structure: &Structure) -> Vec<Atom> {
    let mut list = vec![];
    for (k, span) in structure.spans.iter().enumerate() {
        if span.is_scalar() {
            list.extend(span.w.clone().zip(span.z.clone()).map(|(i, j)| Atom { span: k, w: i..i + 1, z: j..j + 1 }));
        } else {
            list.push(Atom { span: k, w: span.w.clone(), z: span.z.clone() });
        }
    }
    list
}

/// The structure with every repeated scalar split into independent complex scalars: diagonal scalings of the original.
pub(crate) fn split_scalars(structure: &Structure) -> Structure {
    let spans = atoms(structure).into_iter().map(|a| Span {
        block: Block::ComplexFull { rows: a.w.len(), cols: a.z.len() },
        w: a.w,
        z: a.z,
    });
    Structure { spans: spans.collect() }
}

/// Strongly connected components, ordered so that M is block upper triangular.
pub(crate) fn components(m: &Mat<c64>, structure: &Structure) -> Vec<Component> {
    let atoms = atoms(structure);
    let n = atoms.len();
    if (0..m.ncols()).all(|j| (0..m.nrows()).all(|i| m[(i, j)] != c64::new(0.0, 0.0))) {
        // Every atom leads to every other.
        return vec![component(&atoms.iter().collect::<Vec<_>>(), structure)];
    }
    let linked = |a: &Atom, b: &Atom| a.z.clone().any(|i| b.w.clone().any(|j| m[(i, j)] != c64::new(0.0, 0.0)));
    // reach[a][b]: b can be reached from a (Warshall; a few dozen atoms at most).
    let mut reach: Vec<Vec<bool>> =
        (0..n).map(|a| (0..n).map(|b| a == b || linked(&atoms[a], &atoms[b])).collect()).collect();
    for k in 0..n {
        let through = reach[k].clone();
        for row in &mut reach {
            if row[k] {
                for (to, via) in row.iter_mut().zip(&through) {
                    *to |= *via;
                }
            }
        }
    }
    // A component reaches strictly more atoms than every component after it.
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|a| std::cmp::Reverse(reach[*a].iter().filter(|r| **r).count()));
    let mut done = vec![false; n];
    let mut parts = vec![];
    for a in order {
        if done[a] {
            continue;
        }
        let members: Vec<&Atom> =
            (0..n).filter(|b| reach[a][*b] && reach[*b][a]).inspect(|b| done[*b] = true).map(|b| &atoms[b]).collect();
        parts.push(component(&members, structure));
    }
    parts
}

fn component(members: &[&Atom], structure: &Structure) -> Component {
    let (mut w, mut z, mut origin) = (vec![], vec![], vec![]);
    let mut spans: Vec<Span> = vec![];
    for atom in members {
        let (w0, z0) = (w.len(), z.len());
        w.extend(atom.w.clone());
        z.extend(atom.z.clone());
        match (spans.last_mut(), origin.last()) {
            (Some(last), Some(k)) if *k == atom.span => {
                last.w.end = w.len();
                last.z.end = z.len();
            }
            _ => {
                origin.push(atom.span);
                spans.push(Span { block: structure.spans[atom.span].block, w: w0..w.len(), z: z0..z.len() });
            }
        }
    }
    for span in &mut spans {
        span.block = match span.block {
            Block::ComplexScalar { .. } => Block::ComplexScalar { n: span.w.len() },
            Block::RealScalar { .. } => Block::RealScalar { n: span.w.len() },
            full => full,
        };
    }
    Component { structure: Structure { spans }, w, z, origin }
}

/// The scaling of the whole from those of the components, with factors between them that suppress the coupling.
pub(crate) fn assemble(
    m: &Mat<c64>,
    structure: &Structure,
    parts: &[(Component, Scaling)],
    largest_bound: f64,
    coupling: f64,
) -> Scaling {
    let mut whole = Scaling::identity(structure);
    // What is left of the coupling adds at most its own size to the bound.
    let allowed =
        if largest_bound > 0.0 { coupling * largest_bound } else { 0.01 * coupling * max_singular_value_complex(m) };
    let mut factors: Vec<f64> = vec![];
    for (k, (part, scaling)) in parts.iter().enumerate() {
        let right = crate::linalg::hermitian::inverse_complex(&scaling.right);
        let mut factor: f64 = 1.0;
        for ((before, above), earlier) in parts[..k].iter().zip(&factors) {
            let coupling = Mat::from_fn(before.z.len(), part.w.len(), |i, j| m[(before.z[i], part.w[j])]);
            let size = (&above.left * coupling * &right).norm_l2();
            if size > 0.0 {
                factor = factor.max(earlier * size / allowed);
            }
        }
        // Beyond this range the scaled matrix itself would overflow; the bound is evaluated with what is reached.
        let factor = factor.min(1e140);
        factors.push(factor);
        place(&mut whole.left, &part.z, &part.z, &scaling.left, factor);
        place(&mut whole.right, &part.w, &part.w, &scaling.right, factor);
        place(&mut whole.skew, &part.w, &part.z, &scaling.skew, 1.0);
    }
    whole
}

fn place(into: &mut Mat<c64>, rows: &[usize], cols: &[usize], part: &Mat<c64>, factor: f64) {
    for (i, r) in rows.iter().enumerate() {
        for (j, c) in cols.iter().enumerate() {
            into[(*r, *c)] = part[(i, j)] * factor;
        }
    }
}
