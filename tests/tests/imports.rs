//! Imports go one way: a module imports only what stands before it in its crate's order, and the modules of a folder do
//! not import one another in a circle.
//!
//! A module is a file or a folder. What a folder's own file (`mod.rs`, or `folder.rs` beside it) imports from its
//! children, and they from it, is not looked at: these belong together. A name that such a file publishes with `use`
//! counts as the module's that it comes from. Tests may import anything.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of the kernel, each after all that it imports.
const KERNEL: &[&str] =
    &["simd", "columns", "geometry", "error", "mesh", "bvh", "traverse", "scene", "sampling", "irradiance"];

/// The modules of the renderer, each after all that it imports.
const RENDER: &[&str] = &[
    "lpe",
    "settings",
    "film",
    "watch",
    "output",
    "denoise",
    "material",
    "scene",
    "executor",
    "camera",
    "light",
    "world",
    "bsdf",
    "estimator",
    "guide",
    "cache",
    "integrator",
    "driver",
    "overlay",
    "irradiance",
    "validate",
    "bake",
    "cubemap",
    "probes",
    "view",
    "cli",
];

/// The names that lead from a crate's root to a module, or to an item of it.
type Names = Vec<String>;

/// A file of a crate.
#[derive(Default)]
struct Module {
    /// What it imports, from the root.
    imports: BTreeSet<Names>,
    /// Names of its own that stand for something elsewhere.
    aliases: BTreeMap<String, Names>,
}

/// The files of a crate, by their names from the root, which has none.
struct Crate(BTreeMap<Names, Module>);

impl Crate {
    fn read(folder: &Path) -> Self {
        let mut modules = BTreeMap::new();
        let mut tests = BTreeSet::new();
        for file in files(folder) {
            let mut names: Names = file
                .strip_prefix(folder)
                .unwrap()
                .with_extension("")
                .iter()
                .map(|name| name.to_str().unwrap().to_owned())
                .collect();
            if names == ["main"] {
                continue;
            }
            if names == ["lib"] || names.last().is_some_and(|name| name == "mod") {
                names.pop();
            }
            let text = fs::read_to_string(&file).unwrap();
            let (text, of_tests) = without_tests(&without_comments(&text));
            tests.extend(of_tests.into_iter().map(|name| [names.clone(), vec![name]].concat()));
            let (uses, rest) = uses(&text);
            let mut module = Module::default();
            for path in uses.into_iter().flat_map(|tree| expand(&tree)) {
                if let Some(path) = absolute(&names, &path) {
                    module.aliases.insert(path.last().unwrap().clone(), path.clone());
                    module.imports.insert(path);
                }
            }
            module.imports.extend(paths(&rest).filter_map(|path| absolute(&names, &path)));
            modules.insert(names, module);
        }
        modules.retain(|names, _| !(1..=names.len()).any(|length| tests.contains(&names[..length])));
        Self(modules)
    }

    /// The module that has what a path leads to.
    fn find(&self, path: &[String]) -> Names {
        let mut path = path.to_vec();
        // Aliases lead to modules below or before; a few steps are enough.
        for _ in 0..8 {
            let known = (0..=path.len()).rev().find(|&length| self.0.contains_key(&path[..length])).unwrap();
            let alias = path.get(known).and_then(|name| self.0[&path[..known]].aliases.get(name));
            match alias {
                Some(alias) if *alias != path[..=known] => path = [alias, &path[known + 1..]].concat(),
                _ => return path[..known].to_vec(),
            }
        }
        path
    }

    /// For each folder the imports from one of its children into another, with the files that import.
    fn edges(&self) -> BTreeMap<Names, BTreeMap<[String; 2], Names>> {
        let mut edges: BTreeMap<Names, BTreeMap<[String; 2], Names>> = BTreeMap::new();
        for (from, module) in &self.0 {
            for to in module.imports.iter().map(|path| self.find(path)) {
                let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
                if let (Some(a), Some(b)) = (from.get(shared), to.get(shared)) {
                    let pairs = edges.entry(from[..shared].to_vec()).or_default();
                    pairs.entry([a.clone(), b.clone()]).or_insert_with(|| from.clone());
                }
            }
        }
        edges
    }

