//! `cargo xtask mutants [PART [SHARD]]`: the code with one small fault at a time, and whether a test notices it.
//!
//! cargo-mutants makes the faults in Rust and runs the tests of the part in a copy of the tree. Those of the shaders
//! are in values that `FAULTS` in tests/passes numbers. The results are written into docs/lab/mutants.md,
//! where other parts and shards stay as they are.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::{Error, Result, cargo, line, python, root, run, say, venv, vulkan};

/// cargo-mutants, as it is installed into target/tools.
const VERSION: &str = "27.1.0";
/// Time after which a mutant counts as noticed: it does not end \[s\].
const LONGEST: &str = "300";
/// The page, and the reasons why survivors are left alone.
const PAGE: &str = "docs/lab/mutants.md";
const REASONS: &str = "benches/mutants.txt";

/// Code that mutants are made of, and what should notice them.
struct Part {
    name: &'static str,
    /// Files of it, as cargo-mutants matches them.
    files: &'static [&'static str],
    /// Package of the code.
    package: &'static str,
    /// Packages of its tests.
    tested: &'static [&'static str],
    /// Arguments of `cargo test` that choose tests.
    tests: &'static [&'static str],
    /// Which of how many mutants are tried unless the command says: all would take a day.
    shard: &'static str,
}

const PARTS: &[Part] = &[
    Part {
        name: "scene",
        files: &["crates/windswept-scene/src/**/*.rs"],
        package: "windswept-scene",
        tested: &["windswept-scene"],
        tests: &[],
        shard: "0/16",
    },
    Part {
        name: "export",
        files: &["crates/windswept-export/src/**/*.rs"],
        package: "windswept-export",
        tested: &["windswept-export", "windswept-cli"],
        tests: &[],
        shard: "0/16",
    },
    Part {
        name: "engine",
        files: &["crates/windswept-engine/src/**/*.rs"],
        package: "windswept-engine",
        tested: &["windswept-engine", "windswept-workspace"],
        tests: &["--lib", "--test=engine", "--test=passes"],
        shard: "0/32",
    },
];
/// The part whose faults are planted by the tests of passes.
const SHADERS: &str = "shaders";

pub(crate) fn test(words: &[&str]) -> Result {
    let driver = vulkan::software_driver()?;
    let python = venv::provide(&python::READERS)?;
    let (asked, shard) = match *words {
        [] => (None, None),
        [part] => (Some(part), None),
        [part, shard] => (Some(part), Some(shard)),
        _ => return Err("mutants: expected a part and a shard, such as `scene 3/16`".to_owned()),
    };
    let names: Vec<&str> = PARTS.iter().map(|part| part.name).chain([SHADERS]).collect();
    if let Some(unknown) = asked.filter(|name| !names.contains(name)) {
        return Err(format!("mutants {unknown}: there are {}", names.join(", ")));
    }
    let on_software = |command: &mut Command| -> Result {
        if let Some(manifest) = &driver {
            command.env("VK_DRIVER_FILES", manifest).env("WGPU_ADAPTER_NAME", "llvmpipe").env("LP_NUM_THREADS", "0");
        }
        command.env("WINDSWEPT_PYTHON", &python);
        vulkan::give_runtime_folder(command);
        venv::provide_cmake(command)
    };
    let mut page = Page::read();
    for part in PARTS.iter().filter(|part| asked.is_none_or(|name| name == part.name)) {
        let shard = shard.unwrap_or(part.shard);
        say(&format!("Mutants of {}, shard {shard}", part.name));
        let (mut tests, mut mutants) = (cargo(), Command::new(tool()?));
        on_software(&mut tests)?;
        on_software(&mut mutants)?;
        page.set(part.name, &format!("shard {shard}"), &part.mutated(tests, mutants, shard)?);
        page.write()?;
    }
    if asked.is_none_or(|name| name == SHADERS) {
        say("Faults planted in the shaders");
        let mut command = cargo();
        on_software(&mut command)?;
        page.set(SHADERS, "all", &planted(command)?);
        page.write()?;
    }
    println!("{PAGE}");
    Ok(())
}

