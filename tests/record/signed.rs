//! A signature needs the lab's key: `codrive sign`, and `--signer` of replay and analyse.

use super::{
    codrive, printed, record,
    resealing::{copy, reseal},
};
use std::{fs, path::Path, process::Command};

fn key(name: &str) -> String {
    format!("{}/tests/data/signing/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_signed_recording_is_authentic_until_anything_of_it_changes() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("p1");
    record(&drive, "1");
    let path = drive.to_str().unwrap();
    let (lab, signers, other) = (key("lab-key"), key("lab-key.pub"), key("other-key.pub"));
    let (code, text) = printed(&mut codrive(&["replay", path]));
    assert!(code == 0 && text.contains("consistent, not authentic") && !text.contains("authentic: signed"), "{text}");
    let (code, text) = printed(&mut codrive(&["replay", path, "--signer", &signers]));
    assert!(code == 1 && text.contains("not signed: there is no") && text.contains("codrive sign"), "{text}");
    let (code, text) = printed(&mut codrive(&["sign", path, "--key", &lab]));
    assert!(code == 0 && text.contains("manifest.json.sig"), "{text}");
    let (code, text) = printed(&mut codrive(&["replay", path, "--signer", &signers]));
    assert!(code == 0 && text.contains("authentic: signed by lab@example.org (SHA256:"), "{text}");
    let (code, text) = printed(&mut codrive(&["analyse", path, "--signer", &signers]));
    assert!(code == 0 && text.starts_with("authentic: signed by lab@example.org"), "{text}");
    let page = || fs::read_to_string(drive.join("analysis/report.html")).unwrap();
    assert!(page().contains("Files: authentic: signed by lab@example.org (SHA256:"), "the report says who signed");
    assert_eq!(printed(&mut codrive(&["analyse", path])).0, 0);
    assert!(page().contains("Files: consistent, not authentic") && !page().contains("authentic: signed"), "no key");
    let (code, text) = printed(&mut codrive(&["replay", path, "--signer", &other]));
    assert!(code == 1 && text.contains("which is not in"), "{text}");

    // All checksums are recomputed after a change of a fact that no drive can prove.
    let forged = folder.path().join("forged");
    copy(&drive, &forged);
    let manifest = fs::read_to_string(forged.join("manifest.json")).unwrap();
    fs::write(forged.join("manifest.json"), manifest.replacen("\"graphics\": null", "\"graphics\": \"other\"", 1))
        .unwrap();
    let signature = fs::read(forged.join("manifest.json.sig")).unwrap();
    fs::remove_file(forged.join("manifest.json.sig")).unwrap();
    reseal(&forged);
    let forged_path = forged.to_str().unwrap();
    assert_eq!(printed(&mut codrive(&["replay", forged_path])).0, 0);
    fs::write(forged.join("manifest.json.sig"), signature).unwrap();
    for command in ["replay", "analyse"] {
        let (code, text) = printed(&mut codrive(&[command, forged_path, "--signer", &signers]));
        assert!(code == 1 && text.contains("was changed after lab@example.org signed it"), "{command}: {text}");
    }
    // A recording that is not as written is not signed.
    fs::write(drive.join("summary.json"), "{}").unwrap();
    let (code, text) = printed(&mut codrive(&["sign", path, "--key", &lab]));
    assert!(code == 1 && text.contains("not signed") && text.contains("summary.json: "), "{text}");
}

#[test]
fn a_baseline_beside_a_signed_recording_is_signed_too_or_not_authentic() {
    let folder = tempfile::tempdir().unwrap();
    let [drive, baseline] = ["p1", "p1-baseline"].map(|name| folder.path().join(name));
    record(&drive, "1");
    let (path, signers) = (drive.to_str().unwrap(), key("lab-key.pub"));
    let sign = |path: &Path| {
        assert_eq!(printed(&mut codrive(&["sign", path.to_str().unwrap(), "--key", &key("lab-key")])).0, 0)
    };
    sign(&drive);
    record(&baseline, "1");
    let (code, text) = printed(&mut codrive(&["analyse", path, "--signer", &signers]));
    assert!(code == 1 && text.contains("not authentic: the baseline beside it is analysed, too: "), "{text}");
    assert!(text.contains("p1-baseline: not signed") && !text.contains("authentic: signed"), "{text}");
    sign(&baseline);
    let (code, text) = printed(&mut codrive(&["analyse", path, "--signer", &signers]));
    assert!(code == 0 && text.starts_with("authentic: signed by lab@example.org"), "{text}");
}

#[test]
fn an_analysis_is_not_written_through_a_link_of_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let [drive, mine, disk] = ["rec", "mine", "disk"].map(|name| folder.path().join(name));
    record(&drive, "3");
    [&mine, &disk].iter().for_each(|path| fs::create_dir(path).unwrap());
    let files = ["report.html", "trials.csv", "events.svg"];
    files.iter().for_each(|name| fs::write(mine.join(name), "mine").unwrap());
    let own = drive.join("analysis");
    let refused = |arguments: &[&str], link: &Path| {
        let (code, text) = printed(&mut codrive(&[&["analyse", drive.to_str().unwrap()], arguments].concat()));
        assert!(code != 0 && text.contains(&format!("{} is a symbolic link", link.display())), "{text}");
        assert!(text.contains("remedy: remove the link"), "{text}");
        assert!(fs::read_dir(&mine).unwrap().count() == 3, "nothing is added");
        assert!(files.iter().all(|name| fs::read(mine.join(name)).unwrap() == b"mine"), "nothing is overwritten");
    };
    std::os::unix::fs::symlink("../mine", &own).unwrap();
    refused(&[], &own);
    refused(&["--out", own.to_str().unwrap()], &own);
    refused(&["--out", own.join("inner").to_str().unwrap()], &own);
    fs::remove_file(&own).unwrap();
    fs::create_dir(&own).unwrap();
    std::os::unix::fs::symlink(&mine, own.join("figures")).unwrap();
    refused(&[], &own.join("figures"));
    // A link that the user names lies outside of the recording, and is followed.
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&disk, &link).unwrap();
    assert_eq!(printed(&mut codrive(&["analyse", drive.to_str().unwrap(), "--out", link.to_str().unwrap()])).0, 0);
    assert!(disk.join("report.html").is_file() && disk.join("figures").is_dir());
}

#[test]
fn ssh_keygen_accepts_the_signature_of_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("p1");
    record(&drive, "1");
    assert_eq!(printed(&mut codrive(&["sign", drive.to_str().unwrap(), "--key", &key("lab-key")])).0, 0);
    verified_by_openssh(&drive.join("manifest.json"));
}

/// Verifies a signature with OpenSSH's ssh-keygen, which scripts/test-setup asks for.
fn verified_by_openssh(file: &Path) {
    let arguments = ["-Y", "verify", "-f", &key("allowed_signers"), "-I", "lab", "-n", "codrive", "-s"];
    let mut command = Command::new("ssh-keygen");
    command.args(arguments).arg(format!("{}.sig", file.display())).stdin(fs::File::open(file).unwrap());
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&[done.stdout, done.stderr].concat()));
}
