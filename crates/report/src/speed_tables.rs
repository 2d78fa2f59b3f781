//! Tables of a `speed-accuracy` run.

use crate::speed_summary::{SpeedTables, Time};
use evaluation::{SpeedAccuracyExperiment, SpeedAccuracyRecord};
use std::fmt::Write as _;

pub(crate) fn markdown(experiment: &SpeedAccuracyExperiment, tables: &SpeedTables) -> String {
    let mut text = String::new();
    pictures(experiment, tables, &mut text);
    front(tables, &mut text);
    techniques(tables, &mut text);
    times(tables, &mut text);
    tables.gpu_table(&mut text);
    needs(tables, &mut text);
    text
}

fn pictures(experiment: &SpeedAccuracyExperiment, tables: &SpeedTables, text: &mut String) {
    let views = tables.views.iter().map(|view| (view.scene.as_str(), view.view.as_str()));
    let links: Vec<String> = experiment
        .pictures_of_views(views)
        .iter()
        .map(|picture| format!("[{}, {}]({}.png)", picture.scene, picture.view, picture.id))
        .collect();
    if let Some(every) = experiment.every_view.as_ref().filter(|_| !links.is_empty()) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "From every view, PCF with receiver plane, then {}: {}.\n",
            every.techniques.join("; "),
            links.join(", ")
        );
    }
    for picture in &experiment.picture {
        let columns = picture.techniques.join("; ");
        let view = if picture.view.is_empty() { "first view" } else { &picture.view };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "![{}, {view}]({}.png)\n", picture.scene, picture.id);
        let _ = writeln!(
            text,
            "{}, {view}, from left to right: PCF with receiver plane; {columns}. Lower bounds as they are, depth bias {} texels + {} \
             slopes; below, parts of the pictures magnified.\n",
            picture.scene, picture.bias.texels, picture.bias.slopes
        );
    }
}

fn percent(value: f64) -> String {
    format!("{:.2} %", 100.0 * value)
}

fn error(record: &SpeedAccuracyRecord) -> String {
    let margin = record.standard_error.map(|e| format!(" ± {:.2}", 200.0 * e)).unwrap_or_default();
    format!("{:.2}{margin} %", 100.0 * record.l1_error)
}

fn blend(record: &SpeedAccuracyRecord) -> String {
    match (record.beta > 0.0, record.leak_reduction > 0.0) {
        (false, false) => "lower bound".to_owned(),
        (true, false) => format!("beta {}", record.beta),
        (false, true) => format!("leak reduction {}", record.leak_reduction),
        (true, true) => format!("beta {}, leak reduction {}", record.beta, record.leak_reduction),
    }
}

fn alpha(record: &SpeedAccuracyRecord) -> String {
    record.alpha.map_or("-".to_owned(), |alpha| format!("{alpha:e}"))
}

// Writing to a string cannot fail.
fn front(tables: &SpeedTables, text: &mut String) {
    let _ = writeln!(
        text,
        "### Nothing is cheaper and more accurate\n\n| technique | format | map | alpha | depth bias | blend | bits a texel | map memory | operations | cost | error |\n|---|---|--:|--:|---|---|--:|--:|--:|--:|--:|"
    );
    for r in tables.front() {
        let memory = f64::from(r.size).powi(2) * r.bits_per_texel as f64 / 8.0 / f64::from(1 << 20);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} texels + {} slopes | {} | {} | {memory:.2} MiB | {:.0} | {:.3} | {} |",
            r.technique,
            r.format,
            r.size,
            alpha(r),
            r.bias_texels,
            r.bias_slopes,
            blend(r),
            r.bits_per_texel,
            r.operations,
            r.cost,
            error(r)
        );
    }
    let _ = writeln!(
        text,
        "\nLower is better everywhere. *Error*: mean |G - F| over all fragments with two standard errors; F is PCF with a \
         receiver plane on the {0}x{0} map. *Cost*: modelled memory traffic and arithmetic of a frame, 1 for the first \
         technique at full size; it is no time. *Operations*: decoding and shading one fragment. *Blend*: beta is the \
         share of the way from the lower to the upper bound, leak reduction p divides shadows by 1 - p.\n",
        tables.full_size()
    );
}

