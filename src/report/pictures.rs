//! The pictures of a results folder: the stem of the files, the section of the page, the order there.
//!
//! A stem is the word of the picture, with underscores; pictures of one kind that come several times are told apart by
//! a detail after a hyphen: `channel-front_x-from-rear_y`. The page takes section and order from the picture, so that
//! a page rebuilt from the files is the page of the run.

use super::sections::PageSection;

/// A kind of picture, in the order in which a section shows them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)]
pub enum Picture {
    Campbell,
    BodeFront,
    BodeRear,
    ModeShapes,
    ModulusFactors,
    Determinability,
    FrequencyErrors,
    Mu,
    MuIterations,
    MuOrder,
    OrderCurve,
    MuSpeed,
    SpeedStability,
    DScales,
    ControllerBode,
    Tools,
    ToolsStiffness,
    Stiffness,
    StiffnessWorst,
    StiffnessSampled,
    Sensitivity,
    SensitivityWorst,
    LoopGain,
    Nyquist,
    Poles,
    ToolStep,
    Animation,
    Response,
    Orbits,
    UnbalanceSpeed,
    Contact,
    Chatter,
    Localisation,
    LocalisationPlaces,
    Impedance,
    Ranking,
    Residual,
    Hammer,
    Channel,
}

impl Picture {
    /// All kinds.
    pub const ALL: [Self; 39] = [
        Self::Campbell,
        Self::BodeFront,
        Self::BodeRear,
        Self::ModeShapes,
        Self::ModulusFactors,
        Self::Determinability,
        Self::FrequencyErrors,
        Self::Mu,
        Self::MuIterations,
        Self::MuOrder,
        Self::OrderCurve,
        Self::MuSpeed,
        Self::SpeedStability,
        Self::DScales,
        Self::ControllerBode,
        Self::Tools,
        Self::ToolsStiffness,
        Self::Stiffness,
        Self::StiffnessWorst,
        Self::StiffnessSampled,
        Self::Sensitivity,
        Self::SensitivityWorst,
        Self::LoopGain,
        Self::Nyquist,
        Self::Poles,
        Self::ToolStep,
        Self::Animation,
        Self::Response,
        Self::Orbits,
        Self::UnbalanceSpeed,
        Self::Contact,
        Self::Chatter,
        Self::Localisation,
        Self::LocalisationPlaces,
        Self::Impedance,
        Self::Ranking,
        Self::Residual,
        Self::Hammer,
        Self::Channel,
    ];

    /// Stem and section.
    fn entry(self) -> (&'static str, PageSection) {
        match self {
            Self::Campbell => ("campbell", PageSection::Model),
            Self::BodeFront => ("bode_front", PageSection::Updating),
            Self::BodeRear => ("bode_rear", PageSection::Updating),
            Self::ModeShapes => ("mode_shapes", PageSection::Updating),
            Self::ModulusFactors => ("modulus_factors", PageSection::Updating),
            Self::Determinability => ("determinability", PageSection::Updating),
            Self::FrequencyErrors => ("frequency_errors", PageSection::Updating),
            Self::Mu => ("mu", PageSection::Design),
            Self::MuIterations => ("mu_iterations", PageSection::Design),
            Self::MuOrder => ("mu_order", PageSection::Design),
            Self::OrderCurve => ("order_curve", PageSection::Design),
            Self::MuSpeed => ("mu_speed", PageSection::Design),
            Self::SpeedStability => ("speed_stability", PageSection::Design),
            Self::DScales => ("d_scales", PageSection::Design),
            Self::ControllerBode => ("controller_bode", PageSection::Design),
            Self::Tools => ("tools", PageSection::Table),
            Self::ToolsStiffness => ("tools_stiffness", PageSection::Table),
            Self::Stiffness => ("stiffness", PageSection::Stiffness),
            Self::StiffnessWorst => ("stiffness_worst", PageSection::Stiffness),
            Self::StiffnessSampled => ("stiffness_sampled", PageSection::Stiffness),
            Self::Sensitivity => ("sensitivity", PageSection::Sensitivity),
            Self::SensitivityWorst => ("sensitivity_worst", PageSection::Sensitivity),
            Self::LoopGain => ("loop_gain", PageSection::Margins),
            Self::Nyquist => ("nyquist", PageSection::Sensitivity),
            Self::Poles => ("poles", PageSection::Sensitivity),
            Self::ToolStep => ("tool_step", PageSection::Simulation),
            Self::Animation => ("animation", PageSection::Simulation),
            Self::Response => ("response", PageSection::Simulation),
            Self::Orbits => ("orbits", PageSection::Simulation),
            Self::UnbalanceSpeed => ("unbalance_speed", PageSection::Simulation),
            Self::Contact => ("contact", PageSection::Simulation),
            Self::Chatter => ("chatter", PageSection::Machining),
            Self::Localisation => ("localisation", PageSection::Diagnosis),
            Self::LocalisationPlaces => ("localisation_places", PageSection::Diagnosis),
            Self::Impedance => ("impedance", PageSection::Diagnosis),
            Self::Ranking => ("ranking", PageSection::Diagnosis),
            Self::Residual => ("residual", PageSection::Diagnosis),
            Self::Hammer => ("hammer", PageSection::Diagnosis),
            Self::Channel => ("channel", PageSection::Diagnosis),
        }
    }

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

    /// Whether it shows a sensor of one plane over a current of the other.
    pub(crate) fn is_cross_channel(&self) -> bool {
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
