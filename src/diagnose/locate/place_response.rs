//! What a free law at a place does to the response of a line.
//!
//! A place offers directions D_a at a line: F_new = F + Σ X_a D_a holds exactly for any law there, however large.  On
//! the shaft X = (Δ⁻¹ − G)⁻¹ of a law Δ (forces −Δ q), forwards and backwards apart where x and y are coupled; in the
//! electronics X is the relative change itself. [`PlaceResponse::moved`] is the response with X and its derivatives to
//! the nuisance parameters, Δ held: dH_new = dH + dB X C + B X dC + B X dG X C.

use super::super::DiagnoseError;
use super::super::fit::model::Model;
use super::super::fit::nuisance::Layout;
use super::joint::STIFFEST_JOINT;
use super::place::Place;
use crate::linalg::c64;
use crate::spindle::response::channels::MAGNETS;
use crate::spindle::response::electronics::ElectronicsLine;
use crate::spindle::response::ported::{Ported, factor};
use crate::spindle::response::{Assembled, Assembly, SIDE, Square, ZERO};
use crate::spindle::{Effect, EffectKind, Location};

pub(super) const ONE: c64 = c64::new(1.0, 0.0);

/// A machine with open ports for a place, at one speed.
pub(crate) struct OpenedPlace<'a> {
    pub(super) place: &'a Place,
    assembled: Assembled,
    extra: Vec<usize>,
    /// Forwards and backwards have laws of their own.
    pub(super) split: bool,
}

/// One line of an opened place.
pub(crate) struct PlaceResponse<'a> {
    pub(super) scene: &'a OpenedPlace<'a>,
    electronics: ElectronicsLine,
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
    b: Vec<c64>,
    c: Vec<c64>,
    pub(super) g: Vec<c64>,
}

impl Place {
    /// Opens the ports of the place in a machine with nuisance parameters `p` and further effects.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the machine cannot be assembled.
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
        if *self == Self::Joint {
            effects.push(Effect {
                kind: EffectKind::ToolJoint,
                location: Location::None,
                values: vec![STIFFEST_JOINT[0], STIFFEST_JOINT[1], 0.0],
            });
        }
        let assembled = model.reduced.assemble(
            p,
            Assembly {
                effects: &effects,
                speed_rad_s,
                derivatives,
                further: &probes,
                probes: &[],
            },
        )?;
        let count = assembled.ports();
        let extra = match self {
            Self::Housing => MAGNETS.to_vec(),
            // The magnet's negative stiffness moves with its plane.
            Self::ActuatorPlane(b) => vec![count - 1, MAGNETS[*b]],
            _ => (count - probes.len()..count).collect(),
        };
        let split =
            self.mechanical() && (assembled.coupled() || matches!(self, Self::Circulating(_)));
        Ok(OpenedPlace {
            place: self,
            assembled,
            extra,
            split,
        })
    }
}

