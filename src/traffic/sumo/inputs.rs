//! Input files of SUMO in this process: canonical copies of network and demand in a private folder. In: a network, a demand. Out: paths for
//! SUMO's options, and one warning for the parts of a file that SUMO does not get. SUMO reads no file of anyone else.

use crate::{
    map::network::Network,
    sumo_xml::{Dropped, stream::LeftOut},
    temporary::TemporaryFolder,
    traffic::{CanonicalDemand, Demand, DemandFault, TrafficError},
};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

/// Input files of one simulation, removed when it ends.
pub(super) struct Inputs {
    folder: TemporaryFolder,
    net: PathBuf,
    demand: CanonicalDemand,
}

impl Inputs {
    /// Writes the network. `net_file` is its name in messages.
    ///
    /// # Errors
    /// The files cannot be written.
    pub fn of_network(network: &Network, net_file: &Path) -> Result<Self, TrafficError> {
        let text = network.sumo_text().as_str().as_bytes();
        let written = TemporaryFolder::new().and_then(|folder| Ok((folder.write("net.xml", text)?, folder)));
        let (net, folder) =
            written.map_err(|error| TrafficError::Setup(format!("the files for SUMO cannot be written: {error}")))?;
        warn_of(net_file, network.sumo_text().dropped());
        Ok(Self { folder, net, demand: CanonicalDemand::default() })
    }

    /// Writes the files of a demand beside the network. Its vehicles are counted until a time, s.
    ///
    /// # Errors
    /// A file is refused or cannot be written, the demand brings too many vehicles, or the program was interrupted.
    pub fn with_demand(mut self, demand: &Demand, network: &Network, until_s: f64) -> Result<Self, TrafficError> {
        self.demand = demand.canonical(network, until_s, self.folder.path()).map_err(|fault| match fault {
            DemandFault::Interrupted => TrafficError::Interrupted,
            other => TrafficError::Setup(other.to_string()),
        })?;
        self.demand.dropped.iter().for_each(|(file, dropped)| warn_of(file, dropped));
        for (file, LeftOut { count, first }) in &self.demand.left_out {
            warn_once(format!("{}: left out for a fault: {count}; the first: {first}", file.display()));
        }
        Ok(self)
    }

    pub fn net(&self) -> &Path {
        &self.net
    }

    pub fn demand(&self) -> &CanonicalDemand {
        &self.demand
    }
}

/// Warns once about the parts of a file that SUMO does not get.
fn warn_of(file: &Path, dropped: &Dropped) {
    if !dropped.is_empty() {
        warn_once(format!("{}: not passed to SUMO, because codrive does not use it: {dropped}", file.display()));
    }
}

/// Logs a warning if it is the first with this text.
fn warn_once(text: String) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    if SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(text.clone()) {
        log::warn!("{text}");
    }
}
