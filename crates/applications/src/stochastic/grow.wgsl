// A level's tiles: those over needed tiles of the next finer level, or of the fragments, with the ring around: a thread a tile.

@group(0) @binding(0) var<storage, read> marks: array<u32>;
@group(0) @binding(1) var<storage, read_write> tiles: array<u32>;
@group(0) @binding(2) var<uniform> plane: FilterPlane;

// Whether a tile that need not exist is needed by itself.
fn is_needed(tile: vec2<u32>) -> bool {
    if tile.x >= ACROSS || tile.y >= DOWN {
        return false;
    }
    if FINEST {
        return marks[u32(plane.number) * ACROSS * DOWN + tile.y * ACROSS + tile.x] != 0u;
    }
    let first = 2u * tile;
    let last = min(first + 1u, vec2<u32>(FINER_ACROSS, FINER_DOWN) - 1u);
    for (var y = first.y; y <= last.y; y = y + 1u) {
        for (var x = first.x; x <= last.x; x = x + 1u) {
            if tiles[FINER_TILES_FIRST + y * FINER_ACROSS + x] != 0u {
                return true;
            }
        }
    }
    return false;
}

@compute @workgroup_size(256)
fn grow(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= ACROSS * DOWN {
        return;
    }
    let tile = vec2<u32>(id.x % ACROSS, id.x / ACROSS);
    var found = false;
    for (var around = 0u; around < 9u; around++) {
        // Before the first tile numbers wrap around.
        found = found || is_needed(tile + vec2<u32>(around % 3u, around / 3u) - 1u);
    }
    tiles[TILES_FIRST + id.x] = select(0u, 1u, found);
}
