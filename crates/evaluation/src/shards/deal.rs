//! Who does what, so that nobody works much longer than the others.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Places of the pieces of each of `count` shards, given what each piece costs: the most expensive one first, always to the shard
/// that has least to do. Nobody then has more than a third above the best division, if no single piece has.
pub(super) fn dealt(costs: &[u64], count: usize) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..costs.len()).collect();
    order.sort_by_key(|&place| (Reverse(costs[place]), place));
    let mut shards = vec![Vec::new(); count];
    let mut loads: BinaryHeap<Reverse<(u64, usize)>> = (0..count).map(|shard| Reverse((0, shard))).collect();
    for place in order {
        let Some(Reverse((load, shard))) = loads.pop() else { break };
        shards[shard].push(place);
        loads.push(Reverse((load.saturating_add(costs[place]), shard)));
    }
    for shard in &mut shards {
        shard.sort_unstable();
    }
    shards
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_dealt_once_and_evenly() {
        let costs: Vec<u64> = (0..500).map(|place| 1 + (place * 7919) % 23).collect();
        for count in [1, 3, 32, 700] {
            let shards = dealt(&costs, count);
            let mut all: Vec<usize> = shards.iter().flatten().copied().collect();
            all.sort_unstable();
            assert_eq!(all, (0..500).collect::<Vec<_>>());
            let loads = shards.iter().map(|shard| shard.iter().map(|&place| costs[place]).sum::<u64>());
            let (longest, mean) =
                (loads.max().unwrap() as f64, costs.iter().sum::<u64>() as f64 / count as f64);
            assert!(longest <= mean.max(23.0) + 1.0, "{count}: {longest} of {mean}");
        }
        assert_eq!(dealt(&[], 2), vec![Vec::<usize>::new(); 2]);
    }
}
