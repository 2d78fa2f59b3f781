// How an interval of texel coordinates falls on texels, at most three pieces of neighbouring texels that are covered alike.

struct Pieces {
    first: array<u32, 3>,
    // The last texel, included.
    last: array<u32, 3>,
    // Covered share of each texel; 0 where there is no piece.
    covered: array<f32, 3>,
}

fn one_piece(first: u32, last: u32) -> Pieces {
    var found: Pieces;
    found.first[0] = first;
    found.last[0] = last;
    found.covered[0] = 1.0;
    return found;
}

// All texels that the interval touches, whole (BHS16 section 3.5).
fn outwards(low: f32, high: f32, size: u32) -> Pieces {
    let first = min(u32(floor(low)), size - 1u);
    return one_piece(first, max(u32(ceil(high)), first + 1u) - 1u);
}

fn pieces(low_end: f32, high_end: f32, size: u32, fit: u32) -> Pieces {
    let limit = f32(size);
    let low = larger(smaller(low_end, limit), 0.0);
    let high = larger(smaller(high_end, limit), 0.0);
    if fit == OUTWARDS {
        return outwards(low, high, size);
    }
    if fit == NEAREST {
        let first = floor(low + 0.5);
        let end = floor(high + 0.5);
        if end > first {
            return outwards(first, end, size);
        }
        return outwards(low, low, size);
    }
    let first = floor(low);
    let last = ceil(high);
    if !(high > low) {
        let texel = min(u32(first), size - 1u);
        return one_piece(texel, texel);
    }
    if last - first <= 1.0 {
        var found = one_piece(u32(first), u32(first));
        found.covered[0] = high - low;
        return found;
    }
    let whole = ceil(low);
    let end = floor(high);
    var found: Pieces;
    found.first[0] = u32(first);
    found.last[0] = u32(first);
    found.covered[0] = whole - low;
    found.first[1] = u32(whole);
    found.last[1] = max(u32(end), 1u) - 1u;
    found.covered[1] = select(0.0, 1.0, end > whole);
    found.first[2] = u32(end);
    found.last[2] = u32(end);
    found.covered[2] = high - end;
    return found;
}
