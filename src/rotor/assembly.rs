//! A shaft: elements in a row with discs, point masses and flexible joints, assembled into the matrices of one plane.
//! Node i has the dofs 2i (w, m) and 2i+1 (ψ, rad). The joint of two shafts has two nodes at one position.

use super::element::{self, ElementMatrices};
use super::section::{Disc, Section};
use super::{MOST_ELEMENTS, RotorError, check_lengths};
use crate::linalg::Mat;

/// A disc's position may differ from its node's by this much, m: positions are sums of printed lengths.
pub(crate) const NODE_TOLERANCE_M: f64 = 1e-6;

/// Springs between two shafts that meet at one position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Translational stiffness, N/m.
    pub translational_n_per_m: f64,
    /// Rotational stiffness, N m/rad.
    pub rotational_n_m_per_rad: f64,
    /// Rotational damping, N m s/rad.
    pub damping_n_m_s_per_rad: f64,
}

/// Matrices of one plane, n×n with n = 2 × nodes.
#[derive(Clone, Debug)]
pub struct PlaneMatrices {
    /// Mass of shaft and discs.
    pub mass: Mat<f64>,
    /// Stiffness of shaft and joints.
    pub stiffness: Mat<f64>,
    /// Gyroscopic matrix of shaft and discs, per rad/s; couples the planes (see [`crate::rotor`]).
    pub gyroscopic: Mat<f64>,
    /// Mass of the beam elements alone.
    pub shaft_mass: Mat<f64>,
    /// Viscous damping of the joints.
    pub joint_damping: Mat<f64>,
}

/// Rigid-body properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of gravity, m from the nose face.
    pub centre_of_gravity_m: f64,
    /// Moment of inertia about the axis, kg m².
    pub polar_inertia_kg_m2: f64,
    /// Moment of inertia about a diameter through the centre of gravity, kg m².
    pub diametral_inertia_kg_m2: f64,
}

/// A shaft that keeps every rule of its parts.
#[derive(Clone, Debug)]
pub struct Rotor {
    sections: Vec<Section>,
    elements: Vec<ElementMatrices>,
    /// Left and right node of each element.
    element_nodes: Vec<[usize; 2]>,
    node_z_m: Vec<f64>,
    discs: Vec<(usize, Disc)>,
    joints: Vec<([usize; 2], Joint)>,
    /// Discs that need not stand on a node.
    added: Vec<Disc>,
}

impl Rotor {
    /// A shaft from z = `origin_m` on, with discs on its nodes.
    ///
    /// # Errors
    /// [`RotorError`] naming the element or disc that breaks a rule.
    pub fn new(origin_m: f64, sections: Vec<Section>, discs: &[Disc]) -> Result<Self, RotorError> {
        if sections.is_empty() {
            return Err(RotorError::NoElements);
        }
        check_lengths([sections.len(), discs.len()], MOST_ELEMENTS)?;
        let mut node_z_m = vec![origin_m];
        let mut z = origin_m;
        for (index, section) in sections.iter().enumerate() {
            section.validate(index)?;
            z += section.length_m;
            node_z_m.push(z);
        }
        let mut placed = Vec::with_capacity(discs.len());
        for (index, disc) in discs.iter().enumerate() {
            let node = place(&node_z_m, index, disc)?;
            placed.push((node, *disc));
        }
        Ok(Self {
            elements: sections.iter().map(element::matrices).collect(),
            element_nodes: (0..sections.len()).map(|i| [i, i + 1]).collect(),
            sections,
            node_z_m,
            discs: placed,
            joints: vec![],
            added: vec![],
        })
    }

    /// What each element and disc of a list breaks; positions of discs are judged on elements that are right.
    pub(crate) fn broken_rules(sections: &[Section], discs: &[Disc]) -> Vec<RotorError> {
        let checked = sections.iter().enumerate().map(|(index, section)| section.validate(index));
        let mut broken: Vec<RotorError> = checked.filter_map(Result::err).collect();
        let mut node_z_m = vec![0.0];
        for section in sections {
            node_z_m.push(node_z_m.last().copied().unwrap_or_default() + section.length_m);
        }
        let is_whole = broken.is_empty();
        broken.extend(discs.iter().enumerate().filter_map(|(index, disc)| {
            if is_whole { place(&node_z_m, index, disc).map(drop).err() } else { disc.validate(index).err() }
        }));
        broken
    }

