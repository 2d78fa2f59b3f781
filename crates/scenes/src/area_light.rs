//! Lights that have an extent: the sun's disc, a window, a lamp.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::scene::MAX_COORDINATE;
use crate::vector::{cross, norm, normalize};

/// The outline of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outline {
    /// All combinations of the half axes with factors in \[-1, 1\].
    Rectangle,
    /// All combinations whose factors have a sum of squares of at most 1; an ellipse where the axes differ.
    Disc,
}

/// A light as it is written down: `sun:DEGREES`, `sun:AxB`, `rect:CENTRE;U;V` or `disc:CENTRE;U;V`.
///
/// A local light shines along U x V, the sun along the view's direction. Records and settings hold the text.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(try_from = "String", into = "String")]
pub enum AreaLight {
    /// Infinitely far. Which way it shines is the view's business.
    Sun {
        /// Disc or rectangle.
        outline: Outline,
        /// Angular diameters along the map's x and y axis in degrees, from 0 to below 180; alike for a disc.
        degrees: [f64; 2],
    },
    /// In space.
    Local {
        /// Disc or rectangle.
        outline: Outline,
        /// World position of the middle.
        centre: [f64; 3],
        /// Half axes, world units, not parallel and not zero.
        half_axes: [[f64; 3]; 2],
    },
}

/// The sun seen from the earth, in degrees.
pub const SUN_DEGREES: f64 = 0.53;

impl TryFrom<String> for AreaLight {
    type Error = LightError;

    fn try_from(text: String) -> Result<Self, LightError> {
        text.parse()
    }
}

impl From<AreaLight> for String {
    fn from(light: AreaLight) -> Self {
        light.to_string()
    }
}

/// The sine of the angle between two half axes below which they count as parallel: single-precision vectors that were
/// meant to be parallel differ by less.
const PARALLEL_SINE: f64 = 1e-6;

/// Least length of a half axis: the square of a length, and the area of the light, stay normal numbers.
const LEAST_AXIS: f64 = 1e-15;

/// Why a light makes no sense.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LightError {
    /// No such kind of light.
    #[error("light `{text}`: expected sun:DEGREES, sun:AxB, rect:CENTRE;U;V or disc:CENTRE;U;V")]
    Form {
        /// What was written.
        text: String,
    },
    /// Something else where a number belongs.
    #[error("light `{text}`: `{part}` is no finite number")]
    Number {
        /// What was written.
        text: String,
        /// The part that is no number.
        part: String,
    },
    /// A vector that has not three components.
    #[error("light `{text}`: {role} `{part}` has {got} components, expected x,y,z")]
    Vector {
        /// What was written.
        text: String,
        /// `centre`, `U` or `V`.
        role: &'static str,
        /// The vector.
        part: String,
        /// How many.
        got: usize,
    },
    /// An angular size that no light has.
    #[error("an angular size of {degrees} degrees makes no light: it must lie from 0 to below 180")]
    Degrees {
        /// The size.
        degrees: f64,
    },
    /// A half axis without length.
    #[error(
        "half axis {role} = {axis:?} of a light must have a length from {LEAST_AXIS:e} to {MAX_COORDINATE:e}"
    )]
    Axis {
        /// `U` or `V`.
        role: &'static str,
        /// The axis.
        axis: [f64; 3],
    },
    /// Two half axes that span nothing.
    #[error("half axes U = {u:?} and V = {v:?} of a light are parallel")]
    Parallel {
        /// First.
        u: [f64; 3],
        /// Second.
        v: [f64; 3],
    },
    /// A centre that is nowhere.
    #[error("centre {centre:?} of a light is not finite or exceeds {MAX_COORDINATE:e}")]
    Centre {
        /// The centre.
        centre: [f64; 3],
    },
}

impl AreaLight {
    /// Infinitely far and without extent: casts hard shadows.
    pub const DISTANT_POINT: Self = Self::Sun { outline: Outline::Disc, degrees: [0.0; 2] };

