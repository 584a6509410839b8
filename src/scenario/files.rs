//! Files that a drive reads. In: a [`Scenario`]. Out: the files by the setting that names them. Fingerprints of runs and of studies take the
//! contents of all of them.

use super::Scenario;
use crate::{
    map::{MapError, RoadMap},
    policy,
    traffic::is_population_path,
};
use std::path::{Path, PathBuf};

/// Setting that names files, and the files.
pub type NamedFiles = (&'static str, Vec<PathBuf>);

impl Scenario {
    /// Returns the files that a drive with these settings reads, by the path of the setting that names them: map, policy, log of the
    /// traffic, population of its drivers, and demand. Files of what is shipped are among them, except those of built-in controllers.
    ///
    /// # Errors
    /// There is no such map.
    pub fn files(&self) -> Result<Vec<NamedFiles>, MapError> {
        let population = Some(Path::new(&self.traffic_drivers)).filter(|_| is_population_path(&self.traffic_drivers));
        let one = |file: &Path| vec![file.to_owned()];
        let files = [
            ("map", RoadMap::files(&self.map)?),
            ("policy", policy::file_of(&self.policy).map(|file| policy::files_of(&file)).unwrap_or_default()),
            ("traffic", self.traffic.log_file().map(one).unwrap_or_default()),
            ("traffic_drivers", population.map(one).unwrap_or_default()),
            ("demand.files", self.demand.files.clone()),
            ("demand.additional_files", self.demand.additional_files.clone()),
        ];
        Ok(files.into_iter().filter(|(_, files)| !files.is_empty()).collect())
    }
}
