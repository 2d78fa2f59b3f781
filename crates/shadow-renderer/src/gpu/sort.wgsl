// Sorts the keys of each texel: by depth, then by triangle. Keys are distinct, so the result is unique.

struct Params {
    texels: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
// After scattering, the next free slot of a texel is its end.
@group(0) @binding(2) var<storage, read> ends: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys: array<vec2<u32>>;

fn greater(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y > b.y || (a.y == b.y && a.x > b.x);
}

// Insertion sort over decreasing gaps (n^1.5 at worst, plain insertion for the usual few layers).
@compute @workgroup_size(256)
fn sort(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.texels {
        return;
    }
    let start = starts[id.x];
    let count = ends[id.x] - start;
    var gap = 1u;
    while 3u * gap + 1u < count {
        gap = 3u * gap + 1u;
    }
    if count <= 24u {
        gap = 1u;
    }
    while gap >= 1u {
        for (var i = gap; i < count; i++) {
            let inserted = keys[start + i];
            var hole = i;
            while hole >= gap {
                let before = keys[start + hole - gap];
                if !greater(before, inserted) {
                    break;
                }
                keys[start + hole] = before;
                hole -= gap;
            }
            keys[start + hole] = inserted;
        }
        gap /= 3u;
    }
}
