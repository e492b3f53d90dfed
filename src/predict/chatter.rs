//! Chatter: the largest stable depth of cut over spindle speed, from the response at the tool of the closed loop.
//!
//! Milling by the zero-order form of Altintas and Budak (CIRP Annals 44, 1995): with the averaged directional
//! coefficients A₀ of the engagement and Φ(jω) = displacement / force at the tool, det(I + Λ A₀ Φ) = 0, hence Λ = −1/e
//! for the eigenvalues e of A₀Φ, and  a_lim = −2π Λ_R (1 + κ²) / (N K_t), κ = Λ_I/Λ_R, at the tooth periods T with ωT =
//! π − 2 arctan κ + 2πk.
//! Orthogonal cutting by Tlusty:  b_lim = −1 / (2 K_s Re G).
//!
//! x is the feed direction, the cutter turns from y towards x as in the source. The response may be that of a turning
//! rotor (2×2, not symmetric); for one that changes with speed take a curve a speed. The zero-order form is accurate
//! for many teeth in the cut. At a few percent of immersion it may be too high or too low, because it lacks the flip
//! lobes that appear there.

use crate::linalg::{Mat, c64};
use std::f64::consts::{PI, TAU};

/// Why no limit can be given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChatterError {
    /// A cutting value out of its range.
    #[error("{what} = {value}: must be {rule}")]
    Value {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be.
        rule: &'static str,
    },
    /// Lists that do not belong together.
    #[error("{frequencies} frequencies but {responses} responses of 2×2; one each is needed, frequencies ascending")]
    Response {
        /// Number of frequencies.
        frequencies: usize,
        /// Number of responses of the right shape.
        responses: usize,
    },
}

/// Cutting force coefficients of a material with a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuttingMaterial {
    /// Tangential force over chip area, Pa. Aluminium 6–9·10⁸, steel 2·10⁹ and more.
    pub tangential_pa: f64,
    /// Radial over tangential force, 0.2–0.4.
    pub radial_ratio: f64,
}

impl CuttingMaterial {
    /// Aluminium, in the middle of its range.
    pub const ALUMINIUM: Self = Self { tangential_pa: 8e8, radial_ratio: 0.3 };
}

/// Teeth of a cutter unless given.
pub const USUAL_TEETH: usize = 2;
/// Radial width of cut over diameter unless given: half the diameter.
pub const USUAL_WIDTH: f64 = 0.5;

/// Teeth and the arc in which they cut; angles from the y axis in the sense of rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Engagement {
    /// Number of teeth.
    pub teeth: usize,
    /// Angle at which a tooth enters, rad.
    pub entry_rad: f64,
    /// Angle at which it leaves, rad.
    pub exit_rad: f64,
}

impl Engagement {
    /// A slot as wide as the cutter.
    pub fn slot(teeth: usize) -> Self {
        Self { teeth, entry_rad: 0.0, exit_rad: PI }
    }

    /// Up milling with a radial width of cut of this fraction of the diameter.
    pub fn up_milling(teeth: usize, width_over_diameter: f64) -> Self {
        Self { teeth, entry_rad: 0.0, exit_rad: (1.0 - 2.0 * width_over_diameter).clamp(-1.0, 1.0).acos() }
    }

    /// Down milling with a radial width of cut of this fraction of the diameter.
    pub fn down_milling(teeth: usize, width_over_diameter: f64) -> Self {
        Self { teeth, entry_rad: (2.0 * width_over_diameter - 1.0).clamp(-1.0, 1.0).acos(), exit_rad: PI }
    }
}

/// One point of the stability limit: chatter frequency, depth, and the phase between the waves of successive teeth.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Critical {
    omega_rad_s: f64,
    depth_m: f64,
    phase_rad: f64,
}

/// The stability limit over chatter frequency; gives the depth at any speed.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityLimit {
    teeth: usize,
    /// Runs of neighbouring frequencies of one eigenvalue with a positive limit.
    runs: Vec<Vec<Critical>>,
}

/// The deepest cut that is stable at every speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinimumDepth {
    /// Depth, m.
    pub depth_m: f64,
    /// Chatter frequency, rad/s.
    pub omega_rad_s: f64,
}

