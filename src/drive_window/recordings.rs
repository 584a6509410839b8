//! Folders for the recordings of one window. In: the requested folder. Out: one folder for each drive, and a text that
//! lists them.

use std::path::{Path, PathBuf};

/// Folders of the drives of one window: `d1`, and beside it `d1-2`, `d1-3` for later drives.
pub struct RecordingFolders {
    out: Option<PathBuf>,
    folders: Vec<PathBuf>,
}

impl std::fmt::Display for RecordingFolders {
    /// Writes the list of the folders; the last drive is the one described below it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut lines = self.folders.iter().enumerate().map(|(k, folder)| match self.folders.len() {
            1 => format!("recorded in              {}\n", folder.display()),
            all if k + 1 == all => format!("drive {all} of {all}, below      {}\n", folder.display()),
            all => format!("drive {} of {all}             {}\n", k + 1, folder.display()),
        });
        lines.try_for_each(|line| f.write_str(&line))
    }
}

impl RecordingFolders {
    pub fn new(out: Option<PathBuf>) -> Self {
        Self { out, folders: Vec::new() }
    }

    /// Returns the folder for the next drive; `None` if drives are not recorded. The first is the requested one; each
    /// later one does not exist yet.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_of_one_window_get_folders_side_by_side() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mut recordings = RecordingFolders::new(Some(at("p 1.a")));
        assert_eq!(recordings.next(), Some(at("p 1.a")));
        assert_eq!(recordings.to_string(), format!("recorded in              {}\n", at("p 1.a").display()));
        // An older folder already has the name.
        std::fs::create_dir(at("p 1.a-2")).unwrap();
        assert_eq!(recordings.next(), Some(at("p 1.a-3")));
        assert_eq!((recordings.next(), recordings.last()), (Some(at("p 1.a-4")), Some(at("p 1.a-4").as_path())));
        let lines: Vec<String> = recordings.to_string().lines().map(str::to_owned).collect();
        let names: Vec<_> = [("drive 1 of 3             ", "p 1.a"), ("drive 2 of 3             ", "p 1.a-3")]
            .into_iter()
            .chain([("drive 3 of 3, below      ", "p 1.a-4")])
            .map(|(head, name)| format!("{head}{}", at(name).display()))
            .collect();
        assert_eq!(lines, names);
        let mut none = RecordingFolders::new(None);
        assert_eq!((none.next(), none.last(), none.to_string()), (None, None, String::new()));
    }
}
