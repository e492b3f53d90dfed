//! A diagnosis as the topic `diagnosis` of the summary.

use super::diagnosis_words::{fault_words, sentence, size, statement};
use super::readable;
use super::summary::{Named, finite};
use crate::diagnose::conclude::verdict::Rival;
use crate::diagnose::locate::localisation::PortScore;
use crate::diagnose::{Diagnosis, NamedEffect, Verdict};
use crate::spindle::effects::AXIS_NAMES as AXES;
use crate::spindle::{Effect, Location};
use serde::{Deserialize, Serialize};

/// Half width of the interval that holds 90 % of a normal distribution, in standard deviations.
const HALF_WIDTH_90: f64 = 1.645;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct DiagnosisSummary {
    pub(crate) verdict: Option<String>,
    pub(crate) sentence: Option<String>,
    pub(crate) effects: Vec<EffectSummary>,
    /// Shown by the records and too small for a name.
    small_effects: Vec<EffectSummary>,
    pub(crate) tie: Vec<RivalSummary>,
    #[serde(flatten)]
    pub(crate) all: GapOfAll,
    gap_nearest: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nearest: Option<NearestSummary>,
    strained: Vec<StrainedSummary>,
    further_off: Vec<FurtherOffSummary>,
    #[serde(flatten)]
    pub(crate) parts: GapsOfParts,
    pub(crate) held_out: String,
    next_measurement: Option<String>,
    worst_block: WorstBlock,
    pub(crate) localisation: Vec<PortSummary>,
    pub(crate) menu: Vec<ProposalSummary>,
    pub(crate) detectable: Vec<DetectableSummary>,
    pub(crate) ranking: Vec<RankedSummary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) correction: Option<CorrectionSummary>,
}

/// Gaps before and after over all records, fitted to all.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct GapOfAll {
    pub(crate) gap_before: Option<f64>,
    pub(crate) gap_after: Option<f64>,
}

/// Gaps before and after of the records that were used and of those that were held out.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct GapsOfParts {
    pub(crate) gap_before_used: Option<f64>,
    pub(crate) gap_after_used: Option<f64>,
    pub(crate) gap_before_held_out: Option<f64>,
    pub(crate) gap_after_held_out: Option<f64>,
}

/// What came nearest to records that nothing explains, and the gap that it leaves.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct NearestSummary {
    effects: Vec<EffectSummary>,
    gap: Option<f64>,
}

/// A nuisance parameter beyond its prior.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct StrainedSummary {
    parameter: String,
    prior_standard_deviations: Option<f64>,
}

/// A number of the machine that is further off than a careful updating leaves.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct FurtherOffSummary {
    parameter: String,
    usual_deviations: Option<f64>,
    relative_change: Option<f64>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct WorstBlock {
    chi2_per_residual: Option<f64>,
    output: usize,
    input: usize,
    from_hz: Option<f64>,
    to_hz: Option<f64>,
}

/// Where an effect sits: one of these, or nothing.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PlaceSummary {
    #[serde(skip_serializing_if = "Option::is_none")]
    bearing: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mode: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    region: Option<String>,
}

/// An effect with its parameters and their intervals.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct EffectSummary {
    pub(crate) effect: String,
    #[serde(default, rename = "where")]
    pub(crate) place: PlaceSummary,
    #[serde(default)]
    pub(crate) parameters: Named<Option<f64>>,
    #[serde(default)]
    pub(crate) standard_deviations: Named<Option<f64>>,
    #[serde(default)]
    pub(crate) intervals_90: Named<[Option<f64>; 2]>,
    #[serde(default)]
    words: String,
}

/// A member of a tie.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RivalSummary {
    #[serde(flatten)]
    members: Members,
    /// What it says is wrong with the records.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    record_faults: Vec<String>,
    #[serde(default)]
    score_above_best: Option<f64>,
}

/// One effect stands for itself; several are a list.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged)]
enum Members {
    Several { effects: Vec<EffectSummary> },
    One(Box<EffectSummary>),
}

/// What a free law at a place explains.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PortSummary {
    pub(crate) port: String,
    chi2_before: Option<f64>,
    pub(crate) chi2_after: Option<f64>,
    pub(crate) score_above_best: Option<f64>,
    shape: String,
    pub(crate) words: String,
    size: Option<f64>,
    size_unit: String,
}

