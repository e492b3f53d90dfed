//! What the numbers of effects are measured by: the size of a machine, so that the coordinates of a fit, their bounds
//! and the least size that is worth a name are those of a spindle of any size.
//!
//! Two machines that are alike in every length, with equal materials and stresses and all times longer by the same
//! factor, have the same coordinates for effects that are alike.

/// Size of a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineScale {
    /// Sampling period, s.
    pub sample_period_s: f64,
    /// Delay beyond half a sample, s.
    pub spare_delay_s: f64,
    /// Bandwidth of the amplifiers, Hz.
    pub amplifier_bandwidth_hz: f64,
    /// Factor on the gyroscopic matrix.
    pub gyroscopic_factor: f64,
    /// Mass of the rotor with its tool, kg.
    pub rotor_mass_kg: f64,
    /// Reciprocal of the first flexible natural frequency of the free rotor, s.
    pub bending_time_s: f64,
    /// Distance between the magnets, m.
    pub bearing_span_m: f64,
    /// Force constant of both bearings, in the mean, N/A.
    pub ki_n_per_a: f64,
    /// Negative stiffness of both bearings, N/m; may be zero.
    pub negative_stiffness_n_per_m: f64,
    /// Largest force per air gap of both bearings, N/m.
    pub force_per_gap_n_per_m: f64,
    /// Young's modulus times outer diameter at the nose, N/m.
    pub nose_n_per_m: f64,
    /// Young's modulus times the cube of the outer diameter at the nose, N m/rad.
    pub nose_n_m_per_rad: f64,
}

impl MachineScale {
    /// Square of half the distance between the magnets, m²: a stiffness at both, tilting about the middle.
    pub fn tilting_arm_m2(&self) -> f64 {
        (0.5 * self.bearing_span_m).powi(2)
    }

    /// Unit of a stiffness at a position, N/m.
    pub fn stiffness_unit_n_per_m(&self) -> f64 {
        0.025 * self.force_per_gap_n_per_m
    }

    /// Unit of a damper at a position, N s/m: the force of a unit of stiffness at the first bending frequency.
    pub fn damping_unit_n_s_per_m(&self) -> f64 {
        self.stiffness_unit_n_per_m() * self.bending_time_s
    }

    /// Unit of a tilting stiffness, N m/rad.
    pub fn tilting_unit_n_m_per_rad(&self) -> f64 {
        0.25 * self.force_per_gap_n_per_m * self.tilting_arm_m2()
    }

    /// Unit of the inertia of a disc, kg m²: a unit of mass at an eighth of the distance between the magnets.
    pub fn inertia_unit_kg_m2(&self) -> f64 {
        6e-3 * self.rotor_mass_kg * (0.125 * self.bearing_span_m).powi(2)
    }

    /// Unit of a signal per rate of a current, m s/A: a hundredth of what the rigid rotor moves at the first bending
    /// frequency.
    pub fn pickup_unit_m_s_per_a(&self) -> f64 {
        1e-2 * self.ki_n_per_a / self.rotor_mass_kg * self.bending_time_s.powi(3)
    }

    /// Unit of a position on the shaft, m.
    pub fn position_unit_m(&self) -> f64 {
        0.25 * self.bearing_span_m
    }

    /// Half the sample rate, Hz.
    pub fn half_sample_rate_hz(&self) -> f64 {
        0.5 / self.sample_period_s
    }
}
