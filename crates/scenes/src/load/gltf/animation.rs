//! Animations evaluated at one time: where nodes are, which morph targets weigh how much, what is visible.

use std::collections::HashMap;

use super::accessor::{Elements, entry};
use super::affine::Trs;
use super::buffers::Buffers;
use super::json::{Animation, AnimationSampler, Channel, Root};
use super::node::trs;
use crate::error::FileFault;
use crate::load::PoseChoice;
use crate::load::warnings::{WarningKind, Warnings};

/// What an animation changes, by node.
#[derive(Debug, Default)]
pub(super) struct Pose {
    trs: HashMap<usize, Trs>,
    weights: HashMap<usize, Vec<f64>>,
    visible: HashMap<usize, bool>,
    /// Number of the animation.
    animation: Option<usize>,
}

/// Names of animations, numbers where they have none.
pub(super) fn names(root: &Root) -> Vec<String> {
    let named = |(number, of): (usize, &Animation)| of.name.clone().unwrap_or_else(|| number.to_string());
    root.animations.iter().enumerate().map(named).collect()
}

impl Pose {
    pub(super) fn trs(&self, node: usize) -> Option<&Trs> {
        self.trs.get(&node)
    }

    pub(super) fn weights(&self, node: usize) -> Option<&[f64]> {
        self.weights.get(&node).map(Vec::as_slice)
    }

    pub(super) fn visible(&self, node: usize) -> Option<bool> {
        self.visible.get(&node).copied()
    }

    pub(super) fn animation(&self) -> Option<usize> {
        self.animation
    }

    /// The pose at a time in seconds, which is clamped to that of the keys; as the file stores it without animations.
    pub(super) fn at(
        root: &Root,
        buffers: &Buffers,
        choice: &PoseChoice,
        warnings: &mut Warnings,
    ) -> Result<Self, FileFault> {
        let mut pose = Self::default();
        let Some((number, animation)) = chosen(root, choice)? else { return Ok(pose) };
        pose.animation = Some(number);
        let time = choice.time.unwrap_or(0.0);
        for (index, channel) in animation.channels.iter().enumerate() {
            let at = format!("animations[{number}].channels[{index}]");
            pose.apply(root, buffers, (animation, channel), time, &at, warnings)?;
        }
        Ok(pose)
    }

    fn apply(
        &mut self,
        root: &Root,
        buffers: &Buffers,
        (animation, channel): (&Animation, &Channel),
        time: f64,
        at: &str,
        warnings: &mut Warnings,
    ) -> Result<(), FileFault> {
        let mut ignored = |what: String| {
            warnings.add(WarningKind::Channel, &what, || format!("{at}: {what}"));
            Ok(())
        };
        let pointer = channel.target.extensions.as_ref().and_then(|e| e.pointer.as_ref());
        let (node, path) = match (&channel.target.node, pointer) {
            (Some(node), _) => (node.index(), channel.target.path.as_str()),
            // Without a node a channel moves nothing (glTF 2.0, 3.11).
            (None, None) => return Ok(()),
            (None, Some(pointer)) => match node_pointer(&pointer.pointer) {
                Some(target) => target,
                None => return ignored(format!("pointer {:?} is not followed", pointer.pointer)),
            },
        };
        let target = entry(&root.nodes, super::json::Whole(node as u64), "nodes")?;
        if target.matrix.is_some() && matches!(path, "translation" | "rotation" | "scale") {
            return ignored(format!("nodes[{node}] has a matrix, which is not animated"));
        }
        let sampler = entry(&animation.samplers, channel.sampler, "samplers")
            .map_err(|_| FileFault::invalid(at, format!("there is no sampler {}", channel.sampler.0)))?;
        let keys = Keys::open(root, buffers, sampler, at)?;
        match path {
            "translation" | "scale" => {
                let value = keys.vector::<3>(&["VEC3"], time, lerp)?;
                let posed = self.trs.entry(node).or_insert_with(|| trs(target));
                let slot = if path == "scale" { &mut posed.scale } else { &mut posed.translation };
                *slot = value;
            }
            "rotation" => {
                let value = keys.vector::<4>(&["VEC4"], time, slerp)?;
                self.trs.entry(node).or_insert_with(|| trs(target)).rotation = value;
            }
            "weights" => {
                self.weights.insert(node, keys.list(time)?);
            }
            "visible" => {
                let [value] = keys.vector::<1>(&["SCALAR"], time, |a, _, _| a)?;
                self.visible.insert(node, value != 0.0);
            }
            other => return ignored(format!("path {other:?} is not known")),
        }
        Ok(())
    }
}

/// The node and path of a pointer such as `/nodes/3/translation`.
fn node_pointer(pointer: &str) -> Option<(usize, &str)> {
    let (node, path) = pointer.strip_prefix("/nodes/")?.split_once('/')?;
    let node = node.parse().ok()?;
    match path {
        "translation" | "rotation" | "scale" | "weights" => Some((node, path)),
        "extensions/KHR_node_visibility/visible" => Some((node, "visible")),
        _ => None,
    }
}

