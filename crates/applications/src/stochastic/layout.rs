//! Where the levels of a plane lie in the buffers of the shaders.

use super::plane::{PlaneFilter, TILE};

/// A level's texels and tiles.
pub(super) struct LevelPlace {
    pub(super) size: [usize; 2],
    /// Place of its first texel.
    pub(super) first: usize,
    /// Tiles along columns and rows.
    pub(super) tiles: [usize; 2],
    /// Place of its first tile.
    pub(super) tiles_first: usize,
}

/// All levels, the finest first.
pub(super) struct Layout {
    pub(super) levels: Vec<LevelPlace>,
    /// Texels of all levels.
    pub(super) texels: usize,
    /// Tiles of all levels.
    pub(super) tiles: usize,
}

impl Layout {
    /// As many levels as a filter makes of a map.
    pub(super) fn new(size: [usize; 2], filter: &PlaneFilter) -> Self {
        let mut layout = Self { levels: Vec::new(), texels: 0, tiles: 0 };
        let mut size = size;
        for _ in 0..=filter.coarse_levels {
            let tiles = size.map(|side| side.div_ceil(TILE));
            let place = LevelPlace { size, first: layout.texels, tiles, tiles_first: layout.tiles };
            layout.levels.push(place);
            layout.texels += size[0] * size[1];
            layout.tiles += tiles[0] * tiles[1];
            if size == [1, 1] {
                break;
            }
            size = size.map(|side| side.div_ceil(2));
        }
        layout
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_lie_one_behind_the_other() {
        let filter = PlaneFilter { coarse_levels: 12, ..PlaneFilter::published() };
        let layout = Layout::new([33, 20], &filter);
        let sizes: Vec<[usize; 2]> = layout.levels.iter().map(|level| level.size).collect();
        assert_eq!(sizes, [[33, 20], [17, 10], [9, 5], [5, 3], [3, 2], [2, 1], [1, 1]]);
        assert_eq!((layout.levels[1].first, layout.levels[1].tiles), (660, [2, 1]));
        assert_eq!(layout.levels[1].tiles_first, 6);
        assert_eq!(layout.texels, 660 + 170 + 45 + 15 + 6 + 2 + 1);
    }
}
