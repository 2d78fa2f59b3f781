//! Vertices in their pose: morph targets first, then the joints of a skin, or the node's own place.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use super::accessor::{Elements, entry};
use super::affine::Affine;
use super::buffers::Buffers;
use super::json::{Root, Whole};
use super::node::Hierarchy;
use crate::error::FileFault;
use crate::load::warnings::{WarningKind, Warnings};

/// Most joints that may move one vertex, in sets of four.
const MAX_JOINT_SETS: usize = 16;

/// Most values of morph targets that are added up for one scene: the time to do so is the file's choice otherwise.
const MAX_MORPHED: u64 = 1 << 28;

/// Largest distance of the sum of a vertex's weights from 1 that goes without a warning: eight weights in eight bits may be
/// off by that much.
const WEIGHT_ROUNDING: f64 = 0.02;

/// World matrices of joints, by skin.
#[derive(Default)]
pub(super) struct Skins {
    known: HashMap<u64, Rc<Vec<Affine>>>,
}

impl Skins {
    /// From bind pose to the world for each joint of a skin.
    pub(super) fn matrices(
        &mut self,
        root: &Root,
        buffers: &Buffers,
        hierarchy: &mut Hierarchy,
        index: Whole,
    ) -> Result<Rc<Vec<Affine>>, FileFault> {
        if let Some(known) = self.known.get(&index.0) {
            return Ok(known.clone());
        }
        let skin = entry(&root.skins, index, "skins")?;
        let at = || format!("skins[{}]", index.0);
        let inverses = skin.inverse_bind_matrices;
        let inverses = inverses
            .map(|index| Elements::open(root, buffers, index, &["MAT4"], "inverseBindMatrices"))
            .transpose()?;
        if let Some(inverses) = inverses.as_ref().filter(|inverses| inverses.len() < skin.joints.len()) {
            let problem =
                format!("{} inverse bind matrices for {} joints", inverses.len(), skin.joints.len());
            return Err(FileFault::invalid(at(), problem));
        }
        let mut matrices = Vec::with_capacity(skin.joints.len());
        for (number, &joint) in skin.joints.iter().enumerate() {
            let world = hierarchy.world(joint)?;
            let inverse = match &inverses {
                None => Affine::IDENTITY,
                Some(inverses) => Affine::of_matrix(&inverses.vector(number), &|| {
                    format!("{}: inverse bind matrix {number}", at())
                })?,
            };
            matrices.push(world.then_inner(&inverse));
        }
        let matrices = Rc::new(matrices);
        self.known.insert(index.0, matrices.clone());
        Ok(matrices)
    }
}

/// What places the vertices of a primitive.
pub(super) enum Placement<'a> {
    Rigid(Affine),
    Skinned { joints: Rc<Vec<Affine>>, sets: Vec<[Elements<'a>; 2]> },
}

impl Placement<'_> {
    /// The matrix of a vertex.
    pub(super) fn of(&self, vertex: usize, at: &str, warnings: &mut Warnings) -> Result<Affine, FileFault> {
        let (joints, sets) = match self {
            Self::Rigid(world) => return Ok(*world),
            Self::Skinned { joints, sets } => (joints, sets),
        };
        let mut weighted: Vec<(f64, Affine)> = Vec::with_capacity(4 * sets.len());
        let mut first = None;
        for [indices, weights] in sets {
            let (indices, weights) = (indices.vector::<4>(vertex), weights.vector::<4>(vertex));
            for (index, weight) in indices.into_iter().zip(weights) {
                if !(weight.is_finite() && weight >= 0.0) {
                    let problem = format!("weight {weight} of a joint at vertex {vertex}");
                    return Err(FileFault::invalid(at, problem));
                }
                let joint = joints.get(index as usize).copied();
                first = first.or(joint);
                if weight == 0.0 {
                    continue;
                }
                let Some(joint) = joint else {
                    let at = format!("{at}: joint of vertex {vertex}");
                    let (index, count) = (index as i64, joints.len() as u64);
                    return Err(FileFault::IndexOutOfRange { at, index, count });
                };
                weighted.push((weight, joint));
            }
        }
        let sum: f64 = weighted.iter().map(|(weight, _)| weight).sum();
        if (sum - 1.0).abs() > WEIGHT_ROUNDING {
            warnings.add(WarningKind::JointWeights, "", || {
                format!("{at}: the joints' weights of vertex {vertex} sum to {sum}, which is scaled to 1")
            });
        }
        match (sum > 0.0, first) {
            (true, _) => Ok(Affine::blend(weighted.into_iter().map(|(weight, map)| (weight / sum, map)))),
            // As if its first joint had all the weight, which is what viewers do.
            (false, Some(joint)) => Ok(joint),
            (false, None) => Err(FileFault::invalid(at, format!("vertex {vertex} has no joint"))),
        }
    }
}

