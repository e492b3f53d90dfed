//! The pictures of a results folder: the stem of the files, the section of the page, the order there.
//!
//! A stem is the word of the picture, with underscores; pictures of one kind that come several times are told apart by
//! a detail after a hyphen: `channel-front_x-from-rear_y`. The page takes section and order from the picture, so that
//! a page rebuilt from the files is the page of the run.

use super::sections::PageSection;

/// The kinds in the order in which a section shows them: variant, stem, section.
macro_rules! kinds {
    ($($kind:ident $stem:literal $section:ident,)*) => {
        /// A kind of picture, in the order in which a section shows them.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[allow(missing_docs)]
        pub enum Picture { $($kind,)* }

        impl Picture {
            /// All kinds.
            pub const ALL: [Self; [$($stem,)*].len()] = [$(Self::$kind,)*];

            fn entry(self) -> (&'static str, PageSection) {
                match self { $(Self::$kind => ($stem, PageSection::$section),)* }
            }
        }
    };
}

kinds! {
    Campbell "campbell" Model,
    WhirlShapes "whirl_shapes" Model,
    Measured "measured" Identification,
    BodeFront "bode_front" Updating,
    BodeRear "bode_rear" Updating,
    ModeShapes "mode_shapes" Updating,
    ModulusFactors "modulus_factors" Updating,
    Determinability "determinability" Updating,
    FrequencyErrors "frequency_errors" Updating,
    Mu "mu" Design,
    MuIterations "mu_iterations" Design,
    MuOrder "mu_order" Design,
    OrderCurve "order_curve" Design,
    MuSpeed "mu_speed" Design,
    SpeedStability "speed_stability" Design,
    DScales "d_scales" Design,
    ControllerBode "controller_bode" Design,
    Tools "tools" Table,
    ToolsStiffness "tools_stiffness" Table,
    Stiffness "stiffness" Stiffness,
    StiffnessWorst "stiffness_worst" Stiffness,
    StiffnessSampled "stiffness_sampled" Stiffness,
    Sensitivity "sensitivity" Sensitivity,
    SensitivityWorst "sensitivity_worst" Sensitivity,
    LoopGain "loop_gain" Margins,
    LoopSigma "loop_sigma" Margins,
    Nyquist "nyquist" Sensitivity,
    Poles "poles" Sensitivity,
    LoopCampbell "loop_campbell" Sensitivity,
    Thrust "thrust" Thrust,
    ToolStep "tool_step" Simulation,
    Animation "animation" Simulation,
    Response "response" Simulation,
    Orbits "orbits" Simulation,
    UnbalanceSpeed "unbalance_speed" Simulation,
    Cascade "cascade" Simulation,
    Contact "contact" Simulation,
    Chatter "chatter" Machining,
    Localisation "localisation" Diagnosis,
    LocalisationPlaces "localisation_places" Diagnosis,
    Impedance "impedance" Diagnosis,
    RotorErrors "rotor_errors" Diagnosis,
    Ranking "ranking" Diagnosis,
    Residual "residual" Diagnosis,
    Hammer "hammer" Diagnosis,
    Channel "channel" Diagnosis,
}

impl Picture {
    /// The picture of its kind that a detail tells apart from the others.
    pub fn with_detail(self, detail: impl Into<String>) -> PictureName {
        PictureName { kind: self, detail: detail.into() }
    }

    /// The picture of its kind with a number: none for the first, from 2 on for the others.
    pub fn with_number(self, number: usize) -> PictureName {
        match number {
            0 | 1 => self.into(),
            more => self.with_detail(more.to_string()),
        }
    }
}

/// A picture of a results folder. Names are in the order of the page.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PictureName {
    kind: Picture,
    detail: String,
}

impl From<Picture> for PictureName {
    fn from(kind: Picture) -> Self {
        kind.with_detail("")
    }
}

impl PictureName {
    pub(crate) fn section(&self) -> PageSection {
        self.kind.entry().1
    }

    /// Whether it shows sensors of one plane over currents of the other.
    pub(crate) fn is_cross_channel(&self) -> bool {
        if self.kind == Picture::Measured {
            return self.detail.contains("-from-");
        }
        let planes = |axes: [char; 2]| {
            self.detail.contains(&format!("_{}-from-", axes[0])) && {
                let from = self.detail.split("-from-").nth(1).unwrap_or_default();
                from.contains(&format!("_{}", axes[1]))
            }
        };
        self.kind == Picture::Channel && (planes(['x', 'y']) || planes(['y', 'x']))
    }

    /// Stem of its files.
    pub fn stem(&self) -> String {
        let kind = self.kind.entry().0;
        match self.detail.as_str() {
            "" => kind.to_owned(),
            detail => format!("{kind}-{detail}"),
        }
    }

    /// The picture whose files have this stem; none for files of another origin.
    pub fn of_stem(stem: &str) -> Option<Self> {
        let (kind, detail) = stem.split_once('-').unwrap_or((stem, ""));
        let mut all = Picture::ALL.into_iter();
        Some(all.find(|k| k.entry().0 == kind)?.with_detail(detail))
    }
}
