use super::*;

#[test]
fn shards_are_written_as_they_are_read() {
    for text in ["1/3", "2/3", "3/3", "1000/1000"] {
        assert_eq!(text.parse::<Shard>().unwrap().to_string(), text);
    }
    for text in ["0/3", "4/3", "1/0", "x", "1/2/3", "-1/2", ""] {
        assert!(text.parse::<Shard>().is_err(), "{text}");
    }
    assert_eq!(ranges(&[1, 2, 3, 7, 9, 10]), "1-3,7,9-10");
}

/// Numbers whose squares are wanted; those that are above the mean go on to a second round.
struct Squares;

impl Pieces for Squares {
    type Key = (u16, u32);
    type Finding = f64;

    fn name(&self) -> &'static str {
        "numbers"
    }

    fn rounds(&self) -> usize {
        2
    }

    fn keys(&self, round: usize, known: &Known<Self>) -> Vec<(u16, u32)> {
        let first = (0..40).map(|number| (0, number));
        if round == 0 {
            return first.collect();
        }
        let mean = known.iter().filter(|(key, _)| key.0 == 0).map(|(_, value)| value).sum::<f64>() / 40.0;
        first.filter(|key| known[key] > mean).map(|(_, number)| (1, number)).collect()
    }

    fn find(
        &self,
        keys: &[(u16, u32)],
        _done: (usize, usize),
        keep: Keep<'_, Self>,
    ) -> Result<(), EvaluationError> {
        for &(round, number) in keys {
            // What is no number must come back as it is, too.
            let value = f64::from(number * (u32::from(round) + 1)).sqrt();
            keep(vec![((round, number), if (round, number) == (1, 39) { f64::NAN } else { value })])?;
        }
        Ok(())
    }
}

fn context<'a>(task: Task<'a>, identity: &str) -> RunContext<'a> {
    RunContext {
        progress: &|_, _| (),
        directory: Path::new("nowhere"),
        task,
        keeps_findings: false,
        backend: crate::run::Backend::Cpu,
        identity: identity.to_owned(),
        started: Instant::now(),
    }
}

const AT_ONCE: Duration = Duration::ZERO;

fn part(parts: &Path, round: usize, shard: &str, identity: &str) -> Result<usize, String> {
    let task = Task::Part { parts, round, shard: shard.parse().unwrap(), patience: AT_ONCE };
    let context = context(task, identity);
    if let Some(recorded) = already_there(&context).map_err(|error| error.to_string())? {
        return Ok(recorded.trials);
    }
    match gather(&context, &context.identity, &Squares).map_err(|error| error.to_string())? {
        Gathered::Part(recorded) => Ok(recorded.trials),
        Gathered::All(_) => Err("a part is not all".to_owned()),
    }
}

fn select(parts: &Path, round: usize) -> Result<usize, String> {
    let context = context(Task::Select { parts, round, patience: AT_ONCE }, "abc");
    match gather(&context, &context.identity, &Squares).map_err(|error| error.to_string())? {
        Gathered::Part(recorded) => Ok(recorded.trials),
        Gathered::All(_) => Err("a selection is not all".to_owned()),
    }
}

/// Findings of the squares.
type Found = Vec<((u16, u32), u64)>;

fn merged(parts: &Path, identity: &str) -> Result<Found, String> {
    let directories = [parts.to_owned()];
    let task = if parts.as_os_str().is_empty() {
        Task::Whole
    } else {
        Task::Merge { directories: &directories, patience: AT_ONCE }
    };
    let context = context(task, identity);
    match gather(&context, &context.identity, &Squares).map_err(|error| error.to_string())? {
        Gathered::All(known) => {
            let mut all: Vec<_> = known.into_iter().map(|(key, value)| (key, value.to_bits())).collect();
            all.sort_unstable();
            Ok(all)
        }
        Gathered::Part(_) => Err("all is not a part".to_owned()),
    }
}

#[test]
fn rounds_of_shards_find_what_one_machine_finds_whatever_happens_between_them() {
    let folder = tempfile::tempdir().unwrap();
    let parts = folder.path();
    let whole = merged(Path::new(""), "abc").unwrap();
    assert_eq!(select(parts, 0), Ok(40));
    assert!(select(parts, 1).unwrap_err().contains("round-0: has no shard of round 0"));
    for shard in ["1/3", "3/3"] {
        assert!((13..=14).contains(&part(parts, 0, shard, "abc").unwrap()));
    }
    assert!(select(parts, 1).unwrap_err().contains("of round 0, 1 of 3 shards are missing: 2"));
    let [first, second] =
        ["1", "2"].map(|i| parts.join("round-0").join(format!("shard-000{i}-of-0003.part")));
    let good = std::fs::read(&first).unwrap();
    // A task that was killed has left a file that nobody reads.
    std::fs::write(parts.join("round-0/.shard-0002-of-0003.part.7-7.partial"), &good[..9]).unwrap();
    assert_eq!(round_state(parts, 0, 3).running, [2]);
    part(parts, 0, "2/3", "abc").unwrap();
    let state = round_state(parts, 0, 3);
    assert_eq!((state.selected, state.done.len(), state.running.len()), (Some(40), 3, 0));
    // Done again, nothing changes.
    part(parts, 0, "1/3", "abc").unwrap();
    assert_eq!(std::fs::read(&first).unwrap(), good);
    // Another build or other inputs; the file stays.
    assert!(
        part(parts, 0, "1/3", "abd").unwrap_err().contains("shard-0001-of-0003.part: belongs to another")
    );
    assert!(merged(parts, "abd").unwrap_err().contains("belongs to another"));
    assert_eq!(std::fs::read(&first).unwrap(), good);
    // Two files for one shard.
    std::fs::copy(&first, parts.join("round-0/shard-0001-of-0003 copy.part")).unwrap();
    assert!(select(parts, 1).unwrap_err().contains("shard 1/3 of round 0 once more"));
    assert_eq!(round_state(parts, 0, 3).faults.len(), 1);
    std::fs::remove_file(parts.join("round-0/shard-0001-of-0003 copy.part")).unwrap();
    // Cut anywhere, it is refused; the shard is done again, and the rest stays.
    for length in [0, 5, good.len() / 2, good.len() - 1] {
        std::fs::write(&first, &good[..length]).unwrap();
        let message = select(parts, 1).unwrap_err();
        assert!(message.contains("shard-0001-of-0003.part: is"), "{message}");
    }
    for at in (0..good.len()).step_by(7) {
        let mut damaged = good.clone();
        damaged[at] ^= 2;
        std::fs::write(&first, damaged).unwrap();
        assert!(select(parts, 1).unwrap_err().contains("shard-0001-of-0003.part"), "byte {at}");
    }
    let other = std::fs::read(&second).unwrap();
    part(parts, 0, "1/3", "abc").unwrap();
    assert!(parts.join("round-0/shard-0001-of-0003.part.damaged").exists());
    assert_eq!(std::fs::read(&second).unwrap(), other);
    let left = select(parts, 1).unwrap();
    assert!((10..30).contains(&left), "{left}");
    // More shards than pieces: some have nothing to do, and say so.
    let shares: Vec<usize> =
        (1..=50).map(|index| part(parts, 1, &format!("{index}/50"), "abc").unwrap()).collect();
    assert_eq!((shares.iter().sum::<usize>(), shares.iter().max()), (left, Some(&1)));
    assert_eq!(merged(parts, "abc").unwrap(), whole);
    assert!(part(parts, 2, "1/3", "abc").unwrap_err().contains("round 2 is none of 2"));
}