/// Opens the joints and weights of a primitive; `None` where it has none.
pub(super) fn joint_sets<'a>(
    attributes: &BTreeMap<String, Whole>,
    open: impl Fn(&str, &[&str]) -> Result<Option<Elements<'a>>, FileFault>,
    at: &str,
) -> Result<Option<Vec<[Elements<'a>; 2]>>, FileFault> {
    let mut sets = Vec::new();
    while attributes.contains_key(&format!("JOINTS_{}", sets.len())) {
        if sets.len() == MAX_JOINT_SETS {
            let (count, limit) = (sets.len() as u64 + 1, MAX_JOINT_SETS as u64);
            return Err(FileFault::TooMany { at: at.into(), what: "sets of joints", count, limit });
        }
        let (joints, weights) = (format!("JOINTS_{}", sets.len()), format!("WEIGHTS_{}", sets.len()));
        let (Some(joints), Some(weights)) = (open(&joints, &["VEC4"])?, open(&weights, &["VEC4"])?) else {
            return Err(FileFault::invalid(at, format!("has {joints} and no {weights}")));
        };
        sets.push([joints, weights]);
    }
    Ok((!sets.is_empty()).then_some(sets))
}

/// Displacements of one attribute: weights and the elements that they weigh.
pub(super) struct Morph<'a> {
    targets: Vec<(f64, Elements<'a>)>,
}

/// How many values of morph targets a scene may still have.
pub(super) struct MorphBudget(u64);

impl Default for MorphBudget {
    fn default() -> Self {
        Self(MAX_MORPHED)
    }
}

impl<'a> Morph<'a> {
    /// The targets of weight other than zero that displace an attribute of `count` vertices, of which `used` will be asked for.
    pub(super) fn open(
        (root, buffers): (&'a Root, &'a Buffers<'a>),
        targets: &[BTreeMap<String, Whole>],
        weights: &[f64],
        attribute: &str,
        [count, used]: [usize; 2],
        (at, budget): (&str, &mut MorphBudget),
    ) -> Result<Self, FileFault> {
        let mut opened = Vec::new();
        for (number, (target, &weight)) in targets.iter().zip(weights).enumerate() {
            if !weight.is_finite() {
                return Err(FileFault::invalid(at, format!("weight {weight} of morph target {number}")));
            }
            let Some(&index) = target.get(attribute).filter(|_| weight != 0.0) else { continue };
            let role = format!("{attribute} of morph target {number}");
            let elements = Elements::open(root, buffers, index, &["VEC3"], &role)?;
            if elements.len() != count {
                let problem = format!("{role} has {} values for {count} vertices", elements.len());
                return Err(FileFault::invalid(at, problem));
            }
            budget.0 = budget.0.checked_sub(used as u64).ok_or_else(|| FileFault::TooMany {
                at: at.into(),
                what: "values of morph targets",
                count: MAX_MORPHED + 1,
                limit: MAX_MORPHED,
            })?;
            opened.push((weight, elements));
        }
        Ok(Self { targets: opened })
    }

    pub(super) fn apply(&self, vertex: usize, mut value: [f64; 3]) -> [f64; 3] {
        for (weight, elements) in &self.targets {
            let by: [f64; 3] = elements.vector(vertex);
            (0..3).for_each(|k| value[k] += weight * by[k]);
        }
        value
    }
}
