//! What the page reads of a summary, any topic of which may be absent. Title, verdict and sentences.

use super::diagnosis_tables::{DiagnosisTopic, QuotedTopic};
use super::frequency_table::UpdatingTopic;
use super::readable::{self, words};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A topic of a summary is not as muspin writes it.
#[derive(Debug, thiserror::Error)]
#[error("summary.json: {topic}: {source}")]
pub struct TopicError {
    /// Key of the topic.
    pub topic: &'static str,
    /// What was expected, and what was found.
    pub source: serde_json::Error,
}

/// The line at the top: `verdict`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct VerdictLine {
    /// Whether every target is met; `None` when the run had none.
    pub(crate) met: Option<bool>,
    pub(crate) sentence: String,
}

/// A topic of the µ controller and of the PID.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct RivalTopic<T> {
    pub(crate) mu: Option<T>,
    pub(crate) pid: Option<T>,
}

/// `design`, as far as the page shows it beside its tables.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct DesignTopic {
    mu_peak: Option<f64>,
    pub(crate) controller_order: Option<usize>,
    mu_peak_reduced: Option<f64>,
    mu_peak_discrete: Option<f64>,
    stable: Option<bool>,
    speed_proof: QuotedTopic,
    controller_stability: Option<String>,
    pub(crate) table_as_written: WrittenTopic,
    pub(crate) largest_mu: Option<f64>,
}

impl DesignTopic {
    /// µ of what is delivered: of the sampled controller if there is one.
    fn final_mu(&self) -> Option<f64> {
        self.largest_mu.or(self.mu_peak_discrete).or(self.mu_peak_reduced).or(self.mu_peak)
    }
}

/// `design.table_as_written`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct WrittenTopic {
    pub(crate) mu_peak_discrete: Option<f64>,
}

/// `stiffness.<controller>`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct StiffnessTopic {
    pub(crate) minimum_n_per_m: Option<f64>,
}

/// `sensitivity.<controller>`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct SensitivityTopic {
    pub(crate) zone: Option<String>,
}

/// The run in sentences.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum PlainWords {
    One(String),
    Several(Vec<String>),
}

/// Topics that the page reads.
#[derive(Clone, Debug, Default)]
pub(crate) struct PageSummary {
    run: Option<String>,
    spindle: Option<String>,
    tool: Option<String>,
    verdict: Option<VerdictLine>,
    plain_words: Option<PlainWords>,
    pub(crate) updating: Option<UpdatingTopic>,
    pub(crate) design: Option<DesignTopic>,
    tightening: Option<QuotedTopic>,
    pub(crate) stiffness: RivalTopic<StiffnessTopic>,
    pub(crate) sensitivity: RivalTopic<SensitivityTopic>,
    pub(crate) diagnosis: Option<DiagnosisTopic>,
    /// The design is unstable: its figures are not shown at the top.
    pub(crate) is_unstable: bool,
}

/// A topic; `None` where the summary has none.
fn topic<T: DeserializeOwned>(summary: &Value, topic: &'static str) -> Result<Option<T>, TopicError> {
    match summary.get(topic) {
        None | Some(Value::Null) => Ok(None),
        Some(value) => T::deserialize(value).map(Some).map_err(|source| TopicError { topic, source }),
    }
}

impl PageSummary {
    /// Reads `summary.json`.
    pub(crate) fn of(summary: &Value) -> Result<Self, TopicError> {
        Ok(Self {
            run: topic(summary, "run")?,
            spindle: topic(summary, "spindle")?,
            tool: topic(summary, "tool")?,
            verdict: topic(summary, "verdict")?,
            plain_words: topic(summary, "plain_words")?,
            updating: topic(summary, "updating")?,
            design: topic(summary, "design")?,
            tightening: topic(summary, "tightening")?,
            stiffness: topic(summary, "stiffness")?.unwrap_or_default(),
            sensitivity: topic(summary, "sensitivity")?.unwrap_or_default(),
            diagnosis: topic(summary, "diagnosis")?,
            is_unstable: summary.get("instability").is_some_and(|found| !found.is_null()),
        })
    }

    /// Name of the machine, or of the command.
    pub(crate) fn title(&self) -> String {
        match (&self.spindle, &self.tool) {
            (Some(spindle), Some(tool)) => format!("{spindle} with {tool}"),
            (Some(name), None) | (None, Some(name)) => name.clone(),
            (None, None) => self.run.clone().unwrap_or_else(|| "muspin".to_owned()),
        }
    }

    fn final_mu(&self) -> Option<f64> {
        self.design.as_ref().and_then(DesignTopic::final_mu)
    }

    /// The verdict that the run states, or the one that its figures imply.
    pub(crate) fn verdict(&self) -> VerdictLine {
        if let Some(stated) = &self.verdict {
            return stated.clone();
        }
        let (mut met, mut parts) = (None, Vec::new());
        let mut note = |good: bool, text: String| {
            met = Some(met.unwrap_or(true) && good);
            parts.push(text);
        };
        if let Some(mu) = self.final_mu() {
            let relation = if mu <= 1.0 { "≤" } else { ">" };
            note(mu <= 1.0, format!("µ = {mu:.3} {relation} 1 for the controller as delivered"));
        }
        if let Some(stable) = self.design.as_ref().and_then(|d| d.stable) {
            let text = if stable { "stable over the whole speed range" } else { "not stable at every speed" };
            note(stable, text.to_owned());
        }
        if let Some((good, words)) = self.diagnosis.as_ref().and_then(stated_verdict) {
            note(good, words);
        }
        let sentence = parts.join("; ");
        VerdictLine { met, sentence: if sentence.is_empty() { "No targets in this run.".to_owned() } else { sentence } }
    }

