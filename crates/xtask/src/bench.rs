//! `cargo xtask bench`: studies of the laboratory (benches/lab), and how fast windswept is beside an earlier build of
//! itself and beside a peer.
//!
//! The compared programs run by turns, so that other load of the machine falls on both. Spread is the median absolute
//! deviation of the turns' ratios.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::{Result, cargo, line, root, run, say, venv, vulkan};

/// The bench that has the studies.
const LAB: &str = "lab";
/// Turns of a comparison.
const TURNS: u32 = 10;
/// Median absolute deviations by which the median ratio must exceed 1 for a row to be called slower.
const SLOWER: f64 = 3.0;
/// Steps of the peer in a turn: as many as of ours, and enough for a median.
const PEER_STEPS: &str = "5";

/// Scenes whose steps run beside the peer's: as many particles as it has, hair that the mean wind drags, larger eddies.
const PEER_SCENES: [&str; 3] = ["fig2b", "fig2a", "fig3c"];

/// Places of GLVND's dispatcher: Debian's and Ubuntu's, Fedora's and Arch's.
const GLVND: [&str; 3] =
    ["/usr/lib/x86_64-linux-gnu/libGLdispatch.so.0", "/usr/lib64/libGLdispatch.so.0", "/usr/lib/libGLdispatch.so.0"];
/// Ending of a row that is a count and no time.
const PARTICLES: &str = "particles";

/// Times of a turn, or of the others: by row, such as `quick, fluid` \[ms\].
type Times = BTreeMap<String, f64>;

/// `cargo xtask bench --save FILE`: keeps the bench as it is built now, to be compared with a later one.
pub(crate) fn save(file: &str, rest: &[&str]) -> Result {
    let built = build(&options(rest)?)?;
    let times = turn(Command::new(&built).arg("step"))?;
    std::fs::copy(&built, file).map_err(|e| format!("{file} cannot be written: {e}"))?;
    for (row, ms) in times.iter().filter(|(row, _)| !row.ends_with(PARTICLES)) {
        println!("{row:<32} {ms:>10.3} ms");
    }
    println!(
        "\n{file} is the program that took these times. On this machine, after a change: cargo xtask bench --compare {file}"
    );
    Ok(())
}

/// `cargo xtask bench --compare FILE`: the bench as it is built now, by turns with the one that `--save` kept.
pub(crate) fn compare(file: &str, rest: &[&str]) -> Result {
    let options = options(rest)?;
    let old = std::path::absolute(file).ok().filter(|path| path.is_file());
    let old = old.ok_or(format!("{file}: no such file; cargo xtask bench --save {file} makes it"))?;
    let built = build(&options)?;
    let steps = |program: &Path| turn(Command::new(program).arg("step"));
    let mut turns = Vec::new();
    for k in 0..options.turns {
        say(&format!("Turn {} of {}", k + 1, options.turns));
        // The second program finds the machine warmer: they take turns in that too.
        turns.push(if k % 2 == 0 {
            let before = steps(&old)?;
            (before, steps(&built)?)
        } else {
            let now = steps(&built)?;
            (steps(&old)?, now)
        });
    }
    println!("{:<32} {:>12} {:>12} {:>8} {:>8}", "row", "before, ms", "now, ms", "ratio", "spread");
    let mut slower = Vec::new();
    for row in rows(&turns) {
        let of = |times: fn(&(Times, Times)) -> &Times| -> Vec<f64> {
            turns.iter().filter_map(|turn| times(turn).get(&row).copied()).collect()
        };
        let (before, now) = (of(|turn| &turn.0), of(|turn| &turn.1));
        let ratios = Ratios::new(&before, &now);
        println!(
            "{row:<32} {:>12.3} {:>12.3} {:>8.3} {:>8.3}",
            median(&before),
            median(&now),
            ratios.median,
            ratios.deviation
        );
        if ratios.is_slower() {
            slower.push(row);
        }
    }
    for (row, which) in lone_rows(&turns) {
        println!("{row:<32} not compared: only the {which} program prints it in every turn");
    }
    if options.turns < TURNS {
        println!("\nFewer than {TURNS} turns: too few to call anything slower.");
    } else if slower.is_empty() {
        println!("\nNothing became slower by more than {SLOWER} median absolute deviations.");
    } else {
        println!("\nSlower by more than {SLOWER} median absolute deviations: {}", slower.join("; "));
    }
    Ok(())
}