    /// `left` and `right` end to end, rigidly or through springs; `right` must begin where `left` ends.
    pub(crate) fn join(left: &Self, right: &Self, joint: Option<Joint>) -> Result<Self, RotorError> {
        let gap = right.from_m() - left.to_m();
        if gap.abs() > NODE_TOLERANCE_M {
            return Err(RotorError::Part {
                what: "gap between the joined shafts (m)".into(),
                value: gap,
                rule: "must be zero".into(),
            });
        }
        if let Some(joint) = joint {
            check_joint(&joint)?;
        }
        let mut rotor = left.clone();
        let shift = left.node_z_m.len() - usize::from(joint.is_none());
        if joint.is_none() {
            rotor.node_z_m.pop();
        }
        rotor.node_z_m.extend(&right.node_z_m);
        let moved = |pair: &[usize; 2]| [pair[0] + shift, pair[1] + shift];
        rotor.sections.extend(right.sections.iter().cloned());
        rotor.elements.extend(right.elements.iter().cloned());
        rotor.element_nodes.extend(right.element_nodes.iter().map(moved));
        rotor.discs.extend(right.discs.iter().map(|(n, d)| (n + shift, *d)));
        rotor.joints.extend(right.joints.iter().map(|(n, j)| (moved(n), *j)));
        rotor.added.extend(&right.added);
        if let Some(joint) = joint {
            rotor.joints.push(([shift - 1, shift], joint));
        }
        Ok(rotor)
    }

    /// The same shaft with a disc anywhere on it; its mass may be negative.
    pub(crate) fn with_added_disc(mut self, disc: Disc) -> Result<Self, RotorError> {
        self.check_position("added disc", disc.position_m)?;
        let bad = |what: &str, value, rule: &str| RotorError::Part { what: what.into(), value, rule: rule.into() };
        if !disc.mass_kg.is_finite() {
            return Err(bad("added mass (kg)", disc.mass_kg, "must be a number"));
        }
        for inertia in [disc.polar_inertia_kg_m2, disc.diametral_inertia_kg_m2] {
            if !(inertia.is_finite() && inertia >= 0.0) {
                return Err(bad("inertia of an added disc (kg m²)", inertia, "must be zero or a positive number"));
            }
        }
        self.added.push(disc);
        Ok(self)
    }

    /// Sections from the tool end to the tail.
    pub(crate) fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Axial positions of the nodes, m from the nose face; a joint has two at one position.
    pub(crate) fn node_positions_m(&self) -> &[f64] {
        &self.node_z_m
    }

    /// Position of the tool end, m.
    pub fn from_m(&self) -> f64 {
        self.node_z_m.first().copied().unwrap_or_default()
    }

    /// Position of the tail end, m.
    pub fn to_m(&self) -> f64 {
        self.node_z_m.last().copied().unwrap_or_default()
    }

    /// Number of dofs of one plane.
    pub fn dofs(&self) -> usize {
        2 * self.node_z_m.len()
    }

    /// Stiffness matrix of element `i` (with its modulus scale) and the dofs it acts on; ∂K/∂factor of a region is the
    /// sum of its elements' matrices over the factor.
    pub(crate) fn element_stiffness(&self, i: usize) -> (&element::Matrix, [usize; 4]) {
        (&self.elements[i].stiffness, self.element_dofs(i))
    }

    /// Joints with the pairs of nodes they connect.
    pub fn joints(&self) -> &[([usize; 2], Joint)] {
        &self.joints
    }

    /// The same shaft with every element's modulus scale multiplied: `factor(i, section)`.
    ///
    /// # Errors
    /// [`RotorError::Element`] when a product is not a positive number.
    pub fn with_modulus_factors(&self, factor: impl Fn(usize, &Section) -> f64) -> Result<Self, RotorError> {
        let mut rotor = self.clone();
        for i in 0..rotor.sections.len() {
            let by = factor(i, &self.sections[i]);
            rotor.sections[i].modulus_scale *= by;
            rotor.sections[i].validate(i)?;
            rotor.elements[i].stiffness *= by;
        }
        Ok(rotor)
    }

    /// The same shaft with every section changed.
    pub(crate) fn with_sections(&self, change: impl Fn(&mut Section)) -> Result<Self, RotorError> {
        let mut rotor = self.clone();
        for (i, section) in rotor.sections.iter_mut().enumerate() {
            change(section);
            section.validate(i)?;
            rotor.elements[i] = element::matrices(section);
        }
        Ok(rotor)
    }

    /// The same shaft with mass and inertia of every disc multiplied; none without discs.
    pub(crate) fn with_disc_factor(&self, factor: f64) -> Option<Self> {
        let mut rotor = self.clone();
        for (_, disc) in &mut rotor.discs {
            disc.mass_kg *= factor;
            disc.polar_inertia_kg_m2 *= factor;
            disc.diametral_inertia_kg_m2 *= factor;
        }
        (!rotor.discs.is_empty()).then_some(rotor)
    }