    /// What is wrong; `recursive` are modules of types that hold one another, which may import one another.
    fn faults(&self, order: &[&str], recursive: &[&str]) -> Vec<String> {
        let mut faults = Vec::new();
        let position = |name: &str| order.iter().position(|known| *known == name);
        let own: BTreeSet<&String> = self.0.keys().filter_map(|names| names.first()).collect();
        faults.extend(own.iter().filter(|name| position(name).is_none()).map(|name| format!("{name} has no place")));
        for (folder, edges) in self.edges() {
            for ([a, b], file) in &edges {
                let is_recursive = [a, b].map(|name| [&folder[..], std::slice::from_ref(name)].concat().join("/"));
                let is_wrong = if is_recursive.iter().all(|name| recursive.contains(&name.as_str())) {
                    false
                } else if folder.is_empty() {
                    matches!((position(a), position(b)), (Some(a), Some(b)) if a < b)
                } else {
                    reaches(&edges, b, a)
                };
                if is_wrong {
                    faults.push(format!(
                        "{}: {a} imports {b}, which stands after it or leads back to it",
                        file.join("/")
                    ));
                }
            }
        }
        faults
    }
}

/// Whether imports lead from one module to another.
fn reaches(edges: &BTreeMap<[String; 2], Names>, from: &str, to: &str) -> bool {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(next) = open.pop() {
        if next == to {
            return true;
        }
        if seen.insert(next) {
            open.extend(edges.keys().filter(|[a, _]| a == next).map(|[_, b]| b.as_str()));
        }
    }
    false
}

/// All Rust files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn without_comments(text: &str) -> String {
    text.lines().filter(|line| !line.trim_start().starts_with("//")).map(|line| format!("{line}\n")).collect()
}

/// A text without items that are for tests, and the names of the modules among them that are files.
fn without_tests(text: &str) -> (String, Vec<String>) {
    const MARKS: [&str; 2] = ["#[cfg(test)]", "#[cfg(all(test,"];
    let (mut kept, mut names, mut rest) = (String::new(), Vec::new(), text);
    while let Some(start) = MARKS.iter().filter_map(|mark| rest.find(mark)).min() {
        kept += &rest[..start];
        let item = &rest[start + 1..];
        let head = item.find(['{', ';']).unwrap_or(item.len());
        let mut end = head + 1;
        if item[head..].starts_with('{') {
            let mut depth = 1;
            end += item[end..]
                .find(|c| {
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    depth == 0
                })
                .map_or(item.len() - end, |end| end + 1);
        } else if let Some((_, name)) = item[..head].split_once("mod ") {
            names.push(name.trim().to_owned());
        }
        rest = &item[end.min(item.len())..];
    }
    (kept + rest, names)
}

/// The trees of `use` statements, and the text without these.
fn uses(text: &str) -> (Vec<String>, String) {
    let (mut trees, mut rest) = (Vec::new(), String::new());
    let mut statement: Option<String> = None;
    for line in text.lines() {
        let begins = line.trim_start().split_once("use ").filter(|(before, _)| {
            before.is_empty() || (before.starts_with("pub") && before.ends_with([' ', ')']) && !before.contains('='))
        });
        match (&mut statement, begins) {
            (Some(tree), _) => *tree += line,
            (None, Some((_, tree))) => statement = Some(tree.to_owned()),
            (None, None) => rest += &format!("{line}\n"),
        }
        if let Some(tree) = statement.take_if(|tree| tree.trim_end().ends_with(';')) {
            trees.push(tree.trim_end().trim_end_matches(';').split_whitespace().collect::<Vec<_>>().join(" "));
        }
    }
    (trees, rest)
}

