//! The truth in flatland (SSSM15 section 3): a line of light over parallel segments.

/// A segment parallel to the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Distance from the light.
    pub depth: f64,
    /// From here ...
    pub start: f64,
    /// ... to there.
    pub end: f64,
}

/// Length of the light \[-R_L, R_L\] that a receiver sees (equation 3): what is left of the light's points when those behind
/// each nearer segment are taken away.
pub fn visible_length(light_radius: f64, receiver: [f64; 2], segments: &[Segment]) -> f64 {
    let [x, depth] = receiver;
    let mut hidden: Vec<[f64; 2]> = segments
        .iter()
        .filter(|segment| segment.depth > 0.0 && segment.depth < depth)
        .map(|segment| {
            // On the way to the light's point u the ray passes u + (x - u) d / d_r.
            let share = segment.depth / depth;
            let from = |end: f64| ((end - x * share) / (1.0 - share)).clamp(-light_radius, light_radius);
            let ends = [from(segment.start), from(segment.end)];
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        })
        .collect();
    hidden.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut visible, mut reached) = (0.0, -light_radius);
    for [start, end] in hidden {
        visible += (start - reached).max(0.0);
        reached = reached.max(end);
    }
    visible + (light_radius - reached).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_hide_their_shadow_once() {
        let of = |depth, start, end| Segment { depth, start, end };
        assert_eq!(visible_length(1.0, [0.0, 4.0], &[]), 2.0);
        // Seen from the middle, a segment halfway hides twice its length.
        let overlapping = [of(2.0, -0.25, 0.0), of(2.0, -0.125, 0.25), of(5.0, -9.0, 9.0)];
        assert_eq!(visible_length(1.0, [0.0, 4.0], &overlapping), 1.0);
        assert_eq!(visible_length(1.0, [0.0, 4.0], &[of(1.0, -3.0, 3.0)]), 0.0);
    }
}
