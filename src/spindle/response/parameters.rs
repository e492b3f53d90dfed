//! The parameters that a response is differentiated to, and where each stands in the vector.
//!
//! Logarithms of the moduli of element groups, of ki, ks and sensor gain of each bearing, of the damping ratios; then
//! the share of a finer mesh, and what another mesh reads at each plane. All are zero for the machine as given. Factors
//! are logarithms: a factor and an effect of the same kind then trade along a straight line, which one step follows.

use crate::spindle::Machine;

/// Flexible modes whose damping is a parameter; the last one's also moves all higher.
pub(crate) const DAMPED_MODES: usize = 6;
/// More groups than this say nothing more about a shaft with four ports.
const MOST_GROUPS: usize = 40;

/// Where each parameter of a machine stands in the vector.
#[derive(Clone, Debug)]
pub struct MachineParameters {
    /// Group of each element, tool tip first (the order of the assembled shaft).
    pub group_of_element: Vec<usize>,
    pub groups: usize,
}

impl MachineParameters {
    pub fn new(machine: &Machine) -> Self {
        let tool = machine.tool.sections.iter().rev().map(|s| s.region.as_deref());
        let spindle = machine.spindle.sections.iter().map(|s| s.region.as_deref());
        let regions: Vec<Option<&str>> = tool.chain(spindle).collect();
        let mut names: Vec<&str> = vec![];
        let loose = regions.iter().filter(|r| r.is_none()).count();
        // Many elements without a region share a factor with their neighbours.
        let per_group = loose.div_ceil(MOST_GROUPS.saturating_sub(16)).max(1);
        let (mut group_of_element, mut next, mut run) = (vec![], 0, (usize::MAX, 0));
        let mut of_name: Vec<usize> = vec![];
        for region in &regions {
            match region {
                Some(name) => {
                    let known = names.iter().position(|n| n == name);
                    let group = match known {
                        Some(k) => of_name[k],
                        None => {
                            names.push(name);
                            of_name.push(next);
                            next += 1;
                            next - 1
                        }
                    };
                    group_of_element.push(group);
                    run = (usize::MAX, 0);
                }
                None => {
                    if run.0 == usize::MAX || run.1 >= per_group {
                        run = (next, 0);
                        next += 1;
                    }
                    run.1 += 1;
                    group_of_element.push(run.0);
                }
            }
        }
        Self { group_of_element, groups: next }
    }

    pub(crate) fn count(&self) -> usize {
        self.reading(4)
    }

    /// Index of ln ki of bearing 0 or 1.
    pub(crate) fn ki(&self, bearing: usize) -> usize {
        self.groups + bearing
    }

    /// Index of ln ks of a bearing.
    pub fn ks(&self, bearing: usize) -> usize {
        self.groups + 2 + bearing
    }

    /// Index of the logarithm of the sensor gain of a bearing.
    pub fn gain(&self, bearing: usize) -> usize {
        self.groups + 4 + bearing
    }

    /// Index of ln ζ of flexible mode `k` (from 0).
    pub fn damping(&self, k: usize) -> usize {
        self.groups + 6 + k.min(DAMPED_MODES - 1)
    }

    /// Index of the mesh.
    pub fn mesh(&self) -> usize {
        self.groups + 6 + DAMPED_MODES
    }

    /// Index of the reading of an actuator plane (front, rear), then of a sensor plane, which counts where the plane is
    /// between nodes.
    pub fn reading(&self, plane: usize) -> usize {
        self.mesh() + 1 + plane
    }

    /// Number of parameters whose derivatives follow from the shaft's coordinates: moduli, ks, ln ζ, mesh.
    pub fn analytic(&self) -> usize {
        self.groups + 2 + DAMPED_MODES + 1
    }

    /// The machine with bearings and damping moved (moduli are moved in the reduced model).
    pub(crate) fn bearings(&self, machine: &Machine, p: &[f64]) -> Machine {
        let mut moved = machine.clone();
        for (b, bearing) in [&mut moved.spindle.front, &mut moved.spindle.rear].into_iter().enumerate() {
            bearing.ki_n_per_a *= p[self.ki(b)].exp();
            bearing.ks_n_per_m *= p[self.ks(b)].exp();
            bearing.sensor_gain *= p[self.gain(b)].exp();
        }
        moved
    }

    /// The machine with everything moved, as it goes into the corrected file.
    pub fn apply(&self, machine: &Machine, p: &[f64]) -> Machine {
        let mut moved = self.bearings(machine, p);
        let tool = machine.tool.sections.len();
        let factor = |element: usize| self.group_of_element.get(element).map_or(1.0, |g| p[*g].exp());
        for (i, section) in moved.spindle.sections.iter_mut().enumerate() {
            section.modulus_scale *= factor(tool + i);
        }
        for (i, section) in moved.tool.sections.iter_mut().enumerate() {
            section.modulus_scale *= factor(tool - 1 - i);
        }
        let nominal = &machine.spindle.damping_ratio;
        let last = nominal.last().copied().unwrap_or_default();
        moved.spindle.damping_ratio = (0..DAMPED_MODES.max(nominal.len()))
            .map(|k| nominal.get(k).copied().unwrap_or(last) * p[self.damping(k)].exp())
            .collect();
        moved
    }
}