impl OpenedPlace<'_> {
    /// One line; with derivatives when there is a layout.
    pub(crate) fn view(&self, omega_rad_s: f64, layout: Option<&Layout>) -> PlaceResponse<'_> {
        let a = &self.assembled;
        let parameters = layout.map(|l| &l.machine);
        let electronics = a.electronics_line(omega_rad_s);
        let plus = a.ported(omega_rad_s, &self.extra, parameters);
        let minus =
            (a.coupled() || self.split).then(|| a.ported(-omega_rad_s, &self.extra, parameters));
        // The directions are those of a machine without springs in one plane: near enough to tell where something is.
        let response = match a.has_plane_springs() {
            true => a.line(omega_rad_s, None).response,
            false => Assembled::response(&electronics, &plus, minus.as_ref()),
        };
        let mut view = PlaceResponse {
            scene: self,
            electronics,
            plus,
            minus,
            response,
            directions: vec![],
        };
        view.directions = view.offered();
        view
    }

    pub(super) fn bond(&self, at: &Ported) -> PortBlocks {
        self.bond_of(at, &at.response, true)
    }

    /// PortBlocks of a matrix of the shape of `at`; of a derivative without the parts that are constant.
    fn bond_of(&self, at: &Ported, values: &[c64], whole: bool) -> PortBlocks {
        let (n, m) = (at.side, at.side - 3);
        let v = |r: usize, c: usize| values[r * n + c];
        if *self.place != Place::Housing {
            return PortBlocks {
                m,
                b: (0..3 * m).map(|i| v(i / m, 3 + i % m)).collect(),
                c: (0..3 * m).map(|i| v(3 + i / 3, i % 3)).collect(),
                g: (0..m * m).map(|i| v(3 + i / m, 3 + i % m)).collect(),
            };
        }
        let ks = self.assembled.negative_stiffness();
        let unit = |i: usize| if whole && i < 2 { ONE } else { ZERO };
        let b = (0..3).map(|o| unit(o) + v(o, 3) * ks[0] + v(o, 4) * ks[1]);
        let c = (0..3).map(|i| unit(i) + v(3, i) * ks[0] + v(4, i) * ks[1]);
        let g = (0..2).fold(ZERO, |sum, f| {
            let row = v(3 + f, 3) * ks[0] + v(3 + f, 4) * ks[1];
            sum + (unit(0) + row) * ks[f]
        });
        PortBlocks {
            m: 1,
            b: b.collect(),
            c: c.collect(),
            g: vec![g],
        }
    }

    /// Derivative of the bond to analytic parameter `i` of the layout's order (moduli, ln ks, ln ζ).
    fn bond_slope(&self, at: &Ported, i: usize, groups: usize) -> PortBlocks {
        let mut d = self.bond_of(at, &at.slopes[i], false);
        if *self.place == Place::Housing && (groups..groups + 2).contains(&i) {
            let (f, ks) = (i - groups, self.assembled.negative_stiffness());
            for o in 0..3 {
                d.b[o] += at.at(o, 3 + f) * ks[f];
                d.c[o] += at.at(3 + f, o) * ks[f];
            }
            let row = (0..2).fold(ONE, |s, e| s + at.at(3 + f, 3 + e) * ks[e]);
            let column = (0..2).fold(ZERO, |s, e| s + at.at(3 + e, 3 + f) * ks[e]);
            d.g[0] += (row + column) * ks[f];
        }
        d
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

pub(super) fn product(a: &[c64], b: &[c64], rows: usize, inner: usize, columns: usize) -> Vec<c64> {
    let mut c = vec![ZERO; rows * columns];
    for i in 0..rows {
        for l in 0..inner {
            for j in 0..columns {
                c[i * columns + j] += a[i * inner + l] * b[l * columns + j];
            }
        }
    }
    c
}

impl PlaceResponse<'_> {
    /// The place.
    pub(crate) fn place(&self) -> &Place {
        self.scene.place
    }

    /// Whether forwards and backwards have laws of their own.
    pub(crate) fn split(&self) -> bool {
        self.scene.split
    }

    /// Linear change that a unit law makes to any response of this kind (a derivative too); `None` where it is not a
    /// mixture of entries.
    fn mixed(&self, f: &Square) -> Option<Square> {
        let rows = |pick: &dyn Fn(usize, usize) -> c64| -> Square {
            std::array::from_fn(|n| pick(n / SIDE, n % SIDE))
        };
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

    /// Change when rows or columns are read further along the shaft: with its slope. The magnet that moves with an
    /// actuator counts in the response itself, not in derivatives (`whole` false), where it is a small part of a small
    /// part.
    fn tilted(&self, plus: &[c64], minus: Option<&[c64]>, whole: bool) -> Square {
        let side = self.plus.side;
        let ks = self.scene.assembled.negative_stiffness();
        let pick = |v: &[c64]| -> [c64; 9] {
            std::array::from_fn(|n| match self.scene.place {
                Place::SensorPlane(b) if n / 3 == *b => v[3 * side + n % 3],
                Place::ActuatorPlane(b) => {
                    let (o, i) = (n / 3, n % 3);
                    let (slope, own) = (v[o * side + 3], v[o * side + b]);
                    let mut change = if i == *b { slope } else { ZERO };
                    if whole {
                        let magnet = slope * v[4 * side + i] + own * v[3 * side + i];
                        change += magnet * ks[*b];
                    }
                    change
                }
                _ => ZERO,
            })
        };
        self.electronics
            .apply(&pick(plus), minus.map(&pick).as_ref())
    }

    fn offered(&self) -> Vec<Square> {
        let place = self.scene.place;
        if let Some(mixed) = self.mixed(&self.response) {
            return vec![mixed];
        }
        let minus = self.minus.as_ref();
        match place {
            Place::SensorPlane(_) | Place::ActuatorPlane(_) => {
                vec![self.tilted(
                    &self.plus.response,
                    minus.map(|m| m.response.as_slice()),
                    true,
                )]
            }
            place if place.mechanical() => {
                let nothing = [ZERO; 9];
                let plane = |bond: &PortBlocks| -> Vec<[c64; 9]> {
                    pairs(bond.m)
                        .map(|(a, b)| {
                            std::array::from_fn(|n| {
                                let (o, i) = (n / 3, n % 3);
                                let one =
                                    |a: usize, b: usize| bond.b[o * bond.m + a] * bond.c[b * 3 + i];
                                if a == b {
                                    one(a, a)
                                } else {
                                    one(a, b) + one(b, a)
                                }
                            })
                        })
                        .collect()
                };
                let forward = plane(&self.scene.bond(&self.plus));
                match minus {
                    Some(minus) if self.scene.split => {
                        let backward = plane(&self.scene.bond(minus));
                        let first = forward
                            .iter()
                            .map(|h| self.electronics.apply(h, Some(&nothing)));
                        let second = backward
                            .iter()
                            .map(|h| self.electronics.apply(&nothing, Some(h)));
                        first.chain(second).collect()
                    }
                    _ => {
                        let alike = forward.iter().map(|h| self.electronics.apply(h, None));
                        match place {
                            Place::Apart(_) => alike
                                .flat_map(|d| [axis_of(&d, 0), axis_of(&d, 1)])
                                .collect(),
                            _ => alike.collect(),
                        }
                    }
                }
            }
            _ => vec![],
        }
    }

    /// ∂F to an analytic parameter without a law.
    fn analytic(&self, i: usize) -> Square {
        let minus = self.minus.as_ref().map(|m| m.block(&m.slopes[i]));
        self.electronics
            .apply(&self.plus.block(&self.plus.slopes[i]), minus.as_ref())
    }

    /// F with X, and its derivatives to the nuisance parameters (without axis gains), the law held.
    pub(crate) fn moved(&self, x: &[c64], layout: &Layout) -> (Square, Vec<Square>) {
        let mut f = self.response;
        for (d, x) in self.directions.iter().zip(x) {
            for (f, d) in f.iter_mut().zip(d) {
                *f += d * x;
            }
        }
        let first = x.first().copied().unwrap_or(ZERO);
        let analytic = layout.machine.analytic();
        let mut slopes: Vec<Square> = Vec::with_capacity(analytic + 4);
        let mechanical = self.scene.place.mechanical();
        for i in 0..analytic {
            let own = match self.scene.place {
                _ if mechanical => self.bonded(i, x, layout.machine.groups),
                Place::SensorPlane(_) | Place::ActuatorPlane(_) => {
                    let d = self.analytic(i);
                    let minus = self.minus.as_ref().map(|m| m.slopes[i].as_slice());
                    let tilted = self.tilted(&self.plus.slopes[i], minus, false);
                    std::array::from_fn(|n| d[n] + first * tilted[n])
                }
                _ => {
                    let d = self.analytic(i);
                    match self.mixed(&d) {
                        Some(m) => std::array::from_fn(|n| d[n] + first * m[n]),
                        None => d,
                    }
                }
            };
            slopes.push(own);
        }
        // The order of the layout: moduli, ki, ks, sensor gains, damping, mesh.
        let mut all: Vec<Square> = slopes.drain(..layout.machine.groups).collect();
        let gain = |rows: bool, b: usize| match self.mixed(&factor(&self.response, rows, b)) {
            Some(m) => {
                let d = factor(&self.response, rows, b);
                std::array::from_fn(|n| d[n] + first * m[n])
            }
            None => factor(&f, rows, b),
        };
        all.extend([0, 1].map(|b| gain(false, b)));
        all.extend(slopes.drain(..2));
        all.extend([0, 1].map(|b| gain(true, b)));
        all.extend(slopes);
        (f, all)
    }

    /// ∂F to an analytic parameter with a law on the shaft.
    fn bonded(&self, i: usize, x: &[c64], groups: usize) -> Square {
        let scene = self.scene;
        let one = |at: &Ported, x: &[c64]| -> [c64; 9] {
            let (bond, slope) = (scene.bond(at), scene.bond_slope(at, i, groups));
            let m = bond.m;
            let x = matrix(m, x);
            let left = product(&bond.b, &x, 3, m, m);
            let right = product(&x, &bond.c, m, m, 3);
            let across = product(&left, &slope.g, 3, m, m);
            let (a, b, c) = (
                product(&slope.b, &right, 3, m, 3),
                product(&left, &slope.c, 3, m, 3),
                product(&across, &right, 3, m, 3),
            );
            let own = at.block(&at.slopes[i]);
            std::array::from_fn(|n| own[n] + a[n] + b[n] + c[n])
        };
        let half = x.len() / 2;
        match (&self.minus, scene.place) {
            (Some(minus), _) if scene.split => {
                let back: Vec<c64> = x[half..].iter().map(|z| z.conj()).collect();
                self.electronics
                    .apply(&one(&self.plus, &x[..half]), Some(&one(minus, &back)))
            }
            (_, Place::Apart(_)) => {
                let (a, b) = (one(&self.plus, &x[..1]), one(&self.plus, &x[1..]));
                let (a, b) = (
                    self.electronics.apply(&a, None),
                    self.electronics.apply(&b, None),
                );
                let (a, b) = (axis_of(&a, 0), axis_of(&b, 1));
                std::array::from_fn(|n| a[n] + b[n])
            }
            _ => self.electronics.apply(&one(&self.plus, x), None),
        }
    }
}

/// The entries of one axis.
fn axis_of(f: &Square, axis: usize) -> Square {
    std::array::from_fn(|n| {
        if n / SIDE % 2 == axis && n % SIDE % 2 == axis {
            f[n]
        } else {
            ZERO
        }
    })
}
