// Means of the channels over a rectangle from a summed-area table of whole numbers modulo 2^32 (BHS16 section 3.2): `table`
// holds WIDTH x HEIGHT texels, row by row, with CHANNELS interleaved. SCALE is the code of 1.

fn prefix(end_x: u32, end_y: u32, channel: u32) -> u32 {
    if end_x == 0u || end_y == 0u {
        return 0u;
    }
    return table[((end_y - 1u) * WIDTH + end_x - 1u) * CHANNELS + channel];
}

// Subtracted as integers: prefix sums have wrapped around.
fn rectangle_sum(first: vec2<u32>, last: vec2<u32>, channel: u32) -> u32 {
    let end = last + vec2<u32>(1u);
    let right = prefix(end.x, end.y, channel) - prefix(end.x, first.y, channel);
    return right - (prefix(first.x, end.y, channel) - prefix(first.x, first.y, channel));
}

fn means(low: vec2<f32>, high: vec2<f32>, fit: u32) -> array<f32, CHANNELS> {
    let columns = pieces(low.x, high.x, WIDTH, fit);
    let rows = pieces(low.y, high.y, HEIGHT, fit);
    var sums: array<f32, CHANNELS>;
    var area = 0.0;
    for (var j = 0u; j < 3u; j++) { if rows.covered[j] > 0.0 {
        for (var i = 0u; i < 3u; i++) { if columns.covered[i] > 0.0 {
            let share = columns.covered[i] * rows.covered[j];
            let first = vec2<u32>(columns.first[i], rows.first[j]);
            let last = vec2<u32>(columns.last[i], rows.last[j]);
            let size = last - first + vec2<u32>(1u);
            area = area + share * f32(size.x * size.y);
            for (var k = 0u; k < CHANNELS; k++) {
                sums[k] = sums[k] + share * f32(rectangle_sum(first, last, k));
            }
        } }
    } }
    for (var k = 0u; k < CHANNELS; k++) {
        sums[k] = sums[k] / (area * f32(SCALE));
    }
    return sums;
}
