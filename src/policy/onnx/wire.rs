//! Check of an ONNX file's encoding before it is parsed. In: its bytes. Out: nothing, or the limit that is exceeded. The file is a
//! protobuf: two of its bytes can become a structure of some hundred bytes, and one byte a number of eight. So the fields are counted in
//! the raw bytes, by the parser's own rules, before it allocates anything.

use super::{
    OnnxFault,
    limits::{MOST_DEPTH, MOST_FIELDS, MOST_VARINTS},
};

/// ONNX messages that contain other messages or lists of numbers.
#[derive(Clone, Copy, PartialEq)]
enum OnnxMessage {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
    Sparse,
    Value,
    Type,
    TensorType,
    Shape,
    Training,
    Function,
    /// Any other message, with few fields.
    Leaf,
}

/// Content of a length-delimited field.
enum FieldContent {
    Message(OnnxMessage),
    /// Numbers of variable length, at least one byte each.
    Varints,
    /// Text, bytes, or numbers of fixed size.
    Bytes,
}

fn held(message: OnnxMessage, field: u64) -> FieldContent {
    use FieldContent::{Bytes, Varints};
    use OnnxMessage::{
        Attribute, Function, Graph, Leaf, Model, Node, Shape, Sparse, Tensor, TensorType, Training, Type, Value,
    };
    FieldContent::Message(match (message, field) {
        (Model, 7) | (Attribute, 6 | 11) | (Training, 1 | 2) => Graph,
        (Model, 8 | 14) | (Graph, 14) | (Tensor, 3 | 13) | (Shape, 1) | (Training, 3 | 4) | (Function, 9) => Leaf,
        (Model, 20) => Training,
        (Model, 25) => Function,
        (Graph, 1) | (Function, 7) => Node,
        (Graph, 5) | (Attribute, 5 | 10) | (Sparse, 1 | 2) => Tensor,
        (Graph, 15) | (Attribute, 22 | 23) => Sparse,
        (Graph, 11..=13) => Value,
        (Node, 5) => Attribute,
        (Attribute, 14 | 15) | (Value, 2) => Type,
        (Type, 1) => TensorType,
        (TensorType, 2) => Shape,
        (Attribute, 8) | (Tensor, 1 | 5 | 7 | 11) | (Sparse, 3) => return Varints,
        _ => return Bytes,
    })
}

/// Checks the encoding of a file.
///
/// # Errors
/// The file is truncated, is no protobuf, or exceeds a limit.
pub fn check(bytes: &[u8]) -> Result<(), OnnxFault> {
    let mut fields = 0;
    walk(bytes, OnnxMessage::Model, 0, &mut fields)
}

fn walk(mut bytes: &[u8], message: OnnxMessage, depth: usize, fields: &mut usize) -> Result<(), OnnxFault> {
    if depth > MOST_DEPTH {
        return Err(OnnxFault::TooDeep);
    }
    while !bytes.is_empty() {
        *fields += 1;
        if *fields > MOST_FIELDS {
            return Err(OnnxFault::ManyFields);
        }
        let tag = varint(&mut bytes).ok_or(OnnxFault::Damaged)?;
        let skip = match tag & 7 {
            0 => {
                varint(&mut bytes).ok_or(OnnxFault::Damaged)?;
                0
            }
            1 => 8,
            5 => 4,
            2 => usize::try_from(varint(&mut bytes).ok_or(OnnxFault::Damaged)?).map_err(|_| OnnxFault::Damaged)?,
            // Groups, which ONNX does not use.
            _ => return Err(OnnxFault::Damaged),
        };
        let (inside, rest) = bytes.split_at_checked(skip).ok_or(OnnxFault::Damaged)?;
        bytes = rest;
        if tag & 7 != 2 {
            continue;
        }
        match held(message, tag >> 3) {
            FieldContent::Message(inner) => walk(inside, inner, depth + 1, fields)?,
            FieldContent::Varints if inside.len() > MOST_VARINTS => {
                return Err(OnnxFault::LongList(inside.len()));
            }
            FieldContent::Varints | FieldContent::Bytes => {}
        }
    }
    Ok(())
}

fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for i in 0..10 {
        let (byte, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u64::from(byte & 0x7f) << (7 * i);
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_empty_nodes_is_refused_before_it_is_read() {
        // 16 MiB of these would become 1.7 GB.
        let graph = [0x0a, 0x00].repeat(MOST_FIELDS);
        let mut file = vec![0x3a];
        let mut size = graph.len();
        while size > 0x7f {
            file.push(size as u8 | 0x80);
            size >>= 7;
        }
        file.push(size as u8);
        file.extend(graph);
        assert!(check(&file).unwrap_err().to_string().starts_with("has too many fields"));
    }

    #[test]
    fn a_cut_file_is_named_as_such() {
        for bytes in [&[0x3a][..], &[0x3a, 0x05, 0x00], &[0x3b, 0x00], &[0x80; 11], &[0x39, 0, 0]] {
            assert_eq!(check(bytes).unwrap_err().to_string(), "is not an ONNX file: it is damaged or cut");
        }
        assert!(check(&[]).is_ok());
    }
}
