//! A batch as jobs of Slurm: how cells are bundled, the two scripts, and what `squeue` says.
//!
//! Slurm does the distributing: a job array over the shards of the batch, and a job that joins them. Nothing is
//! kept of it but the scripts; what is done stands in the folder of the batch, what is queued Slurm is asked.

use crate::files::sha256_hex;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

/// Digits of the hash of a folder in the names of its jobs.
const NAME_DIGITS: usize = 10;
/// A job may take so many times as long as it should, for nodes and cells that are slower than thought.
const TIME_FACTOR: f64 = 3.0;
/// Shortest limit of time of a job, minutes.
const LEAST_MINUTES: f64 = 15.0;
/// Limit of time of the job that joins, minutes.
const MERGE_MINUTES: usize = 30;
/// Fields of a line of `squeue`: job, place in its array, state, reason, node.
pub const QUEUE_FORMAT: &str = "%F|%K|%T|%r|%N";

/// Which cells a task computes: every N-th from its number on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bundles {
    /// N of the shards I/N.
    pub shards: usize,
    /// Shards with cells that are missing, from 1, each with how many.
    pub missing: BTreeMap<usize, usize>,
}

impl Bundles {
    /// Missing cells (by their places in the plan) in about so many shards, at most `most` of them: as few near
    /// the wanted number as share them evenly.
    pub fn of(missing: &[usize], wanted: usize, most: usize) -> Self {
        let at_most = most.min(missing.len()).max(1);
        let least = wanted.clamp(1, at_most);
        let shared = |shards: usize| {
            let mut each = BTreeMap::new();
            for cell in missing {
                *each.entry(cell % shards + 1).or_insert(0) += 1;
            }
            Self { shards, missing: each }
        };
        let near = (least..=(least + least / 2 + 2).min(most.max(1))).map(shared);
        // What is missing may be every N-th cell, which N shards would put into one.
        let even = missing.len().div_ceil(least);
        let near = near.min_by_key(|b| (b.largest().max(even), b.shards));
        near.unwrap_or_else(|| shared(least))
    }

    /// Cells of the largest share.
    pub fn largest(&self) -> usize {
        self.missing.values().copied().max().unwrap_or(0)
    }

    /// The shards as Slurm writes them: `1-4,7`.
    pub fn indices(&self) -> String {
        let mut parts: Vec<(usize, usize)> = Vec::new();
        for shard in self.missing.keys().copied() {
            match parts.last_mut() {
                Some((_, last)) if *last + 1 == shard => *last = shard,
                _ => parts.push((shard, shard)),
            }
        }
        let each =
            parts.iter().map(|(a, b)| if a == b { a.to_string() } else { format!("{a}-{b}") });
        each.collect::<Vec<_>>().join(",")
    }
}

/// What the scripts say.
#[derive(Debug, Clone, PartialEq)]
pub struct SlurmJobs {
    /// Name of the jobs: that of the folder they work for.
    pub name: String,
    /// The batch's own name, for people.
    pub title: String,
    /// Program, batch file and folder, whole paths.
    pub program: String,
    /// See `program`.
    pub batch: String,
    /// See `program`.
    pub folder: String,
    /// Cells in tasks.
    pub bundles: Bundles,
    /// Cores of a task.
    pub threads: usize,
    /// How long the largest task should take, minutes.
    pub minutes: f64,
    /// Queue of the cluster.
    pub partition: Option<String>,
    /// Further options of `sbatch`, a line each.
    pub options: Vec<String>,
    /// Options of the tasks that compute cells.
    pub of_cells: Vec<String>,
    /// Options of the job that joins.
    pub of_merge: Vec<String>,
    /// The job that joins also makes the pages of the best cells.
    pub has_best_pages: bool,
}

impl SlurmJobs {
    /// Folder of scripts and logs, in that of the batch.
    pub const FOLDER: &'static str = "slurm";
    /// The script of the job array.
    pub const CELLS: &'static str = "slurm/cells.sbatch";
    /// The script of the job that joins.
    pub const MERGE: &'static str = "slurm/merge.sbatch";

