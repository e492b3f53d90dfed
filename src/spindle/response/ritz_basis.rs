//! The Ritz vectors of a shaft: quasi-static shapes of forces at ports, and of changed moduli, beside its lowest modes.

use crate::linalg::{Mat, symmetric_eigen};
use crate::rotor::modes::RIGID;
use crate::rotor::{PlanarModes, Rotor};
use crate::spindle::{Effect, EffectKind, Location, Machine, SpindleError};

/// Modes kept: of the reference shaft the fortieth lies beyond 100 kHz.
pub(super) const MODES: usize = 20;
/// Sensors and actuators may sit off their drawing by about this much of the distance between the magnets: forces there
/// are ports as well.
const BESIDE: f64 = 0.02;
/// Ritz vectors whose independent part is smaller than this (squared, relative) repeat the others.
const INDEPENDENT: f64 = 1e-8;
/// Parts of the shaft, at the ends of which forces act.
const PARTS: usize = 22;

/// Forces at ports, and at the joint, whose quasi-static shapes are coordinates.
pub(super) struct PortRows {
    rows: Vec<Vec<(usize, f64)>>,
    /// Ports of tool and planes; the others stand on a grid along the shaft.
    own: usize,
    /// Whether the last two are those of the joint.
    joint: bool,
}

impl PortRows {
    /// Whether shape `i` belongs to a port or to the joint.
    pub(super) fn first(&self, i: usize) -> bool {
        let rows = self.rows.len();
        i < self.own || (self.joint && i < rows && i + 2 >= rows)
    }
}

/// Nodes of a joint: on the tool, on the spindle.
type Ends = [usize; 2];

/// The machine with a joint of these values at the nose face.
pub(super) fn add_joint(machine: &Machine, values: [f64; 3]) -> Result<Machine, SpindleError> {
    let joint = Effect::new(EffectKind::ToolJoint, Location::None, values.to_vec())?;
    Ok(machine.clone().with_effect(joint))
}

/// Rows of tool, planes, places beside the planes, a grid along the shaft, and the joint.
pub(super) fn port_rows(machine: &Machine, rotor: &Rotor, joint: Option<Ends>) -> Result<PortRows, SpindleError> {
    let planes = &machine.spindle.planes;
    let own = [planes.front_sensor_m, planes.front_actuator_m, planes.rear_actuator_m, planes.rear_sensor_m];
    let beside_m = BESIDE * planes.bearing_span_m();
    let beside = own.iter().flat_map(|z| [z - beside_m, z + beside_m]);
    let ports: Vec<f64> = [machine.tool_plane_m(), rotor.from_m()]
        .into_iter()
        .chain(own)
        .chain(beside)
        .map(|z| z.clamp(rotor.from_m(), rotor.to_m()))
        .collect();
    let part_m = (rotor.to_m() - rotor.from_m()) / PARTS as f64;
    let grid = (0..=PARTS).map(|i| (rotor.from_m() + i as f64 * part_m).min(rotor.to_m()));
    let mut rows = vec![];
    for z in ports.iter().copied().chain(grid) {
        rows.push(rotor.shape_at("port", z)?);
    }
    if let Some([a, b]) = joint {
        rows.push(vec![(2 * a, 1.0), (2 * b, -1.0)]);
        rows.push(vec![(2 * a + 1, 1.0), (2 * b + 1, -1.0)]);
    }
    Ok(PortRows { rows, own: ports.len(), joint: joint.is_some() })
}

/// Forces at the ports, and those by which a changed modulus bends the lowest modes, dofs × forces; with the number of
/// groups. Modes below the end of a sweep, and one above, change with a modulus as the coordinates must follow.
pub(super) fn static_forces(
    rotor: &Rotor,
    modes: &PlanarModes,
    ports: &PortRows,
    group_of_element: &[usize],
    slow_rad_s: f64,
) -> (Mat<f64>, usize) {
    let count = group_of_element.iter().max().map_or(0, |g| g + 1);
    let flexible = modes.omega_rad_s.get(RIGID..).unwrap_or_default();
    let slow = flexible.iter().take_while(|w| **w < slow_rad_s).count();
    let bent = (slow + 1).min(flexible.len()).min(MODES);
    let own = ports.rows.len();
    let mut forces = Mat::zeros(rotor.dofs(), own + count * bent);
    for (c, row) in ports.rows.iter().enumerate() {
        for (dof, a) in row {
            forces[(*dof, c)] += a;
        }
    }
    for element in 0..rotor.sections().len() {
        let Some(group) = group_of(group_of_element, element) else {
            continue;
        };
        let (stiffness, dofs) = rotor.element_stiffness(element);
        for mode in 0..bent {
            for r in 0..4 {
                let force: f64 = (0..4).map(|c| stiffness[(r, c)] * modes.shapes[(dofs[c], RIGID + mode)]).sum();
                forces[(dofs[r], own + group * bent + mode)] += force;
            }
        }
    }
    (forces, count)
}