fn chosen<'a>(root: &'a Root, choice: &PoseChoice) -> Result<Option<(usize, &'a Animation)>, FileFault> {
    let all = || root.animations.iter().enumerate();
    let named = |wanted: &str| {
        let by_name = all().find(|(_, animation)| animation.name.as_deref() == Some(wanted));
        by_name.or_else(|| wanted.parse::<usize>().ok().and_then(|number| all().nth(number)))
    };
    match choice.animation.as_deref() {
        None => match (all().next(), choice.time) {
            (None, Some(time)) => {
                let problem = format!("there is none to be shown at {time} seconds");
                Err(FileFault::invalid("animations", problem))
            }
            (_, None) if root.animations.len() > 1 => Ok(None),
            (first, _) => Ok(first),
        },
        Some(wanted) => match (named(wanted), wanted) {
            (Some(found), _) => Ok(Some(found)),
            (None, "none") => Ok(None),
            (None, _) => {
                let names = names(root);
                let known = if names.is_empty() { "no animation".into() } else { names.join(", ") };
                Err(FileFault::invalid("animations", format!("none is called {wanted:?}: there is {known}")))
            }
        },
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Interpolation {
    Step,
    Linear,
    Cubic,
}

/// The keys of a sampler.
struct Keys<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    sampler: &'a AnimationSampler,
    times: Elements<'a>,
    interpolation: Interpolation,
    at: &'a str,
}

/// Between which keys a time lies, and how far along.
struct Between {
    keys: [usize; 2],
    share: f64,
    seconds: f64,
}

impl<'a> Keys<'a> {
    fn open(
        root: &'a Root,
        buffers: &'a Buffers<'a>,
        sampler: &'a AnimationSampler,
        at: &'a str,
    ) -> Result<Self, FileFault> {
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::Cubic,
            Some(other) => {
                return Err(FileFault::invalid(at, format!("interpolation {other:?} is not known")));
            }
        };
        let times = Elements::open(root, buffers, sampler.input, &["SCALAR"], "input")?;
        if times.len() == 0 {
            return Err(FileFault::invalid(at, "has no keys"));
        }
        Ok(Self { root, buffers, sampler, times, interpolation, at })
    }

    fn between(&self, time: f64) -> Between {
        let (mut low, mut high) = (0, self.times.len());
        // The first key later than `time`.
        while low < high {
            let middle = low + (high - low) / 2;
            if self.times.number(middle) <= time { low = middle + 1 } else { high = middle }
        }
        let first = low.saturating_sub(1);
        let last = low.min(self.times.len() - 1);
        let [from, to] = [first, last].map(|key| self.times.number(key));
        let share = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        Between { keys: [first, last], share, seconds: (to - from).max(0.0) }
    }

    fn output(&self, expected: &[&str], values: usize) -> Result<Elements<'a>, FileFault> {
        let output = Elements::open(self.root, self.buffers, self.sampler.output, expected, "output")?;
        let each = if self.interpolation == Interpolation::Cubic { 3 } else { 1 };
        let needed = (self.times.len() as u64).saturating_mul(each).saturating_mul(values as u64);
        if (output.len() as u64) < needed {
            let problem =
                format!("{} values for {} keys, {needed} are needed", output.len(), self.times.len());
            return Err(FileFault::invalid(self.at, problem));
        }
        Ok(output)
    }

    fn vector<const N: usize>(
        &self,
        expected: &[&str],
        time: f64,
        mix: fn([f64; N], [f64; N], f64) -> [f64; N],
    ) -> Result<[f64; N], FileFault> {
        let output = self.output(expected, 1)?;
        let Between { keys: [a, b], share, seconds } = self.between(time);
        Ok(match self.interpolation {
            Interpolation::Step => output.vector(a),
            Interpolation::Linear => mix(output.vector(a), output.vector(b), share),
            Interpolation::Cubic => {
                let part = |key: usize, part: usize| output.vector::<N>(3 * key + part);
                let [from, leaving, arriving, to] = [part(a, 1), part(a, 2), part(b, 0), part(b, 1)];
                std::array::from_fn(|k| hermite([from[k], leaving[k], arriving[k], to[k]], share, seconds))
            }
        })
    }

    /// Weights of morph targets: as many for each key as the output has.
    fn list(&self, time: f64) -> Result<Vec<f64>, FileFault> {
        let output = self.output(&["SCALAR"], 1)?;
        let each = if self.interpolation == Interpolation::Cubic { 3 } else { 1 };
        let targets = output.len() / self.times.len() / each;
        let Between { keys: [a, b], share, seconds } = self.between(time);
        let value =
            |key: usize, part: usize, target: usize| output.number((key * each + part) * targets + target);
        Ok((0..targets)
            .map(|target| match self.interpolation {
                Interpolation::Step => value(a, 0, target),
                Interpolation::Linear => {
                    let (from, to) = (value(a, 0, target), value(b, 0, target));
                    from + share * (to - from)
                }
                Interpolation::Cubic => {
                    let points =
                        [value(a, 1, target), value(a, 2, target), value(b, 0, target), value(b, 1, target)];
                    hermite(points, share, seconds)
                }
            })
            .collect())
    }
}

fn lerp<const N: usize>(a: [f64; N], b: [f64; N], t: f64) -> [f64; N] {
    std::array::from_fn(|k| a[k] + t * (b[k] - a[k]))
}

/// The shorter way between two rotations.
fn slerp(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
    /// From this cosine on the arc is straight to double precision.
    const STRAIGHT: f64 = 1.0 - 1e-9;
    let cosine: f64 = (0..4).map(|k| a[k] * b[k]).sum();
    let (b, cosine) = if cosine < 0.0 { (b.map(|c| -c), -cosine) } else { (b, cosine) };
    if cosine > STRAIGHT {
        return lerp(a, b, t);
    }
    let angle = cosine.acos();
    let [from, to] = [(1.0 - t) * angle, t * angle].map(|part| part.sin() / angle.sin());
    std::array::from_fn(|k| from * a[k] + to * b[k])
}

/// glTF 2.0, appendix C.5: value, tangents per second, value.
fn hermite([from, leaving, arriving, to]: [f64; 4], t: f64, seconds: f64) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * from
        + seconds * (t3 - 2.0 * t2 + t) * leaving
        + (3.0 * t2 - 2.0 * t3) * to
        + seconds * (t3 - t2) * arriving
}