    /// Name of all jobs for a folder, by its whole path.
    pub fn name_of(folder: &Path) -> String {
        let hash = sha256_hex(folder.as_os_str().as_encoded_bytes());
        format!("ergopath-{}", &hash[..NAME_DIGITS])
    }

    /// The log of a task, in the folder of the batch.
    pub fn log(job: u64, shard: usize) -> String {
        format!("{}/cells_{job}_{shard}.txt", Self::FOLDER)
    }

    /// Both scripts, as (name, bytes).
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        let file = |name: &str, text: String| (name.to_owned(), text.into_bytes());
        vec![file(Self::CELLS, self.cells()), file(Self::MERGE, self.merge())]
    }

    fn head(&self, about: &str, own: &[String]) -> String {
        // One line, whatever the name holds.
        let title: String = self.title.split_whitespace().collect::<Vec<_>>().join(" ");
        let mut text = format!("#!/bin/bash\n# {about} of the batch \"{title}\".\n");
        let _ = writeln!(
            text,
            "# To submit by hand, in {}:\n#   sbatch {}\n#   sbatch --dependency=afterany:JOB {}",
            self.folder,
            Self::CELLS,
            Self::MERGE
        );
        let partition = self.partition.iter().map(|p| format!("--partition={p}"));
        let all = [format!("--job-name={}", self.name)].into_iter().chain(own.iter().cloned());
        // Slurm goes by the last of two lines that say the same.
        for option in all.chain(partition).chain(self.options.iter().cloned()) {
            let _ = writeln!(text, "#SBATCH {option}");
        }
        let quoted = |path: &str| shell_words::quote(path).into_owned();
        let _ = write!(
            text,
            "\n# Another program for the nodes: export ERGOPATH=...\nergopath=${{ERGOPATH:-{}}}\nbatch={}\n\
             folder={}\n\n\
             if [ ! -f \"$folder/batch.json\" ]; then\n  \
             echo \"$(hostname) does not see $folder: it has to be on a file system that all nodes share\" >&2\n  \
             exit 2\nfi\n\
             if ! command -v \"$ergopath\" >/dev/null; then\n  \
             echo \"$(hostname) does not see the program $ergopath: put it where all nodes see it\" >&2\n  \
             exit 2\nfi\n\n",
            quoted(&self.program),
            quoted(&self.batch),
            quoted(&self.folder)
        );
        text
    }

    fn cells(&self) -> String {
        let minutes = (TIME_FACTOR * self.minutes).max(LEAST_MINUTES).ceil();
        let mut text = self.head(
            "Cells",
            &[
                format!("--array={}", self.bundles.indices()),
                format!("--cpus-per-task={}", self.threads),
                format!("--time={minutes}"),
                format!("--output={}/cells_%A_%a.txt", Self::FOLDER),
                "--open-mode=append".to_owned(),
                // A node that dies takes no cell with it: its task starts again elsewhere.
                "--requeue".to_owned(),
            ],
        );
        let _ = write!(
            text,
            "# Each cell is written whole and never computed twice, so a task may be killed and run again.\n\
             # What ends on its own fault gets one more attempt.\n\
             for attempt in 1 2; do\n  \
             \"$ergopath\" batch \"$batch\" -o \"$folder\" --shard \"$SLURM_ARRAY_TASK_ID/{}\" \\\n    \
             --threads \"${{SLURM_CPUS_PER_TASK:-1}}\"{}\n  \
             code=$?\n  \
             case $code in\n    \
             0 | 4) exit 0 ;;         # 4: some cells failed, and their rows say why\n    \
             2 | 130) exit $code ;;   # 2: the input is wrong, 130: told to end\n  \
             esac\n  \
             echo \"attempt $attempt of shard $SLURM_ARRAY_TASK_ID on $(hostname) ended with code $code\" >&2\n\
             done\nexit $code\n",
            self.bundles.shards,
            joined(&self.of_cells)
        );
        text
    }

    fn merge(&self) -> String {
        let mut text = self.head(
            "Joins the cells",
            &[
                "--cpus-per-task=1".to_owned(),
                format!("--time={MERGE_MINUTES}"),
                format!("--output={}/merge_%j.txt", Self::FOLDER),
                "--requeue".to_owned(),
            ],
        );
        let options = joined(&self.of_merge);
        let _ = write!(text, "\"$ergopath\" batch --merge \"$folder\"{options}\ncode=$?\n");
        if self.has_best_pages {
            let _ = write!(
                text,
                "# All cells are there: now the pages of the best.\ncase $code in\n  0 | 3 | 4 | 5)\n    \
                 \"$ergopath\" batch \"$batch\" -o \"$folder\"{options}\n    code=$?\n    ;;\nesac\n"
            );
        }
        text.push_str("exit $code\n");
        text
    }
}

