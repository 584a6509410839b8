//! Picture of the secondary task at a tick. In: nothing. Out: a [`TaskDisplay`], which the screen shows and the driver sees.

/// Secondary task as the driver sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TaskDisplay {
    /// Number of stimuli so far; each new one has another number.
    pub stimulus: u32,
    pub shown: TaskPicture,
}

/// Content of the picture of a secondary task.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TaskPicture {
    /// No picture of a task.
    #[default]
    None,
    /// The red signal of the detection response task.
    Signal,
    /// A digit of the n-back task.
    Digit {
        digit: u8,
        /// Number of digits back, as far as a press is asked for.
        n: u8,
        /// True if the button is to be pressed; `None` if no press is asked for.
        is_match: Option<bool>,
    },
    /// A display of the surrogate reference task.
    Search {
        /// Seed of the circles' places.
        seed: u64,
        /// Number of columns of the cursor.
        columns: u8,
        /// Column of the target, from 0 on the left.
        target_column: u8,
        /// Column of the cursor, from 0 on the left.
        cursor: u8,
        /// Diameter of the target, as a multiple of the other circles'.
        size_ratio: f64,
    },
    /// The closed shutter of an occlusion.
    Closed {
        /// True if a press opens it.
        opens_on_press: bool,
    },
}

impl TaskDisplay {
    /// Visits the numbers of the display; none without a task.
    pub(super) fn visit(&self, put: &mut impl FnMut(&'static str, u32, f64)) {
        if self.stimulus > 0 {
            put("stimulus", 0, self.stimulus.into());
        }
        match self.shown {
            TaskPicture::None => {}
            TaskPicture::Signal => put("signal", 0, 1.0),
            TaskPicture::Digit { digit, .. } => put("digit", 0, digit.into()),
            TaskPicture::Search { target_column, cursor, .. } => {
                put("target column", 0, target_column.into());
                put("cursor", 0, cursor.into());
            }
            TaskPicture::Closed { .. } => put("shutter", 0, 1.0),
        }
    }
}
