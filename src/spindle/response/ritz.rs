//! The free-free shaft in Ritz coordinates in which moduli, joint and ports can move without a new FE assembly.
//!
//! Every element of the file is halved, and what a finer mesh would change is kept as a number of its own
//! (`mesh_correction`), so that the mesh of the model is not what the data complain about. The coordinates are
//! the lowest modes and the quasi-static shapes (K + s²M)⁻¹b of forces at the ports, mass-orthonormal:  K = K₀ + Σ e_g
//! K_g (+ k_t tᵀt + k_r rᵀr of the joint), M = I. The first two coordinates are the exact rigid modes. Limits: valid up
//! to about the highest kept mode; the end of a sweep lies far below.

use super::condensation::Condensation;
use super::mesh_correction;
use super::ritz_basis::{
    MODES, add_joint, beside, group_strains, independent_part, joint_rows, over_coordinates, port_rows, static_forces,
    without_rigid,
};
use super::shaft_modes::frequency;
use crate::linalg::{Mat, solve, symmetric_eigen};
use crate::rotor::modes::RIGID;
use crate::rotor::tilt::Tilt;
use crate::rotor::{PlanarModes, Rotor};
use crate::spindle::band::sweep_end_rad_s;
use crate::spindle::halved::refine_mesh;
use crate::spindle::{Machine, SpindleError};
use std::ops::Range;

/// Shift of the quasi-static shapes, rad/s: makes the free shaft's stiffness invertible; any value far below the kept
/// modes' range serves.
const SHIFT_RAD_S: f64 = 2000.0;
/// A joint as good as rigid, in E·d and E·d³ of the nose: a hundred times the stiffest tool interface, far from the
/// rounding of the shaft's own stiffness.
const RIGID_JOINT: [f64; 2] = [100.0, 40.0];
/// Modes of the shaft with a rigid joint beside those of the loose one: a joint of any stiffness lies between the two.
const RIGID_JOINT_MODES: usize = 12;
/// Quasi-static directions kept: the ports of one shaft span few.
const STATIC_DIRECTIONS: usize = 56;
/// Part of a group's influence on slow motion below which a strain is left out of derivatives.
const NO_STRAIN: f64 = 1e-4;
/// How much more the shapes of the ports and of the joint count, so that none of them is lost among the others.
const PORT_WEIGHT: f64 = 10.0;
/// Joint with which the coordinates are made, in the same units: it shapes them only, not what they can express.
const JOINT_START: [f64; 2] = [0.02, 0.004];

/// Reduced matrices of a shaft, and what its ports see.
#[derive(Clone, Debug)]
pub(crate) struct ReducedShaft {
    rotor: Rotor,
    /// The same with the elements of the file.
    file: Rotor,
    shapes: Mat<f64>,
    /// Flexibility that the coordinates leave out, over the freedoms of the shaft.
    left_out: Mat<f64>,
    /// Stiffness with every modulus factor 1 and without the movable joint, n×n.
    pub stiffness: Mat<f64>,
    /// Stiffness of each element group, n×n.
    pub groups: Vec<Mat<f64>>,
    /// What a mesh twice as fine adds to the flexibility under inertia, n×n: Z = K − ω²M − ω⁴ C.
    pub mesh: Mat<f64>,
    /// Strains v of all groups and of the mesh, K_g = Σ v vᵀ: coordinates × strains.
    pub strains: Mat<f64>,
    /// Which of them belong to a group; the last are those of the mesh.
    pub strains_of_group: Vec<Range<usize>>,
    pub gyroscopic: Mat<f64>,
    /// Relative translation and rotation of the movable joint, if there is one.
    pub joint: Option<[Vec<f64>; 2]>,
    /// True flexible modes of the nominal shaft, rad/s.
    pub flexible_rad_s: Vec<f64>,
    /// Which coordinates follow the others, without a movable joint.
    pub(super) condensation: Option<Condensation>,
}

