//! The tables of a candidate search's page.

use crate::search_summary::{SearchTables, error};
use evaluation::{SearchExperiment, SearchRecord};
use std::fmt::Write as _;

/// Rows of the table of the best.
const BEST: usize = 50;

/// All tables as Markdown. Writing to a string cannot fail.
pub(crate) fn markdown(experiment: &SearchExperiment, tables: &SearchTables) -> String {
    let mut text = String::new();
    best(&mut text, tables);
    classes(&mut text, tables);
    sizes(&mut text, tables);
    marks(&mut text, experiment, tables);
    certainty(&mut text, tables);
    speed(&mut text, tables);
    text
}

fn row(text: &mut String, record: &SearchRecord) {
    let _ = writeln!(
        text,
        "| {} | {} to {} | `{}` | {} | {} | {} |",
        record.rank,
        record.rank_low,
        record.rank_high,
        record.basis,
        record.class,
        error(record),
        record.fragments
    );
}

const HEADER: &str =
    "| rank | rank range | basis | class | mean error | fragments |\n|--:|---|---|---|--:|--:|\n";

fn best(text: &mut String, tables: &SearchTables) {
    let m = tables.main_order();
    let all = tables.of(m);
    let _ = write!(
        text,
        "## The best {} of {} candidates of {m} functions\n\n{HEADER}",
        BEST.min(all.len()),
        all.len()
    );
    all.iter().take(BEST).for_each(|record| row(text, record));
    let marked = [tables.power(), tables.trigonometric()];
    for record in marked.into_iter().flatten().filter(|r| r.rank > BEST) {
        row(text, record);
    }
    text.push_str(
        "\nMean error is |G - F| as a fraction of the kernel's weight, over all fragments of all views, every view \
         weighing the same. ± is half a 99 % interval of the difference to power moments, which were evaluated on the \
         whole sample; the rank range is what these intervals allow.\n\n",
    );
}

fn classes(text: &mut String, tables: &SearchTables) {
    let all = tables.of(tables.main_order());
    let mut seen: Vec<&str> = Vec::new();
    let _ = write!(text, "## The best of each class\n\n{HEADER}");
    for record in all {
        if !seen.contains(&record.class.as_str()) {
            seen.push(&record.class);
            row(text, record);
        }
    }
    text.push_str("\nA class has candidates only if the family has that many functions of one kind.\n\n");
}

fn sizes(text: &mut String, tables: &SearchTables) {
    text.push_str(
        "## Number of functions\n\n| m | candidates | best | its error | 10th | median | worst |\n\
         |--:|--:|---|--:|--:|--:|--:|\n",
    );
    for m in tables.orders() {
        let all = tables.of(m);
        let Some(first) = all.first() else { continue };
        let percent = |place: usize| format!("{:.2} %", 100.0 * all[place.min(all.len() - 1)].l1_error);
        let _ = writeln!(
            text,
            "| {m} | {} | `{}` | {} | {} | {} | {} |",
            all.len(),
            first.basis,
            error(first),
            percent(9),
            percent(all.len() / 2),
            percent(all.len() - 1)
        );
    }
    text.push('\n');
}

fn marks(text: &mut String, experiment: &SearchExperiment, tables: &SearchTables) {
    text.push_str(
        "## Closed forms on the same fragments, and what moving depths changes\n\n\
         | technique | error | moved to the support | change |\n|---|--:|--:|--:|\n",
    );
    for mark in &tables.marks {
        let percent =
            |value: f64, deviation: f64| format!("{:.3} ± {:.3} %", 100.0 * value, 100.0 * deviation);
        let exact = match (mark.l1_error, mark.standard_error) {
            (Some(value), Some(deviation)) => percent(value, deviation),
            _ => "-".to_owned(),
        };
        let change = match (mark.l1_error, mark.difference_standard_error) {
            (Some(value), Some(deviation)) => percent(mark.moved_l1_error - value, deviation),
            _ => "-".to_owned(),
        };
        let moved = percent(mark.moved_l1_error, mark.moved_standard_error);
        let _ = writeln!(text, "| {} | {exact} | {moved} | {change} |", mark.technique);
    }
    let _ = writeln!(
        text,
        "\nCandidates are judged with every depth moved to the nearest end of {} equal cells, and their bounds are those \
         over these depths. ± is one standard error. The change shifts the level of all techniques alike and hardly their \
         differences.\n",
        experiment.cells
    );
}

fn certainty(text: &mut String, tables: &SearchTables) {
    text.push_str(
        "## Linear programs\n\n| m | block | fragments | candidates | programs | in double-double | uncertified |\n\
         |--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for stage in &tables.stages {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} |",
            stage.m,
            stage.block,
            stage.fragments,
            stage.candidates,
            stage.programs,
            stage.exact,
            stage.uncertified
        );
    }
    let fragments: usize = tables.views.iter().map(|view| view.fragments).sum();
    let sampled: usize = tables.views.iter().map(|view| view.sampled).sum();
    let active: usize = tables.views.iter().map(|view| view.active).sum();
    let _ = writeln!(
        text,
        "\n{sampled} of {fragments} fragments on {} views were drawn; {:.1} % of these have F > 0 and need a program, \
         equal ones only once. A block is for the candidates that can still be among the best after those before it.\n",
        tables.views.len(),
        100.0 * active as f64 / sampled.max(1) as f64
    );
    if !tables.agreement.is_empty() {
        let compared: usize = tables.agreement.iter().map(|a| a.fragments).sum();
        let failed: usize = tables.agreement.iter().map(|a| a.failed).sum();
        let worst = tables.agreement.iter().map(|a| a.largest_disagreement).fold(0.0, f64::max);
        let gap = tables.agreement.iter().map(|a| a.largest_gap).fold(0.0, f64::max);
        let _ = writeln!(
            text,
            "The double-double simplex method, started cold, on {compared} of these programs for {} bases drawn at \
             random: largest disagreement {worst:.1e} (it failed on {failed}), largest distance between a bound and its \
             proof {gap:.1e}.\n",
            tables.agreement.len()
        );
    }
}

fn speed(text: &mut String, tables: &SearchTables) {
    let speeds = tables.speeds();
    if speeds.is_empty() {
        return;
    }
    text.push_str(
        "## Speed\n\n| basis | FastSimplex, programs/s | good_lp with microlp | ratio | microlp wrong or refused |\n\
         |---|--:|--:|--:|--:|\n",
    );
    for speed in &speeds {
        let _ = writeln!(
            text,
            "| `{}` | {:.2} million | {:.0} | {:.0} | {} of {} |",
            speed.basis,
            speed.fast / 1e6,
            speed.microlp,
            speed.fast / speed.microlp,
            speed.microlp_wrong,
            speed.microlp_programs
        );
    }
    text.push_str(
        "\nOne thread, the fastest of all repetitions (samples.csv has each). FastSimplex includes preparing the columns and \
         a certificate for each bound, and solves every program of the last block to 1e-6; microlp is not checked while it \
         is timed and gets some of the same programs.\n",
    );
}
