//! What the applications of a scene share, counted once, and the cheapest set of them.

use super::budget::Budget;
use serde::Serialize;

/// Something that several applications can use, once it is made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shared {
    /// What it is; the same for all that can use the same one.
    pub name: String,
    /// Modelled bytes of making it, which the cost of each application contains.
    #[serde(skip)]
    pub(super) cost: f64,
    /// Memory in bytes.
    pub bytes: u64,
}

/// Bytes of a depth, written and read, and kept.
const DEPTH_TRAFFIC: f64 = 8.0;
const DEPTH_BYTES: u64 = 4;

impl Shared {
    /// The depth map that everything is made from.
    pub(super) fn depth(side: u32) -> Self {
        let texels = u64::from(side).pow(2);
        Self {
            name: format!("depth map of {side}x{side}"),
            cost: DEPTH_TRAFFIC * texels as f64,
            bytes: DEPTH_BYTES * texels,
        }
    }

    /// A filtered map; `cost` is that of its frame without the depth map and without the pixels that read it.
    pub(super) fn filtered(
        [bound, transform, format, kernel]: [&str; 4],
        side: u32,
        cost: f64,
        bits_per_texel: usize,
    ) -> Self {
        Self {
            name: format!("{bound} in {format} ({transform}), {side}x{side}, filtered by {kernel}"),
            cost,
            bytes: u64::from(side).pow(2) * bits_per_texel as u64 / 8,
        }
    }
}

/// A choice of one application, in modelled bytes.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) application: &'static str,
    pub(super) name: String,
    pub(super) cost: f64,
    /// Memory without what is shared.
    pub(super) bytes: u64,
    pub(super) uses: Vec<Shared>,
}

/// The cheapest set of what is good enough for each application.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Together {
    /// One for each application.
    pub members: Vec<String>,
    /// What more than one of them uses.
    pub shared: Vec<Shared>,
    /// Modelled cost with everything shared counted once, in the unit of hard shadows.
    pub cost: f64,
    /// The same in milliseconds on the card of the budget.
    pub cost_ms: f64,
    /// Without sharing.
    pub cost_apart: f64,
    /// Memory with everything shared counted once, depth maps included.
    pub bytes: u64,
    /// Without sharing.
    pub bytes_apart: u64,
}

/// Tries every combination of one member an application; `None` for fewer than two applications. `unit` is what costs are
/// told in.
pub(super) fn cheapest(applications: &[Vec<Member>], unit: f64, budget: &Budget) -> Option<Together> {
    if applications.len() < 2 || applications.iter().any(Vec::is_empty) {
        return None;
    }
    let mut sets: Vec<Vec<&Member>> = vec![Vec::new()];
    for members in applications {
        let longer = |set: &Vec<_>| {
            members.iter().map(|member| set.iter().copied().chain([member]).collect()).collect::<Vec<_>>()
        };
        sets = sets.iter().flat_map(longer).collect();
    }
    let costed = sets.into_iter().map(|set| (total(&set), set));
    let (cost, set) = costed.reduce(|a, b| if b.0 < a.0 { b } else { a })?;
    let all = || set.iter().flat_map(|member| &member.uses);
    let mut distinct: Vec<&Shared> = Vec::new();
    for shared in all() {
        if !distinct.iter().any(|known| known.name == shared.name) {
            distinct.push(shared);
        }
    }
    let own: u64 = set.iter().map(|member| member.bytes).sum();
    let uses = |name: &str| all().filter(|shared| shared.name == name).count();
    Some(Together {
        members: set.iter().map(|member| format!("{}: {}", member.application, member.name)).collect(),
        shared: distinct
            .iter()
            .filter(|shared| uses(&shared.name) > 1)
            .map(|&shared| shared.clone())
            .collect(),
        cost: cost / unit,
        cost_ms: budget.milliseconds(cost),
        cost_apart: set.iter().map(|member| member.cost).sum::<f64>() / unit,
        bytes: own + distinct.iter().map(|shared| shared.bytes).sum::<u64>(),
        bytes_apart: own + all().map(|shared| shared.bytes).sum::<u64>(),
    })
}

/// Cost of a set in which nothing is made twice.
fn total(set: &[&Member]) -> f64 {
    let mut made: Vec<&str> = Vec::new();
    let mut saved = 0.0;
    for shared in set.iter().flat_map(|member| &member.uses) {
        if made.contains(&shared.name.as_str()) {
            saved += shared.cost;
        } else {
            made.push(&shared.name);
        }
    }
    set.iter().map(|member| member.cost).sum::<f64>() - saved
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(application: &'static str, name: &str, cost: f64, uses: Vec<Shared>) -> Member {
        Member { application, name: name.to_owned(), cost, bytes: 10, uses }
    }

    #[test]
    fn what_is_shared_counts_once_and_may_change_the_choice() {
        let (large, small) = (Shared::depth(100), Shared::depth(50));
        let hard = vec![
            member("hard", "on a small map", 50_000.0, vec![small.clone()]),
            member("hard", "on a large map", 60_000.0, vec![large.clone()]),
        ];
        let soft = vec![member("soft", "on a large map", 200_000.0, vec![large.clone()])];
        let set = cheapest(&[hard.clone(), soft], 1000.0, &Budget::default()).unwrap();
        // 80 000 of the large depth map are saved.
        assert_eq!(set.members, ["hard: on a large map", "soft: on a large map"]);
        assert_eq!((set.cost, set.cost_apart), (180.0, 260.0));
        assert_eq!((set.bytes, set.bytes_apart), (40_020, 80_020));
        assert_eq!(set.shared, [large]);
        let other = vec![member("soft", "on a small map", 70_000.0, vec![small])];
        let set = cheapest(&[hard.clone(), other], 1000.0, &Budget::default()).unwrap();
        assert_eq!(set.members[0], "hard: on a small map");
        assert!(cheapest(&[hard], 1.0, &Budget::default()).is_none());
    }
}