/// Largest s(1−s)(1−2s), at s = (3 − √3)/6: √3/18.
const MOST_MISREAD: f64 = 0.096_225;

impl ReducedShaft {
    /// The shaft of `machine` (with the effects it has); `movable_joint` cuts it at the nose face.
    pub(crate) fn new(
        machine: &Machine,
        group_of_element: &[usize],
        movable_joint: bool,
    ) -> Result<Self, SpindleError> {
        let fine = refine_mesh(machine);
        let at_nose = |shares: [f64; 2]| {
            let [translation, turning] = machine.spindle.joint_at_nose(shares);
            [translation, turning, 0.0]
        };
        let start = at_nose(JOINT_START);
        let with_joint =
            |machine: &Machine| if movable_joint { add_joint(machine, start) } else { Ok(machine.clone()) };
        let file = with_joint(machine)?.rotor()?;
        let machine = with_joint(&fine)?;
        let rotor = machine.rotor()?;
        let modes = PlanarModes::new(&rotor)?;
        let flexible_rad_s = modes.omega_rad_s[RIGID..].to_vec();
        let slow_rad_s = sweep_end_rad_s(&machine, &flexible_rad_s);
        let (k, m) = (&modes.matrices.stiffness, &modes.matrices.mass);
        let kept = (RIGID + MODES).min(modes.len());
        let joint = movable_joint.then(|| rotor.joints().last().map(|j| j.0)).flatten();
        let ports = port_rows(&machine, &rotor, joint)?;
        let (forces, count) = static_forces(&rotor, &modes, &ports, group_of_element, slow_rad_s);
        let shifted = Mat::from_fn(k.nrows(), k.ncols(), |i, j| k[(i, j)] + SHIFT_RAD_S * SHIFT_RAD_S * m[(i, j)]);
        let mut statics = solve(&shifted, &forces)?;
        let mut directions = STATIC_DIRECTIONS;
        if movable_joint {
            let stiff = PlanarModes::new(&add_joint(&fine, at_nose(RIGID_JOINT))?.rotor()?)?;
            let count = RIGID_JOINT_MODES.min(stiff.len().saturating_sub(RIGID));
            statics = beside(&statics, &stiff.shapes.submatrix(0, RIGID, stiff.shapes.nrows(), count).to_owned());
            directions += count;
        }
        let modal = modes.shapes.submatrix(0, 0, k.nrows(), kept).to_owned();
        let weight = |i: usize| if ports.first(i) { PORT_WEIGHT } else { 1.0 };
        let extra = independent_part(&modal, &statics, m, weight, directions)?;
        let (shapes, own_rad_s) = by_frequency(&beside(&modal, &extra), k)?;
        let left_out = left_out(&shifted, &shapes)?;
        let own_strains = group_strains(&rotor, &shapes, group_of_element, count);
        let finer = refine_mesh(&machine).rotor()?;
        let mesh = mesh_correction::flexibility(&rotor, &finer, &shapes)?;
        let joint = joint.map(|ends| joint_rows(&shapes, ends));
        let reduce = |a: &Mat<f64>| shapes.transpose() * (a * &shapes);
        let mut stiffness = without_rigid(&reduce(k));
        for (row, value) in joint.iter().flatten().zip(start) {
            let n = stiffness.nrows();
            stiffness = Mat::from_fn(n, n, |i, j| stiffness[(i, j)] - value * row[i] * row[j]);
        }
        let (strains, strains_of_group) = strains(&own_strains, &mesh, &stiffness, slow_rad_s)?;
        let groups = own_strains.iter().map(|b| b * b.transpose()).collect();
        let condensation = match joint {
            None => Some(Condensation::new(&own_rad_s, slow_rad_s)),
            // With a joint of any stiffness, fast coordinates need not stay fast.
            Some(_) => None,
        };
        Ok(Self {
            mesh,
            gyroscopic: reduce(&modes.matrices.gyroscopic),
            flexible_rad_s,
            rotor,
            file,
            shapes,
            left_out,
            stiffness,
            groups,
            strains,
            strains_of_group,
            joint,
            condensation,
        })
    }

