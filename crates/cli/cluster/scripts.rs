//! The files of the folder: everything that a cluster does stands in them.

use super::plan::{FILE, Plan};
use super::{Arguments, Engine};
use crate::outcome::Failure;
use anyhow::{Context, anyhow};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Seconds that files may take to show: network file systems remember for half a minute that a file was not there.
const WAIT: u64 = 60;

/// A word of the shell.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// Writes all files into a new folder, which appears whole or not at all; returns their names.
pub(super) fn write(
    arguments: &Arguments,
    plan: &Plan,
    (experiment, out): (&Path, &Path),
) -> Result<Vec<String>, Failure> {
    let is_taken = std::fs::read_dir(out).is_ok_and(|mut entries| entries.next().is_some()) || out.is_file();
    if is_taken {
        let reason = format!("{}: is there already and not empty: nothing was written", out.display());
        return Err(Failure::Input(anyhow!(reason)));
    }
    let absolute = std::path::absolute(out).with_context(|| out.display().to_string())?;
    if absolute.to_string_lossy().contains(['\n', '%']) {
        return Err(Failure::Input(anyhow!("{}: Slurm gives % in names a meaning", out.display())));
    }
    let source = crate::experiments::text(experiment)?;
    let program = std::env::current_exe().context("the program's own path")?;
    let setup = match &arguments.setup {
        Some(path) => {
            let read = std::fs::read(path);
            Some(read.map_err(|error| Failure::Input(anyhow!("--setup {}: {error}", path.display())))?)
        }
        None => None,
    };
    let parent = absolute.parent().unwrap_or(&absolute).to_owned();
    let name = absolute.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let making = parent.join(format!(".{name}.{}.partial", std::process::id()));
    let folder = Making(making);
    let place = |error: std::io::Error| anyhow!("{}: {error}", absolute.display());
    std::fs::create_dir_all(folder.0.join("logs")).map_err(place)?;
    let here = std::env::current_dir().context("the current folder")?;
    let mut files: Vec<(String, Vec<u8>)> = vec![
        (format!("{}.toml", plan.experiment), source),
        ("settings.sh".to_owned(), settings(arguments, plan, &absolute, &here).into_bytes()),
    ];
    for round in 0..plan.rounds {
        files.push((format!("select-{round}.sh"), select(arguments, plan, round).into_bytes()));
        files.push((format!("round-{round}.sh"), round_script(arguments, plan, round).into_bytes()));
    }
    files.push(("merge.sh".to_owned(), merge(arguments, plan).into_bytes()));
    files.push(("submit.sh".to_owned(), submit(plan).into_bytes()));
    files.push(("README.md".to_owned(), readme(plan).into_bytes()));
    files.extend(setup.map(|text| ("setup.sh".to_owned(), text)));
    if plan.engine == Engine::Parallel {
        files.push(("machines".to_owned(), b":\n".to_vec()));
    }
    let json = serde_json::to_string_pretty(plan).context("the plan")?;
    files.push((FILE.to_owned(), (json + "\n").into_bytes()));
    for (name, bytes) in &files {
        std::fs::write(folder.0.join(name), bytes).map_err(place)?;
    }
    // A program that is built anew while tasks wait must not become another one for them.
    std::fs::copy(&program, folder.0.join("msm")).map_err(place)?;
    // An empty folder may be there.
    let _ = std::fs::remove_dir(&absolute);
    std::fs::rename(&folder.0, &absolute).map_err(place)?;
    Ok(files.into_iter().map(|(name, _)| name).collect())
}

/// A folder in the making, taken back unless it got its name.
struct Making(PathBuf);