/// `cargo xtask bench --peer`: whole steps of the paper's scenes at one substep, by turns with SPlisHSPlasH on as many
/// particles as fig2b has.
pub(crate) fn peer(rest: &[&str]) -> Result {
    let options = options(rest)?;
    let python = venv::provide(&["pysplishsplash"])?;
    let built = build(&options)?;
    let own = || turn(Command::new(&built).arg("step").args(PEER_SCENES));
    let peer = |particles: f64| {
        let mut command = Command::new(&python);
        command.arg(root().join("benches/peer/splishsplash.py")).arg(particles.to_string()).arg(PEER_STEPS);
        // The native module of pysplishsplash needs GLVND and is not linked to it.
        if let Some(library) = GLVND.iter().find(|path| Path::new(path).is_file()) {
            command.env("LD_PRELOAD", library);
        }
        turn(&mut command).map_err(|e| format!("{e}; benches/peer/splishsplash.py says what it needs"))
    };
    // The scene's own size, before anything counts.
    let particles = of(&own()?, "fig2b, particles")?;
    let (mut ours, mut theirs) = (PEER_SCENES.map(|_| Vec::new()), Vec::new());
    let mut of_peer = particles;
    for k in 0..options.turns {
        say(&format!("Turn {} of {}", k + 1, options.turns));
        // The second program finds the machine warmer: they take turns in that too.
        let (own, other) = if k % 2 == 0 {
            let own = own()?;
            (own, peer(particles)?)
        } else {
            let other = peer(particles)?;
            (own()?, other)
        };
        for (scene, times) in PEER_SCENES.iter().zip(&mut ours) {
            times.push(of(&own, &format!("{scene}, wall"))?);
        }
        theirs.push(of(&other, "wall")?);
        of_peer = of(&other, "particles")?;
    }
    println!("\n{:<14} {:>12} {:>12} {:>30}", "a step", "least, ms", "median, ms", "over SPlisHSPlasH, by turns");
    println!("{:<14} {:>12.1} {:>12.1}", "SPlisHSPlasH", least(&theirs), median(&theirs));
    for (scene, times) in PEER_SCENES.iter().zip(&ours) {
        let ratios = Ratios::new(&theirs, times);
        let by_turns = format!("{:.3} ± {:.3}", ratios.median, ratios.deviation);
        println!("{scene:<14} {:>12.1} {:>12.1} {by_turns:>30}", least(times), median(times));
    }
    let each = Ratios::new(&theirs, &ours[0]).median * of_peer / particles;
    println!("\nfig2b has {particles} particles and SPlisHSPlasH {of_peer}: a particle takes {each:.3} of its time");
    Ok(())
}

/// `cargo xtask bench STUDY`: a study of the laboratory, on the adapter that WGPU_ADAPTER_NAME names or the best one.
pub(crate) fn study(words: &[&str]) -> Result {
    vulkan::any_driver()?;
    let mut command = cargo();
    venv::provide_cmake(&mut command)?;
    vulkan::give_runtime_folder(&mut command);
    if words.first() == Some(&"stress") {
        // Two stresses run side by side, each on one core.
        command.env("LP_NUM_THREADS", "0");
    }
    run(command.args(["bench", "--workspace", "--bench", LAB, "--"]).args(words))
}

/// Options after `--save FILE`, `--compare FILE` or `--peer`.
struct Options {
    turns: u32,
    profile: String,
}

fn options(rest: &[&str]) -> Result<Options> {
    let mut options = Options { turns: TURNS, profile: "bench".to_owned() };
    for pair in rest.chunks(2) {
        match *pair {
            ["--turns", turns] => {
                options.turns =
                    turns.parse().ok().filter(|n| *n > 0).ok_or(format!("--turns {turns}: expected a number"))?;
            }
            ["--profile", profile] => options.profile = profile.to_owned(),
            _ => return Err(format!("{}: expected --turns N or --profile NAME", pair.join(" "))),
        }
    }
    Ok(options)
}

/// Builds the laboratory and returns its program.
fn build(options: &Options) -> Result<PathBuf> {
    vulkan::any_driver()?;
    say("Building the laboratory");
    let mut command = cargo();
    venv::provide_cmake(&mut command)?;
    command.args(["bench", "--workspace", "--no-run", "--bench", LAB, "--message-format", "json"]);
    command.args(["--profile", &options.profile]);
    let output = command.stderr(Stdio::inherit()).output().map_err(|e| format!("{}: {e}", line(&command)))?;
    if !output.status.success() {
        return Err(format!("{} ended with {}", line(&command), output.status));
    }
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let program = text.lines().rev().find_map(executable);
    program.ok_or(format!("{} named no program", line(&command)))
}

