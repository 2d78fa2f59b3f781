//! The TOML keys of the kind `ranking-map`.

use crate::error::EvaluationError;
use crate::experiment::keys::{not_empty, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::SceneSettings;
use crate::kinds::search::{SearchAgreement, SearchExperiment, SearchReference, SearchTiming};
use applications::BiasSetting;
use serde::{Deserialize, Serialize};
use shadow_filtering::KernelSpec;

/// Name of the settings that all others are compared with.
pub(super) const BASE: &str = "as the search";

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RankingMapExperiment {
    /// Scenes, shadow maps and filter; its keys stand beside the others.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// As in a search.
    pub bias: BiasSetting,
    /// As in a search.
    #[serde(default)]
    pub reference: SearchReference,
    /// As in a search.
    #[serde(default)]
    pub family: Vec<String>,
    /// Functions of a candidate.
    pub order: usize,
    /// As in a search.
    pub cells: usize,
    /// As in a search.
    pub tolerance: f64,
    /// How many of the best are compared as a set.
    pub best: usize,
    /// How many of the best are followed through all variations, beside power and trigonometric moments.
    pub follow: usize,
    /// What is varied, each beside the settings above.
    pub variation: Vec<Variation>,
}

/// Settings that differ from those of the file in what is given here.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Variation {
    /// Name in records.
    pub name: String,
    /// What is varied; those of one axis stand together.
    pub axis: String,
    /// Other fragments of the same views.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Depth biases.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<BiasSetting>,
    /// Filter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kernel: Option<KernelSpec>,
    /// Cells of the support.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cells: Option<usize>,
    /// What G is compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<SearchReference>,
    /// Side of the shadow map in texels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<u32>,
    /// One scene alone, as in `scenes`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// One view alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
}

impl Settings for RankingMapExperiment {
    const KIND: &'static str = "ranking-map";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        // The search knows several orders, this kind one.
        let single = |error| match error {
            EvaluationError::Key { key, reason } if key == "orders[0]" => {
                EvaluationError::key("order", reason.replacen("orders: ", "order: ", 1))
            }
            other => other,
        };
        self.search(&Variation::default()).check().map_err(single)?;
        not_empty([("variation", self.variation.is_empty())])?;
        let names = || self.variation.iter().map(|variation| variation.name.as_str());
        unique(("variation", "name", "variation"), names())?;
        for (i, variation) in self.variation.iter().enumerate() {
            let place = format!("variation[{i}]");
            if variation.name == BASE {
                let reason =
                    format!("variation `{BASE}` is the name of the settings that others are compared with");
                return Err(EvaluationError::key(format!("{place}.name"), reason));
            }
            let plain = Variation {
                name: variation.name.clone(),
                axis: variation.axis.clone(),
                ..Variation::default()
            };
            if variation.name.is_empty() {
                return Err(EvaluationError::key(format!("{place}.name"), "variation without a name"));
            }
            if *variation == plain {
                let reason = format!("variation `{}` varies nothing", variation.name);
                return Err(EvaluationError::key(place, reason));
            }
            if let Some(scene) = variation.scene.as_ref().filter(|scene| !self.scenery.scenes.contains(scene))
            {
                let reason = format!("scene `{scene}` is none of `scenes`");
                return Err(EvaluationError::key(format!("{place}.scene"), reason));
            }
            self.search(variation).check().map_err(|error| match error {
                EvaluationError::Key { key, reason } => {
                    EvaluationError::key(format!("{place}.{key}"), format!("{place}: {reason}"))
                }
                other => other,
            })?;
        }
        Ok(())
    }

    evaluated_on_scenes!();

    fn scenes_replaced(&mut self) {
        let (scenes, views) = (&self.scenery.scenes, &self.scenery.views);
        let is_there = |variation: &Variation| {
            variation.scene.as_ref().is_none_or(|scene| scenes.contains(scene))
                && variation.view.as_ref().is_none_or(|view| views.contains(view))
        };
        self.variation.retain(is_there);
    }
}

impl RankingMapExperiment {
    /// The search whose candidates are judged: one block of all fragments.
    pub(super) fn search(&self, variation: &Variation) -> SearchExperiment {
        let mut scenery = self.scenery.clone();
        scenery.seed = variation.seed.unwrap_or(scenery.seed);
        scenery.kernel = variation.kernel.unwrap_or(scenery.kernel);
        scenery.size = variation.size.unwrap_or(scenery.size);
        if let Some(scene) = &variation.scene {
            scenery.scenes = vec![scene.clone()];
        }
        if let Some(view) = &variation.view {
            scenery.views = vec![view.clone()];
        }
        SearchExperiment {
            scenery,
            bias: variation.bias.unwrap_or(self.bias),
            reference: variation.reference.unwrap_or(self.reference),
            family: self.family.clone(),
            orders: vec![self.order],
            blocks: 1,
            best: self.best,
            recorded: None,
            cells: variation.cells.unwrap_or(self.cells),
            tolerance: self.tolerance,
            mark: Vec::new(),
            agreement: SearchAgreement { bases: 0, fragments: 0 },
            timing: SearchTiming { repetitions: 1, bases: 0, microlp_fragments: 0 },
        }
    }
}
