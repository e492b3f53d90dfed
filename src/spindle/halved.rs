//! The same machine with a finer mesh: elements cut in two halves each, which describe the same body.

use super::{EffectKind, Machine, RotorOnSupports, SpindleError};
use crate::rotor::assembly::NODE_TOLERANCE_M;
use crate::rotor::{Rotor, Section};

/// What is assembled from elements of a tool and of a shaft.
pub trait Meshed: Clone {
    /// Elements of the tool, none without one, and of the shaft, each list in the order of its file.
    fn elements(&self) -> [&[Section]; 2];

    /// The same with other elements.
    #[must_use]
    fn with_elements(&self, lists: [Vec<Section>; 2]) -> Self;

    /// The shaft with its tool.
    ///
    /// # Errors
    /// [`SpindleError`] when a part breaks a rule.
    fn assembled(&self) -> Result<Rotor, SpindleError>;
}

impl Meshed for Machine {
    fn elements(&self) -> [&[Section]; 2] {
        [&self.tool.sections, &self.spindle.sections]
    }

    fn with_elements(&self, lists: [Vec<Section>; 2]) -> Self {
        let mut machine = self.clone();
        [machine.tool.sections, machine.spindle.sections] = lists;
        machine
    }

    fn assembled(&self) -> Result<Rotor, SpindleError> {
        self.rotor()
    }
}

impl Meshed for RotorOnSupports {
    fn elements(&self) -> [&[Section]; 2] {
        [self.tool.as_ref().map_or(&[], |tool| &tool.sections), &self.sections]
    }

    fn with_elements(&self, [tool, sections]: [Vec<Section>; 2]) -> Self {
        let mut rotor = Self { sections, ..self.clone() };
        if let Some(own) = &mut rotor.tool {
            own.sections = tool;
        }
        rotor
    }

    fn assembled(&self) -> Result<Rotor, SpindleError> {
        self.rotor()
    }
}

/// Every element in two halves.
#[must_use]
pub fn refine_mesh<M: Meshed>(machine: &M) -> M {
    halve_elements(machine, |_| true)
}

/// The machine as a rig has it, for which the mesh of the file is an approximation: every element in two halves but
/// those that hold a tilting stiffness, as this is defined with the element of the file.
#[must_use]
pub fn refined_around_tilting(machine: &Machine) -> Machine {
    let tilting = machine.of_kind(EffectKind::TiltingStiffness);
    let at: Vec<f64> = tilting.filter_map(|e| e.location.position_m()).collect();
    let elements = (machine.tool.sections.iter().rev()).chain(&machine.spindle.sections);
    let mut from = -machine.tool.length_m();
    let mut whole: Vec<bool> = vec![];
    for element in elements {
        let to = from + element.length_m;
        // An end belongs to both elements: which one is read there is left to the shaft.
        whole.push(at.iter().any(|z| (from - NODE_TOLERANCE_M..=to + NODE_TOLERANCE_M).contains(z)));
        from = to;
    }
    // From the tip first to the order of the file, the nose first.
    let tool = machine.tool.sections.len();
    whole[..tool].reverse();
    halve_elements(machine, |element| !whole[element])
}

/// The machine with the chosen elements in two halves; elements count from the tool's first to the spindle's last, each
/// list in the order of its file.
pub(super) fn halve_elements<M: Meshed>(machine: &M, chosen: impl Fn(usize) -> bool) -> M {
    let [tool, shaft] = machine.elements();
    let split = |sections: &[Section], first: usize| -> Vec<Section> {
        let mut all = Vec::with_capacity(2 * sections.len());
        for (k, section) in sections.iter().enumerate() {
            if chosen(first + k) { all.extend(halves(section)) } else { all.push(section.clone()) }
        }
        all
    };
    machine.with_elements([split(tool, 0), split(shaft, tool.len())])
}

/// The two halves of an element; a cone is cut at its mean diameter.
fn halves(section: &Section) -> [Section; 2] {
    [0, 1].map(|half| {
        let part = |[from, to]: [f64; 2]| {
            let middle = 0.5 * (from + to);
            if half == 0 { [from, middle] } else { [middle, to] }
        };
        Section {
            length_m: 0.5 * section.length_m,
            outer_diameter_m: part(section.outer_diameter_m),
            inner_diameter_m: part(section.inner_diameter_m),
            mass_outer_diameter_m: part(section.mass_outer_diameter_m),
            mass_inner_diameter_m: part(section.mass_inner_diameter_m),
            ..section.clone()
        }
    })
}
