//! What a free law at a place does to the response of a line.
//!
//! A place offers directions D_a at a line: F_new = F + Σ X_a D_a holds exactly for any law there, however large.  On
//! the shaft X = (Δ⁻¹ − G)⁻¹ of a law Δ (forces −Δ q), forwards and backwards apart where x and y are coupled; in the
//! electronics X is the relative change itself.

use super::super::DiagnoseError;
use super::super::fit::model::Model;
use super::joint::stiffest_joint;
use super::place::Place;
use crate::linalg::c64;
use crate::spindle::response::channels::MAGNETS;
use crate::spindle::response::electronics::ElectronicsLine;
use crate::spindle::response::ported::Ported;
use crate::spindle::response::{Assembled, Assembly, SIDE, Square, ZERO};
use crate::spindle::{Effect, EffectKind, Location};

pub(super) const ONE: c64 = c64::new(1.0, 0.0);

/// A machine with open ports for a place, at one speed.
pub(crate) struct OpenedPlace<'a> {
    pub(super) place: &'a Place,
    pub(super) assembled: Assembled,
    extra: Vec<usize>,
    /// Forwards and backwards have laws of their own.
    pub(super) split: bool,
    /// Stiffness of the joint that counts as rigid, N/m and N m/rad.
    pub(super) rigid: [f64; 2],
}

/// One line of an opened place.
pub(crate) struct PlaceResponse<'a> {
    pub(super) scene: &'a OpenedPlace<'a>,
    pub(super) electronics: ElectronicsLine,
    pub(super) plus: Ported,
    pub(super) minus: Option<Ported>,
    /// F without a law.
    pub response: Square,
    /// D_a.
    pub directions: Vec<Square>,
}

/// B, C, G of one sign of frequency: 3×m, m×3, m×m.
pub(super) struct PortBlocks {
    pub(super) m: usize,
    pub(super) b: Vec<c64>,
    pub(super) c: Vec<c64>,
    pub(super) g: Vec<c64>,
}

impl Place {
    /// Opens the ports of the place in a machine with nuisance parameters `p` and further effects.
    pub(crate) fn scene<'a>(
        &'a self,
        model: &Model,
        p: &[f64],
        effects: &[Effect],
        speed_rad_s: f64,
        derivatives: bool,
    ) -> Result<OpenedPlace<'a>, DiagnoseError> {
        let probes = self.probes(model);
        let mut effects = effects.to_vec();
        let rigid = stiffest_joint(&model.reduced.machine.spindle);
        if *self == Self::Joint {
            effects.push(Effect {
                kind: EffectKind::ToolJoint,
                location: Location::None,
                values: vec![rigid[0], rigid[1], 0.0],
            });
        }
        let assembled = model.reduced.assemble(
            p,
            Assembly { effects: &effects, speed_rad_s, derivatives, further: &probes, ..Assembly::default() },
        )?;
        let count = assembled.ports();
        let extra = match self {
            Self::Housing => MAGNETS.to_vec(),
            // The magnet's negative stiffness moves with its plane.
            Self::ActuatorPlane(b) => vec![count - 1, MAGNETS[*b]],
            _ => (count - probes.len()..count).collect(),
        };
        let split = self.mechanical() && (assembled.is_coupled() || matches!(self, Self::Circulating(_)));
        Ok(OpenedPlace { place: self, assembled, extra, split, rigid })
    }
}

impl OpenedPlace<'_> {
    pub(crate) fn view(&self, omega_rad_s: f64) -> PlaceResponse<'_> {
        let a = &self.assembled;
        let electronics = a.electronics_line(omega_rad_s);
        let plus = a.reduce_to_ports(omega_rad_s, &self.extra);
        let minus = (a.is_coupled() || self.split).then(|| a.reduce_to_ports(-omega_rad_s, &self.extra));
        // The directions are those of a machine without springs in one plane: near enough to tell where something is.
        let response = if a.has_plane_laws() {
            a.line(omega_rad_s, None).response
        } else {
            Assembled::response(&electronics, &plus, minus.as_ref())
        };
        let mut view = PlaceResponse { scene: self, electronics, plus, minus, response, directions: vec![] };
        view.directions = view.offer_laws();
        view
    }

    pub(super) fn bond(&self, at: &Ported) -> PortBlocks {
        let (n, m) = (at.side, at.side - 3);
        let v = |r: usize, c: usize| at.response[r * n + c];
        if *self.place != Place::Housing {
            return PortBlocks {
                m,
                b: (0..3 * m).map(|i| v(i / m, 3 + i % m)).collect(),
                c: (0..3 * m).map(|i| v(3 + i / 3, i % 3)).collect(),
                g: (0..m * m).map(|i| v(3 + i / m, 3 + i % m)).collect(),
            };
        }
        let ks = self.assembled.negative_stiffness();
        let unit = |i: usize| if i < 2 { ONE } else { ZERO };
        let b = (0..3).map(|o| unit(o) + v(o, 3) * ks[0] + v(o, 4) * ks[1]);
        let c = (0..3).map(|i| unit(i) + v(3, i) * ks[0] + v(4, i) * ks[1]);
        let g = (0..2).fold(ZERO, |sum, f| {
            let row = v(3 + f, 3) * ks[0] + v(3 + f, 4) * ks[1];
            sum + (unit(0) + row) * ks[f]
        });
        PortBlocks { m: 1, b: b.collect(), c: c.collect(), g: vec![g] }
    }
}