/// A measurement that would separate the members of a tie.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct ProposalSummary {
    pub(crate) measurement: String,
    pub(crate) separation_chi2: Option<f64>,
}

/// The smallest size of an effect that the data would show.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct DetectableSummary {
    pub(crate) effect: String,
    #[serde(rename = "where")]
    pub(crate) place: PlaceSummary,
    parameters: Named<Option<f64>>,
    pub(crate) words: String,
    named_from: Named<Option<f64>>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct RankedSummary {
    pub(crate) effect: String,
    #[serde(rename = "where")]
    pub(crate) place: PlaceSummary,
    pub(crate) score_above_best: Option<f64>,
}

/// What stands in for a name when the verdict is unexplained.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct CorrectionSummary {
    pub(crate) port: String,
    shape: Option<String>,
    #[serde(flatten)]
    pub(crate) gaps: GapsOfParts,
    law: String,
    corrected_response: String,
}

impl From<&Diagnosis> for DiagnosisSummary {
    fn from(d: &Diagnosis) -> Self {
        let strained = d
            .strained
            .iter()
            .map(|(name, sd)| StrainedSummary { parameter: name.clone(), prior_standard_deviations: finite(*sd) });
        let further_off = d.further_off.iter().map(|f| FurtherOffSummary {
            parameter: f.parameter.clone(),
            usual_deviations: finite(f.usual_deviations),
            relative_change: finite(f.relative_change),
        });
        let menu = d
            .menu
            .iter()
            .map(|m| ProposalSummary { measurement: m.text.clone(), separation_chi2: finite(m.separation) });
        let detectable = d.detectable.iter().map(|e| DetectableSummary {
            effect: e.effect.kind.name().to_owned(),
            place: PlaceSummary::from(&e.effect.location),
            parameters: parameters(&e.effect),
            words: size(&e.effect),
            named_from: parameters(&e.named_from),
        });
        let ranking = d.ranking.iter().map(|(e, score)| RankedSummary {
            effect: e.kind.name().to_owned(),
            place: PlaceSummary::from(&e.location),
            score_above_best: finite(*score),
        });
        let (used, held) = (d.gaps(false), d.gaps(true));
        Self {
            verdict: Some(d.verdict.name().to_owned()),
            sentence: Some(sentence(d)),
            effects: d.effects.iter().map(EffectSummary::from).collect(),
            small_effects: d.small_effects.iter().map(EffectSummary::from).collect(),
            tie: d.tie.iter().map(RivalSummary::from).collect(),
            all: GapOfAll { gap_before: finite(d.gap_before), gap_after: finite(d.gap_after) },
            gap_nearest: finite(d.gap_nearest),
            nearest: (d.verdict == Verdict::Unexplained).then(|| NearestSummary {
                effects: d.nearest.iter().cloned().map(|e| EffectSummary::from(&NamedEffect::from(e))).collect(),
                gap: finite(d.gap_nearest),
            }),
            strained: strained.collect(),
            further_off: further_off.collect(),
            parts: GapsOfParts::of(used, (d.gap_before_held_out, d.gap_after_held_out)),
            held_out: d.held_out.clone(),
            next_measurement: d.next_measurement.clone(),
            worst_block: WorstBlock {
                chi2_per_residual: finite(d.misfit.value),
                output: d.misfit.output,
                input: d.misfit.input,
                from_hz: finite(d.misfit.band_hz.0),
                to_hz: finite(d.misfit.band_hz.1),
            },
            localisation: d.localisation.ports.iter().map(PortSummary::from).collect(),
            menu: menu.collect(),
            detectable: detectable.collect(),
            ranking: ranking.collect(),
            correction: d.correction.as_ref().map(|c| CorrectionSummary {
                port: c.port.clone(),
                shape: d.localisation.named_port().map(PortScore::shape),
                gaps: GapsOfParts::of(used, held),
                law: "correction.csv".to_owned(),
                corrected_response: "corrected-frf.csv".to_owned(),
            }),
        }
    }
}

impl DiagnosisSummary {
    /// The effects whose parameters are shown: all members of a tie, or what was named.
    pub(crate) fn shown_effects(&self) -> Vec<&EffectSummary> {
        let tied: Vec<&EffectSummary> = self.tie.iter().flat_map(RivalSummary::effects).collect();
        if tied.is_empty() { self.effects.iter().collect() } else { tied }
    }
}