impl Drop for Making {
    fn drop(&mut self) {
        // After the rename there is nothing of this name.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn settings(arguments: &Arguments, plan: &Plan, folder: &Path, here: &Path) -> String {
    let mut options = format!("--scale {} --threads {}", plan.scale, plan.threads);
    let mut scenes = String::new();
    for scene in &arguments.scenes {
        // Writing to a string cannot fail.
        let _ = write!(scenes, " --scene {}", quoted(scene));
    }
    if let Some(seed) = arguments.seed {
        let _ = write!(options, " --seed {seed}");
    }
    if arguments.exhaustive {
        options += " --exhaustive";
    }
    let folder = folder.display().to_string();
    let setup = if arguments.setup.is_some() { ". \"$FOLDER/setup.sh\"\n" } else { "" };
    format!(
        "# What all tasks begin with.\n\
         FOLDER={folder}\n\
         SHARDS={shards}\n\
         # One task of `msm run`, with what all have in common.\n\
         task() {{\n  exec \"$FOLDER/msm\" run \"$FOLDER/{name}.toml\" {options}{scenes} --wait {WAIT} \"$@\"\n}}\n\
         {setup}\
         # Scenes are named as seen from here.\n\
         cd {here}\n",
        folder = quoted(&folder),
        shards = plan.shards,
        name = plan.experiment,
        here = quoted(&here.display().to_string()),
    )
}

/// The lines that Slurm reads; GNU parallel takes them for comments and needs none.
fn head(arguments: &Arguments, plan: &Plan, job: &str, log: &str) -> String {
    if plan.engine == Engine::Parallel {
        return "#!/bin/sh\n".to_owned();
    }
    let mut head = format!(
        "#!/bin/sh\n\
         #SBATCH --job-name={name}-{job}\n\
         #SBATCH --output=logs/{log}.log\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --requeue\n\
         #SBATCH --nodes=1\n\
         #SBATCH --cpus-per-task={threads}\n",
        name = plan.job,
        threads = plan.threads,
    );
    let options = [("partition", &arguments.partition), ("time", &arguments.time), ("mem", &arguments.mem)];
    for (option, value) in options {
        if let Some(value) = value {
            let _ = writeln!(head, "#SBATCH --{option}={value}");
        }
    }
    head
}

fn select(arguments: &Arguments, plan: &Plan, round: usize) -> String {
    let what = if round == 0 {
        "# Writes down the pieces of the first round, and what all shards would compute alike.\n".to_owned()
    } else {
        format!("# Reads what round {} has found and writes down the pieces of round {round}.\n", round - 1)
    };
    let head = head(arguments, plan, &format!("select-{round}"), &format!("select-{round}"));
    format!("{head}{what}. ./settings.sh\ntask --parts \"$FOLDER/parts\" --select {round}\n")
}

fn round_script(arguments: &Arguments, plan: &Plan, round: usize) -> String {
    let head = head(arguments, plan, &format!("round-{round}"), &format!("round-{round}-%a"));
    let (array, index) = match plan.engine {
        Engine::Slurm => (format!("#SBATCH --array=1-{}\n", plan.shards), "$SLURM_ARRAY_TASK_ID"),
        Engine::Parallel => (String::new(), "$1"),
    };
    format!(
        "{head}{array}\
         # One shard of round {round}: one file in parts/round-{round}, written whole or not at all. Where it is, nothing is done.\n\
         . ./settings.sh\n\
         task --parts \"$FOLDER/parts\" --round {round} --shard \"{index}/$SHARDS\"\n"
    )
}

fn merge(arguments: &Arguments, plan: &Plan) -> String {
    format!(
        "{head}\
         # Completes the run from what all shards have found: records, figures and page below results/.\n\
         . ./settings.sh\n\
         if ls \"$FOLDER\"/results/*/*/provenance.json >/dev/null 2>&1; then\n  \
           echo \"merged before\"\n  exit 0\nfi\n\
         task --out \"$FOLDER/results\" --merge \"$FOLDER/parts\"\n",
        head = head(arguments, plan, "merge", "merge")
    )
}

fn submit(plan: &Plan) -> String {
    let usage = "# sh submit.sh               all rounds, each after the one before it\n";
    let rounds = plan.rounds;
    match plan.engine {
        Engine::Slurm => format!(
            "#!/bin/sh\n{usage}\
             # sh submit.sh 1              from round 1 on\n\
             # sh submit.sh 1 3,7-9        from round 1 on, and of that only shards 3 and 7 to 9\n\
             # sh submit.sh {rounds}              only what completes the run\n\
             set -eu\n\
             cd \"$(dirname \"$0\")\"\n\
             round=${{1:-0}}\n\
             some=${{2:-}}\n\
             after=\n\
             submit() {{\n  \
               after=$(sbatch --parsable --kill-on-invalid-dep=yes ${{after:+--dependency=afterok:$after}} \"$@\")\n  \
               after=${{after%%;*}}\n  \
               echo \"$after $*\"\n}}\n\
             while [ \"$round\" -lt {rounds} ]; do\n  \
               [ -n \"$some\" ] || submit \"select-$round.sh\"\n  \
               submit ${{some:+--array=$some}} \"round-$round.sh\"\n  \
               some=\n  \
               round=$((round + 1))\n\
             done\n\
             submit merge.sh\n"
        ),
        Engine::Parallel => format!(
            "#!/bin/sh\n{usage}\
             # sh submit.sh 1              from round 1 on\n\
             # sh submit.sh 1 \"3 7 8 9\"    from round 1 on, and of that only these shards\n\
             # sh submit.sh {rounds}              only what completes the run\n\
             # The file `machines` has a line for each machine, as GNU parallel reads them: `4/node17` runs four tasks there at a\n\
             # time, `:` is this machine.\n\
             set -eu\n\
             cd \"$(dirname \"$0\")\"\n\
             round=${{1:-0}}\n\
             some=${{2:-}}\n\
             while [ \"$round\" -lt {rounds} ]; do\n  \
               [ -n \"$some\" ] || sh \"select-$round.sh\" >>\"logs/select-$round.log\" 2>&1\n  \
               # A task whose machine has failed is run again elsewhere.\n  \
               parallel --will-cite --sshloginfile machines --workdir \"$PWD\" --retries 3 \\\n    \
                 --joblog \"logs/round-$round.joblog\" \\\n    \
                 \"sh round-$round.sh {{}} >>logs/round-$round-{{}}.log 2>&1\" ::: ${{some:-$(seq {shards})}}\n  \
               some=\n  \
               round=$((round + 1))\n\
             done\n\
             sh merge.sh >>logs/merge.log 2>&1\n",
            shards = plan.shards
        ),
    }
}

fn readme(plan: &Plan) -> String {
    let Plan { experiment, scale, rounds, shards, .. } = plan;
    format!(
        "`{experiment}.toml` at scale {scale}, in {rounds} rounds of {shards} shards; everything that runs stands in these scripts.\n\
         `sh submit.sh` begins: `select-K.sh` writes down what round K is made of, `round-K.sh` is one of its shards, `merge.sh` ends.\n\
         Every shard leaves one file in `parts/round-K/`; killed or repeated at any time, it does no harm; output goes to `logs/`.\n\
         `./msm cluster status .` tells what is done, running and missing, and the line that submits again what is missing.\n\
         The run is recorded below `results/`, with the bytes that one machine would have written.\n"
    )
}
