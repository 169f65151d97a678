//! The pages for people say what is there: links lead somewhere, files and passes that are named exist, and each
//! equation's row leads to its pass, reference function and test.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// Folders of the repository that a page may name a file of.
const FOLDERS: [&str; 8] = ["crates/", "shaders/", "tests/", "examples/", "benches/", "python/", "docs/", ".github/"];
/// Laboratory books: in the words and file names of their dates.
const LAB: &str = "docs/lab";
/// Folders of `shaders/` whose files are passes.
const PASSES: [&str; 10] = [
    "forcing/",
    "neighbours/",
    "fluid/",
    "rods/",
    "contact/",
    "turbulence/",
    "viscosity/",
    "commit/",
    "sort/",
    "reduce/",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Names of the files of a folder with this extension.
fn files(folder: &str, extension: &str) -> Vec<String> {
    let entries = fs::read_dir(root().join(folder)).unwrap_or_else(|error| panic!("{folder}: {error}"));
    let paths = entries.map(|entry| entry.unwrap().path());
    let named = paths.filter(|path| path.extension().is_some_and(|found| found == extension));
    named.map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect()
}

fn pages() -> Vec<String> {
    let mut pages = [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
        "benches/README.md",
        "crates/README.md",
        "fuzz/README.md",
        "python/README.md",
    ]
    .map(str::to_owned)
    .to_vec();
    for folder in ["docs", "docs/decisions", LAB] {
        pages.extend(files(folder, "md").iter().map(|name| format!("{folder}/{name}")));
    }
    pages
}

/// The text outside blocks of code.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// Texts between backticks.
fn spans(text: &str) -> Vec<String> {
    prose(text).split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Anchors of a page's headings, as GitHub makes them.
fn anchors(text: &str) -> BTreeSet<String> {
    let slug = |heading: &str| -> String {
        let kept =
            heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>();
        kept.trim().replace(' ', "-")
    };
    prose(text).lines().filter(|line| line.starts_with('#')).map(|line| slug(line.trim_start_matches('#'))).collect()
}

#[test]
fn links_lead_somewhere() {
    let mut broken = Vec::new();
    for page in pages() {
        let text = read(&page);
        for link in prose(&text).split("](").skip(1).map(|rest| rest.split(')').next().unwrap().to_owned()) {
            if link.contains("://") {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let folder = Path::new(&page).parent().unwrap();
            let target = if file.is_empty() { PathBuf::from(&page) } else { folder.join(file) };
            let there = root().join(&target);
            let found =
                there.exists() && (anchor.is_empty() || anchors(&fs::read_to_string(&there).unwrap()).contains(anchor));
            if !found {
                broken.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn files_and_passes_that_pages_name_exist() {
    let mut missing = Vec::new();
    for page in pages().into_iter().filter(|page| !page.starts_with(LAB)) {
        for span in spans(&read(&page)) {
            let path = span.split([' ', ',', ':']).next().unwrap();
            let example = path.contains(['…', '*']) || path.chars().any(|c| c.is_ascii_uppercase());
            let pass = PASSES.iter().any(|folder| path.starts_with(folder) && path.len() > folder.len());
            let exists = if pass {
                root().join(format!("shaders/{path}.wgsl")).exists()
            } else if FOLDERS.iter().any(|folder| path.starts_with(folder)) {
                root().join(path).exists()
            } else {
                true
            };
            if !example && !exists {
                missing.push(format!("{page}: {span}"));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

/// Source text of a module of the reference, with the files inside it.
fn reference_of(module: &str) -> String {
    let source = "crates/windswept-reference/src";
    let inner = format!("{source}/{module}");
    let inside = if root().join(&inner).exists() { files(&inner, "rs") } else { Vec::new() };
    let texts = inside.iter().map(|name| read(&format!("{inner}/{name}")));
    std::iter::once(read(&format!("{source}/{module}.rs"))).chain(texts).collect()
}

/// Stages of the step: the files that record passes.
fn stages() -> Vec<String> {
    let folder = "crates/windswept-engine/src/step";
    let mut names = files(folder, "rs");
    names.retain(|name| read(&format!("{folder}/{name}")).contains("pub fn record("));
    names.iter().map(|name| name.trim_end_matches(".rs").to_owned()).collect()
}

#[test]
fn a_stage_has_one_file_in_each_of_three_places() {
    let mut missing = Vec::new();
    for stage in stages() {
        let test = read(&format!("tests/passes/{stage}.rs"));
        for (place, text, wanted) in [
            ("step", read("crates/windswept-engine/src/step.rs"), format!("{stage}::record(")),
            ("reference's step", reference_of("step"), format!("{stage}::run(")),
            ("reference", reference_of(&stage), "\npub fn run(".to_owned()),
            ("comparisons", test.clone(), "\npub const ROWS: &[Row]".to_owned()),
            ("walk", read("tests/passes/walk.rs"), format!("{stage}::ROWS")),
            ("faults", test, "\npub const FAULTS: &[Fault]".to_owned()),
            ("planted faults", read("tests/passes/steps.rs"), format!("{stage}::FAULTS")),
        ] {
            if !text.contains(&wanted) {
                missing.push(format!("{place}: {wanted}"));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn each_equation_leads_to_its_pass_reference_and_test() {
    let page = read("ARCHITECTURE.md");
    let section = page.split("## Where an equation of the paper is").nth(1).unwrap().split("\n## ").next().unwrap();
    let rows: Vec<Vec<&str>> = section
        .lines()
        .filter(|line| line.starts_with("| "))
        .skip(1)
        .map(|line| line.trim_matches('|').split('|').collect())
        .collect();
    let mut wrong = Vec::new();
    for row in &rows {
        let [equation, pass, function, test] = row[..] else { panic!("{row:?}") };
        let passes = spans(pass).into_iter().filter(|name| PASSES.iter().any(|folder| name.starts_with(folder)));
        if passes.count() == 0 && !pass.contains("shaders/") {
            wrong.push(format!("{equation}: no pass"));
        }
        let lost = |name: &str| {
            let (module, function) = name.split_once("::").unwrap();
            !reference_of(&module.to_lowercase()).contains(&format!("pub fn {function}("))
        };
        wrong.extend(spans(function).into_iter().filter(|name| lost(name)).map(|name| format!("{equation}: {name}")));
        let mut file = String::new();
        let mut tests = 0;
        for span in spans(test) {
            if span.contains('/') {
                file = read(&span);
                continue;
            }
            tests += 1;
            if !file.contains(&format!("fn {span}(")) {
                wrong.push(format!("{equation}: {span}"));
            }
        }
        if spans(function).is_empty() || tests == 0 {
            wrong.push(format!("{equation}: no reference function, or no test"));
        }
    }
    assert!(rows.len() >= 8 && wrong.is_empty(), "{} rows, {wrong:#?}", rows.len());
}
