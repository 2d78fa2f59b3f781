// Percentage-closer soft shadows (Fernando 2005): every texel of both regions is asked.

fn blockers_within(low: vec2<f32>, high: vec2<f32>, fit: u32, z: f32) -> Blockers {
    let columns = pieces(low.x, high.x, WIDTH, fit);
    let rows = pieces(low.y, high.y, HEIGHT, fit);
    var found: Blockers;
    var area = 0.0;
    for (var j = 0u; j < 3u; j++) { if rows.covered[j] > 0.0 {
        for (var y = rows.first[j]; y <= rows.last[j]; y++) {
            for (var i = 0u; i < 3u; i++) { if columns.covered[i] > 0.0 {
                let weight = columns.covered[i] * rows.covered[j];
                for (var x = columns.first[i]; x <= columns.last[i]; x++) {
                    let depth = textureLoad(depths, vec2<u32>(x, y), 0).x;
                    area = area + weight;
                    if depth < z {
                        found.mass = found.mass + weight;
                        found.depth_sum = found.depth_sum + weight * depth;
                    }
                }
            } }
        }
    } }
    found.mass = smaller(found.mass / area, 1.0);
    found.depth_sum = found.depth_sum / area;
    return found;
}

fn soft_shadow(penumbra: Penumbra, at: vec2<f32>, z: f32, bias: f32) -> f32 {
    let searched = search_widths(penumbra, z);
    let blockers = blockers_within(at - 0.5 * searched, at + 0.5 * searched, SEARCH_FIT, z - SEARCH_BIAS_SHARE * bias);
    if !(blockers.mass > 0.0) {
        return 0.0;
    }
    if blockers.mass > UMBRA {
        return 1.0;
    }
    let widths = filter_widths(penumbra, z, average_blocker(blockers, z));
    let used = vec2<f32>(larger(widths.x, LEAST_WIDTH), larger(widths.y, LEAST_WIDTH));
    let compared = z - bias_share(used) * bias;
    return blockers_within(dithered(at - 0.5 * used), dithered(at + 0.5 * used), FILTER_FIT, compared).mass;
}
