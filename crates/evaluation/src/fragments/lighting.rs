//! Which lights of a scene are looked at, where a person and not an experiment chooses.

use super::{LoadedScene, Source};
use crate::error::EvaluationError;
use scenes::{AreaLight, LightView, ViewError, find_view, lit_by, read_views};
use std::path::PathBuf;

/// Views and a light, as on the command line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lighting {
    /// Names of views, or directions `x,y,z` in which light travels; without them all of the scene without extent.
    pub views: Vec<String>,
    /// A TOML file of views in place of the scene's.
    pub file: Option<PathBuf>,
    /// A light in place of the views': one at infinity along each of them, or one in space.
    pub light: Option<AreaLight>,
}

impl Lighting {
    fn of_scene(&self, own: Vec<LightView>, origin: [f64; 3]) -> Result<Vec<LightView>, LightingError> {
        let known = match &self.file {
            None => own,
            Some(path) => {
                let read = read_views(path)?;
                read.into_iter().map(|view| view.relative_to(origin)).collect()
            }
        };
        if let Some(twice) = repeated(&self.views) {
            return Err(LightingError::Twice(twice.to_owned()));
        }
        let is_local = self.light.is_some_and(|light| light.front().is_some());
        let views = match &self.views[..] {
            // A local light has its own direction.
            _ if is_local => Vec::new(),
            // Views of a file were written down to be looked at.
            [] if self.file.is_some() => known,
            [] => known.into_iter().filter(|view| !view.light.has_extent()).collect(),
            wanted => wanted.iter().map(|wanted| find_view(&known, wanted)).collect::<Result<Vec<_>, _>>()?,
        };
        Ok(lit_by(self.light, views, self.views.first().map(String::as_str), origin)?)
    }
}

/// The first name that stands before.
fn repeated(names: &[String]) -> Option<&str> {
    names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)).map(|(_, name)| name.as_str())
}

#[derive(Debug, thiserror::Error)]
enum LightingError {
    #[error("view `{0}` is asked for twice")]
    Twice(String),
    #[error(transparent)]
    View(#[from] ViewError),
    #[error(transparent)]
    File(#[from] scenes::SceneError),
}

impl<'a> LoadedScene<'a> {
    /// Reads a scene with the lights that were asked for.
    pub(crate) fn load_lit(label: &'a str, lighting: &Lighting) -> Result<Self, EvaluationError> {
        let value = |reason: String| EvaluationError::Value(reason);
        let (source, own) =
            Source::load(label).map_err(|reason| value(format!("scene `{label}`: {reason}")))?;
        let lights = match &source {
            Source::Scene(scene) => {
                lighting.of_scene(own, scene.origin).map_err(|error| value(error.to_string()))?
            }
            Source::Stack(_) if *lighting == Lighting::default() => own,
            Source::Stack(_) => {
                return Err(value(format!(
                    "scene `{label}` is a stack: it was rendered under its own light, and takes no view and no light"
                )));
            }
        };
        Ok(LoadedScene { label, source, lights })
    }

    /// The same scene under its lights at infinity as if they had no extent; the scene is read again.
    pub(crate) fn under_parallel_light(&self) -> Result<Self, EvaluationError> {
        let fail = |reason: String| EvaluationError::Value(format!("scene `{}`: {reason}", self.label));
        let (source, _) = Source::load(self.label).map_err(fail)?;
        let lights = self.lights.iter().filter(|view| view.light.front().is_none());
        let lights: Vec<LightView> =
            lights.map(|view| LightView::directional(view.name.clone(), view.direction)).collect();
        if lights.is_empty() {
            return Err(fail("single scattering needs parallel light, a sun".to_owned()));
        }
        Ok(Self { label: self.label, source, lights })
    }
}
