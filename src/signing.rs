//! Signatures of files by a key of the lab, in OpenSSH's format (SSHSIG, `ssh-keygen -Y`). In: a private key or a list of
//! signers, and the bytes of a file. Out: a signature, or the name of the signer. Keys are Ed25519 without a passphrase. Other
//! keys sign with `ssh-keygen -Y sign -f KEY -n codrive FILE`, in the same format.

use crate::file::{SETTINGS_BYTES, read_text};
use ssh_key::{Algorithm, HashAlg, LineEnding, PrivateKey, PublicKey, SshSig};
use std::{
    fmt,
    path::{Path, PathBuf},
};

/// Namespace of the signatures: a signature made for another purpose, such as a mail, is refused.
pub const NAMESPACE: &str = "codrive";

/// Reason why something was not signed, or a signature was not accepted.
#[derive(Debug, thiserror::Error)]
pub enum SigningError {
    /// File that cannot be read.
    #[error("{path}: {why}")]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        why: std::io::Error,
    },
    /// Private key that cannot be used.
    #[error("{path}: {why}\n  remedy: make a key with ssh-keygen -t ed25519 -N '' -f lab-key, or sign with {tool}")]
    Key {
        /// Path of the file.
        path: PathBuf,
        /// Description of the fault.
        why: String,
        /// Command that signs with other keys.
        tool: String,
    },
    /// List of signers that cannot be used.
    #[error(
        "{path}{line}: {why}; allowed: a line NAME ssh-ed25519 KEY for each signer, in the format of ssh-keygen -Y, or \
         a public key (.pub)"
    )]
    Signers {
        /// Path of the file.
        path: PathBuf,
        /// Position such as `, line 3`; empty if no line is at fault.
        line: String,
        /// Description of the fault.
        why: String,
    },
    /// Signature that is not of these bytes by one of these signers.
    #[error("{0}")]
    NotSigned(String),
}

/// Person or lab that has signed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signer {
    /// Name in the list of signers.
    pub name: String,
    /// Fingerprint of the key, as `ssh-keygen -l` prints it.
    pub fingerprint: String,
}

impl fmt::Display for Signer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.name, self.fingerprint)
    }
}

/// Keys that may sign, with the names of their owners.
#[derive(Clone, Debug)]
pub struct SignerList {
    path: PathBuf,
    signers: Vec<(String, PublicKey)>,
}

fn read(path: &Path) -> Result<String, SigningError> {
    read_text(path, SETTINGS_BYTES).map_err(|why| SigningError::File { path: path.into(), why })
}

/// Signs bytes with the private key in a file. Returns the signature as text, for a file.
///
/// # Errors
/// The key cannot be read, has a passphrase or is of another kind.
pub fn sign(key: &Path, bytes: &[u8]) -> Result<String, SigningError> {
    let tool = format!("ssh-keygen -Y sign -f {} -n {NAMESPACE} FILE", key.display());
    let fault = |why: String| SigningError::Key { path: key.into(), why, tool: tool.clone() };
    let private = PrivateKey::from_openssh(read(key)?).map_err(|why| {
        fault(format!("not a readable private key ({why}); allowed: Ed25519 in OpenSSH's format, without a passphrase"))
    })?;
    if private.is_encrypted() {
        return Err(fault("has a passphrase; allowed: a key without a passphrase".into()));
    }
    if private.algorithm() != Algorithm::Ed25519 {
        return Err(fault(format!("is of kind {}; allowed: ssh-ed25519", private.algorithm())));
    }
    let signature = private.sign(NAMESPACE, HashAlg::Sha512, bytes).map_err(|why| fault(why.to_string()))?;
    signature.to_pem(LineEnding::LF).map_err(|why| fault(why.to_string()))
}

impl SignerList {
    /// Reads a list of signers, or a public key, whose comment then is the name.
    ///
    /// # Errors
    /// The list cannot be read, has an invalid line, or has no signer.
    pub fn load(path: &Path) -> Result<Self, SigningError> {
        let mut signers = Vec::new();
        for (i, line) in read(path)?.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            signers.push(signer(line).map_err(|why| {
                let line = format!(", line {}", i + 1);
                SigningError::Signers { path: path.into(), line, why }
            })?);
        }
        if signers.is_empty() {
            return Err(SigningError::Signers {
                path: path.into(),
                line: String::new(),
                why: "it names no signer".into(),
            });
        }
        Ok(Self { path: path.into(), signers })
    }

    /// Returns the listed signer of these bytes; `name` names the signed file in messages.
    ///
    /// # Errors
    /// The text is no signature of these bytes, or one by a key that is not on the list.
    pub fn verify(&self, name: &str, bytes: &[u8], text: &str) -> Result<Signer, SigningError> {
        let fault = |why: String| SigningError::NotSigned(format!("{name}: {why}"));
        let signature = SshSig::from_pem(text).map_err(|why| fault(format!("its signature cannot be read: {why}")))?;
        // The parser accepts inconsistent lengths; OpenSSH writes one form only, which is required here.
        let letters = |text: &str| text.split_whitespace().collect::<String>();
        if signature.to_pem(LineEnding::LF).map(|text| letters(&text)) != Ok(letters(text)) {
            return Err(fault("its signature is not in OpenSSH's format".into()));
        }
        if signature.namespace() != NAMESPACE {
            let (is, allowed) = (signature.namespace(), NAMESPACE);
            return Err(fault(format!(
                "its signature was made for {is:?}; allowed: {allowed:?} (ssh-keygen -Y sign -n {allowed})"
            )));
        }
        let fingerprint = signature.public_key().fingerprint(HashAlg::Sha256).to_string();
        let signer = self.signers.iter().find(|(_, key)| key.key_data() == signature.public_key());
        let Some((signer, key)) = signer else {
            let list = self.path.display();
            return Err(fault(format!("it is signed by the key {fingerprint}, which is not in {list}")));
        };
        key.verify(NAMESPACE, bytes, &signature).map_err(|_| {
            fault(format!("the signature does not match: the file was changed after {signer} signed it"))
        })?;
        Ok(Signer { name: signer.clone(), fingerprint })
    }
}

/// Parses a line of a list: `NAME [namespaces="codrive"] ssh-ed25519 KEY [comment]`, or a public key with its comment.
fn signer(line: &str) -> Result<(String, PublicKey), String> {
    let kind = Algorithm::Ed25519.to_string();
    let at = line.find(&kind).ok_or("there is no key of kind ssh-ed25519")?;
    let key = PublicKey::from_openssh(&line[at..]).map_err(|why| format!("the key cannot be read: {why}"))?;
    let mut words = line[..at].split_whitespace();
    let Some(name) = words.next() else {
        let comment = key.comment().trim();
        return if comment.is_empty() {
            Err("the key has no comment that names its owner".into())
        } else {
            Ok((comment.into(), key))
        };
    };
    for option in words {
        let namespaces = option.strip_prefix("namespaces=").map(|list| list.trim_matches('"'));
        if !namespaces.is_some_and(|list| list.split(',').any(|namespace| namespace == NAMESPACE)) {
            return Err(format!("the option {option} is not known; allowed: namespaces=\"{NAMESPACE}\""));
        }
    }
    Ok((name.into(), key))
}

#[cfg(test)]
mod tests;