    /// Assembled matrices of one plane.
    pub fn plane_matrices(&self) -> PlaneMatrices {
        let n = self.dofs();
        let mut stiffness = Mat::zeros(n, n);
        let mut gyroscopic = Mat::zeros(n, n);
        let mut shaft_mass = Mat::zeros(n, n);
        let mut joint_damping = Mat::zeros(n, n);
        for (i, part) in self.elements.iter().enumerate() {
            let dofs = self.element_dofs(i);
            for (r, row) in dofs.into_iter().enumerate() {
                for (c, col) in dofs.into_iter().enumerate() {
                    shaft_mass[(row, col)] += part.mass[(r, c)];
                    stiffness[(row, col)] += part.stiffness[(r, c)];
                    gyroscopic[(row, col)] += part.gyroscopic[(r, c)];
                }
            }
        }
        let mut mass = shaft_mass.clone();
        for (node, disc) in &self.discs {
            mass[(2 * node, 2 * node)] += disc.mass_kg;
            mass[(2 * node + 1, 2 * node + 1)] += disc.diametral_inertia_kg_m2;
            gyroscopic[(2 * node + 1, 2 * node + 1)] += disc.polar_inertia_kg_m2;
        }
        let carry = |m: &mut Mat<f64>, row: &[(usize, f64)], value: f64| {
            for (i, a) in row {
                for (j, b) in row {
                    m[(*i, *j)] += value * a * b;
                }
            }
        };
        for disc in &self.added {
            let [rotation, _] = self.rotation_at_unchecked(disc.position_m);
            carry(&mut mass, &self.shape_at_unchecked(disc.position_m), disc.mass_kg);
            carry(&mut mass, &rotation, disc.diametral_inertia_kg_m2);
            carry(&mut gyroscopic, &rotation, disc.polar_inertia_kg_m2);
        }
        let spring = |m: &mut Mat<f64>, a: usize, b: usize, k: f64| {
            m[(a, a)] += k;
            m[(b, b)] += k;
            m[(a, b)] -= k;
            m[(b, a)] -= k;
        };
        for ([a, b], joint) in &self.joints {
            let (wa, wb) = (2 * a, 2 * b);
            spring(&mut stiffness, wa, wb, joint.translational_n_per_m);
            spring(&mut stiffness, wa + 1, wb + 1, joint.rotational_n_m_per_rad);
            spring(&mut joint_damping, wa + 1, wb + 1, joint.damping_n_m_s_per_rad);
        }
        PlaneMatrices { mass, stiffness, gyroscopic, shaft_mass, joint_damping }
    }

    /// Mass, centre of gravity and moments of inertia.
    pub fn mass_properties(&self) -> MassProperties {
        let matrices = self.plane_matrices();
        self.properties_from(&matrices)
    }

    pub(super) fn properties_from(&self, matrices: &PlaneMatrices) -> MassProperties {
        let n = self.dofs();
        let shift = Mat::from_fn(n, 1, |i, _| if i % 2 == 0 { 1.0 } else { 0.0 });
        let tilt = Mat::from_fn(n, 1, |i, _| if i % 2 == 0 { self.node_z_m[i / 2] } else { 1.0 });
        let form = |a: &Mat<f64>, b: &Mat<f64>| (a.transpose() * &matrices.mass * b)[(0, 0)];
        let mass_kg = form(&shift, &shift);
        let centre = form(&shift, &tilt) / mass_kg;
        // About the centre of gravity from the start: no difference of large numbers.
        let about = Mat::from_fn(n, 1, |i, _| if i % 2 == 0 { self.node_z_m[i / 2] - centre } else { 1.0 });
        let shaft: f64 = self.elements.iter().map(|e| e.polar_inertia_kg_m2).sum();
        let discs = self.discs.iter().map(|(_, disc)| disc).chain(&self.added);
        let discs: f64 = discs.map(|disc| disc.polar_inertia_kg_m2).sum();
        MassProperties {
            mass_kg,
            centre_of_gravity_m: centre,
            polar_inertia_kg_m2: shaft + discs,
            diametral_inertia_kg_m2: form(&about, &about),
        }
    }

    /// Row of shape functions that reads the deflection at `position_m` from the dofs of a plane (and, transposed, puts
    /// a force there): pairs (dof, coefficient). At a joint, the tail side.
    ///
    /// # Errors
    /// [`RotorError::OffShaft`] beyond the ends.
    pub fn shape_at(&self, what: &str, position_m: f64) -> Result<Vec<(usize, f64)>, RotorError> {
        self.check_position(what, position_m)?;
        Ok(self.shape_at_unchecked(position_m))
    }

    /// The element at a position and the place in it, s = z/L; on a node within the tolerance of positions the node
    /// itself.
    pub(crate) fn element_at(&self, what: &str, position_m: f64) -> Result<(usize, f64), RotorError> {
        self.check_position(what, position_m)?;
        Ok(self.element_at_unchecked(position_m))
    }

