//! `cargo xtask docs`: the book with the APIs of Rust and Python beside it, in `target/docs`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::links::{BOOK, MARK, Pages, broken, is_outside, replaced, target};
use crate::{Result, cargo, python, root, run, say, system, venv};

/// The version that the pages were looked at with.
const MDBOOK: &str = "0.5.4";
/// The Python API is made by it.
const PDOC: &str = "pdoc == 16.0.0";
/// Where links lead whose files the book does not have.
const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");
/// Files that the book shows besides pages.
const PICTURES: [&str; 3] = ["svg", "webp", "png"];

/// Builds all, and fails on a link that leads nowhere.
pub(crate) fn build() -> Result {
    let mdbook = provide_mdbook()?;
    let package = python::install("dev")?;
    let book = root().join("target/book");
    let (source, parts, api) = (book.join("src"), book.join("parts"), book.join("python"));
    for folder in [&source, &parts, &api] {
        let removed = if folder.exists() { fs::remove_dir_all(folder) } else { Ok(()) };
        removed.and_then(|()| fs::create_dir_all(folder)).map_err(|e| format!("{}: {e}", folder.display()))?;
    }

    say("The Python API");
    venv::provide(&[PDOC])?;
    // Isolated: the package is the installed one, not the source beside the program.
    run(Command::new(&package).current_dir(&book).args(["-I", "-m", "pdoc", "windswept", "--output-dir"]).arg(&api))?;

    say("The Rust API");
    let mut rust = cargo();
    venv::provide_cmake(&mut rust)?;
    run(rust.args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "--deny warnings"))?;

    say("The book");
    run(Command::new(&package).current_dir(root()).args(["-I", "docs/generate.py"]).arg(&parts))?;
    let pages = filled(pages_in(&root())?, &parts)?;
    let rust = root().join("target/doc");
    let lost = broken(&pages, |path| {
        let in_api = |name: &str, folder: &Path| path.strip_prefix(format!("{BOOK}/{name}")).map(|x| folder.join(x));
        in_api("rust", &rust).or_else(|_| in_api("python", &api)).unwrap_or_else(|_| root().join(path)).exists()
    });
    if !lost.is_empty() {
        return Err(format!("links that lead nowhere:\n  {}", lost.join("\n  ")));
    }
    let summary = Path::new(BOOK).join("SUMMARY.md");
    let listed = listed(&pages, &summary);
    for path in listed.iter().chain([&summary]) {
        write(&listed, path, &pages[path], &source)?;
    }
    let built = root().join("target/docs");
    copy(&root().join(BOOK).join("book.toml"), &book.join("book.toml"))?;
    run(Command::new(mdbook).arg("build").arg(&book).arg("--dest-dir").arg(&built))?;
    copy(&rust, &built.join("rust"))?;
    copy(&api, &built.join("python"))?;
    println!("\nOpen target/docs/index.html: {} pages; the links of {} lead somewhere", listed.len(), pages.len());
    Ok(())
}

/// mdBook, in `target/tools`.
fn provide_mdbook() -> Result<PathBuf> {
    let tools = root().join("target/tools");
    let mdbook = tools.join("bin").join(format!("mdbook{}", std::env::consts::EXE_SUFFIX));
    if !system::succeeds(&mdbook.to_string_lossy(), &["--version"]) {
        say("Building mdBook into target/tools");
        let mut install = cargo();
        install.args(["install", "mdbook", "--version", MDBOOK, "--locked", "--debug", "--no-default-features"]);
        run(install.args(["--features", "search", "--root"]).arg(&tools))?;
    }
    Ok(mdbook)
}

/// The Markdown pages of the repository.
fn pages_in(root: &Path) -> Result<Pages> {
    let git = Command::new("git").current_dir(root).args(["ls-files", "-z", "*.md"]).output();
    let listed = git.map_err(|e| format!("git ls-files: {e}"))?.stdout;
    let paths = String::from_utf8_lossy(&listed).into_owned();
    let read = |path: &str| match fs::read_to_string(root.join(path)) {
        Ok(text) => Ok((path.into(), text)),
        Err(error) => Err(format!("{path}: {error}")),
    };
    paths.split_terminator('\0').map(read).collect()
}

/// The pages with their generated parts.
fn filled(mut pages: Pages, parts: &Path) -> Result<Pages> {
    for (page, text) in &mut pages {
        while let Some((before, rest)) = text.split_once(MARK) {
            let (name, after) = rest.split_once(" -->").ok_or(format!("{}: an open {MARK}", page.display()))?;
            let part = parts.join(name).with_extension("md");
            let part = fs::read_to_string(part).map_err(|e| format!("{}: {name}: {e}", page.display()))?;
            *text = format!("{before}{}{after}", part.trim());
        }
    }
    Ok(pages)
}