fn techniques(tables: &SpeedTables, text: &mut String) {
    let scenes = tables.scenes();
    let mut sizes: Vec<u32> = tables.best().map(|r| r.size).collect();
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes.dedup();
    let _ = write!(
        text,
        "### Every technique with its own best biases\n\n| technique | format | alpha | bits | cost |"
    );
    for size in &sizes {
        let _ = write!(text, " at {size} |");
    }
    for scene in &scenes {
        let _ = write!(text, " {scene} |");
    }
    let columns = sizes.len() + scenes.len();
    let _ = writeln!(text, "\n|---|---|--:|--:|--:{}|", "|--:".repeat(columns));
    let mut full = tables.full();
    full.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
    for r in full {
        let _ = write!(
            text,
            "| {} | {} | {} | {} | {:.2} |",
            r.technique,
            r.format,
            alpha(r),
            r.bits_per_texel,
            r.cost
        );
        for &size in &sizes {
            let same = |o: &&SpeedAccuracyRecord| {
                o.size == size && o.technique == r.technique && o.format == r.format
            };
            let cell = tables.best().find(same).map_or("-".to_owned(), |o| percent(o.l1_error));
            let _ = write!(text, " {cell} |");
        }
        for scene in &scenes {
            let cell = tables.part(r, scene, "all").map_or("-".to_owned(), |o| percent(o.l1_error));
            let _ = write!(text, " {cell} |");
        }
        text.push('\n');
    }
    let _ = writeln!(
        text,
        "\nErrors of all scenes by side of the map, then of single scenes at full size. `depth` is percentage-closer \
         filtering without a receiver plane.\n"
    );
}

fn times(tables: &SpeedTables, text: &mut String) {
    let _ = writeln!(
        text,
        "### Time on one core\n\n| technique | format | precision | shading a fragment | ratio | encoding and filtering a texel | ratio |\n|---|---|---|--:|--:|--:|--:|"
    );
    let mut seen: Vec<(&str, &str, &str)> = Vec::new();
    for sample in &tables.samples {
        let key = (sample.technique.as_str(), sample.format.as_str(), sample.precision.as_str());
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        let (technique, format, precision) = key;
        let cell = |stage: &str| {
            let time = tables.time(technique, format, precision, stage);
            let ratio = tables.ratio(technique, format, precision, stage);
            let show =
                |Time { least, median, most }: Time| format!("{median:.1} ns ({least:.1} to {most:.1})");
            (time.map_or("-".to_owned(), show), ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}")))
        };
        let ((shade, shade_ratio), (filter, filter_ratio)) = (cell("shade"), cell("filter"));
        let stored = if precision == "f32" { format } else { "-" };
        let _ = writeln!(
            text,
            "| {technique} | {stored} | {precision} | {shade} | {shade_ratio} | {filter} | {filter_ratio} |"
        );
    }
    let _ = writeln!(
        text,
        "\nMedian, least and most over the rounds; ratios are to the first technique in the same round and precision, median. A \
         call at a time, without vector units; what a graphics processor takes is another matter.\n"
    );
}

fn needs(tables: &SpeedTables, text: &mut String) {
    text.push_str("### How many moments kernels need\n\n");
    for (by, tolerance) in tables.need_kinds() {
        let what = match by {
            "rank" => format!(
                "Surfaces in a kernel: eigenvalues of the moment matrix above {tolerance:e} of the largest"
            ),
            "gap" => format!("Least number of moments whose sharp bounds are closer than {tolerance}"),
            _ => format!("Least number of moments whose lower bound loses less than {tolerance} to PCF"),
        };
        let names: Vec<String> =
            tables.needs("all", by, tolerance).into_iter().map(|(needs, _)| needs).collect();
        let _ = writeln!(
            text,
            "{what}:\n\n| scene | {} |\n|---{}|",
            names.join(" | "),
            "|--:".repeat(names.len())
        );
        for scene in tables.scenes().into_iter().chain(["all"]) {
            let shares: Vec<String> = tables
                .needs(scene, by, tolerance)
                .into_iter()
                .map(|(_, share)| format!("{:.1} %", 100.0 * share))
                .collect();
            let _ = writeln!(text, "| {scene} | {} |", shares.join(" | "));
        }
        text.push('\n');
    }
}
