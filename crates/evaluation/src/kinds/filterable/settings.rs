//! The TOML keys of the kind `filterable`.

use crate::error::EvaluationError;
use crate::experiment::kind::{RunContext, Settings};
use crate::role::{Role, check_roles};
use crate::run::Recorded;
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, FilteringError, KernelSpec, Reference, SurfaceCounter, TechniqueSpec};

/// Largest accepted side of a shadow map.
pub(crate) const MAX_SIZE: u32 = 8192;

/// The TOML keys of this kind, beside `kind` and `scale`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FilterableExperiment {
    /// What is asked.
    pub question: String,
    /// What is expected, written before the first run.
    pub expectation: String,
    /// Seed of the sample of fragments.
    pub seed: u64,
    /// Side of the square shadow map in texels.
    pub size: u32,
    /// Names of procedural scenes, or files.
    pub scenes: Vec<String>,
    /// Names of light views; empty for all of a scene.
    #[serde(default)]
    pub views: Vec<String>,
    /// Fragments a view, spread evenly over all; 0 for all.
    pub fragments: usize,
    /// Of these, fragments a view for techniques that solve a linear program.
    #[serde(default)]
    pub certified_fragments: usize,
    /// Fragments a view at which closed forms are compared with the certified linear program.
    #[serde(default)]
    pub agreement_fragments: usize,
    /// The filter.
    pub kernel: KernelSpec,
    /// Largest difference between the receiver's depth and its tangent plane at a tap.
    pub plane_limit: f64,
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

/// A bias for F and one for all techniques.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BiasSetting {
    /// Bias of F, on top of the receiver plane.
    pub reference: DepthBias,
    /// Bias of every technique; they know no receiver plane.
    pub technique: DepthBias,
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

impl Role for FilterableTechnique {
    fn role(&self) -> Option<&str> {
        self.role.as_deref()
    }
}

impl Settings for FilterableExperiment {
    const KIND: &'static str = "filterable";

    fn seed(&self) -> u64 {
        self.seed
    }

    fn check(&self) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| Err(EvaluationError::Key { key: key.to_owned(), reason });
        if !(1..=MAX_SIZE).contains(&self.size) {
            return fail("size", format!("size = {} is not between 1 and {MAX_SIZE}", self.size));
        }
        for (key, empty) in [
            ("scenes", self.scenes.is_empty()),
            ("bias", self.bias.is_empty()),
            ("technique", self.technique.is_empty()),
        ] {
            if empty {
                return fail(key, format!("{key} is empty"));
            }
        }
        self.fits(&self.kernel, "kernel")?;
        for (key, sampled) in [
            ("certified_fragments", self.certified_fragments),
            ("agreement_fragments", self.agreement_fragments),
        ] {
            if self.fragments > 0 && sampled > self.fragments {
                return fail(key, format!("{key} = {sampled} exceeds fragments = {}", self.fragments));
            }
        }
        SurfaceCounter::new(self.surface_gap, self.plane_limit).map_err(in_key(""))?;
        for (i, bias) in self.bias.iter().enumerate() {
            bias.reference.check().map_err(in_key(&format!("bias[{i}].reference")))?;
            bias.technique.check().map_err(in_key(&format!("bias[{i}].technique")))?;
        }
        check_roles(&self.technique, "technique")?;
        for (i, technique) in self.technique.iter().enumerate() {
            if self.technique[..i].iter().any(|other| other.name == technique.name) {
                let key = format!("technique[{i}].name");
                return fail(&key, format!("technique `{}` appears twice", technique.name));
            }
            self.check_technique(i)?;
        }
        if !self.maps.views.is_empty() && self.maps.size == 0 {
            return fail("maps.size", "maps.size = 0 leaves no pixel".to_owned());
        }
        for name in &self.maps.techniques {
            if !self.technique.iter().any(|technique| technique.name == *name) {
                return fail(
                    "maps.techniques",
                    format!("maps.techniques: technique `{name}` is not defined"),
                );
            }
        }
        for (i, picture) in self.picture.iter().enumerate() {
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            if picture.id.is_empty() || !picture.id.chars().all(plain) {
                let key = format!("picture[{i}].id");
                return fail(
                    &key,
                    format!("picture id `{}` is no file name of letters, digits and -", picture.id),
                );
            }
            if self.picture[..i].iter().any(|other| other.id == picture.id) {
                return fail(&format!("picture[{i}].id"), format!("picture `{}` appears twice", picture.id));
            }
            if picture.techniques.is_empty() {
                let key = format!("picture[{i}].techniques");
                return fail(&key, format!("picture `{}` names no techniques", picture.id));
            }
            for name in &picture.techniques {
                if !self.technique.iter().any(|technique| technique.name == *name) {
                    let key = format!("picture[{i}].techniques");
                    return fail(
                        &key,
                        format!("picture `{}`: technique `{name}` is not defined", picture.id),
                    );
                }
            }
        }
        Ok(())
    }

    fn scenes(&self) -> Option<&[String]> {
        Some(&self.scenes)
    }

    fn replace_scenes(&mut self, scenes: &[String]) {
        self.scenes = scenes.to_vec();
        self.views.clear();
        if !self.maps.views.is_empty() {
            self.maps.views = vec!["*".to_owned()];
        }
        self.picture.truncate(1);
        for picture in &mut self.picture {
            picture.scene.clone_from(&scenes[0]);
            picture.view.clear();
            picture.texel = None;
        }
    }

    fn run(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        self.evaluate(context)
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
            (None, Some(kernel)) => self.fits(kernel, &format!("{place}.comparison")).map_err(named),
            _ => Err(EvaluationError::Key {
                key: place,
                reason: format!("technique `{}` needs either `method` or `comparison`", technique.name),
            }),
        }
    }

    /// Rejects kernels that cannot be built, or are larger than the map.
    fn fits(&self, kernel: &KernelSpec, place: &str) -> Result<(), EvaluationError> {
        let built = kernel.build().map_err(in_key(place))?;
        if built.size() > self.size as usize {
            return Err(EvaluationError::Key {
                key: format!("{place}.size"),
                reason: format!("{place}.size = {} exceeds the map's size = {}", built.size(), self.size),
            });
        }
        Ok(())
    }

    /// How F is computed under a bias.
    pub(crate) fn reference(&self, bias: &BiasSetting) -> Reference {
        Reference { bias: bias.reference, plane_limit: self.plane_limit }
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

    /// Whether a linear program is solved for each fragment.
    pub fn is_certified(&self) -> bool {
        self.method.as_ref().is_some_and(TechniqueSpec::is_certified)
    }
}

/// The error with its key below `place`, the empty one being the top of the file.
pub(crate) fn in_key(place: &str) -> impl Fn(FilteringError) -> EvaluationError {
    move |error| {
        let inner = match &error {
            FilteringError::Parameter { key, .. } => key,
            FilteringError::Basis(_) => "basis",
            _ => "",
        };
        let dot = if place.is_empty() || inner.is_empty() { "" } else { "." };
        let colon = if place.is_empty() { "" } else { ": " };
        EvaluationError::Key { key: format!("{place}{dot}{inner}"), reason: format!("{place}{colon}{error}") }
    }
}
