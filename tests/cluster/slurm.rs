//! A Slurm of two nodes on the loopback address: its daemons, started here and ended here.

use crate::scripts::{experiment, folder, found, msm, records, status, succeeded, whole};
use libtest_mimic::Failed;
use serde_json::Value;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// What must be installed.
pub const PROGRAMS: [&str; 6] = ["slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel"];

/// Longest time for anything.
const PATIENCE: Duration = Duration::from_secs(300);

/// Seconds that every task sleeps first: there is time to kill something.
const SLEEP: &str = "sleep 0.4\n";

/// Two nodes of two processors each, and who controls them.
struct Cluster {
    folder: PathBuf,
    control: Child,
    nodes: Vec<Child>,
}

impl Cluster {
    fn start(folder: &Path) -> Result<Self, Failed> {
        for name in ["state", "spool-n1", "spool-n2"] {
            std::fs::create_dir_all(folder.join(name))?;
        }
        // Ports that are free now.
        let listeners = [0; 3].map(|_| TcpListener::bind("127.0.0.1:0"));
        let mut ports = Vec::new();
        for listener in listeners {
            ports.push(listener?.local_addr()?.port());
        }
        let user = String::from_utf8(Command::new("id").arg("-un").output()?.stdout)?;
        let (user, place) = (user.trim(), folder.display());
        let text = format!(
            "ClusterName=loopback\nSlurmctldHost=localhost(127.0.0.1)\nSlurmUser={user}\nSlurmdUser={user}\n\
             AuthType=auth/none\nCredType=cred/none\nAuthInfo=cred_expire=5\nSlurmctldPort={}\n\
             SlurmctldPidFile={place}/control.pid\nSlurmdPidFile={place}/%n.pid\nSlurmdSpoolDir={place}/spool-%n\n\
             StateSaveLocation={place}/state\nSlurmctldLogFile={place}/control.log\nSlurmdLogFile={place}/%n.log\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSwitchType=switch/none\nMpiDefault=none\n\
             SlurmdParameters=config_overrides\nSelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\n\
             JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/none\n\
             SchedulerType=sched/builtin\nReturnToService=0\nKillWait=2\nMailProg=/bin/true\n\
             NodeName=n1 NodeHostname=localhost NodeAddr=127.0.0.1 Port={} CPUs=2\n\
             NodeName=n2 NodeHostname=localhost NodeAddr=127.0.0.1 Port={} CPUs=2\n\
             PartitionName=all Nodes=n1,n2 Default=YES State=UP MaxTime=INFINITE\n",
            ports[0], ports[1], ports[2]
        );
        std::fs::write(folder.join("slurm.conf"), text)?;
        std::fs::write(folder.join("cgroup.conf"), "CgroupAutomount=no\n")?;
        let daemon = |program: &str, arguments: &[&str]| -> Result<Child, Failed> {
            let program = found(program).ok_or("is gone")?;
            let mut command = Command::new(program);
            command.env("SLURM_CONF", folder.join("slurm.conf")).arg("-D").args(arguments);
            Ok(command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?)
        };
        let control = daemon("slurmctld", &[])?;
        let nodes = vec![daemon("slurmd", &["-N", "n1"])?, daemon("slurmd", &["-N", "n2"])?];
        let cluster = Self { folder: folder.to_owned(), control, nodes };
        cluster.until("two idle nodes", || {
            let text = cluster.says("sinfo", &["--noheader", "--Node", "--format=%t"])?;
            Ok(text.lines().filter(|state| *state == "idle").count() == 2)
        })?;
        Ok(cluster)
    }

    /// A command of this Slurm.
    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    fn says(&self, program: &str, arguments: &[&str]) -> Result<String, Failed> {
        Ok(String::from_utf8(self.command(program).args(arguments).output()?.stdout)?)
    }

