//! Side of the road on which traffic drives, as files and users name it: left or right.

/// Side of the road on which traffic drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrivingSide {
    Left,
    Right,
}

impl DrivingSide {
    /// Returns the name on the command line: `left` or `right`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}