/// The program of cargo-mutants, installed into target/tools where it is not there yet.
fn tool() -> Result<PathBuf> {
    let tools = root().join("target/tools");
    let program = tools.join(if cfg!(windows) { "bin/cargo-mutants.exe" } else { "bin/cargo-mutants" });
    if !program.exists() {
        say(&format!("Installing cargo-mutants {VERSION} into target/tools"));
        let mut install = cargo();
        run(install.args(["install", "cargo-mutants", "--version", VERSION, "--locked", "--root"]).arg(&tools))?;
    }
    Ok(program)
}

/// Mutants that were tried, by what became of them; each as cargo-mutants names it.
#[derive(Debug, Default, PartialEq)]
struct Tried {
    noticed: usize,
    endless: usize,
    /// Faults that do not compile are no mutants.
    not_built: usize,
    survivors: Vec<String>,
    /// How many there were to try in the shard, and how many the part has.
    to_try: usize,
    of_part: usize,
}

impl Part {
    /// Arguments that choose the packages of the tests.
    fn chosen(&self, option: &'static str) -> impl Iterator<Item = &'static str> {
        self.tested.iter().flat_map(move |package| [option, package])
    }

    /// Arguments that choose the code.
    fn mutable(&self) -> impl Iterator<Item = &'static str> {
        ["--package", self.package].into_iter().chain(self.files.iter().flat_map(|file| ["--file", file]))
    }

    /// How many mutants the part has, in all shards.
    fn count(&self) -> Result<usize> {
        let mut list = Command::new(tool()?);
        list.current_dir(root()).args(["mutants", "--list", "--colors", "never"]).args(self.mutable());
        let output =
            list.stderr(Stdio::inherit()).output().map_err(|e| format!("{} did not start: {e}", line(&list)))?;
        if !output.status.success() {
            return Err(format!("{} ended with {}", line(&list), output.status));
        }
        Ok(String::from_utf8_lossy(&output.stdout).lines().count())
    }

    /// Runs the tests of the part, then cargo-mutants on a shard of it; returns the shard's section of the page.
    fn mutated(&self, mut tests: Command, mut command: Command, shard: &str) -> Result<String> {
        // Without a fault the tests pass. cargo-mutants itself would run those of the mutated package only.
        run(tests.arg("test").args(self.chosen("--package")).args(self.tests))?;
        let of_part = self.count()?;
        let all = root().join("target/mutants");
        let out = all.join(self.name);
        std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
        command.current_dir(root()).env("CARGO_TARGET_DIR", all.join("build"));
        // Each mutant links all its test programs anew, and no debugger looks at them.
        command.env("CARGO_PROFILE_DEV_DEBUG", "0");
        command.args(["mutants", "--no-shuffle", "--colors", "never", "--baseline", "skip", "--timeout", LONGEST]);
        // Every file has its part in a shard: by slices a shard would be a file or two.
        command.args(["--sharding", "round-robin", "--shard", shard]).arg("--output").arg(&out);
        command.args(self.mutable()).args(self.chosen("--test-package")).arg("--").args(self.tests);
        let status = command.status().map_err(|e| format!("{} did not start: {e}", line(&command)))?;
        let tried = Tried::read(&out.join("mutants.out"), of_part)?;
        // 2: some survive; 3: some do not end. A run that is stopped ends otherwise, and has tried some.
        if !matches!(status.code(), Some(0 | 2 | 3)) && tried.all() == 0 {
            return Err(format!("{} ended with {status}", line(&command)));
        }
        Ok(section(&tried, &reasons()?))
    }
}

impl Tried {
    /// Reads the results that cargo-mutants left in its folder.
    fn read(folder: &Path, of_part: usize) -> Result<Self> {
        let lines = |name: &str| -> Result<Vec<String>> {
            let path = folder.join(name);
            let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            Ok(text.lines().map(str::to_owned).collect())
        };
        Ok(Self {
            noticed: lines("caught.txt")?.len(),
            endless: lines("timeout.txt")?.len(),
            not_built: lines("unviable.txt")?.len(),
            survivors: lines("missed.txt")?,
            to_try: lines("mutants.json")?.iter().filter(|row| row.trim_start().starts_with("\"genre\":")).count(),
            of_part,
        })
    }

