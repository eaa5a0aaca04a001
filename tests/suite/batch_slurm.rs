//! `ergopath batch --engine slurm` on a real Slurm of two nodes on this machine: whatever happens to nodes, tasks
//! and disk, the joined table is that of one machine.

use crate::common::{assert_refused, cells_done, files, workplace};
use crate::outputs_cli::has;
use crate::skips::skip;
use assert_cmd::Command;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_ergopath");
/// Longer than anything here takes, for machines that do much besides.
const PATIENCE: Duration = Duration::from_mins(2);
const DAEMONS: [&str; 3] = ["munged", "slurmctld", "slurmd"];

/// Six cells that take a moment each: three tasks of two cells with `BUNDLED`.
const CELLS: usize = 6;
const BUNDLED: [&str; 4] = ["--seconds-per-cell", "30", "--minutes-per-job", "1"];

fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(started.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn printed(program: &str, arguments: &[&str]) -> String {
    let output = std::process::Command::new(program).args(arguments).output().unwrap();
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// A program of the system, also where only root looks.
fn daemon(name: &str) -> Option<PathBuf> {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&folders).chain(["/usr/sbin".into(), "/sbin".into()]);
    folders.map(|f| f.join(name)).find(|p| p.is_file())
}

/// munge, a controller and nodes of their own, in a folder of their own; gone with it.
struct Cluster {
    room: TempDir,
    daemons: BTreeMap<String, Child>,
}

impl Cluster {
    /// None where this machine has none to start.
    fn start() -> Option<Self> {
        let missing = DAEMONS.iter().chain(&["sbatch"]).find(|d| daemon(d).is_none());
        if missing.is_some() {
            skip("Slurm (apt-get install slurmctld slurmd slurm-client munge)");
            return None;
        }
        if printed("id", &["-u"]) != "0" {
            skip("root, who may start a Slurm of its own");
            return None;
        }
        let mut cluster = Self { room: tempfile::tempdir().unwrap(), daemons: BTreeMap::new() };
        cluster.configure();
        let place = |name: &str| cluster.place(name).display().to_string();
        let munge = [
            "--foreground".to_owned(),
            "--force".to_owned(),
            format!("--socket={}", place("munge/socket")),
            format!("--key-file={}", place("munge/key")),
            format!("--pid-file={}", place("munge/pid")),
            format!("--log-file={}", place("munge/log")),
            format!("--seed-file={}", place("munge/seed")),
        ];
        let munge: Vec<&str> = munge.iter().map(String::as_str).collect();
        cluster.run("munged", "munged", &munge);
        wait_for("munge", || cluster.place("munge/socket").exists().then_some(()));
        cluster.run("slurmctld", "slurmctld", &["-D"]);
        for node in ["n1", "n2"] {
            cluster.run(node, "slurmd", &["-D", "-N", node]);
        }
        wait_for("both nodes", || {
            (cluster.ask("sinfo", &["-h", "-n", "n1,n2", "-p", "main", "-o", "%D %t"]) == "2 idle")
                .then_some(())
        });
        Some(cluster)
    }

    fn place(&self, name: &str) -> PathBuf {
        self.room.path().join(name)
    }

    fn configure(&self) {
        use std::os::unix::fs::PermissionsExt;
        for folder in ["state", "spool.n1", "spool.n2", "spool.blind", "munge"] {
            std::fs::create_dir(self.place(folder)).unwrap();
        }
        // All four are held at a time, so that they differ.
        let ports: Vec<TcpListener> =
            (0..4).map(|_| TcpListener::bind("127.0.0.1:0").unwrap()).collect();
        let ports: Vec<u16> = ports.iter().map(|l| l.local_addr().unwrap().port()).collect();
        let key: Vec<u8> =
            (0..128u32).map(|k| (k.wrapping_mul(ports[0].into()) >> 3) as u8).collect();
        std::fs::write(self.place("munge/key"), key).unwrap();
        for (name, mode) in [("", 0o755), ("munge", 0o711), ("munge/key", 0o600)] {
            let mode = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(self.place(name), mode).unwrap();
        }
        let (host, user) = (printed("hostname", &["-s"]), printed("id", &["-un"]));
        let room = self.room.path().display();
        let mut text = String::new();
        for line in [
            "ClusterName=test".to_owned(),
            format!("SlurmctldHost={host}(127.0.0.1)"),
            format!("SlurmctldPort={}", ports[0]),
            format!("SlurmUser={user}"),
            format!("SlurmdUser={user}"),
            "AuthType=auth/munge".to_owned(),
            // A task whose node died may start again after that many seconds.
            format!("AuthInfo=socket={room}/munge/socket,cred_expire=6"),
            "CredType=cred/munge".to_owned(),
            format!("StateSaveLocation={room}/state"),
            format!("SlurmdSpoolDir={room}/spool.%n"),
            format!("SlurmctldPidFile={room}/slurmctld.pid"),
            format!("SlurmdPidFile={room}/%n.pid"),
            format!("SlurmctldLogFile={room}/slurmctld.log"),
            format!("SlurmdLogFile={room}/%n.log"),
            "MailProg=/bin/true".to_owned(),
            "ProctrackType=proctrack/linuxproc".to_owned(),
            "TaskPlugin=task/none".to_owned(),
            "JobAcctGatherType=jobacct_gather/none".to_owned(),
            "AccountingStorageType=accounting_storage/none".to_owned(),
            "SelectType=select/cons_tres".to_owned(),
            "SelectTypeParameters=CR_Core".to_owned(),
            "SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000".to_owned(),
            "ReturnToService=2".to_owned(),
            "SlurmdTimeout=2".to_owned(),
            "MessageTimeout=2".to_owned(),
            "TCPTimeout=1".to_owned(),
            "KillWait=1".to_owned(),
            "MpiDefault=none".to_owned(),
            "SwitchType=switch/none".to_owned(),
            format!(
                "NodeName=n1,n2,blind NodeHostname={host} NodeAddr=127.0.0.1 Port={},{},{} CPUs=1",
                ports[1], ports[2], ports[3]
            ),
            "PartitionName=main Nodes=n1,n2 Default=YES State=UP".to_owned(),
            "PartitionName=blind Nodes=blind State=UP".to_owned(),
        ] {
            writeln!(text, "{line}").unwrap();
        }
        std::fs::write(self.place("slurm.conf"), text).unwrap();
    }

    fn run(&mut self, name: &str, program: &str, arguments: &[&str]) {
        let mut command = std::process::Command::new(daemon(program).unwrap());
        let log = std::fs::File::create(self.place(&format!("{name}.out"))).unwrap();
        command.args(arguments).env("SLURM_CONF", self.place("slurm.conf"));
        command.stdin(Stdio::null()).stdout(log.try_clone().unwrap()).stderr(log);
        self.daemons.insert(name.to_owned(), command.spawn().unwrap());
    }

    fn ask(&self, program: &str, arguments: &[&str]) -> String {
        let mut command = std::process::Command::new(daemon(program).unwrap());
        command.args(arguments).env("SLURM_CONF", self.place("slurm.conf"));
        String::from_utf8_lossy(&command.output().unwrap().stdout).trim().to_owned()
    }

    /// Shards whose tasks are at work. One that has written its cells may still be among them.
    fn running(&self) -> BTreeSet<usize> {
        let shards = self.ask("squeue", &["-h", "--array", "--states=RUNNING", "--format=%K"]);
        shards.lines().filter_map(|l| l.trim().parse().ok()).collect()
    }

    /// Processes of jobs on a node: the scripts, what watches over them, and what they have started.
    fn on_node(&self, node: &str) -> Vec<u32> {
        let spool = self.place(&format!("spool.{node}/job")).display().to_string();
        let table = printed("ps", &["-eo", "pid=,ppid=,args="]);
        let table: Vec<(u32, u32, &str)> = table
            .lines()
            .filter_map(|l| {
                let (pid, rest) = l.trim().split_once(char::is_whitespace)?;
                let (parent, words) = rest.trim().split_once(char::is_whitespace)?;
                Some((pid.parse().ok()?, parent.parse().ok()?, words))
            })
            .collect();
        let mut found: Vec<u32> = Vec::new();
        for (pid, parent, words) in &table {
            if words.contains(&spool) {
                found.extend([*parent, *pid]);
            }
        }
        let mut k = 0;
        while k < found.len() {
            let children =
                table.iter().filter(|(pid, parent, _)| *parent == found[k] && !found.contains(pid));
            let children: Vec<u32> = children.map(|(pid, ..)| *pid).collect();
            found.extend(children);
            k += 1;
        }
        found.retain(|pid| *pid > 1 && *pid != std::process::id());
        found
    }

    /// A node loses its power.
    fn kill_node(&mut self, node: &str) {
        let mut daemon = self.daemons.remove(node).unwrap();
        daemon.kill().unwrap();
        daemon.wait().unwrap();
        kill(&self.on_node(node));
    }
}

fn kill(processes: &[u32]) {
    for pid in processes {
        let _ = std::process::Command::new("kill")
            .args(["-9", &pid.to_string()])
            .stderr(Stdio::null())
            .status();
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for node in ["n1", "n2", "blind"] {
            if let Some(mut daemon) = self.daemons.remove(node) {
                let _ = daemon.kill();
                let _ = daemon.wait();
            }
            kill(&self.on_node(node));
        }
        for daemon in self.daemons.values_mut() {
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

/// A batch, the cluster, and a program for the nodes that waits as long as it is told to.
struct Place<'a> {
    cluster: &'a Cluster,
    folder: &'a Path,
    output: PathBuf,
}

impl Place<'_> {
    fn new<'a>(cluster: &'a Cluster, folder: &'a Path, output: &str) -> Place<'a> {
        Place { cluster, folder, output: folder.join(output) }
    }

    fn arguments(&self) -> Vec<String> {
        let path = |p: &Path| p.display().to_string();
        let mut all =
            vec!["batch".to_owned(), path(&self.folder.join("batch.toml")), "-o".to_owned()];
        all.push(path(&self.output));
        all.extend(
            ["--engine", "slurm", "--pages", "none"]
                .iter()
                .chain(&BUNDLED)
                .map(|s| (*s).to_owned()),
        );
        all
    }

    fn command(&self) -> Command {
        let mut command = Command::new(PROGRAM);
        command.args(self.arguments()).env("SLURM_CONF", self.cluster.place("slurm.conf"));
        command.env("ERGOPATH", self.folder.join("waits"));
        command
    }

    /// The command, running.
    fn started(&self) -> Run {
        let log = self.folder.join("said.txt");
        let file = std::fs::File::create(&log).unwrap();
        let mut command = std::process::Command::new(PROGRAM);
        command.args(self.arguments()).env("SLURM_CONF", self.cluster.place("slurm.conf"));
        command.env("ERGOPATH", self.folder.join("waits"));
        command.stdin(Stdio::null()).stdout(file.try_clone().unwrap()).stderr(file);
        Run { child: command.spawn().unwrap(), log }
    }

    /// From now on these shards wait before they begin.
    fn hold(&self, shards: &str) {
        std::fs::write(self.folder.join("hold"), shards).unwrap();
    }

    fn release(&self) {
        std::fs::remove_file(self.folder.join("hold")).unwrap();
    }

    fn cells(&self) -> usize {
        cells_done(&self.output)
    }

    /// The tables are those of one machine, byte for byte.
    fn assert_whole(&self, plain: &BTreeMap<String, Vec<u8>>) {
        let own = tables(&self.output);
        assert!(own == *plain, "{}", self.output.display());
    }
}

/// A command that runs, and the file of all that it says.
struct Run {
    child: Child,
    log: PathBuf,
}

impl Run {
    fn said(&self) -> String {
        let said = std::fs::read(&self.log).unwrap();
        let flat = String::from_utf8_lossy(&said).replace(['\n', '│'], " ");
        flat.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Its end: its code and all that it said.
    fn ended(mut self) -> (Option<i32>, String) {
        let status = self.child.wait().unwrap();
        (status.code(), self.said())
    }
}

fn tables(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = files(folder);
    all.retain(|name, _| {
        ["cells.csv", "cells.parquet", "columns.csv", "batch.json", "batch.html"]
            .contains(&&name[..])
    });
    assert_eq!(all.len(), 5, "{:?}", all.keys());
    all
}

/// A folder with a batch of six cells, and a program that holds shards on demand.
fn batch_room() -> TempDir {
    use std::os::unix::fs::PermissionsExt;
    let (room, _) = workplace();
    let write = |name: &str, text: &str| std::fs::write(room.path().join(name), text).unwrap();
    write(
        "own.csv",
        "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0.42,-0.35,0.95,0,1,0,0\n4,0.45,0.25,1.25,0,1,0,0\n",
    );
    let tiny = std::fs::read_to_string(room.path().join("tiny.toml")).unwrap();
    let tiny = tiny.replace("steps = 30", "steps = 10");
    write("tiny.toml", &tiny.replace("rollouts_final = 6", "rollouts_final = 2"));
    write(
        "batch.toml",
        "schema = \"ergopath/batch/1\"\nname = \"Six cells\"\nmode = \"assess\"\npaths = [\"own.csv\"]\n\
         scenarios = [\"bench.toml\"]\nplanners = [\"tiny.toml\"]\nseeds = [1, 2, 3, 4, 5, 6]\n",
    );
    let waits = format!(
        "#!/bin/bash\n# Waits while its shard is named in `hold`.\nfor word in \"$@\"; do\n  \
         while [ \"${{word#*/3}}\" = '' ] && grep -qs \"$word\" {0}/hold; do sleep 0.05; done\ndone\n\
         exec {PROGRAM} \"$@\"\n",
        room.path().display()
    );
    write("waits", &waits);
    let mode = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(room.path().join("waits"), mode).unwrap();
    room
}

#[test]
fn without_slurm_it_is_said_what_is_missing() {
    let room = batch_room();
    let mut command = Command::new(PROGRAM);
    let output = room.path().join("out");
    command.arg("batch").arg(room.path().join("batch.toml")).arg("-o").arg(&output);
    command.args(["--engine", "slurm"]).env("PATH", room.path());
    assert_refused(&mut command, "squeue: is not on this machine");

    // The scripts can be written anywhere.
    command.args(["--no-submit", "--partition", "day", "--sbatch=--account=lab"]).args(BUNDLED);
    command.args(["--gate", "rula_peak <= 7"]).assert().success();
    let text = |name: &str| std::fs::read_to_string(output.join("slurm").join(name)).unwrap();
    let (cells, merge) = (text("cells.sbatch"), text("merge.sbatch"));
    for line in [
        "#SBATCH --array=1-3",
        "#SBATCH --partition=day",
        "#SBATCH --account=lab",
        "#SBATCH --requeue",
    ] {
        assert!(cells.lines().any(|l| l == line), "{line} in {cells}");
    }
    assert!(merge.contains("--gate 'rula_peak <= 7'") && !merge.contains("--array"), "{merge}");
    for script in ["cells.sbatch", "merge.sbatch"] {
        let is_read = std::process::Command::new("bash")
            .arg("-n")
            .arg(output.join("slurm").join(script))
            .status();
        assert!(is_read.unwrap().success(), "{script}");
    }
    for (option, words) in [
        ("--sbatch=--array=1-2", "`--array` is set by ergopath"),
        ("--sbatch=account", "`account` is no option"),
        ("--minutes-per-job=0", "0 is outside"),
    ] {
        let mut command = Command::new(PROGRAM);
        command.arg("batch").arg(room.path().join("batch.toml")).arg("-o").arg(&output);
        assert_refused(command.args(["--engine", "slurm", option]), words);
    }
}

#[test]
fn a_real_slurm_gives_the_table_of_one_machine() {
    let Some(mut cluster) = Cluster::start() else { return };
    let room = batch_room();
    let plain = {
        let output = room.path().join("plain");
        let mut command = Command::new(PROGRAM);
        command.arg("batch").arg(room.path().join("batch.toml")).arg("-o").arg(&output);
        command.args(["--pages", "none"]).assert().success();
        tables(&output)
    };
    plain_run(&cluster, room.path(), &plain);
    interrupted_and_cancelled(&cluster, room.path(), &plain);
    killed_twice(&cluster, room.path(), &plain);
    full_disk(&cluster, room.path(), &plain);
    unseen_folder(&mut cluster, room.path());
    dead_node(&mut cluster, room.path(), &plain);
}

fn plain_run(cluster: &Cluster, room: &Path, plain: &BTreeMap<String, Vec<u8>>) {
    let place = Place::new(cluster, room, "with spaces 'and' signs");
    let run = place.command().assert().success();
    let said = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    assert!(said.contains("6 cells, 3 tasks of about 1 min each on 1 core"), "{said}");
    assert!(said.contains("6 cells: 6 with a path"), "{said}");
    place.assert_whole(plain);
    // The job that joins has done so as well.
    let logs = files(&place.output.join("slurm"));
    let merged = logs.iter().find(|(name, _)| name.starts_with("merge_")).unwrap().1;
    assert!(String::from_utf8_lossy(merged).contains("6 cells: 6 with a path"), "{logs:?}");
    // Again: nothing is missing, and nothing is submitted.
    let again = place.command().assert().success();
    let said = String::from_utf8(again.get_output().stdout.clone()).unwrap();
    assert!(!said.contains("job array"), "{said}");
    let mut refused = Place::new(cluster, room, "refused").command();
    assert_refused(
        refused.args(["--partition", "nowhere"]),
        "invalid partition specified: nowhere",
    );
}

fn interrupted_and_cancelled(cluster: &Cluster, room: &Path, plain: &BTreeMap<String, Vec<u8>>) {
    let place = Place::new(cluster, room, "left");
    place.hold("2/3 3/3");
    let run = place.started();
    wait_for("the first two cells, and the tasks that are held", || {
        (place.cells() == 2 && cluster.running() == [2, 3].into()).then_some(())
    });
    // Started in the background of a script, a program is told to ignore Ctrl-C.
    let signal = if has("self", "SigIgn:", 2) { "-TERM" } else { "-INT" };
    let interrupt =
        std::process::Command::new("kill").args([signal, &run.child.id().to_string()]).status();
    assert!(interrupt.unwrap().success());
    let (code, said) = run.ended();
    assert!(code == Some(130) && said.contains("the jobs go on"), "{code:?} {said}");
    assert_eq!(cluster.running(), [2, 3].into());

    // The same command follows them and submits nothing; the jobs are cancelled, then it is run once more.
    let run = place.started();
    wait_for("that it follows", || {
        run.said().contains("is queued or running already").then_some(())
    });
    let name = cluster.ask("squeue", &["-h", "--format=%j"]);
    let name = name.lines().next().unwrap();
    cluster.ask("scancel", &[&format!("--name={name}")]);
    let (code, said) = run.ended();
    assert!(said.contains("is queued or running already") && !said.contains("6 cells,"), "{said}");
    assert!(
        code == Some(1) && said.contains("4 cells have no result: 2, 3, 5, 6"),
        "{code:?} {said}"
    );
    assert!(said.contains("CANCELLED"), "{said}");
    place.release();
    let run = place.command().assert().success();
    let said = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    assert!(said.contains(": 4 cells, 2 tasks"), "{said}");
    place.assert_whole(plain);
}

fn killed_twice(cluster: &Cluster, room: &Path, plain: &BTreeMap<String, Vec<u8>>) {
    let place = Place::new(cluster, room, "killed");
    place.hold("2/3");
    let run = place.started();
    let mut killed: Vec<u32> = Vec::new();
    for _ in 0..2 {
        let held = format!("{}/waits batch .*--shard 2/3", room.display());
        let pid = wait_for("the shard that is held", || {
            let found = printed("pgrep", &["-f", &held]);
            found.lines().filter_map(|l| l.parse().ok()).find(|p| !killed.contains(p))
        });
        kill(&[pid]);
        killed.push(pid);
    }
    let (code, said) = run.ended();
    assert!(code == Some(1) && said.contains("2 cells have no result: 2, 5"), "{code:?} {said}");
    assert!(
        said.contains("attempt 2 of shard 2") && said.contains("ended with code 137"),
        "{said}"
    );
    assert_eq!(place.cells(), CELLS - 2);
    place.release();
    place.command().assert().success();
    place.assert_whole(plain);
}

fn full_disk(cluster: &Cluster, room: &Path, plain: &BTreeMap<String, Vec<u8>>) {
    let disk = room.join("disk");
    std::fs::create_dir(&disk).unwrap();
    let mount = std::process::Command::new("mount")
        .args(["-t", "tmpfs", "-o", "size=1m", "tmpfs"])
        .arg(&disk)
        .stderr(Stdio::null())
        .status();
    if !mount.is_ok_and(|s| s.success()) {
        skip("way to mount a small disk");
        return;
    }
    let _disk = Mounted(disk.clone());
    let place = Place::new(cluster, room, "disk/out");
    place.hold("1/3 2/3 3/3");
    let run = place.started();
    wait_for("two tasks", || (cluster.running().len() == 2).then_some(()));
    let ballast = disk.join("ballast");
    let filled = std::fs::write(&ballast, vec![0u8; 4 << 20]);
    assert!(filled.is_err(), "the disk is not full");
    place.release();
    let (code, said) = run.ended();
    assert!(code == Some(1) && said.contains("have no result"), "{code:?} {said}");
    std::fs::remove_file(&ballast).unwrap();
    place.command().assert().success();
    place.assert_whole(plain);
}

/// A disk that goes with the test.
struct Mounted(PathBuf);

impl Drop for Mounted {
    fn drop(&mut self) {
        let _ = std::process::Command::new("umount").arg("-l").arg(&self.0).status();
    }
}

/// A node that has another disk where the folder is.
fn unseen_folder(cluster: &mut Cluster, room: &Path) {
    let folder = room.join("unseen");
    std::fs::create_dir(&folder).unwrap();
    let script = "mount -t tmpfs tmpfs \"$1\" && exec slurmd -D -N blind";
    let own = ["-m", "sh", "-c", script, "sh", folder.to_str().unwrap()];
    cluster.run("blind", "unshare", &own);
    let is_up =
        |c: &Cluster| c.ask("sinfo", &["-h", "-n", "blind", "-p", "blind", "-o", "%t"]) == "idle";
    let started = Instant::now();
    while !is_up(cluster) {
        if started.elapsed() > Duration::from_secs(10) {
            skip("way to start a node that sees other disks");
            return;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let mut command = Place::new(cluster, room, "unseen/out").command();
    let run = command.args(["--partition", "blind"]).assert().code(1);
    let said = String::from_utf8_lossy(&run.get_output().stderr).replace(['\n', '│'], " ");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        said.contains("6 cells have no result") && said.contains("do not see this folder"),
        "{said}"
    );
}

fn dead_node(cluster: &mut Cluster, room: &Path, plain: &BTreeMap<String, Vec<u8>>) {
    let place = Place::new(cluster, room, "dead");
    place.hold("2/3");
    let run = place.started();
    wait_for("four cells, and the last task", || {
        (place.cells() == 4 && cluster.running() == [2].into()).then_some(())
    });
    let output = place.output.clone();
    let node = cluster.ask("squeue", &["-h", "--array", "--states=RUNNING", "--format=%N"]);
    cluster.kill_node(&node);
    let place = Place { cluster, folder: room, output };
    place.release();
    // Slurm sees by itself that the node is gone, and starts the task on the other.
    let (code, said) = run.ended();
    assert!(code == Some(0) && said.contains("6 cells: 6 with a path"), "{code:?} {said}");
    place.assert_whole(plain);
}
