//! Indices of a network's parts within the program, cheap to store and to compare. In and out: plain numbers. Each part also has its SUMO
//! id (`id`), for tables and messages.

macro_rules! index_types {
    ($($(#[$meta:meta])* $name:ident),* $(,)?) => {
        $(
            $(#[$meta])*
            #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
            pub struct $name(u32);

            impl $name {
                /// Returns the index in the network's list.
                pub fn index(self) -> usize {
                    self.0 as usize
                }

                /// Converts an index in the network's list.
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
    /// Index of an edge: lanes side by side in one direction.
    EdgeId,
    /// Index of a lane; internal lanes, crossings and walking areas have one too.
    LaneId,
    /// Index of a junction in the network.
    JunctionId,
    /// Index of a signal in the network.
    SignalId,
    /// Index of a connection from a lane to a lane.
    ConnectionId,
}
