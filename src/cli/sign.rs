//! `codrive sign`: signs a recording or a data set with a key of the lab; also checks such signatures. In: a folder, and a key
//! or a list of signers. Out: a signature file beside the signed file, or the signer's name.
//!
//! The signed file holds the SHA-256 of all others: `manifest.json` in a recording, `SHA256SUMS` in a data set.

use super::{CliError, analyse, out};
use crate::{
    analysis::{FolderContents, text::joined_with_and},
    drive_loop::RunError,
    file::read_bounded,
    record::{self, RecordError, is_there, manifest, seals::SIGNATURE},
    signing::{self, Signer, SignerList, SigningError},
    study::checksums,
};
use clap::{Arg, ArgMatches, Command, value_parser};
use std::path::{Path, PathBuf};

/// Maximum size of a signed file, bytes.
const MOST_BYTES: u64 = 64 << 20;

fn path(name: &'static str, value: &'static str) -> Arg {
    Arg::new(name).value_name(value).value_parser(value_parser!(PathBuf))
}

pub(super) fn command() -> Command {
    Command::new("sign")
        .about("Sign a recording or a data set with the lab's key; changes by others are then detected")
        .after_help(
            "Checksums detect a change, but a person who changes a file can write new checksums.\n\
             A new signature needs the key.\n\n\
             Example:\n  \
             ssh-keygen -t ed25519 -N '' -f lab-key     once: lab-key stays with the lab, lab-key.pub is public\n  \
             codrive sign data --key lab-key            after the last session\n  \
             codrive analyse data --signer lab-key.pub  refuses data that the lab did not sign\n\n\
             Signed file: manifest.json of a recording (manifest.json.sig), SHA256SUMS of a data set. Both list the \
             SHA-256 of all other files.\n\
             A data set is signed when all its sessions are over; an added participant or plan is then detected.\n\
             Sign again after each change, such as another participant in a data set.\n\
             Check with OpenSSH: ssh-keygen -Y verify -f signers -I NAME -n codrive -s manifest.json.sig < \
             manifest.json\n\
             Keys with a passphrase and keys of other kinds sign with OpenSSH: ssh-keygen -Y sign -f KEY -n codrive \
             FILE",
        )
        .arg(path("folder", "DIR").required(true).help("A recording, or the folder of a study"))
        .arg(
            path("key", "FILE")
                .long("key")
                .required(true)
                .help("Private key: Ed25519, made by ssh-keygen, without a passphrase"),
        )
}

/// Returns the flag `--signer` of commands that check a signature.
pub(super) fn signer_argument() -> Arg {
    path("signer", "FILE").long("signer").help(
        "Accepted signers (codrive sign): a public key (lab-key.pub), or a list of signers in the format of ssh-keygen \
         -Y. The exit code is 1 without a signature by one of them",
    )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let (Some(folder), Some(key)) = (matches.get_one::<PathBuf>("folder"), matches.get_one::<PathBuf>("key")) else {
        return Ok(());
    };
    let changed: Vec<String> = if is_recording(folder)? {
        record::open(folder)?;
        record::changes(folder)?.iter().map(ToString::to_string).collect()
    } else {
        let (contents, changed) = analyse::compared(folder)?;
        not_covered(&contents)?.map_or(Ok(()), |parts| {
            Err(CliError::Failed(format!(
                "{}: not signed, because {} does not list {parts}, which an analysis uses\n  remedy: end the session, or \
                 exclude or erase the participant, and sign then",
                folder.display(),
                checksums::FILE
            )))
        })?;
        changed.iter().map(ToString::to_string).collect()
    };
    if !changed.is_empty() {
        let found = changed.join("\n  ");
        return Err(CliError::Failed(format!(
            "{}: not signed, because files were changed after they were written\n  {found}",
            folder.display()
        )));
    }
    let file = signed_file(folder)?;
    let signature = signing::sign(key, &read(&file)?)?;
    let beside = beside(&file);
    record::replace(&beside, signature.as_bytes())?;
    out::line(format_args!("{}: signed; {} holds the signature", folder.display(), beside.display()))?;
    Ok(())
}

fn is_recording(folder: &Path) -> Result<bool, RecordError> {
    is_there(&folder.join(manifest::FILE))
}

/// Returns the path of the file to sign in a folder.
fn signed_file(folder: &Path) -> Result<PathBuf, RecordError> {
    Ok(folder.join(if is_recording(folder)? { manifest::FILE } else { checksums::FILE }))
}

/// Checks whether a signature lies beside the file to sign.
fn is_signed(folder: &Path) -> Result<bool, RecordError> {
    is_there(&beside(&signed_file(folder)?))
}

