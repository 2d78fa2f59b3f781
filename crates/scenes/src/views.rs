//! Light views read from TOML, and those that are asked for by name, direction or light.

use std::path::Path;

use serde::Deserialize;
use thiserror::Error;

use crate::error::{FileFault, SceneError};
use crate::load::source::read_limited;
use crate::scene::MAX_COORDINATE;
use crate::vector::norm;
use crate::{AreaLight, LightView};

/// Largest accepted views file: far more than anyone writes by hand.
const MAX_VIEWS_BYTES: u64 = 1 << 20;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewsFile {
    #[serde(default)]
    view: Vec<ViewEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewEntry {
    name: String,
    direction: Option<[f64; 3]>,
    light: Option<AreaLight>,
}

/// Reads light views from a TOML file of `[[view]]` tables with the keys `name`, `direction` and, if it has an extent,
/// `light`.
///
/// `light` is the text of an [`AreaLight`], such as `"sun:0.53"` or `"rect:0,9,0;1,0,0;0,0,1"`. `direction` is the way the
/// light travels in world space, any length; a local light has its own and is refused another. Errors: unreadable file,
/// bad TOML, an unknown key or a light that makes no sense (with the line), no view at all, a name that is empty or given
/// twice, and a direction that is missing, zero, NaN, infinite or outside what a 32-bit float can normalise.
pub fn read_views(path: impl AsRef<Path>) -> Result<Vec<LightView>, SceneError> {
    let path = path.as_ref();
    read(path).map_err(|fault| fault.in_file(&path.to_string_lossy()))
}

fn read(path: &Path) -> Result<Vec<LightView>, FileFault> {
    let bytes = read_limited(path, MAX_VIEWS_BYTES)?;
    let text = str::from_utf8(&bytes).map_err(|error| FileFault::invalid("views", error.to_string()))?;
    parse_views(text)
}

fn parse_views(text: &str) -> Result<Vec<LightView>, FileFault> {
    let file: ViewsFile = toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = 1 + text.as_bytes()[..start].iter().filter(|&&byte| byte == b'\n').count();
        FileFault::invalid(format!("line {line}"), error.message())
    })?;
    if file.view.is_empty() {
        return Err(FileFault::invalid("views", "no [[view]] table"));
    }
    let mut views: Vec<LightView> = Vec::with_capacity(file.view.len());
    for entry in file.view {
        let at = format!("view {:?}", entry.name);
        if entry.name.trim().is_empty() {
            return Err(FileFault::invalid(at, format!("view number {} has an empty name", views.len() + 1)));
        }
        if views.iter().any(|view| view.name == entry.name) {
            return Err(FileFault::invalid(at, "this name is given twice"));
        }
        let light = entry.light.unwrap_or(AreaLight::DISTANT_POINT);
        let given = match (entry.direction, light.front()) {
            (Some(direction), None) => direction,
            (None, Some(front)) => front,
            (None, None) => return Err(FileFault::invalid(at, "missing field `direction`")),
            (Some(direction), Some(_)) => {
                let problem = format!("direction {direction:?} is one too many: {light} shines along U x V");
                return Err(FileFault::invalid(at, problem));
            }
        };
        let direction = given.map(|component| component as f32);
        let length = norm(direction.map(f64::from));
        // NaN is in no range.
        if !(1e-15..=MAX_COORDINATE).contains(&length) {
            return Err(FileFault::invalid(at, format!("direction {given:?} must be finite and not zero")));
        }
        views.push(LightView::new(entry.name, light, direction));
    }
    Ok(views)
}

/// A light view that cannot be had.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ViewError {
    /// There is none to begin with.
    #[error("the scene has no light view; give --view x,y,z")]
    None,
    /// Neither a name nor three numbers.
    #[error("--view: `{wanted}` is neither a view of this scene ({}) nor a direction x,y,z", known.join(", "))]
    Unknown {
        /// What was asked for.
        wanted: String,
        /// Names of the scene's views.
        known: Vec<String>,
    },
    /// Three numbers, and yet no direction.
    #[error("--view: `{wanted}` is no direction: it must be finite and not zero")]
    Direction {
        /// What was asked for.
        wanted: String,
    },
    /// A view for a light that needs none.
    #[error("--view {wanted}: the light `{light}` shines along U x V")]
    Local {
        /// What was asked for.
        wanted: String,
        /// The light.
        light: AreaLight,
    },
}

/// The view of a name, else of a direction `x,y,z` in which the light travels.
///
/// # Errors
/// [`ViewError`] for what is neither, and a direction that is zero or not finite.
pub fn find_view(views: &[LightView], wanted: &str) -> Result<LightView, ViewError> {
    if let Some(view) = views.iter().find(|view| view.name == wanted) {
        return Ok(view.clone());
    }
    let numbers: Result<Vec<f64>, _> = wanted.split(',').map(|number| number.trim().parse()).collect();
    let wanted = wanted.to_owned();
    let direction = match numbers.as_deref() {
        Ok(&[x, y, z]) => [x, y, z].map(|component| component as f32),
        _ => {
            let known = views.iter().map(|view| view.name.clone()).collect();
            return Err(ViewError::Unknown { wanted, known });
        }
    };
    if !direction.iter().all(|component| component.is_finite()) || direction == [0.0; 3] {
        return Err(ViewError::Direction { wanted });
    }
    Ok(LightView::directional(format!("light {wanted}"), direction))
}

