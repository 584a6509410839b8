//! Pages of docs/: each begins with what the reader will have at its end, and is in the summary of the site. In: docs/. Out: nothing, or
//! the pages at fault.

use super::{links, root};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// Returns the pages of a folder and of those below it, relative to docs/.
fn pages(folder: &Path, docs: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let all = entries.flat_map(|path| if path.is_dir() { pages(&path, docs) } else { vec![path] });
    let relative = all.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
    relative.map(|path| path.strip_prefix(docs).unwrap_or(&path).to_path_buf()).collect()
}

#[test]
fn every_page_begins_with_its_goal_and_is_once_in_the_summary() {
    let docs = root().join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let mut listed: BTreeMap<&str, usize> = BTreeMap::new();
    for target in links(&summary).into_iter().filter(|target| !target.is_empty()) {
        *listed.entry(target).or_default() += 1;
    }
    let pages = pages(&docs, &docs);
    assert!(pages.len() > 40, "{}", pages.len());
    for page in pages.iter().filter(|page| *page != Path::new("SUMMARY.md")) {
        let text = fs::read_to_string(docs.join(page)).unwrap();
        let goal = text.lines().filter(|line| !line.is_empty()).nth(1);
        assert!(goal.is_some_and(|line| line.starts_with("**Goal:** ")), "{} begins without **Goal:**", page.display());
        assert_eq!(listed.get(page.to_str().unwrap()), Some(&1), "{} in docs/SUMMARY.md", page.display());
    }
}
