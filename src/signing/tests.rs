//! Tests of signatures against OpenSSH's own tool, which made the files in `tests/data/signing`.

use super::*;
use std::fs;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/signing").join(name)
}

fn text(name: &str) -> String {
    fs::read_to_string(data(name)).expect("there")
}

fn list(lines: &str) -> Result<SignerList, SigningError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("signers");
    fs::write(&path, lines).expect("written");
    SignerList::load(&path)
}

/// Fingerprint as printed by `ssh-keygen -l -f lab-key.pub`.
const FINGERPRINT: &str = "SHA256:vRV0BeQlkER/YP83Y2XcSuIJI6nzl0ll3N0ndaZpBss";

#[test]
fn a_signature_equals_that_of_ssh_keygen_to_the_byte() {
    // Ed25519 is deterministic (RFC 8032): the same key and bytes give the same signature.
    assert_eq!(sign(&data("lab-key"), b"abc").expect("signed"), text("abc.txt.sig"));
}

#[test]
fn a_signature_of_ssh_keygen_is_accepted_with_the_signers_name() {
    for (signers, name) in [("allowed_signers", "lab"), ("lab-key.pub", "lab@example.org")] {
        let signers = SignerList::load(&data(signers)).expect("a list");
        let signer = signers.verify("abc.txt", b"abc", &text("abc.txt.sig")).expect("authentic");
        assert_eq!(signer, Signer { name: name.into(), fingerprint: FINGERPRINT.into() });
        assert_eq!(signer.to_string(), format!("{name} ({FINGERPRINT})"));
    }
}

#[test]
fn a_signature_of_other_bytes_key_or_purpose_is_refused() {
    let lab = SignerList::load(&data("allowed_signers")).expect("a list");
    let refused = |signers: &SignerList, bytes: &[u8], signature: &str| {
        signers.verify("p1/manifest.json", bytes, signature).expect_err("not authentic").to_string()
    };
    let good = text("abc.txt.sig");
    let why = refused(&lab, b"abd", &good);
    assert!(
        why.contains("p1/manifest.json: the signature does not match: the file was changed after lab signed it"),
        "{why}"
    );
    let other = SignerList::load(&data("other-key.pub")).expect("a list");
    let why = refused(&other, b"abc", &good);
    assert!(why.contains(FINGERPRINT) && why.contains("which is not in") && why.contains("other-key.pub"), "{why}");
    let why = refused(&lab, b"abc", &text("mail.txt.sig"));
    assert!(why.contains("made for \"file\"; allowed: \"codrive\""), "{why}");
    let why = refused(&lab, b"abc", "no signature");
    assert!(why.contains("cannot be read"), "{why}");
    // A change of any single byte of the signature must be detected.
    let line = good.lines().nth(2).expect("three lines");
    for at in 0..line.len() {
        let mut changed = line.to_owned().into_bytes();
        changed[at] = if changed[at] == b'A' { b'B' } else { b'A' };
        let changed = good.replace(line, &String::from_utf8(changed).expect("letters"));
        refused(&lab, b"abc", &changed);
    }
}

#[test]
fn a_key_that_cannot_sign_here_is_reported_with_a_tool_that_can() {
    for (key, why) in [
        ("locked-key", "has a passphrase"),
        ("ecdsa-key", "not a readable private key"),
        ("lab-key.pub", "not a readable private key"),
    ] {
        let message = sign(&data(key), b"abc").expect_err("not usable").to_string();
        assert!(message.contains(key) && message.contains(why), "{message}");
        assert!(message.contains("ssh-keygen -Y sign -f ") && message.contains(" -n codrive FILE"), "{message}");
    }
    let message = sign(&data("none"), b"abc").expect_err("no file").to_string();
    assert!(message.contains("signing/none: "), "{message}");
}

#[test]
fn a_list_of_signers_is_read_by_line_and_errors_name_the_line() {
    let key = text("lab-key.pub");
    let key = key.rsplit_once(' ').expect("a comment").0;
    let names = |lines: &str| -> Vec<String> {
        list(lines).expect("a list").signers.into_iter().map(|(name, _)| name).collect()
    };
    assert_eq!(
        names(&format!("# the lab\n\nann,ben {key} at work\neve namespaces=\"file,codrive\" {key}\n")),
        ["ann,ben", "eve"]
    );
    let refused = |lines: &str| list(lines).expect_err("no list").to_string();
    for (lines, why) in [
        (String::new(), "signers: it names no signer"),
        (
            format!("# one\nann namespaces=\"file\" {key}\n"),
            "signers, line 2: the option namespaces=\"file\" is not known",
        ),
        (format!("ann cert-authority {key}\n"), "line 1: the option cert-authority is not known"),
        ("ann ssh-rsa AAAA\n".into(), "line 1: there is no key of kind ssh-ed25519"),
        ("ann ssh-ed25519 AAAA\n".into(), "line 1: the key cannot be read"),
        (key.into(), "line 1: the key has no comment that names its owner"),
    ] {
        let message = refused(&lines);
        assert!(message.contains(why) && message.contains("allowed: a line NAME ssh-ed25519 KEY"), "{message}");
    }
}
