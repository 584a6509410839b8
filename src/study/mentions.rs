//! Files that name a participant, for an erasure. In: a data set, a participant code. Out: `derivatives/` of other programs without the
//! participant's folders, rows and files; and the list of other files that still name the participant.

use super::{ParticipantCode, SessionError, bids::TABLE_BYTES};
use crate::{
    file::{open_regular, read_text},
    record::{self, RecordError},
};
use std::{
    fs,
    io::{self, Read},
    path::{Path, PathBuf},
};

/// Table columns that may hold a participant code without `sub-`.
const PARTICIPANT_COLUMNS: [&str; 4] = ["participant", "participant_id", "subject", "sub"];
/// Extensions of a recording's own files, which never name a participant.
const NAMELESS: [&str; 3] = ["parquet", "blocks", "wav"];
/// Bytes that are searched at a time.
const PIECE: usize = 1 << 20;

/// Removes a participant from the results of other programs: deletes folders and files whose name has `sub-CODE`, removes the
/// participant's rows of tables, and deletes other files whose content has `sub-CODE`.
///
/// # Errors
/// A file or folder cannot be read, written or removed.
pub(super) fn remove_from_derived(root: &Path, code: &ParticipantCode) -> Result<(), SessionError> {
    let derived = root.join("derivatives");
    if !derived.is_dir() {
        return Ok(());
    }
    each_file(&derived, &mut |path, is_folder| {
        let is_named = names(&path.file_name().unwrap_or_default().to_string_lossy(), code);
        if !is_named && (is_folder || without_rows(path, code)? || !is_named_in(path, code)?) {
            return Ok(!is_folder);
        }
        let removed = if is_folder { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        removed.map_err(|why| RecordError::File { path: path.into(), why })?;
        Ok(true)
    })
}

/// Lists the files and folders of a data set that name a participant, except the list of erased participants.
///
/// # Errors
/// A file or folder cannot be read.
pub(super) fn files(root: &Path, code: &ParticipantCode) -> Result<Vec<PathBuf>, SessionError> {
    let mut found = Vec::new();
    each_file(root, &mut |path, is_folder| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_nameless = path.extension().is_some_and(|ending| NAMELESS.iter().any(|one| ending == *one));
        let is_ledger = path.parent() == Some(root) && name == "erased.tsv";
        if names(&name, code) || (!is_folder && !is_nameless && !is_ledger && is_named_in(path, code)?) {
            found.push(path.to_path_buf());
            return Ok(true);
        }
        Ok(!is_folder)
    })?;
    found.sort();
    Ok(found)
}

/// Visits every file and folder below `folder`, except symbolic links. `visit` returns true for a folder that must not be entered.
fn each_file(
    folder: &Path,
    visit: &mut dyn FnMut(&Path, bool) -> Result<bool, SessionError>,
) -> Result<(), SessionError> {
    let fault = |why| SessionError::from(RecordError::File { path: folder.into(), why });
    for entry in fs::read_dir(folder).map_err(fault)? {
        let entry = entry.map_err(fault)?;
        let kind = entry.file_type().map_err(fault)?;
        if kind.is_symlink() {
            continue;
        }
        let path = entry.path();
        if !visit(&path, kind.is_dir())? && kind.is_dir() {
            each_file(&path, visit)?;
        }
    }
    Ok(())
}

/// Returns true if the text contains `sub-CODE` as a whole word.
fn names(text: &str, code: &ParticipantCode) -> bool {
    first_of(text.as_bytes(), code).is_some()
}

/// Returns the first position of `sub-CODE` with no letter or digit after it.
fn first_of(bytes: &[u8], code: &ParticipantCode) -> Option<usize> {
    let subject = code.subject().into_bytes();
    let mut from = 0;
    while let Some(at) = bytes[from..].iter().position(|byte| *byte == subject[0]) {
        let rest = &bytes[from + at..];
        let is_whole = |after: Option<&u8>| !after.is_some_and(u8::is_ascii_alphanumeric);
        if rest.starts_with(&subject) && is_whole(rest.get(subject.len())) {
            return Some(from + at);
        }
        from += at + 1;
    }
    None
}

