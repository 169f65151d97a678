//! The pages for people say what is there: links lead somewhere, the book has every page, files and passes that are
//! named exist, and each equation's row leads to its pass, reference function and test.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{collections::BTreeSet, fs, path::Path};

#[path = "../crates/xtask/src/links.rs"]
#[allow(dead_code)] // `cargo xtask docs` uses the rest.
mod links;

use links::{Pages, broken, prose, replaced, target};

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

/// The Markdown pages of the repository.
fn pages() -> Pages {
    let mut pages = Pages::new();
    for folder in ["", "docs", "benches", "crates", "fuzz", "python"] {
        add_pages(Path::new(folder), folder == "docs", &mut pages);
    }
    pages
}

/// Adds the pages in a folder, and with `deep` those in its folders.
fn add_pages(folder: &Path, deep: bool, pages: &mut Pages) {
    for entry in fs::read_dir(root().join(folder)).unwrap() {
        let path = folder.join(entry.unwrap().file_name());
        if deep && root().join(&path).is_dir() {
            add_pages(&path, deep, pages);
        } else if path.extension().is_some_and(|ending| ending == "md") {
            pages.insert(path.clone(), read(path.to_str().unwrap()));
        }
    }
}

/// Texts between backticks.
fn spans(text: &str) -> Vec<String> {
    prose(text).split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// `cargo xtask docs` looks at the anchors of generated parts, and at the APIs, too.
#[test]
fn links_lead_somewhere() {
    let is_api = |path: &Path| ["docs/rust", "docs/python"].iter().any(|folder| path.starts_with(folder));
    let broken = broken(&pages(), |path| is_api(path) || root().join(path).exists());
    assert!(broken.is_empty(), "{broken:#?}");
}

/// What is in `docs`, apart from the laboratory books, is in the book's table of contents, once.
#[test]
fn the_book_has_every_page_once() {
    let pages = pages();
    let summary = Path::new("docs/SUMMARY.md");
    let mut listed = Vec::new();
    replaced(&pages[summary], |link| {
        listed.extend((!link.is_empty()).then(|| target(summary, link).0));
        link.to_owned()
    });
    let unique: BTreeSet<_> = listed.iter().cloned().collect();
    assert_eq!(unique.len(), listed.len(), "{listed:#?}");
    let of_book = |path: &&std::path::PathBuf| path.starts_with("docs") && !path.starts_with(LAB) && *path != summary;
    let missing: Vec<_> = pages.keys().filter(of_book).filter(|path| !unique.contains(*path)).collect();
    assert!(missing.is_empty(), "{missing:#?}");
}

/// A part that a page wants is one that `docs/generate.py` writes, and each of those stands on one page.
#[test]
fn generated_parts_stand_on_a_page() {
    let program = read("docs/generate.py");
    let parts = program.split("PARTS: ").nth(1).unwrap().split("\n}").next().unwrap();
    let written: Vec<_> = parts.lines().filter_map(|line| line.trim().strip_prefix('"')?.split_once('"')).collect();
    let mut written: Vec<_> = written.into_iter().map(|(name, _)| name.to_owned()).collect();
    let pages = pages();
    let marks = pages.iter().filter(|(path, _)| path.starts_with("docs") && !path.starts_with(LAB));
    let mut wanted: Vec<_> = marks
        .flat_map(|(_, text)| text.split(links::MARK).skip(1).map(|rest| rest.split(" -->").next().unwrap().to_owned()))
        .collect();
    written.sort();
    wanted.sort();
    assert!(!wanted.is_empty() && wanted == written, "{wanted:?} {written:?}");
}

#[test]
fn files_and_passes_that_pages_name_exist() {
    let mut missing = Vec::new();
    for (page, text) in pages().into_iter().filter(|(page, _)| !page.starts_with(LAB)) {
        for span in spans(&text) {
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
                missing.push(format!("{}: {span}", page.display()));
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
