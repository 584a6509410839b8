//! The files that SUMO in this process reads: canonical copies of network and demand in a private folder. In: a network, a demand. Out: paths
//! for SUMO's options, and one warning for what a file has and SUMO is not given. Nobody else's file ever reaches SUMO.

use crate::{
    map::network::Network,
    sumo_xml::Dropped,
    temporary::TemporaryFolder,
    traffic::{CanonicalDemand, Demand, DemandFault, TrafficError},
};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

/// The files of one simulation, removed when it ends.
pub(super) struct Inputs {
    folder: TemporaryFolder,
    net: PathBuf,
    demand: CanonicalDemand,
}

impl Inputs {
    /// Writes the network, which `net_file` names in messages.
    ///
    /// # Errors
    /// The system refuses.
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
    /// A file is refused, the demand brings too many vehicles, or the system refuses.
    pub fn with_demand(mut self, demand: &Demand, network: &Network, until_s: f64) -> Result<Self, TrafficError> {
        self.demand = demand.canonical(network, until_s, self.folder.path()).map_err(|fault| match fault {
            DemandFault::Interrupted => TrafficError::Interrupted,
            other => TrafficError::Setup(other.to_string()),
        })?;
        self.demand.dropped.iter().for_each(|(file, dropped)| warn_of(file, dropped));
        Ok(self)
    }

    /// The network.
    pub fn net(&self) -> &Path {
        &self.net
    }

    /// The demand.
    pub fn demand(&self) -> &CanonicalDemand {
        &self.demand
    }

    /// A demand with the copies in the place of its files.
    pub fn demand_of(&self, demand: &Demand) -> Demand {
        Demand { files: self.demand.files.clone(), flows: demand.flows.clone() }
    }
}

/// Says once what of a file SUMO is not given.
fn warn_of(file: &Path, dropped: &Dropped) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    if dropped.is_empty() {
        return;
    }
    let text = format!("{}: SUMO is not given {dropped}: codrive knows no use for it", file.display());
    if SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(text.clone()) {
        log::warn!("{text}");
    }
}
