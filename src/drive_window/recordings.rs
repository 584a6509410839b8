//! Where the drives of one window are recorded. In: the folder that was asked for. Out: one for each drive, and words on which
//! is which.

use std::path::{Path, PathBuf};

/// Folders of the drives of one window: `d1`, and beside it `d1-2`, `d1-3` for those that began later.
pub struct RecordingFolders {
    out: Option<PathBuf>,
    folders: Vec<PathBuf>,
}

impl RecordingFolders {
    pub fn new(out: Option<PathBuf>) -> Self {
        Self { out, folders: Vec::new() }
    }

    /// The next drive's; `None` if drives are not recorded. The first is the one that was asked for, and none of the others
    /// is there yet.
    pub fn next(&mut self) -> Option<PathBuf> {
        let out = self.out.as_ref()?;
        let number = |number: usize| {
            let mut name = out.file_name().unwrap_or_default().to_owned();
            name.push(format!("-{number}"));
            out.with_file_name(name)
        };
        let folder = match self.folders.len() {
            0 => out.clone(),
            before => (before + 1..).map(number).find(|folder| !folder.exists() && !self.folders.contains(folder))?,
        };
        self.folders.push(folder.clone());
        Some(folder)
    }

    pub fn last(&self) -> Option<&Path> {
        self.folders.last().map(PathBuf::as_path)
    }

    /// Which drive is described below, and where each lies.
    pub fn words(&self) -> String {
        let lines = self.folders.iter().enumerate().map(|(k, folder)| match self.folders.len() {
            1 => format!("recorded in              {}\n", folder.display()),
            all if k + 1 == all => format!("drive {all} of {all}, below      {}\n", folder.display()),
            all => format!("drive {} of {all}             {}\n", k + 1, folder.display()),
        });
        lines.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_of_one_window_lie_side_by_side_and_none_takes_anothers_place() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mut recordings = RecordingFolders::new(Some(at("p 1.a")));
        assert_eq!(recordings.next(), Some(at("p 1.a")));
        assert_eq!(recordings.words(), format!("recorded in              {}\n", at("p 1.a").display()));
        // One of yesterday is in the way.
        std::fs::create_dir(at("p 1.a-2")).unwrap();
        assert_eq!(recordings.next(), Some(at("p 1.a-3")));
        assert_eq!((recordings.next(), recordings.last()), (Some(at("p 1.a-4")), Some(at("p 1.a-4").as_path())));
        let lines: Vec<String> = recordings.words().lines().map(str::to_owned).collect();
        let names: Vec<_> = [("drive 1 of 3             ", "p 1.a"), ("drive 2 of 3             ", "p 1.a-3")]
            .into_iter()
            .chain([("drive 3 of 3, below      ", "p 1.a-4")])
            .map(|(head, name)| format!("{head}{}", at(name).display()))
            .collect();
        assert_eq!(lines, names);
        let mut none = RecordingFolders::new(None);
        assert_eq!((none.next(), none.last(), none.words()), (None, None, String::new()));
    }
}
