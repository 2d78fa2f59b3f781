//! At which depth bias F is computed, and what another one does: the level of every error hangs on it.

use super::rows::distinct;
use crate::page::{Block, Table, Text, in_percent};
use evaluation::{DepthBias, ReferenceRecord};

/// The reference of a run.
pub(crate) struct ReferenceLevel<'a> {
    bias: DepthBias,
    records: &'a [ReferenceRecord],
}

impl<'a> ReferenceLevel<'a> {
    /// Of a run whose F is computed at this bias; without rows in runs before they were recorded.
    pub(crate) fn new(bias: DepthBias, records: &'a [ReferenceRecord]) -> Self {
        Self { bias, records }
    }

    /// A sentence about errors with the bias that they are against, and the mean of F at others.
    pub(crate) fn before(&self, sentence: &str) -> String {
        let means: Vec<String> = self.beside().into_iter().map(|(_, mean)| in_percent(mean, 1)).collect();
        let texels: Vec<String> = self.beside().into_iter().map(|(texels, _)| texels.to_string()).collect();
        let level = match means.is_empty() {
            true => String::new(),
            false => format!(", whose mean is {} % at {} texels", means.join(", "), texels.join(", ")),
        };
        format!("Against F at a depth bias of {}{level}: {sentence}", self.at())
    }

    /// The bias in words.
    pub(crate) fn at(&self) -> String {
        let DepthBias { texels, slopes } = self.bias;
        let plural = if texels == 1.0 { "" } else { "s" };
        let slopes = if slopes == 0.0 { String::new() } else { format!(" + {slopes} slopes") };
        format!("{texels} texel{plural}{slopes}")
    }

    /// Means of F over the views, each view counting alike, by the constant bias in texels, ascending.
    fn beside(&self) -> Vec<(f64, f64)> {
        let mut biases = distinct(self.records.iter().map(|r| r.bias_texels));
        biases.sort_by(f64::total_cmp);
        let mean = |texels: f64| {
            let of_bias = self.records.iter().filter(|r| r.bias_texels == texels);
            let values: Vec<f64> = of_bias.map(|r| r.mean_reference).collect();
            values.iter().sum::<f64>() / values.len().max(1) as f64
        };
        biases.into_iter().map(|texels| (texels, mean(texels))).collect()
    }

    /// The mean of F by view and bias; nothing in runs before it was recorded.
    pub(crate) fn blocks(&self, level: u8) -> Vec<Block> {
        let views = distinct(self.records.iter().map(|r| (r.scene.as_str(), r.view.as_str())));
        let biases: Vec<f64> = self.beside().into_iter().map(|(texels, _)| texels).collect();
        let cells = |&(scene, view): &(&str, &str)| {
            let mean = |texels: &f64| {
                let of =
                    |r: &&ReferenceRecord| r.scene == scene && r.view == view && r.bias_texels == *texels;
                self.records.iter().find(of).map(|r| in_percent(r.mean_reference, 1)).into()
            };
            let name: Text = format!("{scene} {view}").into();
            std::iter::once(name).chain(biases.iter().map(mean)).collect()
        };
        let table = Table::default()
            .left(["view"])
            .right(biases.iter().map(|texels| format!("{texels} texels")))
            .rows(views.iter().map(cells));
        let note = format!(
            "Mean of F in percent. All errors of this page are against F at {}; a bias that makes F darker or lighter moves all of \
             them.",
            self.at()
        );
        Block::section(level, "What the depth bias does to F", table, Some(note.into()))
    }
}