    /// How many were tried.
    fn all(&self) -> usize {
        self.noticed + self.endless + self.not_built + self.survivors.len()
    }
}

/// A mutant's file and fault, without the place in the file, which changes with every edit.
fn name(mutant: &str) -> String {
    let mut parts = mutant.splitn(4, ':');
    match (parts.next(), parts.next(), parts.next(), parts.next()) {
        (Some(file), Some(_), Some(_), Some(fault)) => format!("{file}:{fault}"),
        _ => mutant.to_owned(),
    }
}

/// Why survivors are left alone, by name: a line with the name, and an indented one with the reason.
fn reasons() -> Result<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(root().join(REASONS)).map_err(|e| format!("{REASONS}: {e}"))?;
    reasons_in(&text)
}

fn reasons_in(text: &str) -> Result<BTreeMap<String, String>> {
    let (mut all, mut named): (BTreeMap<String, String>, Option<&str>) = (BTreeMap::new(), None);
    for row in text.lines().filter(|row| !row.trim().is_empty() && !row.starts_with('#')) {
        match (row.strip_prefix("    "), named) {
            (None, _) => named = Some(row),
            (Some(reason), Some(name)) => drop(all.insert(name.to_owned(), reason.trim().to_owned())),
            (Some(_), None) => return Err(format!("{REASONS}: {row:?} is the reason of no mutant")),
        }
    }
    Ok(all)
}

/// The section of a shard: counts, and the survivors with their reasons.
fn section(tried: &Tried, reasons: &BTreeMap<String, String>) -> String {
    let mut text = format!(
        "Commit {}: {} of the part's {} mutants were tried, of {} in this shard. Tests notice {}, {} do not end, {} do not compile and {} survive.\n",
        commit(),
        tried.all(),
        tried.of_part,
        tried.to_try,
        tried.noticed,
        tried.endless,
        tried.not_built,
        tried.survivors.len(),
    );
    if !tried.survivors.is_empty() {
        text += "\n| Survivor | Why it is left alone |\n|---|---|\n";
    }
    for survivor in &tried.survivors {
        let name = name(survivor);
        let reason = reasons.get(&name).map_or("**no reason yet**", String::as_str);
        text += &format!("| `{}` | {reason} |\n", name.replace('|', "\\|"));
    }
    text
}

/// Plants the faults of the shaders; returns their section of the page.
fn planted(mut command: Command) -> Result<String> {
    let words =
        ["test", "--workspace", "--test", "passes", "a_difference_is_named", "--", "--include-ignored", "--nocapture"];
    let output =
        command.args(words).stderr(Stdio::inherit()).output().map_err(|e| format!("{}: {e}", line(&command)))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let named = text.lines().filter(|row| row.contains(" differs by ")).count();
    if !output.status.success() || named == 0 {
        return Err(format!(
            "{} found {named} faults, and ended with {}: a fault is not named",
            line(&command),
            output.status
        ));
    }
    Ok(format!(
        "Commit {}: {named} faults, at least one in every pass; the comparison with the reference names the pass of each.\n",
        commit()
    ))
}