/// Group of an element of the refined shaft: every element of the file is two there.
fn group_of(group_of_element: &[usize], element: usize) -> Option<usize> {
    group_of_element.get(element / 2).copied()
}

/// The strongest directions of `statics` that `modal` does not already express, mass-orthonormal: a grid of positions
/// spans a smooth space of few dimensions.
pub(super) fn independent_part(
    modal: &Mat<f64>,
    statics: &Mat<f64>,
    mass: &Mat<f64>,
    weight: impl Fn(usize) -> f64,
    directions: usize,
) -> Result<Mat<f64>, SpindleError> {
    let shared = modal.transpose() * (mass * statics);
    let rest = statics - modal * shared;
    let gram = rest.transpose() * (mass * &rest);
    let candidates = statics.ncols();
    let scale: Vec<f64> = (0..candidates)
        .map(|i| {
            let own = gram[(i, i)].max(0.0).sqrt();
            if own > 0.0 { weight(i) / own } else { 0.0 }
        })
        .collect();
    let gram = Mat::from_fn(candidates, candidates, |i, j| gram[(i, j)] * scale[i] * scale[j]);
    let (values, vectors) = symmetric_eigen(&gram)?;
    let largest = values.last().copied().unwrap_or(0.0);
    let used: Vec<usize> =
        (0..candidates).rev().filter(|i| values[*i] > INDEPENDENT * largest).take(directions).collect();
    let combine =
        Mat::from_fn(candidates, used.len(), |i, j| scale[i] * vectors[(i, used[j])] / values[used[j]].sqrt());
    Ok(&rest * combine)
}

/// Columns of two matrices side by side.
pub(super) fn beside(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let n = a.ncols();
    Mat::from_fn(a.nrows(), n + b.ncols(), |i, j| if j < n { a[(i, j)] } else { b[(i, j - n)] })
}

/// Strains B of every element group in the coordinates `shapes`, coordinates × two per element, exactly zero for the
/// rigid ones: the stiffness of the group is B Bᵀ.
///
/// An element bends and shears: its stiffness has rank two and is K₂ᵀ K₂₂⁻¹ K₂, with K₂ its rows at one end.
pub(super) fn group_strains(
    rotor: &Rotor,
    shapes: &Mat<f64>,
    group_of_element: &[usize],
    count: usize,
) -> Vec<Mat<f64>> {
    let mut strains: Vec<Vec<Vec<f64>>> = vec![vec![]; count];
    for element in 0..rotor.sections().len() {
        let Some(group) = group_of(group_of_element, element) else {
            continue;
        };
        let (own, dofs) = rotor.element_stiffness(element);
        let row = |i: usize| -> [f64; 4] { std::array::from_fn(|j| own[(i, j)]) };
        // Rows of L⁻¹K₂, L Lᵀ = K₂₂.
        let (deflection, slope) = (row(2), row(3));
        let first = deflection.map(|k| k / deflection[2].sqrt());
        let left = (slope[3] - first[3] * first[3]).sqrt();
        let second = std::array::from_fn(|j| (slope[j] - first[3] * first[j]) / left);
        strains[group].extend([first, second].map(|strain| {
            let row: Vec<(usize, f64)> = dofs.into_iter().zip(strain).collect();
            over_coordinates(&row, shapes)
        }));
    }
    let matrix = |strains: &Vec<Vec<f64>>| {
        Mat::from_fn(shapes.ncols(), strains.len(), |i, r| if i < RIGID { 0.0 } else { strains[r][i] })
    };
    strains.iter().map(matrix).collect()
}

/// What a row over the freedoms of the shaft reads of the coordinates `shapes`.
pub(super) fn over_coordinates(row: &[(usize, f64)], shapes: &Mat<f64>) -> Vec<f64> {
    (0..shapes.ncols()).map(|k| row.iter().map(|(dof, a)| a * shapes[(*dof, k)]).sum()).collect()
}

/// The symmetric part, exactly zero for the rigid coordinates.
pub(super) fn without_rigid(a: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| if i < RIGID || j < RIGID { 0.0 } else { 0.5 * (a[(i, j)] + a[(j, i)]) })
}

/// Relative translation and rotation of a joint in the coordinates `shapes`, exactly zero for the rigid ones.
pub(super) fn joint_rows(shapes: &Mat<f64>, [a, b]: Ends) -> [Vec<f64>; 2] {
    [0, 1].map(|d| {
        (0..shapes.ncols())
            .map(|c| if c < RIGID { 0.0 } else { shapes[(2 * a + d, c)] - shapes[(2 * b + d, c)] })
            .collect()
    })
}
