//! Light of a colour behind coloured glass: a map for each channel (BHS16 section 4.3) against one for the luminance.

use super::records::ColourRecord;
use super::run::Plan;
use super::view::{View, layered};
use crate::error::EvaluationError;
use crate::fragments::{LoadedScene, Source, chosen};
use crate::statistics::rounded;
use applications::truths;
use scenes::LightView;
use shadow_filtering::Receiver;
use shadow_renderer::Spectrum;

const CHANNELS: [(Spectrum, &str); 3] =
    [(Spectrum::Red, "red"), (Spectrum::Green, "green"), (Spectrum::Blue, "blue")];

/// Rows of a view; none for a stack, which has one kind of light, and where no surface has a colour.
pub(super) fn records(
    plan: &Plan<'_>,
    (loaded, light): (&LoadedScene<'_>, &LightView),
    view: &View,
) -> Result<Vec<ColourRecord>, EvaluationError> {
    let experiment = plan.experiment;
    let (Some(setting), Source::Scene(scene)) = (&experiment.colour, &loaded.source) else {
        return Ok(Vec::new());
    };
    let is_coloured = |transmission: [f32; 3]| transmission.iter().any(|&share| share != transmission[0]);
    if !scene.materials.iter().flat_map(|m| &m.opacity).any(|opacity| is_coloured(opacity.transmission)) {
        return Ok(Vec::new());
    }
    let techniques = experiment.named(&setting.techniques, "colour.techniques")?;
    let places = chosen(view.samples.len(), experiment.scenery.fragments, experiment.scenery.seed, 0);
    let receivers: Vec<Receiver> = places.iter().map(|&place| view.samples[place].receiver).collect();
    let mut rows = Vec::new();
    for (spectrum, channel) in CHANNELS {
        let stack = loaded.translucent(light, experiment.scenery.size, spectrum)?.stack;
        let own = view.with_map(layered(&stack)?);
        let truth = truths(&own.shadow(experiment, &plan.kernel), &receivers);
        for &index in &techniques {
            rows.push(ColourRecord {
                scene: loaded.label.to_owned(),
                view: light.name.clone(),
                technique: experiment.technique[index].name.clone(),
                channel: channel.to_owned(),
                receivers: receivers.len(),
                mean_truth: rounded(truth.iter().sum::<f64>() / truth.len().max(1) as f64),
                l1_error: rounded(plan.mean_error(index, &own, &receivers, &truth)?),
                one_map_error: rounded(plan.mean_error(index, view, &receivers, &truth)?),
            });
        }
    }
    Ok(rows)
}