    /// Shear angle of element `i`: its dofs with their coefficients.
    pub(crate) fn shear(&self, i: usize) -> Vec<(usize, f64)> {
        let coefficients = element::shear(&self.sections[i]);
        self.element_dofs(i).into_iter().zip(coefficients).collect()
    }

    /// Row that reads the slope of the deflection at a position, on a node its rotation; transposed, it puts a moment
    /// there.
    pub(crate) fn slope_at(&self, what: &str, position_m: f64) -> Result<Vec<(usize, f64)>, RotorError> {
        self.check_position(what, position_m)?;
        Ok(self.read_element(position_m, element::hermite_slope))
    }

    /// Rows that read the rotation of the section at a position and its derivative along the shaft; transposed, the
    /// first puts a moment there.
    pub(crate) fn rotation_at(&self, what: &str, position_m: f64) -> Result<[Vec<(usize, f64)>; 2], RotorError> {
        self.check_position(what, position_m)?;
        Ok(self.rotation_at_unchecked(position_m))
    }

    fn rotation_at_unchecked(&self, position_m: f64) -> [Vec<(usize, f64)>; 2] {
        let (element, s) = self.element_at_unchecked(position_m);
        let dofs = self.element_dofs(element);
        element::rotation(&self.sections[element], s).map(|row| dofs.into_iter().zip(row).collect())
    }

    fn shape_at_unchecked(&self, position_m: f64) -> Vec<(usize, f64)> {
        self.read_element(position_m, element::hermite)
    }

    fn read_element(&self, position_m: f64, coefficients: fn(f64, f64) -> [f64; 4]) -> Vec<(usize, f64)> {
        let (element, s) = self.element_at_unchecked(position_m);
        let coefficients = coefficients(s, self.sections[element].length_m);
        self.element_dofs(element).into_iter().zip(coefficients).filter(|(_, c)| *c != 0.0).collect()
    }

    fn element_at_unchecked(&self, position_m: f64) -> (usize, f64) {
        let element = (0..self.sections.len())
            .rev()
            .find(|i| self.node_z_m[self.element_nodes[*i][0]] <= position_m + NODE_TOLERANCE_M)
            .unwrap_or(0);
        let left = self.node_z_m[self.element_nodes[element][0]];
        let length = self.sections[element].length_m;
        let mut s = (position_m - left) / length;
        if (s * length).abs() < NODE_TOLERANCE_M {
            s = 0.0;
        } else if ((s - 1.0) * length).abs() < NODE_TOLERANCE_M {
            s = 1.0;
        }
        (element, s)
    }

    /// Freedoms (w₁, ψ₁, w₂, ψ₂) of element `i`.
    pub(crate) fn element_dofs(&self, i: usize) -> [usize; 4] {
        let [a, b] = self.element_nodes[i];
        [2 * a, 2 * a + 1, 2 * b, 2 * b + 1]
    }

    fn check_position(&self, what: &str, position_m: f64) -> Result<(), RotorError> {
        let (from_m, to_m) = (self.from_m(), self.to_m());
        if position_m >= from_m - NODE_TOLERANCE_M && position_m <= to_m + NODE_TOLERANCE_M {
            return Ok(());
        }
        Err(RotorError::OffShaft { what: what.to_owned(), position_m, from_m, to_m })
    }
}

fn place(node_z_m: &[f64], index: usize, disc: &Disc) -> Result<usize, RotorError> {
    disc.validate(index)?;
    let node = nearest(node_z_m, disc.position_m);
    let off = (node_z_m[node] - disc.position_m).abs();
    if off.is_nan() || off > NODE_TOLERANCE_M {
        return Err(RotorError::Disc {
            index,
            field: "position_m",
            value: disc.position_m,
            rule: format!("is not on a node; the nearest node is at {:.6}", node_z_m[node]),
        });
    }
    Ok(node)
}

fn check_joint(joint: &Joint) -> Result<(), RotorError> {
    let stiff = [
        ("translational_n_per_m", joint.translational_n_per_m),
        ("rotational_n_m_per_rad", joint.rotational_n_m_per_rad),
    ];
    for (what, value) in stiff {
        if !(value.is_finite() && value > 0.0) {
            return Err(RotorError::Part {
                what: format!("joint {what}"),
                value,
                rule: "must be a positive number".into(),
            });
        }
    }
    if !joint.damping_n_m_s_per_rad.is_finite() {
        return Err(RotorError::Part {
            what: "joint damping_n_m_s_per_rad".into(),
            value: joint.damping_n_m_s_per_rad,
            rule: "must be a number".into(),
        });
    }
    Ok(())
}

fn nearest(nodes: &[f64], z: f64) -> usize {
    let mut best = 0;
    for (i, node) in nodes.iter().enumerate() {
        if (node - z).abs() < (nodes[best] - z).abs() {
            best = i;
        }
    }
    best
}