fn beside(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(format!(".{SIGNATURE}"));
    name.into()
}

fn read(path: &Path) -> Result<Vec<u8>, CliError> {
    read_bounded(path, MOST_BYTES).map_err(|why| CliError::Failed(format!("{}: {why}", path.display())))
}

/// Returns the parts of a data set that an analysis uses although no signature covers them; `None` if there are none.
fn not_covered(contents: &FolderContents) -> Result<Option<String>, CliError> {
    let Some(root) = &contents.root else { return Ok(None) };
    let parts: Vec<String> = checksums::open_parts(root).map_err(RunError::from)?.into_iter().collect();
    Ok((!parts.is_empty()).then(|| joined_with_and(&parts)))
}

/// Returns a line on the signature of what is analysed: the signer, or that no signature was checked. `None` if no signer is asked for and
/// parts were changed.
///
/// # Errors
/// No listed signer has signed all that the analysis uses.
pub(super) fn of_analysis(
    contents: &FolderContents,
    is_changed: bool,
    matches: &ArgMatches,
) -> Result<Option<String>, CliError> {
    let folder = contents.folder();
    let Some(list) = matches.get_one::<PathBuf>("signer") else {
        return if is_changed { Ok(None) } else { signature(folder, matches).map(Some) };
    };
    let list = SignerList::load(list)?;
    let signer = signer(folder, &list)?;
    let not_authentic = |why: String| Err(CliError::Failed(format!("{}: not authentic: {why}", folder.display())));
    if let Some(parts) = not_covered(contents)? {
        return not_authentic(format!(
            "the signature of {signer} does not cover {parts}\n  remedy: remove what does not belong to the data set, or let \
             {} sign again",
            signer.name
        ));
    }
    // The drive without advice beside a recording alone is analysed, too.
    let alone = contents.found.iter().filter(|_| contents.root.is_none());
    for baseline in alone.filter_map(|drive| drive.baseline.as_ref()) {
        if let Err(why) = self::signer(baseline, &list) {
            return not_authentic(format!("the baseline beside it is analysed, too: {why}"));
        }
    }
    let own_plan = if matches.contains_id("study") { "; the plan of --study is not part of it" } else { "" };
    Ok(Some(if is_changed {
        format!("not authentic: {signer} signed other files than these (named above)")
    } else {
        format!("authentic: signed by {signer}{own_plan}")
    }))
}

/// Returns a line on the signature of a folder whose files agree with their checksums: the signer, or that no signature was
/// checked.
pub(super) fn signature(folder: &Path, matches: &ArgMatches) -> Result<String, CliError> {
    let Some(list) = matches.get_one::<PathBuf>("signer") else {
        let signed = is_signed(folder)?;
        let how = if signed { "--signer FILE checks the signature" } else { "codrive sign --help" };
        return Ok(format!("consistent, not authentic: a person who changes a file can write a new checksum ({how})"));
    };
    Ok(format!("authentic: signed by {}", signer(folder, &SignerList::load(list)?)?))
}

/// Finds the listed signer of a folder, or of the data set around a recording.
fn signer(folder: &Path, list: &SignerList) -> Result<Signer, CliError> {
    let file = signed_file(folder)?;
    let signature = beside(&file);
    if is_there(&signature)? {
        let text = read(&signature)?;
        return Ok(list.verify(&file.display().to_string(), &read(&file)?, &String::from_utf8_lossy(&text))?);
    }
    let is_recording = is_recording(folder)?;
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
    let mut data_set = None;
    for root in whole.ancestors().skip(1).filter(|_| is_recording) {
        if is_signed(root)? {
            data_set = Some(root);
            break;
        }
    }
    let Some(root) = data_set else {
        let text = format!(
            "{}: not signed: there is no {}\n  remedy: sign it with codrive sign",
            folder.display(),
            signature.display()
        );
        return Err(CliError::Failed(text));
    };
    let signer = signer(root, list)?;
    if checksums::lists(root, &whole.join(manifest::FILE)).map_err(RunError::from)? {
        return Ok(signer);
    }
    let text = format!(
        "{}: {signer} signed the data set with another version of this recording, or without it",
        folder.display()
    );
    Err(CliError::Failed(text))
}

impl From<SigningError> for CliError {
    fn from(error: SigningError) -> Self {
        match error {
            SigningError::File { .. } | SigningError::Key { .. } | SigningError::Signers { .. } => {
                Self::Input(error.to_string())
            }
            SigningError::NotSigned(_) => Self::Failed(error.to_string()),
        }
    }
}
