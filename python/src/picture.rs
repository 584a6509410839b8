//! Pictures of drives, drawn by the renderer of the window (the cargo feature `desktop`). In: a world, the name of a view, a size. Out: a
//! numpy array.

use codrive::{
    render::{DrivePictures, MAX_SIDE},
    scenario::Scenario,
    scene::ViewKind,
    sim::World,
};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};

/// View and size of a picture.
#[derive(Clone, Copy)]
pub struct Shot {
    kind: ViewKind,
    size: [u32; 2],
}

impl Shot {
    /// Returns a view by its name, with a size in pixels.
    ///
    /// # Errors
    /// `ValueError` for an unknown view or an invalid size.
    pub fn new(view: &str, size: [u32; 2]) -> PyResult<Self> {
        let known = ViewKind::NAMED.iter().find(|(name, _)| *name == view).map(|(_, kind)| *kind);
        let names = ViewKind::NAMED.map(|(name, _)| name).join(", ");
        let kind = known.ok_or_else(|| PyValueError::new_err(format!("view is {view:?}; allowed: {names}")))?;
        if let Some(side) = size.into_iter().find(|side| !(1..=MAX_SIDE).contains(side)) {
            return Err(PyValueError::new_err(format!(
                "a side of the picture is {side} pixels; allowed: 1 to {MAX_SIDE}"
            )));
        }
        Ok(Self { kind, size })
    }

    /// Returns red, green and blue of each pixel, row by row. Creates `pictures` if there is none yet.
    ///
    /// # Errors
    /// The reason why it cannot be drawn.
    pub fn draw(self, pictures: &mut Option<DrivePictures>, world: &World) -> Result<Vec<u8>, String> {
        if world.snapshot().is_without_ego && self.kind != ViewKind::Birdseye {
            return Err("view: there is no participant's vehicle to see from; allowed: birdseye".into());
        }
        let drawing = match pictures {
            Some(drawing) => drawing,
            None => {
                // Trees are those of the default seed, so that all drives of one environment look alike.
                let scenario = Scenario { seed: Scenario::default().seed, ..world.scenario().clone() };
                pictures.insert(DrivePictures::new(world.map(), &scenario).map_err(|why| why.to_string())?)
            }
        };
        let picture = drawing.draw(world, self.kind, self.size).map_err(|why| why.to_string())?;
        Ok(picture.pixels().flat_map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]).collect())
    }

    /// Converts these bytes to a numpy array, uint8, `(height, width, 3)`.
    ///
    /// # Errors
    /// As [`Shot::draw`], as `RuntimeError`.
    pub fn array<'py>(self, py: Python<'py>, drawn: Result<Vec<u8>, String>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let [width, height] = self.size.map(|side| side as usize);
        PyArray1::from_vec(py, drawn.map_err(PyRuntimeError::new_err)?).reshape([height, width, 3])
    }
}