    pub(crate) fn len(&self) -> usize {
        self.shapes.ncols()
    }

    /// First and last position on the shaft, m.
    pub(crate) fn span_m(&self) -> (f64, f64) {
        (self.rotor.from_m(), self.rotor.to_m())
    }

    /// What a port at a position reads of the coordinates.
    pub(crate) fn row(&self, position_m: f64) -> Result<Vec<f64>, SpindleError> {
        Ok(self.reduce_row(&self.rotor.shape_at("port", position_m)?))
    }

    /// What a port that turns with the shaft at a position reads of the coordinates.
    pub(crate) fn slope_row(&self, position_m: f64) -> Result<Vec<f64>, SpindleError> {
        Ok(self.reduce_row(&self.rotor.slope_at("port", position_m)?))
    }

    /// What reads the rotation of the section at a position, of the coordinates, and its derivative along the shaft.
    pub(crate) fn rotation_rows(&self, position_m: f64) -> Result<[Vec<f64>; 2], SpindleError> {
        Ok(self.rotor.rotation_at("port", position_m)?.map(|row| self.reduce_row(&row)))
    }

    /// What a moment at a position acts on, with the flexibility that the coordinates do not show.
    pub(crate) fn tilt_at(&self, position_m: f64) -> Result<Tilt, SpindleError> {
        let tilt = self.file.tilt_at("port", position_m)?;
        let dofs = self.ends(tilt.element);
        let form = |a: &[f64; 4], b: &[f64; 4]| -> f64 {
            let own = |i: usize, j: usize| a[i] * self.left_out[(dofs[i], dofs[j])] * b[j];
            (0..4).flat_map(|i| (0..4).map(move |j| own(i, j))).sum()
        };
        let more = (form(&tilt.row, &tilt.row), 2.0 * form(&tilt.along, &tilt.row));
        Ok(tilt.softer(more.0, more.1))
    }

    /// What a moment at a position acts on, over the coordinates.
    pub(crate) fn tilt_row(&self, position_m: f64) -> Result<Vec<f64>, SpindleError> {
        let tilt = self.file.tilt_at("port", position_m)?;
        Ok(self.over_ends(tilt.element, tilt.row))
    }

    /// The derivative of [`Self::tilt_row`] to the position.
    pub(crate) fn tilt_along_row(&self, position_m: f64) -> Result<Vec<f64>, SpindleError> {
        let tilt = self.file.tilt_at("port", position_m)?;
        Ok(self.over_ends(tilt.element, tilt.along))
    }

    /// Freedoms of the ends of an element of the file, of which there are two here.
    fn ends(&self, element: usize) -> [usize; 4] {
        let [w1, psi1, _, _] = self.rotor.element_dofs(2 * element);
        let [_, _, w2, psi2] = self.rotor.element_dofs(2 * element + 1);
        [w1, psi1, w2, psi2]
    }

    fn over_ends(&self, element: usize, row: [f64; 4]) -> Vec<f64> {
        let pairs: Vec<(usize, f64)> = self.ends(element).into_iter().zip(row).collect();
        self.reduce_row(&pairs)
    }

    /// What another mesh may read more or less at a position between the nodes of the file, one unit; none on a node.
    ///
    /// Cubic functions with the rotations ψ as slopes leave out the shear angle γ: of an element of length L the
    /// deflection misses γL s(1−s)(1−2s), at most 0.096 γL, and near a node γ times the distance from it. Every mesh
    /// that has the nodes of the file stays within that, and so does the shaft.
    pub(crate) fn misread(&self, position_m: f64) -> Result<Option<Vec<f64>>, SpindleError> {
        let (element, s) = self.rotor.element_at("port", position_m)?;
        let Some(section) = self.rotor.sections().get(element) else {
            return Ok(None);
        };
        // Every element of the file is two here.
        let from_node = if element % 2 == 0 { s } else { 1.0 - s };
        if from_node == 0.0 {
            return Ok(None);
        }
        let unit = from_node.min(MOST_MISREAD) * section.length_m;
        let row = self.reduce_row(&self.rotor.shear(element));
        Ok(Some(row.iter().map(|shear| unit * shear).collect()))
    }

