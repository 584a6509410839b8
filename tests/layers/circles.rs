//! Check of the files within a room: no circle of imports has more than three of them. In: the paths in the code of `src/`. Out: the
//! largest circle of each room.

use super::{add_paths, code, root, sources};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};

/// Path of a module from the root of the program, name by name.
type Names = Vec<String>;

/// A file of `src/`: what each name of its imports stands for, and the paths that it uses.
#[derive(Default)]
struct Module {
    imports: BTreeMap<String, Names>,
    uses: Vec<Names>,
}

/// Returns the code without items for tests at the left margin, and without the paths of `pub(in ...)`.
fn without_tests(text: &str) -> String {
    let (text, mut kept) = (code(text).replace("pub(in crate::", "pub("), Vec::new());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.starts_with("#[cfg(test)]") || line.starts_with("#[cfg(all(test") {
            lines.by_ref().find(|line| *line == "}" || line.ends_with(';') && !line.starts_with(' '));
        } else {
            kept.push(line);
        }
    }
    kept.join("\n")
}

/// Returns a path from the root of the program, given the module that names it; `None` for libraries.
fn from_root(here: &[String], path: &str, modules: &BTreeSet<Names>) -> Option<Names> {
    let mut base = here.to_vec();
    for (k, name) in path.split("::").filter(|name| !name.is_empty()).enumerate() {
        match name {
            "crate" => base.clear(),
            "self" => {}
            "super" => drop(base.pop()),
            _ => base.push(name.to_owned()),
        }
        if k == 0 && base.len() > here.len() && !modules.contains(&base) {
            return None;
        }
    }
    Some(base)
}

/// Returns what a file with this code imports and uses.
fn read(here: &[String], text: &str, modules: &BTreeSet<Names>) -> Module {
    let (mut module, mut rest) = (Module::default(), String::new());
    let absolute = |paths: Vec<String>| paths.into_iter().filter_map(|path| from_root(here, &path, modules));
    for statement in text.split_inclusive(';') {
        let (before, tree) = statement.split_once("use ").unwrap_or((statement, ""));
        let lead = before.rsplit('\n').next().unwrap_or_default().trim();
        let is_import = !tree.is_empty() && (lead.is_empty() || lead.starts_with("pub"));
        rest.push_str(if is_import { before } else { statement });
        let mut paths = Vec::new();
        if is_import {
            add_paths(tree, "", &mut paths);
        }
        for path in absolute(paths) {
            module.imports.extend(path.last().map(|name| (name.clone(), path.clone())));
            module.uses.extend(lead.is_empty().then_some(path));
        }
    }
    let words = rest.split(|c: char| !(c.is_alphanumeric() || "_:".contains(c)));
    module.uses.extend(absolute(words.filter(|word| word.contains("::")).map(str::to_owned).collect()));
    module
}

/// Returns the module that defines the item of a path; names that a module imports are followed.
fn definer(path: &[String], modules: &BTreeMap<Names, Module>, steps: usize) -> Option<Names> {
    let depth = (0..=path.len()).rev().find(|depth| modules.contains_key(&path[..*depth]))?;
    let (here, rest) = path.split_at(depth);
    let target = rest.first().and_then(|name| modules[here].imports.get(name));
    match target.filter(|target| steps > 0 && target[..] != path[..=depth]) {
        Some(target) => definer(&[target, &rest[1..]].concat(), modules, steps - 1),
        None => Some(here.to_vec()),
    }
}

/// Returns everything that can be reached from `start`.
fn reached<'a>(start: &'a [String], arrows: &'a BTreeMap<Names, BTreeSet<Names>>) -> BTreeSet<&'a [String]> {
    let (mut found, mut open) = (BTreeSet::new(), vec![start]);
    while let Some(here) = open.pop() {
        open.extend(arrows[here].iter().map(Vec::as_slice).filter(|next| found.insert(*next)));
    }
    found
}

#[test]
fn files_of_a_room_import_each_other_in_small_circles_only() {
    let mut texts = BTreeMap::new();
    for file in sources(&root().join("src")) {
        let parts = file.strip_prefix(root().join("src")).unwrap().with_extension("");
        let mut here: Vec<String> = parts.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        here.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
        if !(here.is_empty() || here.iter().any(|part| part.ends_with("tests"))) {
            texts.insert(here, without_tests(&fs::read_to_string(&file).unwrap()));
        }
    }
    let names = texts.keys().cloned().collect();
    let modules: BTreeMap<Names, Module> =
        texts.iter().map(|(here, text)| (here.clone(), read(here, text, &names))).collect();
    let mut arrows: BTreeMap<Names, BTreeSet<Names>> = BTreeMap::new();
    for (here, module) in &modules {
        let targets = module.uses.iter().filter_map(|path| definer(path, &modules, 9));
        arrows.insert(here.clone(), targets.filter(|to| to[0] == here[0]).collect());
    }
    let mut largest: BTreeMap<&str, BTreeSet<&[String]>> = BTreeMap::new();
    for here in arrows.keys() {
        let mut circle = reached(here, &arrows);
        circle.retain(|other| reached(other, &arrows).contains(here.as_slice()));
        let known = largest.entry(&here[0]).or_default();
        if circle.len() > known.len().max(3) {
            *known = circle;
        }
    }
    largest.retain(|_, circle| !circle.is_empty());
    assert!(largest.is_empty(), "circles of files; move what others need into a file of its own: {largest:#?}");
}