impl GapsOfParts {
    fn of(used: (f64, f64), held_out: (f64, f64)) -> Self {
        Self {
            gap_before_used: finite(used.0),
            gap_after_used: finite(used.1),
            gap_before_held_out: finite(held_out.0),
            gap_after_held_out: finite(held_out.1),
        }
    }
}

impl From<&Location> for PlaceSummary {
    fn from(location: &Location) -> Self {
        let mut place = Self::default();
        match location {
            Location::None => {}
            Location::Bearing(b) => place.bearing = Some(b.name().to_owned()),
            Location::Axis(axis) => place.axis = Some(AXES[*axis % 4].to_owned()),
            Location::Across { from, to } => {
                place.from = Some(AXES[*from % 4].to_owned());
                place.to = Some(AXES[*to % 4].to_owned());
            }
            Location::Position(z) => place.position_m = Some(*z),
            Location::InPlane(z, plane) => {
                place.position_m = Some(*z);
                place.axis = Some(plane.name().to_owned());
            }
            Location::Mode(mode) => place.mode = Some(*mode),
            Location::Region(region) => place.region = Some(region.clone()),
        }
        place
    }
}

impl PlaceSummary {
    /// The place in words; empty for an effect without one.
    pub(crate) fn words(&self) -> String {
        let position = self.position_m.map(|z| readable::figure("position_m", z));
        let mode = self.mode.map(|m| m.to_string());
        let named = [&self.bearing, &self.axis, &self.from, &self.to, &self.region].map(Option::clone);
        let all = named.into_iter().chain([position, mode]).flatten();
        all.collect::<Vec<String>>().join(", ")
    }
}

fn parameters(effect: &Effect) -> Named<Option<f64>> {
    key_values(effect, effect.values.iter().map(|x| finite(*x)))
}

/// Values under the names of an effect's parameters.
fn key_values<T>(effect: &Effect, values: impl Iterator<Item = T>) -> Named<T> {
    let parameters = effect.kind.parameters().iter();
    parameters.map(|p| p.name.to_owned()).zip(values).collect()
}

impl From<&NamedEffect> for EffectSummary {
    fn from(e: &NamedEffect) -> Self {
        let deviations = e.standard_deviations.iter().map(|x| finite(*x));
        let mut deviations = key_values(&e.effect, deviations);
        let intervals = e.intervals.iter().map(|(a, b)| [finite(*a), finite(*b)]);
        let mut intervals = key_values(&e.effect, intervals);
        if let Some(sd) = e.position_sd_m {
            deviations.0.push(("position_m".to_owned(), finite(sd)));
        }
        if let (Some(sd), Some(z)) = (e.position_sd_m, e.effect.location.position_m()) {
            let ends = [z - HALF_WIDTH_90 * sd, z + HALF_WIDTH_90 * sd];
            intervals.0.push(("position_m".to_owned(), ends.map(finite)));
        }
        Self {
            effect: e.effect.kind.name().to_owned(),
            place: PlaceSummary::from(&e.effect.location),
            parameters: parameters(&e.effect),
            standard_deviations: deviations,
            intervals_90: intervals,
            words: statement(e),
        }
    }
}

impl From<&Rival> for RivalSummary {
    fn from(rival: &Rival) -> Self {
        Self {
            members: match &rival.effects[..] {
                [one] => Members::One(Box::new(EffectSummary::from(one))),
                several => Members::Several { effects: several.iter().map(EffectSummary::from).collect() },
            },
            record_faults: rival.record_faults.iter().map(fault_words).collect(),
            score_above_best: finite(rival.score_above_best),
        }
    }
}

impl RivalSummary {
    fn effects(&self) -> &[EffectSummary] {
        match &self.members {
            Members::One(effect) => std::slice::from_ref(effect.as_ref()),
            Members::Several { effects } => effects,
        }
    }
}

impl From<&PortScore> for PortSummary {
    fn from(p: &PortScore) -> Self {
        let law = p.law();
        Self {
            port: p.port.clone(),
            chi2_before: finite(p.chi2_before),
            chi2_after: finite(p.chi2_after),
            score_above_best: finite(p.score_above_best),
            shape: law.map_or("nothing", |l| l.name_of_shape()).to_owned(),
            words: p.shape(),
            size: finite(law.map_or(0.0, |l| l.size())),
            size_unit: law.map_or("", |l| l.unit.key()).to_owned(),
        }
    }
}