/// The pages that the table of contents names.
fn listed(pages: &Pages, summary: &Path) -> BTreeSet<PathBuf> {
    let mut listed = BTreeSet::new();
    replaced(pages.get(summary).map_or("", String::as_str), |link| {
        listed.extend((!link.is_empty()).then(|| target(summary, link).0));
        link.to_owned()
    });
    listed
}

/// The place in the book of a file of the repository: pages in the folder of the book come without its name.
fn in_book(path: &Path) -> &Path {
    path.strip_prefix(BOOK).unwrap_or(path)
}

/// Writes a page, and the pictures that it shows, with links to what the book does not have leading to the repository.
fn write(listed: &BTreeSet<PathBuf>, page: &Path, text: &str, source: &Path) -> Result {
    let mut failed = None;
    let up = "../".repeat(in_book(page).components().count() - 1);
    let text = replaced(text, |link| {
        let (path, anchor) = target(page, link);
        let anchor = if anchor.is_empty() { String::new() } else { format!("#{anchor}") };
        let picture = path.extension().is_some_and(|ending| PICTURES.iter().any(|known| ending == *known));
        // A page that is not written yet has an empty link in the table of contents.
        if link.is_empty() || is_outside(link) {
            return link.to_owned();
        }
        if picture && let Err(error) = copy(&root().join(&path), &source.join(in_book(&path))) {
            failed = Some(error);
        }
        if picture || listed.contains(&path) || !root().join(&path).exists() {
            format!("{up}{}{anchor}", in_book(&path).display())
        } else {
            let kind = if root().join(&path).is_dir() { "tree" } else { "blob" };
            format!("{REPOSITORY}/{kind}/main/{}{anchor}", path.display())
        }
    });
    let there = source.join(in_book(page));
    let written = fs::create_dir_all(there.parent().unwrap_or(source)).and_then(|()| fs::write(&there, text));
    failed.map_or(Ok(()), Err).and(written.map_err(|e| format!("{}: {e}", there.display())))
}

/// Copies a file, or a folder with all that is in it.
fn copy(from: &Path, to: &Path) -> Result {
    let failed = |e: std::io::Error| format!("{}: {e}", from.display());
    if !from.is_dir() {
        fs::create_dir_all(to.parent().unwrap_or(to)).map_err(failed)?;
        return fs::copy(from, to).map(drop).map_err(failed);
    }
    for entry in fs::read_dir(from).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}

#[cfg(test)]
mod check {
    use std::path::Path;

    use super::{filled, in_book};
    use crate::links::{Pages, anchors, broken, replaced, target};

    /// Links are those outside code, and lead from the folder of their page.
    #[test]
    fn links_are_found_and_followed() {
        let page = "[a](b.md) and `c`\n```sh\n[d](e.md)\n```\n[f](../g.md#h)";
        assert_eq!(
            replaced(page, |link| format!("<{link}>")),
            "[a](<b.md>) and `c`\n```sh\n[d](e.md)\n```\n[f](<../g.md#h>)"
        );
        let of = |link| target(Path::new("docs/how-to/head.md"), link);
        assert_eq!(of("../../ARCHITECTURE.md#flow"), ("ARCHITECTURE.md".into(), "flow"));
        assert_eq!(of("#the-grid"), ("docs/how-to/head.md".into(), "the-grid"));
        assert_eq!(in_book(Path::new("docs/how-to/head.md")), Path::new("how-to/head.md"));
    }

    /// A link that leads nowhere, by its file or its anchor, is named with its page.
    #[test]
    fn broken_links_are_named() {
        let pages: Pages = [
            (
                "a.md".into(),
                "# Head line\n[1](b.md#there) [2](b.md#lost) [3](c.md) [4](d.rs) [5](https://e)".to_owned(),
            ),
            ("b.md".into(), "## There\n[6](a.md#head-line)".to_owned()),
        ]
        .into();
        assert_eq!(broken(&pages, |path| path == Path::new("d.rs")), ["a.md: b.md#lost", "a.md: c.md"]);
        assert!(anchors(&pages[Path::new("b.md")]).contains("there"));
    }

    /// A part that nothing wrote is an error that names page and part.
    #[test]
    fn a_missing_part_is_named() {
        let pages = || Pages::from([("a.md".into(), "<!-- generated: no-such-part -->".to_owned())]);
        let error = filled(pages(), Path::new("/no/folder")).expect_err("no such file");
        assert!(error.starts_with("a.md: no-such-part: "), "{error}");
    }
}