    fn reduce_row(&self, row: &[(usize, f64)]) -> Vec<f64> {
        over_coordinates(row, &self.shapes)
    }
}

/// Strains of the groups and of the mesh, coordinates × strains, and the columns of each: those of a group in
/// directions that do not repeat each other. Strains that move slow coordinates next to nothing are left out.
fn strains(
    groups: &[Mat<f64>],
    mesh: &Mat<f64>,
    stiffness: &Mat<f64>,
    slow_rad_s: f64,
) -> Result<(Mat<f64>, Vec<Range<usize>>), SpindleError> {
    let (mut columns, mut ranges): (Vec<Vec<f64>>, _) = (vec![], vec![]);
    let n = mesh.nrows();
    let scale: Vec<f64> = (0..n).map(|k| (slow_rad_s * slow_rad_s + stiffness[(k, k)].max(0.0)).recip()).collect();
    let mut add = |values: &[f64], strains: &Mat<f64>| {
        let largest = values.last().copied().unwrap_or_default();
        let from = columns.len();
        let large = |k: &usize| values[*k] > NO_STRAIN * largest;
        let column = |k: usize| strains.col_as_slice(k).to_vec();
        columns.extend((0..values.len()).filter(large).map(column));
        ranges.push(from..columns.len());
    };
    for own in groups {
        // With S the scales, S B Bᵀ S and (S B)ᵀ S B have the same eigenvalues but for zeros, and B times an
        // eigenvector of the second is the strain of its eigenvalue.
        let scaled = Mat::from_fn(n, own.ncols(), |i, r| scale[i] * own[(i, r)]);
        let (values, vectors) = symmetric_eigen(&(scaled.transpose() * &scaled))?;
        add(&values, &(own * vectors));
    }
    let scaled = Mat::from_fn(n, n, |i, j| mesh[(i, j)] * scale[i] * scale[j]);
    let (values, vectors) = symmetric_eigen(&scaled)?;
    let strain = |i: usize, k: usize| values[k].max(0.0).sqrt() * vectors[(i, k)] / scale[i];
    add(&values, &Mat::from_fn(n, n, strain));
    let matrix = Mat::from_fn(n, columns.len(), |i, j| columns[j][i]);
    Ok((matrix, ranges))
}

/// Flexibility of `matrix` less that within the span of `shapes`: what loads move that the shapes do not follow.
fn left_out(matrix: &Mat<f64>, shapes: &Mat<f64>) -> Result<Mat<f64>, SpindleError> {
    let n = matrix.nrows();
    let all = solve(matrix, &Mat::identity(n, n))?;
    let within = solve(&(shapes.transpose() * (matrix * shapes)), &shapes.transpose().to_owned())?;
    Ok(all - shapes * within)
}

/// Coordinates that span the same as `shapes`, ordered by the frequencies, rad/s, that they have among themselves; the
/// rigid ones stay as they are.
fn by_frequency(shapes: &Mat<f64>, stiffness: &Mat<f64>) -> Result<(Mat<f64>, Vec<f64>), SpindleError> {
    let flexible = shapes.subcols(RIGID, shapes.ncols() - RIGID).to_owned();
    let among = flexible.transpose() * (stiffness * &flexible);
    let (squares, turn) = symmetric_eigen(&among)?;
    let rigid = shapes.subcols(0, RIGID).to_owned();
    let mut own_rad_s = vec![0.0; RIGID];
    own_rad_s.extend(squares.iter().map(|square| frequency(*square)));
    Ok((beside(&rigid, &(flexible * turn)), own_rad_s))
}