/// The views of a light that was asked for: a local one by itself, placed in the file's coordinates, others along each of
/// `views`. Without a light the views as they are.
///
/// # Errors
/// [`ViewError::Local`] where `wanted`, the views' own names on the command line, is given for a local light;
/// [`ViewError::None`] for no view to shine along.
pub fn lit_by(
    light: Option<AreaLight>,
    views: Vec<LightView>,
    wanted: Option<&str>,
    origin: [f64; 3],
) -> Result<Vec<LightView>, ViewError> {
    match (light, wanted) {
        (Some(light), Some(wanted)) if light.front().is_some() => {
            Err(ViewError::Local { wanted: wanted.to_owned(), light })
        }
        (Some(light), None) if light.front().is_some() => {
            Ok(vec![LightView::new(light.to_string(), light, [0.0; 3]).relative_to(origin)])
        }
        (_, _) if views.is_empty() => Err(ViewError::None),
        (None, _) => Ok(views),
        (Some(light), _) => {
            let along =
                |view: LightView| LightView::new(format!("{} {light}", view.name), light, view.direction);
            Ok(views.into_iter().map(along).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        parse_views(text).unwrap_err().in_file("v.toml").to_string()
    }

    #[test]
    fn views_are_read_in_order() {
        let views = parse_views(
            "[[view]]\nname = \"low\"\ndirection = [1, -0.1, 0]\n[[view]]\nname=\"b\"\ndirection=[0,-2.5,0]",
        )
        .unwrap();
        assert_eq!(views[0], LightView::directional("low", [1.0, -0.1, 0.0]));
        assert_eq!(views[1].direction, [0.0, -2.5, 0.0]);
    }

    #[test]
    fn a_direction_without_a_direction_names_its_view() {
        for bad in ["[0,0,0]", "[nan,0,1]", "[0,inf,0]", "[1e-60,0,0]", "[1e300,0,0]"] {
            let text = format!("[[view]]\nname = \"low\"\ndirection = {bad}");
            let message = message(&text);
            assert!(message.starts_with("v.toml: view \"low\": direction ["), "{message}");
        }
    }

    #[test]
    fn lights_have_a_size_and_local_ones_a_place() {
        let views = parse_views(
            "[[view]]\nname='sun'\ndirection=[1,-1,0]\nlight='sun:0.53'\n\
             [[view]]\nname='lamp'\nlight='disc:0,4,0;1,0,0;0,0,1'",
        )
        .unwrap();
        assert_eq!(views[0].light, "sun:0.53".parse().unwrap());
        assert_eq!(views[1].direction, [0.0, -1.0, 0.0]);
        assert!(views[1].light.has_extent());
        let refused = |light: &str| message(&format!("[[view]]\nname='a'\n{light}"));
        assert!(refused("light='rect:0,0,0;1,0,0'").starts_with("v.toml: line 3: light `rect:0,0,0;1,0,0`"));
        assert!(refused("light='disc:0,0,0;0,0,0;0,1,0'").contains("line 3: half axis U = [0.0, 0.0, 0.0]"));
        assert!(refused("light='sun:-2'\ndirection=[1,0,0]").contains("size of -2 degrees"));
        assert!(refused("light='sun:2'").contains("view \"a\": missing field `direction`"));
        assert!(refused("light=3").contains("line 3"));
        let both = refused("light='disc:0,4,0;1,0,0;0,0,1'\ndirection=[1,0,0]");
        assert!(both.starts_with("v.toml: view \"a\": direction [1.0, 0.0, 0.0] is one too many"), "{both}");
    }

    #[test]
    fn unknown_keys_missing_keys_and_bad_toml_name_the_line() {
        assert!(
            message("[[view]]\nname='a'\ndirection=[1,0,0]\ncolour='red'").contains("line 4: unknown field")
        );
        assert!(message("[[view]]\nname='a'").contains("missing field `direction`"));
        assert!(message("[[view]]\nname='a'\ndirection=[1,0]").contains("line 3"));
        assert!(message("[[view").starts_with("v.toml: line 1: "));
        assert!(message("").contains("no [[view]] table"));
        assert!(message("[[view]]\nname='a'\ndirection=[1,0,0]\n".repeat(2).as_str()).contains("twice"));
        assert!(message("[[view]]\nname=' '\ndirection=[1,0,0]\n").contains("empty name"));
    }

    #[test]
    fn a_missing_file_is_an_error_that_names_it() {
        let message = read_views("no/such/views.toml").unwrap_err().to_string();
        assert!(message.starts_with("no/such/views.toml: cannot read: "), "{message}");
    }
}