/// Pairs a ≤ b of a symmetric m×m matrix.
pub(super) fn pairs(m: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..m).flat_map(move |a| (a..m).map(move |b| (a, b)))
}

pub(super) fn matrix(m: usize, x: &[c64]) -> Vec<c64> {
    let mut full = vec![ZERO; m * m];
    for ((a, b), x) in pairs(m).zip(x) {
        full[a * m + b] = *x;
        full[b * m + a] = *x;
    }
    full
}

impl PlaceResponse<'_> {
    pub(crate) fn place(&self) -> &Place {
        self.scene.place
    }

    /// Whether forwards and backwards have laws of their own.
    pub(crate) fn split(&self) -> bool {
        self.scene.split
    }

    /// Linear change that a unit law makes to any response of this kind (a derivative too); `None` where it is not a
    /// mixture of entries.
    pub(super) fn mix_axes(&self, f: &Square) -> Option<Square> {
        let rows = |pick: &dyn Fn(usize, usize) -> c64| -> Square { std::array::from_fn(|n| pick(n / SIDE, n % SIDE)) };
        let own = |i: usize, j: usize| f[SIDE * i + j];
        let when = |yes: bool, i: usize, j: usize| if yes { own(i, j) } else { ZERO };
        Some(match self.scene.place {
            Place::Sensors(b) => rows(&|i, j| when(i / 2 == *b, i, j)),
            Place::Sensor(axis) => rows(&|i, j| when(i == *axis, i, j)),
            Place::Currents(b) => rows(&|i, j| when(j / 2 == *b, i, j)),
            Place::Current(axis) => rows(&|i, j| when(j == *axis, i, j)),
            Place::Loop => rows(&|i, j| when(j < 4, i, j)),
            Place::Turned(b) => rows(&|i, j| match (i / 2 == *b, i % 2) {
                (true, 0) => own(i + 1, j),
                (true, _) => -own(i - 1, j),
                _ => ZERO,
            }),
            Place::Coupled(b) => rows(&|i, j| match (j / 2 == *b, j % 2) {
                (true, 0) => own(i, j + 1),
                (true, _) => own(i, j - 1),
                _ => ZERO,
            }),
            Place::Crosstalk(b) => rows(&|i, j| match (j / 2 == *b, *b) {
                (true, 0) => own(i, j + 2),
                (true, _) => own(i, j - 2),
                _ => ZERO,
            }),
            _ => return None,
        })
    }

    /// Change when rows or columns are read further along the shaft: with its slope, and with the magnet that moves
    /// with an actuator.
    fn tilt_axes(&self) -> Square {
        let side = self.plus.side;
        let ks = self.scene.assembled.negative_stiffness();
        let pick = |at: &Ported| -> [c64; 9] {
            let v = &at.response;
            std::array::from_fn(|n| match self.scene.place {
                Place::SensorPlane(b) if n / 3 == *b => v[3 * side + n % 3],
                Place::ActuatorPlane(b) => {
                    let (o, i) = (n / 3, n % 3);
                    let (slope, own) = (v[o * side + 3], v[o * side + b]);
                    let change = if i == *b { slope } else { ZERO };
                    let magnet = slope * v[4 * side + i] + own * v[3 * side + i];
                    change + magnet * ks[*b]
                }
                _ => ZERO,
            })
        };
        let minus = self.minus.as_ref().map(pick);
        self.electronics.apply(&pick(&self.plus), minus.as_ref())
    }

    fn offer_laws(&self) -> Vec<Square> {
        let place = self.scene.place;
        if let Some(mixed) = self.mix_axes(&self.response) {
            return vec![mixed];
        }
        let minus = self.minus.as_ref();
        match place {
            Place::SensorPlane(_) | Place::ActuatorPlane(_) => {
                vec![self.tilt_axes()]
            }
            place if place.mechanical() => {
                let nothing = [ZERO; 9];
                let plane = |bond: &PortBlocks| -> Vec<[c64; 9]> {
                    pairs(bond.m)
                        .map(|(a, b)| {
                            std::array::from_fn(|n| {
                                let (o, i) = (n / 3, n % 3);
                                let one = |a: usize, b: usize| bond.b[o * bond.m + a] * bond.c[b * 3 + i];
                                if a == b { one(a, a) } else { one(a, b) + one(b, a) }
                            })
                        })
                        .collect()
                };
                let forward = plane(&self.scene.bond(&self.plus));
                match minus {
                    Some(minus) if self.scene.split => {
                        let backward = plane(&self.scene.bond(minus));
                        let first = forward.iter().map(|h| self.electronics.apply(h, Some(&nothing)));
                        let second = backward.iter().map(|h| self.electronics.apply(&nothing, Some(h)));
                        first.chain(second).collect()
                    }
                    _ => {
                        let alike = forward.iter().map(|h| self.electronics.apply(h, None));
                        match place {
                            Place::Apart(_) => alike.flat_map(|d| [axis_of(&d, 0), axis_of(&d, 1)]).collect(),
                            _ => alike.collect(),
                        }
                    }
                }
            }
            _ => vec![],
        }
    }
}

/// The entries of one axis.
pub(super) fn axis_of(f: &Square, axis: usize) -> Square {
    std::array::from_fn(|n| if n / SIDE % 2 == axis && n % SIDE % 2 == axis { f[n] } else { ZERO })
}
