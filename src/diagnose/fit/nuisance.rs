//! Nuisance parameters that are never exactly right: moduli, force constants, negative stiffness, sensor gains,
//! damping, the mesh and its reading between nodes, and the gain of every sensor axis after each levitation. They are
//! fitted with every hypothesis, held by priors.
//!
//! Factors are logarithms: a factor and an effect of the same kind then trade along a straight line, which one step
//! follows. Prior standard deviations: what a careful updating leaves open (ki 2 %, ks 4 %, sensor gain 1 %, moduli 1
//! %, ζ 20 %).

use crate::spindle::response::parameters::{DAMPED_MODES, MachineParameters};

/// Standard deviation of the logarithm of a force constant.
const KI_SD: f64 = 0.02;
/// Standard deviation of the logarithm of a negative stiffness.
const KS_SD: f64 = 0.04;
/// Standard deviation of the logarithm of a sensor gain.
const GAIN_SD: f64 = 0.01;
/// Standard deviation of the logarithm of a modulus.
const MODULUS_SD: f64 = 0.01;
/// Standard deviation of a damping ratio, relative; of its logarithm above the model's value.
const DAMPING_SD: f64 = 0.2;
/// Standard deviation of the mesh: 0 is the mesh of the model, 1 one twice as fine, 4/3 a continuum.
const MESH_SD: f64 = 0.7;
/// Standard deviation of what another mesh reads at a plane between two nodes: the shaft itself may be one unit off.
const READING_SD: f64 = 0.7;

/// Where each parameter stands in the vector, with its prior.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Those of the machine, which stand first.
    pub machine: MachineParameters,
    /// Number of sweep records, each with four axis gains.
    pub sweeps: usize,
    pub sd: Vec<f64>,
    /// Factor on those of the machine; 1 is what a careful updating leaves.
    pub width: f64,
}

impl Layout {
    /// Those of a machine measured with sweeps whose axis gains scatter by `axis_gain_sd`.
    pub fn new(machine: MachineParameters, axis_gain_sd: &[[f64; 4]]) -> Self {
        let mut sd = vec![MODULUS_SD; machine.groups];
        sd.extend([KI_SD, KI_SD, KS_SD, KS_SD, GAIN_SD, GAIN_SD]);
        sd.extend([DAMPING_SD; DAMPED_MODES]);
        sd.push(MESH_SD);
        sd.extend([READING_SD; 4]);
        sd.extend(axis_gain_sd.iter().flatten());
        Self { machine, sweeps: axis_gain_sd.len(), sd, width: 1.0 }
    }

    /// Widens the priors of the machine but for the mesh and its reading, and not those of axis gains.
    pub(crate) fn widen_priors(&mut self, width: f64) {
        let own = self.machine.mesh();
        self.sd[..own].iter_mut().for_each(|sd| *sd *= width);
        self.width *= width;
    }

    /// How many prior standard deviations a parameter is off at p, with its sign, and the derivative to p. A damping
    /// ratio that is too low is off in the ratio itself: its logarithm goes to −∞ where the ratio is five deviations
    /// away.
    pub(crate) fn deviation(&self, k: usize, p: f64) -> (f64, f64) {
        let sd = self.sd.get(k).copied().unwrap_or(f64::INFINITY);
        let damping = self.machine.damping(0)..=self.machine.damping(DAMPED_MODES);
        if damping.contains(&k) && p < 0.0 { (p.exp_m1() / sd, p.exp() / sd) } else { (p / sd, sd.recip()) }
    }

    /// The priors at p: for each parameter the weight on the diagonal of the normal equations, and what it adds to the
    /// right-hand side.
    pub(crate) fn pull<'a>(&'a self, p: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        p.iter().enumerate().map(|(k, p)| {
            let (off, slope) = self.deviation(k, *p);
            (slope * slope, -off * slope)
        })
    }

    pub(crate) fn prior(&self, p: &[f64]) -> f64 {
        let off = p.iter().enumerate().map(|(k, p)| self.deviation(k, *p).0);
        off.map(|off| off * off).sum()
    }

    pub fn len(&self) -> usize {
        self.sd.len()
    }

    pub fn is_empty(&self) -> bool {
        self.sd.is_empty()
    }

    /// Index of the gain of an axis in a sweep.
    pub fn axis(&self, sweep: usize, axis: usize) -> usize {
        self.machine.count() + 4 * sweep + axis
    }

    /// Keeps parameters where they make sense: factors within e^±0.7, damping within e^±2, the mesh not finer than a
    /// continuum and what other elements may add.
    pub fn clamp(&self, p: &mut [f64]) {
        let damping = self.machine.damping(0)..=self.machine.damping(DAMPED_MODES);
        for (k, p) in p.iter_mut().enumerate() {
            let (lo, hi) = match k {
                k if damping.contains(&k) => (-2.0, 2.0),
                k if k == self.machine.mesh() => (-0.5, 1.5),
                k if (self.machine.reading(0)..self.machine.reading(4)).contains(&k) => (-2.0, 2.0),
                _ => (-0.7, 0.7),
            };
            *p = p.clamp(lo, hi);
        }
    }
}