    /// The class of the verdict's line, and what it begins with: a diagnosis that finds something missing has met no
    /// target.
    pub(crate) fn label(&self, met: Option<bool>) -> (&'static str, &'static str) {
        let found = self.diagnosis.as_ref().filter(|_| self.run.as_deref() == Some("diagnose"));
        let adequate = found.is_none_or(|found| found.verdict.as_deref() == Some("adequate"));
        match met {
            None => ("open", "Result"),
            Some(true) if !adequate => ("open", "Explained"),
            Some(false) if found.is_some() => ("missed", "✗ Not explained"),
            Some(true) if found.is_some() => ("met", "✓ Adequate"),
            Some(true) => ("met", "✓ Targets met"),
            Some(false) => ("missed", "✗ Target missed"),
        }
    }

    /// The run in sentences: those that it wrote itself, else those that its figures give; and what is proven.
    pub(crate) fn sentences(&self) -> Vec<String> {
        let mut sentences: Vec<String> = match &self.plain_words {
            None => vec![],
            Some(PlainWords::One(words)) => vec![words.clone()],
            Some(PlainWords::Several(all)) => all.clone(),
        };
        let own = !sentences.is_empty();
        let design = self.design.as_ref();
        let proven = [
            design.and_then(|d| d.speed_proof.sentence.clone()),
            design.and_then(|d| d.controller_stability.clone()),
            self.tightening.as_ref().and_then(|t| t.sentence.clone()),
        ];
        sentences.extend(proven.into_iter().flatten());
        if !own {
            sentences.extend(self.controller_sentences());
            sentences.extend(self.diagnosis_sentences());
        }
        sentences
    }

    fn controller_sentences(&self) -> Vec<String> {
        let mut sentences = vec![];
        let order = self.design.as_ref().and_then(|d| d.controller_order);
        if let (Some(order), Some(mu)) = (order, self.final_mu()) {
            let meaning = if mu <= 1.0 {
                "every specification holds for every plant within the uncertainty"
            } else {
                "some plant within the uncertainty misses a specification"
            };
            sentences.push(format!("The delivered controller has {order} states and µ = {mu:.3}: {meaning}."));
        }
        let minimum = |s: &Option<StiffnessTopic>| s.as_ref().and_then(|s| s.minimum_n_per_m);
        let (mu, pid) = (minimum(&self.stiffness.mu), minimum(&self.stiffness.pid));
        if let (Some(mu), Some(pid)) = (mu, pid) {
            let (softest, rival) = (readable::four_digits(mu * 1e-6), readable::four_digits(pid * 1e-6));
            sentences.push(format!(
                "At its softest the tool plane has {softest} N/µm with the µ controller and {rival} N/µm with the \
                 PID, a factor of {:.2}.",
                mu / pid
            ));
        }
        let zone = |s: &Option<SensitivityTopic>| s.as_ref().and_then(|s| s.zone.clone());
        let (mu, pid) = (zone(&self.sensitivity.mu), zone(&self.sensitivity.pid));
        if let (Some(mu), Some(pid)) = (mu, pid) {
            sentences.push(format!("ISO 14839-3 zone {mu} with the µ controller, zone {pid} with the PID."));
        }
        sentences
    }

    fn diagnosis_sentences(&self) -> Vec<String> {
        let Some(found) = &self.diagnosis else {
            return vec![];
        };
        let mut sentences: Vec<String> = found.sentence.iter().cloned().collect();
        if let (Some(before), Some(after)) = (found.gap_before, found.gap_after) {
            sentences.push(format!("The gap between model and measurement goes from {before:.2} σ to {after:.2} σ."));
        }
        sentences.extend(found.consequence.sentence.clone());
        sentences
    }
}

fn stated_verdict(found: &DiagnosisTopic) -> Option<(bool, String)> {
    let names: Vec<&str> = found.effects.iter().map(|e| e.effect.as_str()).collect();
    diagnosis_verdict(found.verdict.as_deref()?, &names)
}

/// Whether a diagnosis of these effects explains the measurement, in words; `None` for an unknown verdict.
pub(crate) fn diagnosis_verdict(verdict: &str, effects: &[&str]) -> Option<(bool, String)> {
    let effects = effects.iter().map(|name| words(name)).collect::<Vec<String>>().join(", ");
    Some(match verdict {
        "adequate" => (true, "the model agrees with the measurement".to_owned()),
        "named" => (true, format!("missing effect found: {effects}")),
        "probable" => (true, format!("probable, on a model to be updated first: {effects}")),
        "tie" => (true, "missing effects found that these data cannot tell apart".to_owned()),
        "unexplained" => (false, "a discrepancy remains that no known effect explains".to_owned()),
        _ => return None,
    })
}