/// The program that a message of cargo says was built of the laboratory.
fn executable(message: &str) -> Option<PathBuf> {
    let is_bench = message.contains(r#""kind":["bench"]"#) && message.contains(&format!(r#""name":"{LAB}""#));
    let (_, rest) = message.split_once(r#""executable":""#).filter(|_| is_bench)?;
    let (path, _) = rest.split_once('"')?;
    Some(Path::new(&path.replace(r"\\", r"\")).to_path_buf())
}

/// Runs a program for one turn and reads its lines: words with tabs between, the last of them a number.
fn turn(program: &mut Command) -> Result<Times> {
    program.current_dir(root());
    if !line(program).contains(".py ") {
        program.arg("--bench");
    }
    vulkan::give_runtime_folder(program);
    let output = program.stderr(Stdio::inherit()).output().map_err(|e| format!("{}: {e}", line(program)))?;
    if !output.status.success() {
        return Err(format!("{} ended with {}", line(program), output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).lines().filter_map(read).collect())
}

fn read(text: &str) -> Option<(String, f64)> {
    let (row, number) = text.rsplit_once('\t')?;
    Some((row.replace('\t', ", "), number.trim().parse().ok()?))
}

fn of(times: &Times, row: &str) -> Result<f64> {
    times.get(row).copied().ok_or(format!("the program printed no line {row:?}"))
}

/// Rows that both have in every turn, but for the counts.
fn rows(turns: &[(Times, Times)]) -> Vec<String> {
    let all = turns.first().map(|(before, _)| before.keys().cloned().collect::<Vec<_>>()).unwrap_or_default();
    let in_all = |row: &String| turns.iter().all(|(before, now)| before.contains_key(row) && now.contains_key(row));
    all.into_iter().filter(|row| in_all(row) && !row.ends_with(PARTICLES)).collect()
}

/// Other rows that one of the two has in every turn, and which that is: of a pass or a scene that is new, or gone.
fn lone_rows(turns: &[(Times, Times)]) -> Vec<(String, &'static str)> {
    let common = rows(turns);
    let lone = |times: fn(&(Times, Times)) -> &Times, which| {
        let first = turns.first().map(|turn| times(turn).keys().cloned().collect::<Vec<_>>()).unwrap_or_default();
        let in_all = |row: &String| turns.iter().all(|turn| times(turn).contains_key(row));
        let is_lone = |row: &String| in_all(row) && !common.contains(row) && !row.ends_with(PARTICLES);
        first.into_iter().filter(is_lone).map(|row| (row, which)).collect::<Vec<_>>()
    };
    [lone(|turn| &turn.0, "old"), lone(|turn| &turn.1, "new")].concat()
}

/// Ratios of two programs' times, turn by turn.
struct Ratios {
    median: f64,
    /// The median absolute deviation.
    deviation: f64,
}

impl Ratios {
    fn new(before: &[f64], now: &[f64]) -> Self {
        let ratios: Vec<f64> = before.iter().zip(now).map(|(before, now)| now / before).collect();
        let middle = median(&ratios);
        let deviations: Vec<f64> = ratios.iter().map(|ratio| (ratio - middle).abs()).collect();
        Self { median: middle, deviation: median(&deviations) }
    }

    fn is_slower(&self) -> bool {
        self.median > 1.0 + SLOWER * self.deviation
    }
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The middle one, or the mean of the middle two.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    if n == 0 { f64::NAN } else { 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]) }
}

#[cfg(test)]
mod check {
    use std::path::PathBuf;

    use super::{Ratios, executable, lone_rows, median, read, rows};

    /// A row that only one of the programs prints is named, with which it is.
    #[test]
    fn rows_of_one_program_are_named() {
        let times = |rows: &[&str]| rows.iter().map(|row| ((*row).to_owned(), 1.0)).collect();
        let turns = [
            (times(&["wall", "old pass", "quick, particles"]), times(&["wall", "new pass"])),
            (times(&["wall", "old pass"]), times(&["wall", "new pass", "once"])),
        ];
        assert_eq!(rows(&turns), ["wall"]);
        assert_eq!(lone_rows(&turns), [("old pass".to_owned(), "old"), ("new pass".to_owned(), "new")]);
    }

    /// A row that takes 5 % longer in every turn is slower, whatever the machine does to both; one that is now faster,
    /// now slower is not.
    #[test]
    fn what_became_slower_is_found() {
        let before = [10.0, 20.0, 11.0, 35.0, 10.5];
        let slower: Vec<f64> = before.iter().zip([1.05, 1.06, 1.05, 1.04, 1.05]).map(|(ms, by)| ms * by).collect();
        let noisy: Vec<f64> = before.iter().zip([1.2, 0.9, 1.05, 0.85, 1.1]).map(|(ms, by)| ms * by).collect();
        assert!(Ratios::new(&before, &slower).is_slower());
        assert!(!Ratios::new(&before, &noisy).is_slower());
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0])), (2.0, 2.5));
    }

    #[test]
    fn lines_are_read() {
        assert_eq!(read("quick\tfluid\t12.5"), Some(("quick, fluid".to_owned(), 12.5)));
        assert_eq!(read("adapter: none"), None);
        let message = r#"{"target":{"kind":["bench"],"name":"lab"},"executable":"/target/lab-1"}"#;
        assert_eq!(executable(message), Some(PathBuf::from("/target/lab-1")));
        assert_eq!(executable(&message.replace("bench", "test")), None);
    }
}
