//! What the papers say in words about stability, beside what was measured.

use super::summary::{Inputs, StabilityTables};
use super::tables::two_digits;
use crate::page::{Claim, Measured, Text, code, percent, player, recorded};
use evaluation::Shape;

/// A sentence of a paper with what the records say about it.
struct Sentence {
    source: &'static str,
    says: &'static str,
    /// Where the page shows it: words and names in turn.
    shown_by: &'static [&'static str],
    measured: fn(&StabilityTables<'_>) -> Measured<String>,
}

const SENTENCES: [Sentence; 9] = [
    Sentence {
        source: "MSM15 4.1",
        says: "The majority of filter kernels are approximated by at most two depths: B is nearly singular",
        shown_by: &["the table of pivots"],
        measured: |t| {
            let (four, six) = (recorded(t.nearly_singular(4))?, recorded(t.nearly_singular(6))?);
            Ok(format!(
                "Of the scenes' kernels {} have a pivot below 1e-6 with four moments, {} with six",
                percent(four, 0),
                percent(six, 0)
            ))
        },
    },
    Sentence {
        source: "MSM15 4.2",
        says: "In double precision the results agree with those of the linear program",
        shown_by: &["atlas-hamburger-4"],
        measured: |t| {
            let published = t.player("four moments, textbook, double precision")?;
            let scenes = t.recommended(published, Inputs::Scenes);
            let hard = t.recommended(published, Inputs::Hard);
            Ok(format!(
                "With a bias of {} the published form errs by at most {} on scenes, {} on hard inputs; it needs {} to \
                 have a number everywhere",
                number(t.alpha(published)),
                two_digits(scenes.error_max),
                two_digits(hard.error_max),
                number(t.smallest_alpha(published, Inputs::Hard, |r| r.not_finite)),
            ))
        },
    },
    Sentence {
        source: "MSM15 4.2",
        says: "Single precision gives numerical noise; alpha = 2e-6 makes it robust",
        shown_by: &["alpha, atlas-hamburger-4"],
        measured: |t| {
            let published = t.player("four moments, as published, single precision")?;
            let scenes = t.recommended(published, Inputs::Scenes);
            let hard = t.recommended(published, Inputs::Hard);
            Ok(format!(
                "Scenes: bound broken for {} of {} fragments, visibly for {}. Hard inputs: visibly for {} of {}",
                scenes.violated, scenes.inputs, scenes.visible, hard.visible, hard.inputs
            ))
        },
    },
    Sentence {
        source: "MSM15 4.2",
        says: "Rarely single pixels are wrong, outside [0, 1], as c_3 approaches 0",
        shown_by: &["atlas-hamburger-4, columns ", "three surfaces", " and ", "pole of c_n"],
        measured: |t| {
            let published = t.player("four moments, textbook, single precision")?;
            let hard = t.recommended(published, Inputs::Hard);
            let ours = t.recommended(t.player("four moments, single precision")?, Inputs::Hard);
            Ok(format!(
                "As published {} of {} hard inputs have no number, {} of these at poles of c_3 and between three \
                 surfaces, and {} lie outside; in 1 / (z - z_f): {} and {}",
                hard.not_finite,
                hard.inputs,
                t.recommended_on(published, &[Shape::Pole, Shape::ThreeSurfaces]).not_finite,
                hard.outside,
                ours.not_finite,
                ours.outside
            ))
        },
    },
    Sentence {
        source: "MSM15 4.2",
        says: "Hausdorff 4MSM eliminates this artifact entirely",
        shown_by: &["atlas-hausdorff-4"],
        measured: |t| {
            let published = t.player("Hausdorff, as published, single precision")?;
            let hard = t.recommended(published, Inputs::Hard);
            Ok(format!(
                "As we read it from the paper {} of {} hard inputs have no number, {} lie outside and {} have a visible \
                 false shadow; ours: {} visible",
                hard.not_finite,
                hard.inputs,
                hard.outside,
                hard.visible,
                t.recommended(t.player("Hausdorff, single precision")?, Inputs::Hard).visible
            ))
        },
    },
    Sentence {
        source: "MSM15 4.3",
        says: "Sixteen bits need alpha = 3e-5; shadows over short ranges suffer from slight noise",
        shown_by: &["alpha, atlas-hamburger-4, row ", "unorm16"],
        measured: |t| {
            let published = t.player("four moments, as published, 16 bits")?;
            let scenes = t.recommended(published, Inputs::Scenes);
            Ok(format!(
                "On scenes the bound holds from alpha = {} on; the noise is {} (99.9 %), the mean loss {}, in single \
                 precision {}",
                number(t.smallest_alpha(published, Inputs::Scenes, |r| r.violated)),
                two_digits(scenes.error_999),
                two_digits(scenes.mean_loss),
                two_digits(
                    t.recommended(t.player("four moments, as published, single precision")?, Inputs::Scenes)
                        .mean_loss
                ),
            ))
        },
    },
    Sentence {
        source: "MSM15 4",
        says: "Hausdorff 4MSM can amplify quantisation artifacts at 16 bits",
        shown_by: &["atlas-hausdorff-4, row ", "unorm16"],
        measured: |t| {
            let four = t.recommended(t.player("four moments, 16 bits")?, Inputs::Scenes);
            let hausdorff = t.recommended(t.player("Hausdorff, 16 bits")?, Inputs::Scenes);
            Ok(format!(
                "Noise on scenes {} (99.9 %) against {} of Hamburger 4, bound broken for {} fragments against {}",
                two_digits(hausdorff.error_999),
                two_digits(four.error_999),
                hausdorff.violated,
                four.violated
            ))
        },
    },
    Sentence {
        source: "MSM15 4, 5",
        says: "The quartic of trigonometric moments can lead to instabilities",
        shown_by: &["atlas-trigonometric-4"],
        measured: |t| {
            let (single, pairs) = (
                t.player("trigonometric, single precision")?,
                t.player("trigonometric, single precision in pairs")?,
            );
            let broken = |method| number(t.smallest_alpha(method, Inputs::Hard, |r| r.violated));
            let four = t.player("four moments, single precision")?;
            Ok(format!(
                "Hard inputs: in single precision the bound holds from alpha = {} on, in pairs of floats with the same \
                 stored numbers from {}; Hamburger 4 in single precision from {}, in {} of the time",
                broken(single),
                broken(pairs),
                broken(four),
                two_digits(recorded(t.nanoseconds(four))? / recorded(t.nanoseconds(single))?),
            ))
        },
    },
    Sentence {
        source: "BHS16 2.5",
        says: "Six moments in ten bits require alpha = 4e-3",
        shown_by: &["alpha, atlas-hamburger-6"],
        measured: |t| {
            let ten = t.player("six moments, 10 bits")?;
            Ok(format!(
                "Bound never broken from {} on, on hard inputs and from {} on scenes; at {} the mean loss on scenes is {}",
                number(t.smallest_alpha(ten, Inputs::Hard, |r| r.violated)),
                number(t.smallest_alpha(ten, Inputs::Scenes, |r| r.violated)),
                number(t.alpha(ten)),
                two_digits(t.recommended(ten, Inputs::Scenes).mean_loss)
            ))
        },
    },
];

fn number(alpha: Option<f64>) -> String {
    alpha.map_or("no bias that was tried".to_owned(), |alpha| format!("{alpha:e}"))
}

impl<'a> StabilityTables<'a> {
    /// Name of the method with this role.
    fn player(&self, role: &'static str) -> Measured<&'a str> {
        player(&self.experiment.technique, role).map(|method| method.name.as_str())
    }

    /// A method's recommended bias.
    fn alpha(&self, name: &str) -> Option<f64> {
        self.experiment.technique.iter().find(|method| method.name == name).map(|method| method.alpha())
    }
}

/// All sentences; those about pivots only of runs with scenes.
pub(crate) fn claims(tables: &StabilityTables<'_>) -> Vec<Claim> {
    let claim = |sentence: &Sentence| {
        let claim = Claim::new(sentence.source, sentence.says, (sentence.measured)(tables))?;
        let pieces = sentence.shown_by.iter().enumerate();
        let text = pieces.map(|(i, &piece)| if i % 2 == 0 { Text::from(piece) } else { code(piece) });
        Some(claim.shown_by(Text::joined(text, "")))
    };
    SENTENCES.iter().filter_map(claim).collect()
}