    /// A directional light of the given angular diameters in degrees.
    ///
    /// # Errors
    /// [`LightError::Degrees`] for a size that is negative, 180 or more, or not a number.
    pub fn sun(outline: Outline, degrees: [f64; 2]) -> Result<Self, LightError> {
        match degrees.into_iter().find(|size| !(0.0..180.0).contains(size)) {
            Some(degrees) => Err(LightError::Degrees { degrees }),
            None => Ok(Self::Sun { outline, degrees }),
        }
    }

    /// A local light.
    ///
    /// # Errors
    /// [`LightError::Centre`], [`LightError::Axis`], [`LightError::Parallel`].
    pub fn local(outline: Outline, centre: [f64; 3], half_axes: [[f64; 3]; 2]) -> Result<Self, LightError> {
        if !centre.iter().all(|c| c.abs() <= MAX_COORDINATE) {
            return Err(LightError::Centre { centre });
        }
        for (role, axis) in ["U", "V"].into_iter().zip(half_axes) {
            let length = norm(axis);
            if !(LEAST_AXIS..=MAX_COORDINATE).contains(&length) {
                return Err(LightError::Axis { role, axis });
            }
        }
        let [u, v] = half_axes;
        if norm(cross(u, v)) <= PARALLEL_SINE * norm(u) * norm(v) {
            return Err(LightError::Parallel { u, v });
        }
        Ok(Self::Local { outline, centre, half_axes })
    }

    /// Whether it is more than a point or a direction.
    pub fn has_extent(&self) -> bool {
        match self {
            Self::Sun { degrees, .. } => *degrees != [0.0; 2],
            Self::Local { .. } => true,
        }
    }

    /// Unit vector in which a local light shines, U x V; `None` for the sun.
    pub fn front(&self) -> Option<[f64; 3]> {
        match self {
            Self::Sun { .. } => None,
            Self::Local { half_axes: [u, v], .. } => {
                // Lengths first: products of long axes overflow.
                Some(normalize(cross(normalize(*u), normalize(*v))))
            }
        }
    }
}

impl FromStr for AreaLight {
    type Err = LightError;

    fn from_str(text: &str) -> Result<Self, LightError> {
        let form = || LightError::Form { text: text.to_owned() };
        let (kind, rest) = text.trim().split_once(':').ok_or_else(form)?;
        match kind.trim() {
            "sun" => {
                let (outline, sizes) = match rest.split_once('x') {
                    Some((a, b)) => (Outline::Rectangle, [number(text, a)?, number(text, b)?]),
                    None => (Outline::Disc, [number(text, rest)?; 2]),
                };
                Self::sun(outline, sizes)
            }
            "rect" => local(text, Outline::Rectangle, rest),
            "disc" => local(text, Outline::Disc, rest),
            _ => Err(form()),
        }
    }
}

fn local(text: &str, outline: Outline, rest: &str) -> Result<AreaLight, LightError> {
    let parts: Vec<&str> = rest.split(';').collect();
    let [centre, u, v] = parts[..] else { return Err(LightError::Form { text: text.to_owned() }) };
    let vector = |role, part| vector(text, role, part);
    AreaLight::local(outline, vector("centre", centre)?, [vector("U", u)?, vector("V", v)?])
}

fn vector(text: &str, role: &'static str, part: &str) -> Result<[f64; 3], LightError> {
    let components = part.split(',').map(|c| number(text, c)).collect::<Result<Vec<f64>, _>>()?;
    components.try_into().map_err(|all: Vec<f64>| LightError::Vector {
        text: text.to_owned(),
        role,
        part: part.trim().to_owned(),
        got: all.len(),
    })
}

fn number(text: &str, part: &str) -> Result<f64, LightError> {
    let value = part.trim().parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| LightError::Number { text: text.to_owned(), part: part.trim().to_owned() })
}

