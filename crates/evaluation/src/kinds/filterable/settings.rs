//! The TOML keys of the kind `filterable`.

use crate::error::EvaluationError;
use crate::experiment::keys::{each, file_name, in_key, not_empty, unique};
use crate::experiment::kind::{Settings, evaluated_on_scenes};
use crate::fragments::{SceneSettings, check_bias};
use crate::pictures::move_to;
use crate::role::{check_names, plays_a_role};
use applications::{BiasSetting, ShadowMethod};
use serde::{Deserialize, Serialize};
use shadow_filtering::{FilteringError, KernelSpec, SurfaceCounter, TechniqueSpec};

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FilterableExperiment {
    /// Scenes, shadow maps and filter; its keys stand beside the others.
    #[serde(skip)]
    pub scenery: SceneSettings,
    /// Of these, fragments a view for techniques that solve a linear program.
    #[serde(default)]
    pub certified_fragments: usize,
    /// Fragments a view at which closed forms are compared with the certified linear program.
    #[serde(default)]
    pub agreement_fragments: usize,
    /// Depths further apart than this, and than their planes' slopes explain, are different surfaces.
    pub surface_gap: f64,
    /// Depth biases; the first is that of maps and pictures.
    pub bias: Vec<BiasSetting>,
    /// What is timed after all errors are known.
    pub timing: FilterableTiming,
    /// The techniques.
    pub technique: Vec<FilterableTechnique>,
    /// Error maps.
    #[serde(default)]
    pub maps: MapSettings,
    /// Single kernels (MSM15 Figure 2).
    #[serde(default)]
    pub picture: Vec<Picture>,
}

/// Timed filters and shading on the first view.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FilterableTiming {
    /// How often each is timed; the fragments are those of the records.
    pub repetitions: usize,
}

/// One technique: prefiltered data, or percentage-closer filtering with a kernel of its own and the techniques' bias.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FilterableTechnique {
    /// Name in records and legends.
    pub name: String,
    /// Part in what papers claim, unique among its like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// A filterable shadow map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<TechniqueSpec>,
    /// A kernel for comparisons a tap; size 1 is the plain shadow map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub comparison: Option<KernelSpec>,
}

/// Error maps of whole views.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MapSettings {
    /// Views as `scene/view`; `*` for all.
    pub views: Vec<String>,
    /// Names of techniques; empty for all but those that solve a linear program.
    #[serde(default)]
    pub techniques: Vec<String>,
    /// Largest side of a map in pixels; larger shadow maps are reduced to the worst value of each block.
    pub size: u32,
}

/// F and the techniques over all fragment depths, for the kernel around one texel.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// File name without extension.
    pub id: String,
    /// Scene, as in `scenes`.
    pub scene: String,
    /// View.
    pub view: String,
    /// Column and row of the texel. Without it: the sampled fragment where the first technique errs most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texel: Option<[u32; 2]>,
    /// Names of techniques.
    pub techniques: Vec<String>,
}

plays_a_role!(FilterableTechnique);

impl Settings for FilterableExperiment {
    const KIND: &'static str = "filterable";
    const ON_SCENES: bool = true;
    const IS_DIVISIBLE: bool = true;

    fn check(&self) -> Result<(), EvaluationError> {
        self.scenery.check(true)?;
        not_empty([("bias", self.bias.is_empty()), ("technique", self.technique.is_empty())])?;
        for (key, sampled) in [
            ("certified_fragments", self.certified_fragments),
            ("agreement_fragments", self.agreement_fragments),
        ] {
            if self.scenery.fragments > 0 && sampled > self.scenery.fragments {
                let most = self.scenery.fragments;
                return Err(EvaluationError::key(
                    key,
                    format!("{key} = {sampled} exceeds fragments = {most}"),
                ));
            }
        }
        SurfaceCounter::new(self.surface_gap, self.scenery.plane_limit).map_err(in_key(""))?;
        each("bias", &self.bias, check_bias)?;
        check_names(&self.technique, "technique")?;
        (0..self.technique.len()).try_for_each(|i| self.check_technique(i))?;
        if !self.maps.views.is_empty() && self.maps.size == 0 {
            return Err(EvaluationError::key("maps.size", "maps.size = 0 leaves no pixel"));
        }
        self.check_names("maps.techniques", "maps.techniques", &self.maps.techniques)?;
        unique(("picture", "id", "picture"), self.picture.iter().map(|picture| picture.id.as_str()))?;
        for (i, picture) in self.picture.iter().enumerate() {
            file_name(&format!("picture[{i}].id"), "picture", &picture.id)?;
            let (key, what) = (format!("picture[{i}].techniques"), format!("picture `{}`", picture.id));
            if picture.techniques.is_empty() {
                return Err(EvaluationError::key(key, format!("{what} names no techniques")));
            }
            self.check_names(&key, &what, &picture.techniques)?;
        }
        Ok(())
    }