/// Averaged directional coefficients A₀ = [[α_xx, α_xy], [α_yx, α_yy]].
pub fn directional_coefficients(cut: &Engagement, radial_ratio: f64) -> [[f64; 2]; 2] {
    let k = radial_ratio;
    let between = |f: &dyn Fn(f64) -> f64| 0.5 * (f(cut.exit_rad) - f(cut.entry_rad));
    let (c, s) = (|p: f64| (2.0 * p).cos(), |p: f64| (2.0 * p).sin());
    [
        [between(&|p| c(p) - 2.0 * k * p + k * s(p)), between(&|p| -s(p) - 2.0 * p + k * c(p))],
        [between(&|p| -s(p) + 2.0 * p + k * c(p)), between(&|p| -c(p) - 2.0 * k * p - k * s(p))],
    ]
}

/// Stability limit of milling from the tool's compliance (2×2, x and y, m/N) at ascending frequencies (rad/s).
/// The grid must resolve the resonances: the limit is interpolated between its points.
///
/// # Errors
/// [`ChatterError`] for values out of range or lists that do not fit.
pub fn milling(
    omega_rad_s: &[f64],
    compliance: &[Mat<c64>],
    material: &CuttingMaterial,
    cut: &Engagement,
) -> Result<StabilityLimit, ChatterError> {
    check(omega_rad_s, compliance, material, cut)?;
    let a0 = directional_coefficients(cut, material.radial_ratio);
    let scale = TAU / (cut.teeth as f64 * material.tangential_pa);
    let mut tracks: [Vec<(f64, c64)>; 2] = [Vec::new(), Vec::new()];
    for (omega, phi) in omega_rad_s.iter().zip(compliance) {
        let product = |i: usize, j: usize| {
            let row = if i == 0 { a0[0] } else { a0[1] };
            phi[(0, j)] * row[0] + phi[(1, j)] * row[1]
        };
        let mut pair = eigenvalues([[product(0, 0), product(0, 1)], [product(1, 0), product(1, 1)]]);
        // Each track goes on with the eigenvalue nearest to its last one.
        if let (Some((_, last)), Some((_, other))) = (tracks[0].last(), tracks[1].last()) {
            let straight = (pair[0] - last).norm() + (pair[1] - other).norm();
            let crossed = (pair[1] - last).norm() + (pair[0] - other).norm();
            if crossed < straight {
                pair.swap(0, 1);
            }
        }
        tracks[0].push((*omega, pair[0]));
        tracks[1].push((*omega, pair[1]));
    }
    let runs = tracks.iter().flat_map(|track| runs(track, |e| -c64::new(scale, 0.0) / e)).collect();
    Ok(StabilityLimit { teeth: cut.teeth, runs })
}

/// Stability limit of orthogonal cutting (one tooth): `specific_pa` is K_s, `oriented` the response of the chip
/// thickness to the cutting force, m/N.
///
/// # Errors
/// [`ChatterError`] for values out of range or lists that do not fit.
pub fn orthogonal(omega_rad_s: &[f64], oriented: &[c64], specific_pa: f64) -> Result<StabilityLimit, ChatterError> {
    positive("specific cutting force", specific_pa)?;
    ascending(omega_rad_s, oriented.len())?;
    let track: Vec<(f64, c64)> = omega_rad_s.iter().copied().zip(oriented.iter().copied()).collect();
    // 1 + b K_s (1 − e^{−jθ}) G = 0 is the same equation with Λ = 1/(K_s G) up to scale.
    Ok(StabilityLimit { teeth: 1, runs: runs(&track, |g| c64::new(0.5 / specific_pa, 0.0) / g) })
}

