//! Reader of an OpenSCENARIO file: the catalogs that it may refer to, and the lists of what is left out. In: elements. Out: elements that references
//! lead to; `positions`, `actions`, `conditions`, `entities` and `storyboard` read the kinds of elements.

use super::{
    document::{self, Element},
    fault::{OpenScenarioError, Problems, Unsupported, meaning_of},
    parameters::{Node, Scope},
};
use crate::toml_text::{did_you_mean, did_you_mean_file};
use std::{
    path::{Path, PathBuf},
    rc::Rc,
};

/// Largest number of files of a folder of catalogs.
const MOST_FILES: usize = 200;
/// Longest chain of entries of which each refers to the next.
const LONGEST_CHAIN: usize = 8;

/// State of reading one scenario.
#[derive(Debug, Default)]
pub(super) struct Reader {
    pub problems: Problems,
    /// Names of all entities, those of unknown kinds included.
    pub entity_names: Vec<String>,
    folders: Vec<PathBuf>,
    /// Outermost elements of the catalogs; empty until a reference needs them.
    catalogs: Vec<Node>,
    /// Number of references that are followed at the moment.
    depth: usize,
}

impl Reader {
    /// Remembers the folders of the catalogs; paths are relative to the folder of the scenario.
    ///
    /// # Errors
    /// A folder has no path.
    pub fn locate_catalogs(&mut self, locations: &Node) -> Result<(), OpenScenarioError> {
        let home = locations.place().file.parent().unwrap_or(Path::new("")).to_path_buf();
        for kind in locations.children()? {
            let folder = kind.child("Directory")?.text("path")?;
            let folder = home.join(folder);
            if !self.folders.contains(&folder) {
                self.folders.push(folder);
            }
        }
        Ok(())
    }

    /// Reports a part of the file with its consequence.
    pub fn leave_out(&mut self, node: &Node, meaning: impl Into<String>) {
        self.leave_out_part(node, "", meaning);
    }

    /// Reports an element by the usual consequence.
    pub fn leave_out_unknown(&mut self, node: &Node) {
        self.leave_out(node, meaning_of(node.name()));
    }

    /// Reports a part of an element, such as one attribute.
    pub fn leave_out_part(&mut self, node: &Node, part: &str, meaning: impl Into<String>) {
        let element = format!("{}{}{part}", node.name(), if part.is_empty() { "" } else { " " });
        let place = node.place();
        let (file, line) = (place.file.to_path_buf(), place.line);
        self.problems.add(Unsupported { file, line, element, meaning: meaning.into() });
    }

    /// Reports attributes and children of an element that are not among these.
    pub fn expect(&mut self, node: &Node, attributes: &[&str], children: &[&str]) -> Result<(), OpenScenarioError> {
        let unknown = node.element.attribute_names().filter(|name| !attributes.contains(name));
        for name in unknown.map(str::to_owned).collect::<Vec<_>>() {
            self.leave_out_part(node, &name, "the attribute has no effect");
        }
        for child in node.children()?.iter().filter(|child| !children.contains(&child.name())) {
            self.leave_out_unknown(child);
        }
        Ok(())
    }

    /// Follows a `CatalogReference` and passes the entry on.
    ///
    /// # Errors
    /// The catalog or the entry does not exist, or entries refer to each other in a circle.
    pub fn follow<T>(
        &mut self,
        reference: &Node,
        read: impl FnOnce(&mut Self, &Node) -> Result<T, OpenScenarioError>,
    ) -> Result<T, OpenScenarioError> {
        self.expect(reference, &["catalogName", "entryName"], &["ParameterAssignments"])?;
        if self.depth >= LONGEST_CHAIN {
            let message = format!("entries of catalogs refer to each other, more than {LONGEST_CHAIN} in a row");
            return Err(reference.fault(message + "\n  remedy: break the circle"));
        }
        let entry = self.entry(reference)?;
        let mut given = Vec::new();
        let lists = reference.all("ParameterAssignments")?;
        for list in &lists {
            for assignment in list.all("ParameterAssignment")? {
                let name = assignment.element.attribute("parameterRef").unwrap_or_default();
                let name = name.trim_start_matches('$').to_owned();
                given.push((name, assignment.text("value")?));
            }
        }
        let scope = Scope::of(&entry, &reference.scope, &given)?;
        self.depth += 1;
        let found = read(self, &Node { element: entry, scope });
        self.depth -= 1;
        found
    }

    fn entry(&mut self, reference: &Node) -> Result<Rc<Element>, OpenScenarioError> {
        let (catalog_name, entry_name) = (reference.text("catalogName")?, reference.text("entryName")?);
        if self.catalogs.is_empty() {
            self.load_catalogs(reference)?;
        }
        let named = |node: &&Node, name: &str| node.element.attribute("name") == Some(name);
        let of_name: Vec<&Node> = self.catalogs.iter().filter(|node| named(node, &catalog_name)).collect();
        if of_name.is_empty() {
            let known: Vec<String> = self.catalogs.iter().map(Node::title).collect();
            let near = did_you_mean(&catalog_name, &known);
            let folders: Vec<String> = self.folders.iter().map(|folder| folder.display().to_string()).collect();
            let message = format!("no catalog \"{catalog_name}\"{near} in {}", folders.join(", "));
            return Err(reference.fault(message + "\n  remedy: name its folder in <CatalogLocations>"));
        }
        let entries = of_name.iter().flat_map(|catalog| &catalog.element.children);
        let of_entry = |entry: &&Rc<Element>| entry.attribute("name") == Some(entry_name.as_str());
        entries.clone().find(of_entry).cloned().ok_or_else(|| {
            let known: Vec<&str> = entries.filter_map(|entry| entry.attribute("name")).collect();
            let near = did_you_mean(&entry_name, &known);
            reference.fault(format!("catalog \"{catalog_name}\" has no entry \"{entry_name}\"{near}"))
        })
    }

    fn load_catalogs(&mut self, reference: &Node) -> Result<(), OpenScenarioError> {
        if self.folders.is_empty() {
            let remedy = "\n  remedy: name the folders of the catalogs in <CatalogLocations>";
            return Err(reference.fault(format!("the scenario names no folder of catalogs{remedy}")));
        }
        for folder in &self.folders {
            let failed = |error: std::io::Error| {
                let near = did_you_mean_file(folder);
                reference.fault(format!("the folder of catalogs {} cannot be read: {error}{near}", folder.display()))
            };
            let entries = std::fs::read_dir(folder).map_err(failed)?;
            let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
            files.retain(|file| file.extension().is_some_and(|end| end.eq_ignore_ascii_case("xosc")));
            files.sort();
            if files.len() > MOST_FILES {
                let most = format!("has {} files .xosc; allowed: at most {MOST_FILES}", files.len());
                return Err(reference.fault(format!("the folder of catalogs {} {most}", folder.display())));
            }
            for file in files {
                let root = document::read(&file)?;
                let catalogs = root.children.iter().filter(|child| child.name == "Catalog");
                self.catalogs
                    .extend(catalogs.map(|element| Node { element: Rc::clone(element), scope: Rc::default() }));
            }
        }
        Ok(())
    }
}
