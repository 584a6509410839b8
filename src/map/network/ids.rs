//! Names of a network's parts within the program: indices, which cost nothing to keep and to compare. In and out: plain numbers.
//! What SUMO calls a part stands in the part itself (`id`), for tables and messages.

macro_rules! index_types {
    ($($(#[$meta:meta])* $name:ident),* $(,)?) => {
        $(
            $(#[$meta])*
            #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
            pub struct $name(u32);

            impl $name {
                /// Its place in the network's list.
                pub fn index(self) -> usize {
                    self.0 as usize
                }

                /// The part at a place in the network's list.
                ///
                /// # Panics
                /// Beyond `u32::MAX`; the limits of a network's file lie far below.
                pub fn from_index(index: usize) -> Self {
                    Self(u32::try_from(index).expect("a network has fewer parts than u32 counts"))
                }
            }
        )*
    };
}

index_types! {
    /// An edge: lanes side by side in one direction.
    EdgeId,
    /// A lane, also one inside a junction, a crossing or a walking area.
    LaneId,
    /// A junction.
    JunctionId,
    /// A signal.
    SignalId,
    /// A connection from a lane to a lane.
    ConnectionId,
}
