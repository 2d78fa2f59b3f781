//! What a file asks for and does not get, without a shadow changing by it.

use std::collections::HashMap;

use serde::Serialize;

use crate::error::one_line;

/// What kind of thing was left out or put right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WarningKind {
    /// A byte order mark before a text.
    ByteOrderMark,
    /// A text in UTF-16.
    Encoding,
    /// Positions whose least and greatest values are not stated.
    MissingBounds,
    /// An extension that is used, not required, and not read.
    UnreadExtension,
    /// A texture whose image is missing or cannot be read.
    MissingTexture,
    /// A material library that is missing or cannot be read.
    MissingLibrary,
    /// A material that no library defines.
    MissingMaterial,
    /// Texture coordinates that are missing or out of range.
    TextureCoordinates,
    /// Normals that are missing where they are referred to, or out of range.
    Normals,
    /// A face of fewer than three corners.
    ShortFace,
    /// A polygon that crosses itself, so that its area is anyone's guess.
    CrossingPolygon,
    /// Weights of joints that do not sum to one.
    JointWeights,
    /// Weights of morph targets that name no target.
    MorphWeights,
    /// A channel of an animation that moves nothing that is read.
    Channel,
    /// A camera that is not used.
    Camera,
    /// A light that is not used.
    Light,
    /// A number that lies outside of its range and was moved into it.
    OutOfRange,
    /// Corners that make up no triangle, or a primitive without positions.
    Incomplete,
    /// A material that is clear throughout.
    Transparent,
}

/// One kind of thing in a file, with how often it occurs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// What it is.
    pub kind: WarningKind,
    /// The first occurrence, in one line.
    pub message: String,
    /// How many there are.
    pub count: u64,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.count {
            1 => f.write_str(&self.message),
            count => write!(f, "{} ({count} times)", self.message),
        }
    }
}

/// Most warnings of one kind that are told apart.
const MOST_OF_A_KIND: usize = 16;

/// Gathers them in the order of their first occurrence.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    list: Vec<Warning>,
    places: HashMap<(WarningKind, String), usize>,
    of_a_kind: HashMap<WarningKind, usize>,
}

impl Warnings {
    /// Counts one; what has the same kind and subject is one warning, whose message is that of the first.
    pub(crate) fn add(&mut self, kind: WarningKind, subject: &str, message: impl FnOnce() -> String) {
        if let Some(&place) = self.places.get(&(kind, subject.to_owned())) {
            self.list[place].count += 1;
            return;
        }
        let seen = self.of_a_kind.entry(kind).or_default();
        *seen += 1;
        if *seen > MOST_OF_A_KIND {
            // A file may name any number of things that are missing.
            let last = self.list.iter_mut().rev().find(|warning| warning.kind == kind);
            last.into_iter().for_each(|warning| warning.count += 1);
            return;
        }
        self.places.insert((kind, subject.to_owned()), self.list.len());
        self.list.push(Warning { kind, message: one_line(&message()), count: 1 });
    }

    pub(crate) fn into_list(self) -> Vec<Warning> {
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_subject_is_one_warning_with_a_count() {
        let mut warnings = Warnings::default();
        for line in 3..6 {
            warnings.add(WarningKind::Normals, "", || format!("line {line}"));
        }
        warnings.add(WarningKind::MissingTexture, "a.png", || "a.png\nis missing".into());
        let list = warnings.into_list();
        let texts: Vec<_> = list.iter().map(ToString::to_string).collect();
        assert_eq!(texts, ["line 3 (3 times)", "a.png\\nis missing"]);
    }

    #[test]
    fn many_subjects_share_the_last_warning_of_their_kind() {
        let mut warnings = Warnings::default();
        for i in 0..100 {
            warnings.add(WarningKind::MissingTexture, &i.to_string(), || format!("{i}"));
        }
        let list = warnings.into_list();
        assert_eq!(list.len(), MOST_OF_A_KIND);
        assert_eq!(list.iter().map(|w| w.count).sum::<u64>(), 100);
    }
}
