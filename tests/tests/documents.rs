//! The documents at the root, in `docs/` and in `embed/`: links lead somewhere, files that ARCHITECTURE.md names exist,
//! and pages for newcomers are short.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a crate of the workspace")
}

/// The files in `folder` and below it, but not those that builds leave.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries =
        fs::read_dir(folder).expect("a folder of the repository").map(|entry| entry.expect("readable").path());
    let (folders, mut found): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    for folder in folders {
        let name = folder.file_name().unwrap_or_default();
        if name != "target" && name != "node_modules" && !name.to_string_lossy().starts_with('.') {
            found.extend(files(&folder));
        }
    }
    found
}

/// The document's lines outside of code blocks.
fn prose(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).expect("a document");
    let mut is_code = false;
    let lines = text.lines().filter(|line| {
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        !is_fence && !is_code
    });
    lines.map(str::to_owned).collect()
}

/// What GitHub makes of headings: lower case, no punctuation, hyphens for spaces.
fn anchors(path: &Path) -> HashSet<String> {
    let lines = prose(path);
    let headings =
        lines.iter().filter_map(|line| line.strip_prefix('#')).map(|line| line.trim_start_matches('#').trim());
    let anchor = |heading: &str| {
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

/// The targets of `[text](target)` in a line.
fn links(line: &str) -> impl Iterator<Item = &str> {
    line.split("](").skip(1).filter_map(|rest| rest.split(')').next())
}

#[test]
fn links_lead_somewhere() {
    let mut checked = 0;
    for document in files(root()).iter().filter(|path| path.extension().is_some_and(|extension| extension == "md")) {
        for line in prose(document) {
            for link in links(&line).filter(|link| !link.starts_with("http")) {
                let (path, anchor) = link.split_once('#').map_or((link, None), |(path, anchor)| (path, Some(anchor)));
                let target = match path {
                    "" => document.clone(),
                    path => document.parent().expect("in a folder").join(path),
                };
                assert!(target.exists(), "{}: {link} does not exist", document.display());
                if let Some(anchor) = anchor {
                    assert!(anchors(&target).contains(anchor), "{}: {link} has no such heading", document.display());
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 50, "only {checked} links were found");
}

#[test]
fn the_files_that_the_architecture_names_exist() {
    let files: Vec<String> = files(root()).iter().map(|path| path.display().to_string()).collect();
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("a document");
    let named: Vec<&str> = text.split('`').skip(1).step_by(2).filter(|code| code.ends_with(".rs")).collect();
    assert!(named.len() > 30, "only {} files are named", named.len());
    for name in named {
        let suffix = format!("/{name}");
        assert!(files.iter().any(|file| file.ends_with(&suffix)), "ARCHITECTURE.md names {name}, which does not exist");
    }
}

#[test]
fn what_is_read_first_is_short() {
    let text = |name: &str| fs::read_to_string(root().join(name)).expect("a document");
    assert!(text("README.md").lines().count() <= 150);
    assert!(text("ARCHITECTURE.md").len() <= 12 * 1024);
}

#[test]
fn no_document_has_the_marks_of_a_merge() {
    for document in files(root()).iter().filter(|path| path.extension().is_some_and(|extension| extension == "md")) {
        let marks = |line: &String| ["<<<<<<< ", ">>>>>>> "].iter().any(|mark| line.starts_with(mark));
        assert!(!prose(document).iter().any(marks), "{}", document.display());
    }
}
