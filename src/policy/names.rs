//! Names of policies. In: a name as the user gave it, and the map. Out: the policy that it stands for, or its file.

use crate::{
    data_folders,
    map::{self, RoadMap},
};
use std::path::PathBuf;

/// Names that [`build`](super::build) knows: the first gives no advice, the others are the names of [`CONTROLLERS`](super::CONTROLLERS).
pub const NAMES: [&str; 6] = ["none", "constant", "two-phase", "follower-stopper", "pi", "linear-feedback"];

/// Name that stands for the shipped speed policy of the map, or for two-phase advice if there is none.
pub const AUTO: &str = "auto";

/// Returns the sorted names of the policies in `assets/policies`.
pub fn shipped() -> Vec<String> {
    let folders = std::fs::read_dir(data_folders::root().join(SHIPPED)).into_iter().flatten().flatten();
    let whole = folders.filter(|folder| folder.path().join("policy.toml").exists());
    let mut names: Vec<String> = whole.map(|folder| folder.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Returns all names: [`AUTO`], [`NAMES`] and the shipped policies.
pub(super) fn all_names() -> Vec<String> {
    std::iter::once(AUTO).chain(NAMES).map(str::to_owned).chain(shipped()).collect()
}

/// Returns the names of everything that can be corrected: controllers and shipped policies.
pub(super) fn correctable_names() -> Vec<String> {
    NAMES[1..].iter().map(|name| (*name).to_owned()).chain(shipped()).collect()
}

/// Folder of the shipped policies, relative to the project's root.
const SHIPPED: &str = "assets/policies";

/// A policy's name after [`AUTO`] has been resolved, with the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResolvedPolicy {
    /// Name of the policy, or path of its file.
    pub name: String,
    /// Reason for the choice; `None` unless [`AUTO`] was resolved.
    pub why: Option<String>,
}

impl ResolvedPolicy {
    /// Returns false for `none`.
    pub fn gives_advice(&self) -> bool {
        self.name != NAMES[0]
    }
}

impl std::fmt::Display for ResolvedPolicy {
    /// Writes the name for display, with the reason in brackets if there is one.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.why {
            Some(why) => write!(f, "{} ({why})", self.name),
            None => f.write_str(&self.name),
        }
    }
}

/// Resolves a policy name for a map: [`AUTO`] to a shipped policy or two-phase, any other name to itself. A shipped map is recognised by
/// name, by path and as a copy.
pub fn resolve(name: &str, map: &RoadMap) -> ResolvedPolicy {
    resolve_among(&shipped(), name, map)
}

/// Resolves a policy name with `shipped` as the list of shipped policies.
fn resolve_among(shipped: &[String], name: &str, map: &RoadMap) -> ResolvedPolicy {
    if name != AUTO {
        return ResolvedPolicy { name: name.into(), why: None };
    }
    let road = map::known_as(map);
    let own = road.as_deref().map(|road| format!("{road}-speed")).filter(|own| shipped.contains(own));
    let why = match (&own, &road) {
        (Some(_), Some(road)) => format!("{AUTO}: the policy that is shipped for {road}"),
        _ if shipped.is_empty() => {
            format!("{AUTO}: no shipped policies at {}", data_folders::root().join(SHIPPED).display())
        }
        _ => format!("{AUTO}: no policy is shipped for {}", map.name),
    };
    ResolvedPolicy { name: own.unwrap_or_else(|| "two-phase".into()), why: Some(why) }
}

/// Returns true if the name is the path of a policy file.
pub fn is_path(name: &str) -> bool {
    name.ends_with(".onnx") || name.ends_with(".toml")
}

/// Returns the policy file of a name: the path itself, or the file of a shipped policy.
pub fn file_of(name: &str) -> Option<PathBuf> {
    if is_path(name) {
        return Some(name.into());
    }
    shipped().iter().any(|own| own == name).then(|| data_folders::root().join(SHIPPED).join(name).join("policy.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{PolicySettings, build};

    #[test]
    fn auto_is_the_shipped_speed_policy_of_the_map_and_two_phase_elsewhere() {
        let on = |policy: &str, map: &str| resolve(policy, &RoadMap::load(map).unwrap());
        assert_eq!(
            on("auto", "ring-250").to_string(),
            "ring-250-speed (auto: the policy that is shipped for ring-250)"
        );
        assert_eq!(on("auto", "ring-641").name, "ring-641-speed");
        assert_eq!(on("auto", "practice").to_string(), "two-phase (auto: no policy is shipped for practice)");
        assert_eq!(on("pi", "ring-250").to_string(), "pi");
        // The same ring, given by path and as a copy with another name.
        let net = data_folders::root().join("maps/ring-250/net.xml");
        assert_eq!(on("auto", &net.to_string_lossy()).name, "ring-250-speed");
        assert_eq!(on("auto", &net.parent().unwrap().to_string_lossy()).name, "ring-250-speed");
        let folder = tempfile::tempdir().unwrap();
        let copy = folder.path().join("other.net.xml");
        std::fs::copy(&net, &copy).unwrap();
        assert_eq!(on("auto", &copy.to_string_lossy()).name, "ring-250-speed");
        // A different road with the name of a shipped map does not count as that map.
        let other = folder.path().join("ring-250");
        std::fs::create_dir(&other).unwrap();
        std::fs::copy(data_folders::root().join("maps/ring-641/net.xml"), other.join("net.xml")).unwrap();
        assert_eq!(on("auto", &other.to_string_lossy()).name, "ring-641-speed");
        let text = std::fs::read_to_string(&net).unwrap().replace("speed=\"30.000000\"", "speed=\"20.000000\"");
        std::fs::write(other.join("net.xml"), text).unwrap();
        assert_eq!(
            on("auto", &other.to_string_lossy()).to_string(),
            "two-phase (auto: no policy is shipped for ring-250)"
        );
        let none = resolve_among(&[], "auto", &RoadMap::load("ring-250").unwrap());
        assert!(none.to_string().starts_with("two-phase (auto: no shipped policies at "), "{none:?}");
        let settings = PolicySettings { aim_mps: 0.0, equilibrium_mps: 4.362, step_s: 0.1 };
        for name in shipped() {
            assert!(file_of(&name).is_some_and(|file| file.exists()));
            assert!(build(&name, &settings).is_ok_and(|policy| policy.is_some()), "{name}");
        }
    }
}
