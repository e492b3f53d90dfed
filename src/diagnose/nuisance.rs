//! Small parameters that are never exactly right: moduli, force constants, negative stiffness, sensor gains, damping,
//! the mesh and its reading between nodes, and the gain of every sensor axis after each levitation. They are fitted with every hypothesis, held by priors.
//!
//! Factors are logarithms: a factor and an effect of the same kind then trade along a straight line, which one step follows.
//! Prior standard deviations: what a careful updating leaves open (ki 2 %, ks 4 %, sensor gain 1 %, moduli 1 %, ζ 20 %).

use crate::spindle::Machine;

/// Standard deviation of the logarithm of a force constant.
const KI_SD: f64 = 0.02;
/// Standard deviation of the logarithm of a negative stiffness.
const KS_SD: f64 = 0.04;
/// Standard deviation of the logarithm of a sensor gain.
const GAIN_SD: f64 = 0.01;
/// Standard deviation of the logarithm of a modulus.
const MODULUS_SD: f64 = 0.01;
/// Standard deviation of the logarithm of a damping ratio.
const DAMPING_SD: f64 = 0.2;
/// Standard deviation of the mesh: 0 is the mesh of the model, 1 one twice as fine, 4/3 a continuum.
const MESH_SD: f64 = 0.7;
/// Standard deviation of what another mesh reads at a plane between two nodes: the shaft itself may be one unit off.
const READING_SD: f64 = 0.7;
/// Flexible modes whose damping is a parameter; the last one's also moves all higher.
pub const DAMPED_MODES: usize = 6;
/// More groups than this say nothing more about a shaft with four ports.
const MOST_GROUPS: usize = 40;

/// Where each parameter stands in the vector, with its prior.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Group of each element, tool tip first (the order of the assembled shaft).
    pub group_of_element: Vec<usize>,
    /// Number of modulus groups.
    pub groups: usize,
    /// Number of sweep records, each with four axis gains.
    pub sweeps: usize,
    /// Prior standard deviations.
    pub sd: Vec<f64>,
}

impl Layout {
    /// Parameters of a machine measured with sweeps whose axis gains scatter by `axis_gain_sd`.
    pub fn new(machine: &Machine, axis_gain_sd: &[[f64; 4]]) -> Self {
        let tool = machine
            .tool
            .sections
            .iter()
            .rev()
            .map(|s| s.region.as_deref());
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
                    let group = known.map(|k| of_name[k]).unwrap_or_else(|| {
                        names.push(name);
                        of_name.push(next);
                        next += 1;
                        next - 1
                    });
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
        let mut sd = vec![MODULUS_SD; next];
        sd.extend([KI_SD, KI_SD, KS_SD, KS_SD, GAIN_SD, GAIN_SD]);
        sd.extend([DAMPING_SD; DAMPED_MODES]);
        sd.push(MESH_SD);
        sd.extend([READING_SD; 4]);
        sd.extend(axis_gain_sd.iter().flatten());
        Self {
            group_of_element,
            groups: next,
            sweeps: axis_gain_sd.len(),
            sd,
        }
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.sd.len()
    }

    /// True without parameters.
    pub fn is_empty(&self) -> bool {
        self.sd.is_empty()
    }

    /// Index of ln ki of bearing 0 or 1.
    pub fn ki(&self, bearing: usize) -> usize {
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

    /// Index of the reading of an actuator plane (front, rear), then of a sensor plane, which counts where the plane is between nodes.
    pub fn reading(&self, plane: usize) -> usize {
        self.mesh() + 1 + plane
    }

    /// Number of parameters whose derivatives follow from the shaft's coordinates: moduli, ks, ln ζ, mesh.
    pub fn analytic(&self) -> usize {
        self.groups + 2 + DAMPED_MODES + 1
    }

    /// Index of the gain of an axis in a sweep.
    pub fn axis(&self, sweep: usize, axis: usize) -> usize {
        self.reading(4) + 4 * sweep + axis
    }

    /// Keeps parameters where they make sense: factors within e^±0.7, damping within e^±2, the mesh not finer than a
    /// continuum and what other elements may add.
    pub fn clamp(&self, p: &mut [f64]) {
        let damping = self.damping(0)..=self.damping(DAMPED_MODES);
        for (k, p) in p.iter_mut().enumerate() {
            let (lo, hi) = match k {
                k if damping.contains(&k) => (-2.0, 2.0),
                k if k == self.mesh() => (-0.5, 1.5),
                k if (self.reading(0)..self.reading(4)).contains(&k) => (-2.0, 2.0),
                _ => (-0.7, 0.7),
            };
            *p = p.clamp(lo, hi);
        }
    }

    /// The machine with bearings and damping moved (moduli are moved in the reduced model).
    pub fn bearings(&self, machine: &Machine, p: &[f64]) -> Machine {
        let mut moved = machine.clone();
        for (b, bearing) in [&mut moved.spindle.front, &mut moved.spindle.rear]
            .into_iter()
            .enumerate()
        {
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
        let factor = |element: usize| {
            self.group_of_element
                .get(element)
                .map_or(1.0, |g| p[*g].exp())
        };
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