/// The commit, and whether the tree has changes, other than what these commands write.
fn commit() -> String {
    let git = |words: &[&str]| {
        let output =
            Command::new("git").current_dir(root()).args(words).output().ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let changes = ["status", "--porcelain", "--untracked-files=no", "--", ":/", ":!benches/results"];
    match (git(&["rev-parse", "--short", "HEAD"]), git(&changes)) {
        (Some(commit), Some(changes)) if changes.is_empty() => commit,
        (Some(commit), _) => format!("{commit} with changes"),
        (None, _) => "unknown".to_owned(),
    }
}

/// Sections of the page, by part and shard.
struct Page(BTreeMap<String, BTreeMap<String, String>>);

impl Page {
    /// The page as it is; empty where there is none.
    fn read() -> Self {
        Self::of(&std::fs::read_to_string(root().join(PAGE)).unwrap_or_default())
    }

    fn of(text: &str) -> Self {
        let mut page = Self(BTreeMap::new());
        for part in text.split("\n## ").skip(1) {
            let mut shards = part.split("\n### ");
            let name = shards.next().unwrap_or_default().trim();
            for (shard, text) in shards.filter_map(|shard| shard.split_once("\n\n")) {
                page.set(name, shard, &format!("{}\n", text.trim_end()));
            }
        }
        page
    }

    fn set(&mut self, part: &str, shard: &str, text: &str) {
        self.0.entry(part.to_owned()).or_default().insert(shard.to_owned(), text.to_owned());
    }

    fn text(&self) -> String {
        let head = "# Mutants\n\nMade by `cargo xtask mutants`; [README](../../benches/README.md#mutants) says how to read it.\n";
        let part = |name: &str| match self.0.get(name) {
            None => format!("\n## {name}\n\nNot tried yet.\n"),
            Some(shards) => {
                let shards = shards.iter().map(|(shard, text)| format!("\n### {shard}\n\n{text}"));
                std::iter::once(format!("\n## {name}\n")).chain(shards).collect()
            }
        };
        let parts = PARTS.iter().map(|part| part.name).chain([SHADERS]).map(part);
        std::iter::once(head.to_owned()).chain(parts).collect()
    }

    fn write(&self) -> Result {
        std::fs::write(root().join(PAGE), self.text()).map_err(|e| -> Error { format!("{PAGE}: {e}") })
    }
}

#[cfg(test)]
mod check {
    use super::{Page, Tried, name, reasons_in, section};

    /// A survivor goes with its reason wherever in its file it stands by now, and one without is seen.
    #[test]
    fn survivors_have_their_reasons() {
        let mutant = "crates/a/src/b.rs:12:5: replace < with <= in Box::<T>::holds";
        assert_eq!(name(mutant), "crates/a/src/b.rs: replace < with <= in Box::<T>::holds");
        let text = "# why\n\ncrates/a/src/b.rs: replace < with <= in Box::<T>::holds\n    The two are never equal.\n";
        let reasons = reasons_in(text).expect("reasons");
        let survivors = vec![mutant.to_owned(), "crates/a/src/b.rs:9:1: replace c with ()".to_owned()];
        let tried = Tried { noticed: 7, endless: 1, not_built: 2, survivors, to_try: 20, of_part: 39 };
        let text = section(&tried, &reasons);
        assert!(
            text.contains(
                "12 of the part's 39 mutants were tried, of 20 in this shard. Tests notice 7, 1 do not end, 2 do not compile and 2 survive."
            ),
            "{text}"
        );
        assert!(text.contains("in Box::<T>::holds` | The two are never equal. |"), "{text}");
        assert!(text.contains("replace c with ()` | **no reason yet** |"), "{text}");
        assert!(reasons_in("    a reason of nothing").is_err());
    }

    /// A shard that runs alone leaves the others on the page as they are, and so do parts.
    #[test]
    fn others_stay() {
        let mut page = Page::of("");
        page.set("scene", "shard 0/2", "Tried.\n\n| a |\n");
        page.set("scene", "shard 1/2", "Tried first.\n");
        page.set("export", "shard 1/2", "Tried.\n");
        let mut again = Page::of(&page.text());
        assert_eq!(again.text(), page.text());
        again.set("scene", "shard 1/2", "Tried again.\n");
        let text = again.text();
        assert!(
            text.contains("## scene\n\n### shard 0/2\n\nTried.\n\n| a |\n\n### shard 1/2\n\nTried again.\n"),
            "{text}"
        );
        assert!(text.contains("## export\n\n### shard 1/2\n\nTried.\n") && !text.contains("first"), "{text}");
        assert!(text.contains("## engine\n\nNot tried yet.\n"), "{text}");
    }
}