fn is_named_in(path: &Path, code: &ParticipantCode) -> Result<bool, SessionError> {
    let fault = |why: io::Error| SessionError::from(RecordError::File { path: path.into(), why });
    let mut file = match open_regular(path) {
        Ok(file) => file,
        // A pipe or a socket holds no stored data.
        Err(why) if why.kind() == io::ErrorKind::InvalidInput => return Ok(false),
        Err(why) => return Err(fault(why)),
    };
    let overlap = code.subject().len() + 1;
    let mut bytes = Vec::new();
    loop {
        let kept = bytes.len().min(overlap);
        bytes.drain(..bytes.len() - kept);
        let read = file.by_ref().take(PIECE as u64).read_to_end(&mut bytes).map_err(fault)?;
        let is_last = read < PIECE;
        // A code at the very end of a piece may continue in the next piece.
        let end = if is_last { bytes.len() } else { bytes.len() - 1 };
        if first_of(&bytes, code).is_some_and(|at| is_last || at + overlap <= end + 1) {
            return Ok(true);
        }
        if is_last {
            return Ok(false);
        }
    }
}

/// Returns the cell separator of a table, by the extension of its name.
fn separator(path: &Path) -> Option<char> {
    match path.extension()?.to_str()? {
        "tsv" => Some('\t'),
        "csv" => Some(','),
        _ => None,
    }
}

/// Removes the rows of a participant from a table. Returns false if the file is not a readable table or still names the participant.
fn without_rows(path: &Path, code: &ParticipantCode) -> Result<bool, SessionError> {
    let Some(separator) = separator(path) else { return Ok(false) };
    let Ok(text) = read_text(path, TABLE_BYTES) else { return Ok(false) };
    let mut lines = text.lines();
    let head = lines.next().unwrap_or_default();
    let plain = |cell: &str| cell.trim().trim_matches('"').to_owned();
    let is_participant: Vec<bool> =
        head.split(separator).map(|name| PARTICIPANT_COLUMNS.contains(&plain(name).to_lowercase().as_str())).collect();
    let is_own = |line: &&str| {
        let mut cells = line.split(separator).enumerate();
        names(line, code) || cells.any(|(k, cell)| is_participant.get(k) == Some(&true) && plain(cell) == code.as_str())
    };
    let kept: String =
        std::iter::once(head).chain(lines.filter(|line| !is_own(line))).map(|line| format!("{line}\n")).collect();
    if names(&kept, code) {
        return Ok(false);
    }
    if kept != text {
        record::replace(path, kept.as_bytes())?;
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_found_as_a_whole_word_across_piece_borders() {
        let code = ParticipantCode::new("P1").unwrap();
        let place = tempfile::NamedTempFile::new().unwrap();
        let found = |bytes: &[u8]| {
            fs::write(place.path(), bytes).unwrap();
            is_named_in(place.path(), &code).unwrap()
        };
        for at in [0, 1, PIECE - 8, PIECE - 6, PIECE - 5, PIECE - 1, PIECE, 2 * PIECE - 3] {
            for (words, is_there) in
                [("sub-P1", true), ("sub-P1\n", true), ("sub-P12", false), ("sub-P1/x", true), ("sub-p1", false)]
            {
                let mut bytes = vec![b's'; at];
                bytes.extend(words.as_bytes());
                assert_eq!(found(&bytes), is_there, "{words} at {at}");
                bytes.extend(vec![b'.'; PIECE]);
                assert_eq!(found(&bytes), is_there, "{words} at {at}, with more behind");
            }
        }
    }

    #[test]
    fn only_the_rows_of_the_participant_leave_a_table() {
        let code = ParticipantCode::new("P1").unwrap();
        let folder = tempfile::tempdir().unwrap();
        for (name, text, kept) in [
            (
                "notes.tsv",
                "at\tparticipant\ttext\n1\tsub-P1\ta\n2\tsub-P2\tP1\n3\tP1\tb\n",
                "at\tparticipant\ttext\n2\tsub-P2\tP1\n",
            ),
            ("all.csv", "subject,x\n\"P1\",1\nP10,2\n", "subject,x\nP10,2\n"),
            ("sessions.tsv", "file\nsub-P1/x.tsv\nsub-P10/x.tsv\n", "file\nsub-P10/x.tsv\n"),
        ] {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            assert!(without_rows(&path, &code).unwrap());
            assert_eq!(fs::read_to_string(&path).unwrap(), kept, "{name}");
        }
        let path = folder.path().join("wide.csv");
        fs::write(&path, "time,sub-P1,sub-P2\n1,2,3\n").unwrap();
        assert!(!without_rows(&path, &code).unwrap(), "a column cannot be taken out by rows");
    }
}