fn joined(options: &[String]) -> String {
    let each = options.iter().flat_map(|o| [Cow::Borrowed(" "), shell_words::quote(o)]);
    each.collect::<Vec<_>>().concat()
}

/// A task or job that Slurm knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Queued {
    /// Its job, of tasks that of their array.
    pub job: u64,
    /// The shard; none of the job that joins.
    pub shard: Option<usize>,
    /// As Slurm names it.
    pub state: String,
    /// Why it waits or failed, as Slurm names it.
    pub reason: String,
    /// Where it runs or ran.
    pub node: String,
}

impl Queued {
    /// The lines of `squeue` in [`QUEUE_FORMAT`]; what does not look so is left out.
    pub fn parse(lines: &str) -> Vec<Self> {
        let one = |line: &str| {
            let fields: Vec<&str> = line.trim().split('|').collect();
            let [job, shard, state, reason, node] = fields[..] else { return None };
            Some(Self {
                job: job.parse().ok()?,
                shard: shard.parse().ok(),
                state: state.to_owned(),
                reason: reason.to_owned(),
                node: node.to_owned(),
            })
        };
        lines.lines().filter_map(one).collect()
    }

    /// At work.
    pub fn is_running(&self) -> bool {
        ["RUNNING", "COMPLETING", "CONFIGURING", "SUSPENDED", "STAGE_OUT"]
            .contains(&&self.state[..])
    }

    /// Ended well.
    pub fn is_completed(&self) -> bool {
        self.state == "COMPLETED"
    }
}

/// Why tasks wait, as Slurm names it, each once.
pub fn reasons(queued: &[Queued]) -> Vec<String> {
    let waiting = queued.iter().filter(|q| !q.is_running() && q.shard.is_some());
    let all: BTreeSet<&str> = waiting.map(|q| q.reason.as_str()).collect();
    all.into_iter().filter(|r| !["None", ""].contains(r)).map(str::to_owned).collect()
}

/// The longest array that Slurm takes, in the lines of `scontrol show config`: its indices are below that.
pub fn largest_index(config: &str) -> Option<usize> {
    let value = config.lines().find_map(|l| {
        let (key, value) = l.split_once('=')?;
        (key.trim() == "MaxArraySize").then(|| value.trim().parse::<usize>().ok())?
    })?;
    value.checked_sub(1).filter(|n| *n > 0)
}