    fn until(&self, what: &str, holds: impl Fn() -> Result<bool, Failed>) -> Result<(), Failed> {
        let clock = Instant::now();
        while !holds()? {
            if clock.elapsed() > PATIENCE {
                let queue = self.says("squeue", &["--array"]).unwrap_or_default();
                let log = std::fs::read_to_string(self.folder.join("control.log")).unwrap_or_default();
                let last: Vec<&str> = log.lines().rev().take(20).collect();
                return Err(format!("no {what} after {PATIENCE:?}:\n{queue}\n{}", last.join("\n")).into());
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        Ok(())
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        // Whatever is left of jobs goes first: their steps outlive the daemons.
        let user = String::from_utf8(Command::new("id").arg("-un").output().unwrap().stdout).unwrap();
        let _ = self.command("scancel").args(["--user", user.trim()]).output();
        std::thread::sleep(Duration::from_millis(300));
        for child in self.nodes.iter_mut().chain([&mut self.control]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn done(told: &Value, round: usize) -> u64 {
    told["rounds"][round]["done"].as_u64().unwrap_or(0)
}

pub fn a_node_dies() -> Result<(), Failed> {
    let out = folder("slurm");
    let whole = whole(&out.join("one"))?;
    let mut cluster = Cluster::start(&out.join("daemons"))?;
    let setup = out.join("setup.sh");
    std::fs::write(&setup, SLEEP)?;
    let many = out.join("many");
    let search = experiment("candidate-search");
    let mut submit = msm(&["cluster", search.to_str().unwrap(), "--scale", "smoke", "--shards", "20"]);
    submit.env("SLURM_CONF", out.join("daemons/slurm.conf"));
    submit.arg("--setup").arg(&setup).arg("--out").arg(&many).args(["--engine", "slurm", "--submit"]);
    succeeded(&submit.output()?)?;
    // In the middle of the first round, while the second node has something to do.
    cluster.until("first shards", || {
        let told = status(&many)?;
        let busy = cluster.says("squeue", &["--noheader", "--nodelist=n2", "--states=RUNNING"])?;
        Ok(done(&told, 0) >= 4 && !busy.trim().is_empty())
    })?;
    let mut node = cluster.nodes.pop().ok_or("there is no second node")?;
    let in_flight =
        cluster.says("squeue", &["--noheader", "--nodelist=n2", "--states=RUNNING", "--format=%i"])?;
    // SIGKILL.
    node.kill()?;
    node.wait()?;
    cluster.says("scontrol", &["update", "NodeName=n2", "State=DOWN", "Reason=killed"])?;
    let told = status(&many)?;
    assert!(done(&told, 0) < 20, "the node died too late: {told}");
    cluster.until("recorded run", || Ok(!status(&many)?["run"].is_null()))?;
    let told = status(&many)?;
    assert!((0..3).all(|round| done(&told, round) == 20), "{told}");
    assert!(told["rounds"].as_array().unwrap().iter().all(|round| round["faults"] == serde_json::json!([])));
    assert!(records(Path::new(told["run"].as_str().unwrap())) == whole, "other bytes: {told}");
    println!("killed with {} tasks on the node", in_flight.lines().count());
    // A part is truncated and another one lost; what comes after cannot begin, and the line that is told repairs all.
    let round = many.join("parts/round-2");
    let cut = round.join("shard-0002-of-0020.part");
    let bytes = std::fs::read(&cut)?;
    std::fs::write(&cut, &bytes[..bytes.len() / 2])?;
    std::fs::remove_file(round.join("shard-0007-of-0020.part"))?;
    std::fs::remove_dir_all(many.join("results"))?;
    let told = status(&many)?;
    assert_eq!(told["rounds"][2]["missing"], serde_json::json!([2, 7]));
    assert!(told["rounds"][2]["faults"].to_string().contains("truncated"), "{told}");
    let line = told["resubmit"].as_str().unwrap();
    assert!(line.ends_with("submit.sh' 2 2,7"), "{line}");
    succeeded(&cluster.command("sh").args(["-c", line]).output()?)?;
    cluster.until("run that was completed again", || Ok(!status(&many)?["run"].is_null()))?;
    assert!(records(Path::new(status(&many)?["run"].as_str().unwrap())) == whole);
    Ok(())
}
