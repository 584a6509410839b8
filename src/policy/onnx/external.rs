//! Weights in a file beside the network's, as PyTorch's exporter writes them. In: the parsed file and its folder. Out: the model with its
//! weights inlined, or the fault. Only regular files of that folder are read, up to the size limit of a network; a link out of the folder
//! is refused.

use super::{
    OnnxFault, TensorFault,
    limits::{MOST_BYTES, MOST_ELEMENTS},
    structure::{element_bytes, is_external},
};
use crate::file::read_part;
use std::{
    io,
    path::{Component, Path, PathBuf},
};
use tract_onnx::pb::{GraphProto, ModelProto, TensorProto};

/// Inlines the weights of other files into the network.
///
/// # Errors
/// A file of weights cannot be read or is not allowed.
pub fn inline(model: &mut ModelProto, folder: &Path) -> Result<(), OnnxFault> {
    let Some(graph) = &mut model.graph else { return Ok(()) };
    let mut left = MOST_BYTES;
    for tensor in tensors_mut(graph).filter(|tensor| is_external(tensor)) {
        let bytes =
            read(tensor, folder, &mut left).map_err(|fault| OnnxFault::Weights { name: tensor.name.clone(), fault })?;
        tensor.raw_data = bytes;
        tensor.external_data.clear();
        tensor.data_location = None;
    }
    Ok(())
}

/// Returns the files of weights in `folder` that the network needs, each once.
pub fn files(model: &ModelProto, folder: &Path) -> Vec<PathBuf> {
    let graph = model.graph.iter();
    let tensors = graph.flat_map(|graph| graph.initializer.iter().chain(attributes(graph)));
    let mut names: Vec<PathBuf> =
        tensors.filter(|tensor| is_external(tensor)).filter_map(|tensor| place(tensor, folder).ok()).collect();
    names.sort();
    names.dedup();
    names
}

fn attributes(graph: &GraphProto) -> impl Iterator<Item = &TensorProto> {
    graph
        .node
        .iter()
        .flat_map(|node| &node.attribute)
        .flat_map(|attribute| attribute.t.iter().chain(&attribute.tensors))
}

fn tensors_mut(graph: &mut GraphProto) -> impl Iterator<Item = &mut TensorProto> {
    let attributes = graph.node.iter_mut().flat_map(|node| &mut node.attribute);
    graph.initializer.iter_mut().chain(attributes.flat_map(|a| a.t.iter_mut().chain(&mut a.tensors)))
}

/// Returns the tensor's `location`, `offset` or `length` in its file, if given.
fn external_value<'a>(tensor: &'a TensorProto, key: &str) -> Option<&'a str> {
    tensor.external_data.iter().find(|entry| entry.key == key).map(|entry| entry.value.as_str())
}

/// Returns the path of the tensor's file; refuses files outside `folder`, also after following links.
fn place(tensor: &TensorProto, folder: &Path) -> Result<PathBuf, TensorFault> {
    let location = external_value(tensor, "location").ok_or(TensorFault::Unnamed)?;
    let inside = Path::new(location).components().all(|part| matches!(part, Component::Normal(_)));
    if location.is_empty() || !inside {
        return Err(TensorFault::Outside(location.into()));
    }
    // An empty path is the current folder.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let absent = |source: io::Error| TensorFault::Absent { location: location.into(), folder: folder.into(), source };
    let (home, found) = (folder.canonicalize().map_err(absent)?, folder.join(location).canonicalize().map_err(absent)?);
    if !found.starts_with(&home) {
        return Err(TensorFault::Outside(location.into()));
    }
    Ok(folder.join(location))
}

fn read(tensor: &TensorProto, folder: &Path, left: &mut u64) -> Result<Vec<u8>, TensorFault> {
    let n = tensor.dims.iter().try_fold(1usize, |n, &dim| n.checked_mul(usize::try_from(dim).ok()?));
    let n = n.filter(|n| *n <= MOST_ELEMENTS).ok_or_else(|| TensorFault::Shape(tensor.dims.clone()))?;
    let size = (n * element_bytes(tensor.data_type)?) as u64;
    let number = |key: &'static str, otherwise: u64| match external_value(tensor, key) {
        Some(text) => text.parse::<u64>().map_err(|_| TensorFault::Place { key, text: text.into() }),
        None => Ok(otherwise),
    };
    let (offset, length) = (number("offset", 0)?, number("length", size)?);
    if length != size {
        return Err(TensorFault::Bytes { dims: tensor.dims.clone(), size, declared: length });
    }
    *left = left.checked_sub(size).ok_or(TensorFault::TooLarge)?;
    let file = place(tensor, folder)?;
    read_part(&file, offset, size).map_err(|source| TensorFault::Unreadable { file, source })
}