/// The job in what `sbatch --parsable` prints: `123` or `123;cluster`.
pub fn submitted_job(printed: &str) -> Option<u64> {
    printed.trim().lines().last()?.split(';').next()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_missing_cell_is_in_one_bundle() {
        for (count, step, wanted, most) in [
            (1, 1, 5, 10),
            (100, 1, 7, 1000),
            (100, 12, 5, 1000),
            (5000, 1, 9000, 1000),
            (10, 3, 0, 1),
        ] {
            let missing: Vec<usize> = (0..count).map(|k| k * step).collect();
            let bundles = Bundles::of(&missing, wanted, most);
            assert_eq!(bundles.missing.values().sum::<usize>(), count);
            assert!(
                bundles.shards <= most
                    && (1..=bundles.shards).contains(bundles.missing.keys().max().unwrap())
            );
            for cell in missing {
                assert!(bundles.missing.contains_key(&(cell % bundles.shards + 1)));
            }
        }
        assert_eq!(Bundles::of(&[0, 1, 2, 3, 4, 5], 3, 1000).shards, 3);
        // Every twelfth cell: four shards would put all into one.
        let every_twelfth: Vec<usize> = (0..60).map(|k| k * 12).collect();
        assert!(Bundles::of(&every_twelfth, 4, 1000).largest() <= 15);
    }

    #[test]
    fn shards_are_written_in_ranges() {
        let of = |shards: &[usize]| Bundles {
            shards: 20,
            missing: shards.iter().map(|s| (*s, 1)).collect(),
        };
        assert_eq!(of(&[1, 2, 3, 7, 9, 10]).indices(), "1-3,7,9-10");
        assert_eq!(of(&[4]).indices(), "4");
    }

    #[test]
    fn what_slurm_prints_is_read() {
        let lines =
            "12|3|RUNNING|None|n1\n12|4|PENDING|Resources|\n13|N/A|PENDING|Dependency|\nnonsense\n";
        let all = Queued::parse(lines);
        assert_eq!(all.len(), 3);
        assert_eq!((all[0].job, all[0].shard, all[0].is_running()), (12, Some(3), true));
        assert_eq!((all[2].shard, &all[2].reason[..]), (None, "Dependency"));
        assert_eq!(reasons(&all), ["Resources"]);
        assert_eq!(largest_index("MaxArraySize            = 1001\nMaxJobCount = 5\n"), Some(1000));
        assert_eq!(largest_index("MaxArraySize = 0\n"), None);
        assert_eq!(submitted_job("123;cluster\n"), Some(123));
        assert_eq!(submitted_job("Submitted"), None);
    }

    #[test]
    fn names_with_spaces_and_quotes_stay_whole() {
        let jobs = SlurmJobs {
            name: SlurmJobs::name_of(Path::new("/x")),
            title: "A\nname".to_owned(),
            program: "/opt/my tools/ergopath".to_owned(),
            batch: "/home/o'neil/b.toml".to_owned(),
            folder: "/home/$x".to_owned(),
            bundles: Bundles::of(&[0, 1], 2, 10),
            threads: 1,
            minutes: 10.0,
            partition: Some("day".to_owned()),
            options: vec!["--account=lab".to_owned()],
            of_cells: vec!["--pages".to_owned(), "none".to_owned()],
            of_merge: vec!["--gate".to_owned(), "rula_peak < 6".to_owned()],
            has_best_pages: true,
        };
        let [cells, merge] = [jobs.cells(), jobs.merge()];
        for text in [&cells, &merge] {
            assert!(text.starts_with("#!/bin/bash\n# ") && text.contains("\"A name\"."), "{text}");
            assert!(text.contains("\n#SBATCH --partition=day\n#SBATCH --account=lab\n"), "{text}");
            // As a shell reads them.
            let value = |key: &str| {
                let line = text.lines().find_map(|l| l.strip_prefix(key)).unwrap();
                shell_words::split(line).unwrap().concat()
            };
            assert_eq!(value("batch="), "/home/o'neil/b.toml");
            assert_eq!(value("folder="), "/home/$x");
        }
        assert!(cells.contains("--array=1-2\n") && cells.contains("--time=30\n"), "{cells}");
        assert!(cells.contains("/2\" \\\n") && cells.contains(" --pages none\n"), "{cells}");
        assert!(merge.contains("--gate 'rula_peak < 6'"), "{merge}");
    }
}