    evaluated_on_scenes!();

    fn scenes_replaced(&mut self) {
        if !self.maps.views.is_empty() {
            self.maps.views = vec!["*".to_owned()];
        }
        self.picture.truncate(1);
        move_to(&self.scenery.scenes[0], self.picture.iter_mut().map(|p| (&mut p.scene, &mut p.view)));
        self.picture.iter_mut().for_each(|picture| picture.texel = None);
    }
}

impl FilterableExperiment {
    fn check_technique(&self, index: usize) -> Result<(), EvaluationError> {
        let technique = &self.technique[index];
        let place = format!("technique[{index}]");
        let named = |error: EvaluationError| match error {
            EvaluationError::Key { key, reason } => {
                EvaluationError::Key { key, reason: format!("technique `{}`: {reason}", technique.name) }
            }
            other => other,
        };
        match (&technique.method, &technique.comparison) {
            (Some(method), None) => {
                // The format counts bits; nothing is rounded to it.
                let checked = method.check_storage(&["alpha", "format"]).and_then(|()| method.draft());
                checked.map(|_| ()).map_err(in_key(&format!("{place}.method"))).map_err(named)
            }
            (None, Some(kernel)) => {
                self.scenery.check_kernel(kernel, &format!("{place}.comparison")).map_err(named)
            }
            (None, None) | (Some(_), Some(_)) => {
                let reason = format!("technique `{}` needs either `method` or `comparison`", technique.name);
                Err(EvaluationError::key(place, reason))
            }
        }
    }

    fn check_names(&self, key: &str, what: &str, names: &[String]) -> Result<(), EvaluationError> {
        let known = |name: &String| self.technique.iter().any(|technique| technique.name == *name);
        match names.iter().find(|name| !known(name)) {
            Some(name) => {
                Err(EvaluationError::key(key, format!("{what}: technique `{name}` is not defined")))
            }
            None => Ok(()),
        }
    }
}

impl MapSettings {
    /// Whether a technique is drawn.
    pub fn shows(&self, technique: &FilterableTechnique) -> bool {
        let named = self.techniques.contains(&technique.name);
        named || (self.techniques.is_empty() && !technique.is_certified())
    }

    /// Whether a view is drawn.
    pub fn covers(&self, scene: &str, view: &str) -> bool {
        let id = format!("{scene}/{view}");
        self.views.iter().any(|wanted| wanted == "*" || *wanted == id)
    }
}

impl FilterableTechnique {
    /// The error with the technique's name.
    pub(crate) fn failure(&self, error: FilteringError) -> EvaluationError {
        EvaluationError::Value(format!("technique `{}`: {error}", self.name))
    }

    /// The technique, ready for any view.
    pub(super) fn prepared(&self) -> Result<ShadowMethod, EvaluationError> {
        let method = match (&self.method, &self.comparison) {
            (Some(method), _) => {
                method.build().map(|technique| ShadowMethod::Prefiltered(Box::new(technique)))
            }
            (None, Some(kernel)) => kernel.build().map(ShadowMethod::Comparison),
            (None, None) => {
                let reason = format!("technique `{}` needs either `method` or `comparison`", self.name);
                return Err(EvaluationError::Value(reason));
            }
        };
        method.map_err(|error| self.failure(error))
    }

    /// Whether a linear program is solved for each fragment.
    pub fn is_certified(&self) -> bool {
        self.method.as_ref().is_some_and(TechniqueSpec::is_certified)
    }
}