/// The paths of a tree like `a::{b, c::{d, e}}`.
fn expand(tree: &str) -> Vec<String> {
    let Some((before, inner)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap().trim();
        return if path.is_empty() { Vec::new() } else { vec![path.to_owned()] };
    };
    let inner = inner.trim_end().strip_suffix('}').unwrap();
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in inner.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match c {
            ',' if depth == 0 => parts.push(String::new()),
            c => parts.last_mut().unwrap().push(c),
        }
    }
    let parts = parts.iter().flat_map(|part| expand(part.trim()));
    parts.map(|part| format!("{before}{part}").replace("::self", "")).collect()
}

/// The paths in expressions and types that begin in this crate.
fn paths(text: &str) -> impl Iterator<Item = String> + '_ {
    let words = text.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
    words.filter(|word| word.starts_with("crate::") || word.starts_with("super::")).map(str::to_owned)
}

/// A path from the root, if it begins in this crate; `names` are those of the module that it stands in.
fn absolute(names: &[String], path: &str) -> Option<Names> {
    let mut parts: Vec<&str> = path.split("::").filter(|part| !part.is_empty() && *part != "*").collect();
    let mut base = match *parts.first()? {
        "crate" => Vec::new(),
        "self" | "super" => names.to_vec(),
        // A child's name, where a folder's own file publishes it; other crates' names lead nowhere.
        _ => return Some([names, &parts.iter().map(|part| (*part).to_owned()).collect::<Vec<_>>()].concat()),
    };
    while matches!(parts.first(), Some(&("crate" | "self" | "super"))) {
        if parts.remove(0) == "super" {
            base.pop();
        }
    }
    base.extend(parts.into_iter().map(str::to_owned));
    Some(base).filter(|path| !path.is_empty())
}

fn check(folder: &str, order: &[&str], recursive: &[&str]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    let read = Crate::read(&folder);
    assert!(read.0.len() > order.len(), "{} has {} files", folder.display(), read.0.len());
    let faults = read.faults(order, recursive);
    assert!(faults.is_empty(), "{}:\n{}", folder.display(), faults.join("\n"));
}

#[test]
fn imports_of_the_kernel_go_one_way() {
    // An item may be an instance of a scene, which has items.
    let scenes = ["scene/object", "scene/item", "scene/view", "scene/owned", "scene/top_level"];
    check("kernel/src", KERNEL, &scenes);
}

#[test]
fn imports_of_the_renderer_go_one_way() {
    check("render/src", RENDER, &[]);
}

/// The check sees circles, upward imports and modules without a place, and passes over what is for tests.
#[test]
fn faults_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    write("lib.rs", "mod a;\nmod b;\npub use a::Shown;\n");
    write("a/mod.rs", "mod one;\nmod two;\npub use one::{\n    Shown,\n    Other as Kept,\n};\n");
    write("a/one.rs", "use std::fmt;\n// use super::two::Two;\n#[cfg(test)]\nmod tests { use crate::b::B; }\n");
    write("a/two.rs", "use super::one::Other;\n");
    write("b.rs", "use crate::Shown;\n#[cfg(test)]\nmod tests;\n");
    write("b/tests.rs", "use crate::c::C;\n");
    assert_eq!(Crate::read(folder.path()).faults(&["a", "b"], &[]), Vec::<String>::new());
    assert_eq!(Crate::read(folder.path()).faults(&["b", "a"], &[]).len(), 1, "upward, by a name of the root");
    assert_eq!(Crate::read(folder.path()).faults(&["a"], &[]).len(), 1, "no place");
    write("a/one.rs", "fn f() -> super::two::Two { todo() }\n");
    assert_eq!(Crate::read(folder.path()).faults(&["a", "b"], &[]).len(), 2, "both ways");
    assert_eq!(Crate::read(folder.path()).faults(&["a", "b"], &["a/one", "a/two"]), Vec::<String>::new());
}