impl fmt::Display for AreaLight {
    /// The text that is read back as the same light.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sun { outline: Outline::Disc, degrees } => write!(out, "sun:{}", degrees[0]),
            Self::Sun { outline: Outline::Rectangle, degrees } => {
                write!(out, "sun:{}x{}", degrees[0], degrees[1])
            }
            Self::Local { outline, centre, half_axes } => {
                let name = match outline {
                    Outline::Rectangle => "rect",
                    Outline::Disc => "disc",
                };
                let list = |v: &[f64; 3]| format!("{},{},{}", v[0], v[1], v[2]);
                write!(out, "{name}:{};{};{}", list(centre), list(&half_axes[0]), list(&half_axes[1]))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_and_written() {
        for text in
            ["sun:0.53", "sun:0", "sun:2x0.5", "rect:0,3,-1;1,0,0;0,0,0.5", "disc:1e3,0,0;1,0,0;0,1,0"]
        {
            let light: AreaLight = text.parse().unwrap();
            assert_eq!(light.to_string().parse(), Ok(light), "{text}");
        }
        assert_eq!("sun:1".parse(), AreaLight::sun(Outline::Disc, [1.0; 2]));
        assert_eq!(" sun: 1 x 2 ".parse(), AreaLight::sun(Outline::Rectangle, [1.0, 2.0]));
    }

    #[test]
    fn errors_name_the_value() {
        for (text, expected) in [
            ("sun:-1", "size of -1 degrees"),
            ("sun:180", "size of 180 degrees"),
            ("sun:1x-2", "size of -2 degrees"),
            ("sun:inf", "`inf` is no finite number"),
            ("sun:nan", "`nan` is no finite number"),
            ("sun:", "`` is no finite number"),
            ("moon:1", "light `moon:1`: expected sun:DEGREES"),
            ("rect:0,0,0;1,0,0", "light `rect:0,0,0;1,0,0`: expected"),
            ("rect:0,0;1,0,0;0,1,0", "centre `0,0` has 2 components"),
            ("rect:0,0,0;0,0,0;0,1,0", "half axis U = [0.0, 0.0, 0.0]"),
            ("disc:0,0,0;1,0,0;0,1e999,0", "`1e999` is no finite number"),
            ("disc:0,0,0;1,0,0;0,0,0", "half axis V = [0.0, 0.0, 0.0]"),
            (
                "disc:0,0,0;1,2,0;-2,-4,0",
                "U = [1.0, 2.0, 0.0] and V = [-2.0, -4.0, 0.0] of a light are parallel",
            ),
            ("disc:0,0,0;1,2,zero;-2,-4,0", "`zero` is no finite number"),
        ] {
            let error = text.parse::<AreaLight>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
        assert!(AreaLight::local(Outline::Disc, [f64::NAN; 3], [[1.0; 3]; 2]).is_err());
        assert!(AreaLight::local(Outline::Disc, [0.0; 3], [[f64::INFINITY, 0.0, 0.0], [1.0; 3]]).is_err());
        assert!(AreaLight::sun(Outline::Disc, [f64::NAN; 2]).is_err());
    }

    #[test]
    fn local_lights_shine_along_u_cross_v() {
        let front = |text: &str| text.parse::<AreaLight>().unwrap().front();
        assert_eq!(front("disc:0,9,0;1,0,0;0,0,2"), Some([0.0, -1.0, 0.0]));
        assert_eq!(front("rect:0,0,0;1e10,0,0;1e9,1e10,0"), Some([0.0, 0.0, 1.0]));
        assert_eq!(front("sun:3"), None);
        let extent = |text: &str| text.parse::<AreaLight>().unwrap().has_extent();
        assert!(
            extent("sun:0x1") && extent("disc:0,9,0;1,0,0;0,0,2") && !extent("sun:0") && !extent("sun:0x0")
        );
    }
}
