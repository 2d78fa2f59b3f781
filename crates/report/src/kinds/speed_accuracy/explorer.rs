//! Pictures to compare.

use super::summary::SpeedTables;
use super::tables::recorded_picture;
use crate::page::{Explorer, RecordedPicture};

/// The pictures of all views under one slider.
pub(super) fn explorers(tables: &SpeedTables<'_>) -> Vec<Explorer> {
    let pictures = tables.pictures();
    let compared = pictures.first().map(|first| first.columns.clone());
    compared.map(|columns| Explorer::Pictures(columns, pictures)).into_iter().collect()
}

impl SpeedTables<'_> {
    /// The pictures of all views, where they were asked for.
    pub(super) fn pictures(&self) -> Vec<RecordedPicture> {
        let views = self.views.iter().map(|view| (view.scene.as_str(), view.view.as_str()));
        self.experiment.pictures_of_views(views).iter().map(recorded_picture).collect()
    }
}