/// Points with a positive limit, split where there is none. `lambda` gives Λ scaled such that depth = −Λ_R (1 + κ²).
fn runs(track: &[(f64, c64)], lambda: impl Fn(c64) -> c64) -> Vec<Vec<Critical>> {
    let mut runs: Vec<Vec<Critical>> = vec![Vec::new()];
    for (omega, value) in track {
        let l = lambda(*value);
        let depth_m = -l.norm_sqr() / l.re;
        if l.re < 0.0 && depth_m.is_finite() {
            // θ = π − 2 arctan κ, in (0, 2π) for Λ_R < 0.
            let phase_rad = PI - 2.0 * (l.im / l.re).atan();
            if let Some(run) = runs.last_mut() {
                run.push(Critical { omega_rad_s: *omega, depth_m, phase_rad });
            }
        } else if runs.last().is_some_and(|run| !run.is_empty()) {
            runs.push(Vec::new());
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

impl StabilityLimit {
    /// Largest stable depth of cut at a spindle speed, m; `None` where no chatter occurs on the grid at this speed.
    pub fn depth_at(&self, speed_rad_s: f64) -> Option<f64> {
        let period = TAU / (self.teeth as f64 * speed_rad_s);
        let waves = |c: &Critical| (c.omega_rad_s * period - c.phase_rad) / TAU;
        let mut least: Option<f64> = None;
        for pair in self.runs.iter().flat_map(|run| run.windows(2)) {
            let [a, b] = pair else { continue };
            // The number of whole waves between two teeth must be an integer: every one passed between the points
            // counts.
            let (u, v) = (waves(a), waves(b));
            let (first, last) = (u.min(v).ceil().max(0.0), u.max(v).floor());
            if first > last || !(u.is_finite() && v.is_finite()) {
                continue;
            }
            for whole in [first, last] {
                let t = if v == u { 0.0 } else { (whole - u) / (v - u) };
                let depth = a.depth_m + t * (b.depth_m - a.depth_m);
                least = Some(least.map_or(depth, |l: f64| l.min(depth)));
            }
        }
        least
    }

    /// Largest stable depth at each of the speeds; not a number where no chatter occurs.
    pub fn depths(&self, speeds_rad_s: &[f64]) -> Vec<f64> {
        speeds_rad_s.iter().map(|s| self.depth_at(*s).unwrap_or(f64::NAN)).collect()
    }

    /// The depth below which cutting is stable at every speed; `None` if no depth chatters.
    pub fn minimum(&self) -> Option<MinimumDepth> {
        let all = self.runs.iter().flatten();
        all.min_by(|a, b| a.depth_m.total_cmp(&b.depth_m))
            .map(|c| MinimumDepth { depth_m: c.depth_m, omega_rad_s: c.omega_rad_s })
    }
}

/// Both eigenvalues of a 2×2 matrix.
fn eigenvalues([[a, b], [c, d]]: [[c64; 2]; 2]) -> [c64; 2] {
    let (mean, half) = (0.5 * (a + d), 0.5 * (a - d));
    let root = (half * half + b * c).sqrt();
    [mean + root, mean - root]
}

fn positive(what: &'static str, value: f64) -> Result<(), ChatterError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(ChatterError::Value { what, value, rule: "positive" }) }
}

fn ascending(omega_rad_s: &[f64], responses: usize) -> Result<(), ChatterError> {
    let sorted = omega_rad_s.windows(2).all(|w| w.first() < w.last());
    if sorted && omega_rad_s.len() == responses && omega_rad_s.first().is_some_and(|w| *w > 0.0) {
        Ok(())
    } else {
        Err(ChatterError::Response { frequencies: omega_rad_s.len(), responses })
    }
}

fn check(
    omega_rad_s: &[f64],
    compliance: &[Mat<c64>],
    material: &CuttingMaterial,
    cut: &Engagement,
) -> Result<(), ChatterError> {
    positive("tangential cutting force", material.tangential_pa)?;
    positive("number of teeth", cut.teeth as f64)?;
    if !(material.radial_ratio.is_finite() && material.radial_ratio >= 0.0) {
        return Err(ChatterError::Value { what: "radial ratio", value: material.radial_ratio, rule: "zero or more" });
    }
    let arc = cut.exit_rad - cut.entry_rad;
    if !(cut.entry_rad >= 0.0 && arc > 0.0 && cut.exit_rad <= TAU) {
        return Err(ChatterError::Value {
            what: "arc of engagement",
            value: arc,
            rule: "positive and within one turn",
        });
    }
    let fitting = compliance.iter().filter(|m| (m.nrows(), m.ncols()) == (2, 2)).count();
    if fitting != compliance.len() {
        return Err(ChatterError::Response { frequencies: omega_rad_s.len(), responses: fitting });
    }
    ascending(omega_rad_s, fitting)
}
