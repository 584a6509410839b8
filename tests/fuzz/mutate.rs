//! Random changes of inputs. In: good inputs and a stream of random numbers. Out: one of them with changed bytes; in text also changed
//! numbers, words and lines; in an ONNX network also a changed structure. The same seed makes the same inputs.

use codrive::rng::Stream;
use prost::Message;
use tract_onnx::pb::{GraphProto, ModelProto, NodeProto};

/// Numbers that often break programs, as people and programs write them.
const NUMBERS: [&str; 24] = [
    "0",
    "-1",
    "1",
    "-0.0",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-308",
    "1e18",
    "1e9",
    "1e8",
    "1e6",
    "100000",
    "0.001",
    "2147483648",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "99999999999999999999999999999999999999999",
    "0x10",
    "",
];
/// Integers that often break programs.
const WHOLE: [i64; 16] =
    [0, 1, -1, 2, 3, 7, 255, 4096, 4097, 65_536, 1 << 22, 1 << 31, 1 << 32, 1 << 40, i64::MAX, i64::MIN];

/// Returns a random item of a list.
fn one<'a, T>(stream: &mut Stream, list: &'a [T]) -> &'a T {
    &list[stream.index(list.len())]
}

fn part(stream: &mut Stream, n: usize, most: usize) -> std::ops::Range<usize> {
    let start = stream.index(n + 1);
    start..start + stream.index((n - start).min(most) + 1)
}

/// Changes bytes without regard to their meaning.
pub fn bytes(stream: &mut Stream, mut input: Vec<u8>, other: &[u8]) -> Vec<u8> {
    for _ in 0..=stream.index(4) {
        let n = input.len();
        match stream.index(9) {
            0 if n > 0 => input[stream.index(n)] ^= 1 << stream.index(8),
            1 if n > 0 => input[stream.index(n)] = stream.index(256) as u8,
            2 => {
                input.drain(part(stream, n, 64));
            }
            3 => {
                let copied = input[part(stream, n, 64)].to_vec();
                let at = stream.index(n + 1);
                input.splice(at..at, copied);
            }
            4 => input.truncate(stream.index(n + 1)),
            5 if n >= 8 => {
                let value = one(stream, &WHOLE).to_le_bytes();
                let (at, width) = (stream.index(n - 7), [1, 2, 4, 8][stream.index(4)]);
                input[at..at + width].copy_from_slice(&value[..width]);
            }
            6 if n > 0 => {
                let range = part(stream, n, 16);
                input[range].fill([0, 0x7f, 0x80, 0xff][stream.index(4)]);
            }
            7 => {
                let theirs = other[part(stream, other.len(), 256)].to_vec();
                let range = part(stream, n, 256);
                input.splice(range, theirs);
            }
            _ => {
                let at = stream.index(n + 1);
                input.insert(at, stream.index(256) as u8);
            }
        }
    }
    input
}

/// Returns the ranges of numbers in a text.
fn numbers(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let inside = |byte: u8| byte.is_ascii_digit() || byte == b'.' || byte == b'-';
    runs(text, inside).into_iter().filter(|run| text[run.clone()].iter().any(u8::is_ascii_digit)).collect()
}

fn runs(text: &[u8], inside: impl Fn(u8) -> bool) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let mut start = None;
    for (at, &byte) in text.iter().chain(b"\0").enumerate() {
        match start {
            None if inside(byte) => start = Some(at),
            Some(from) if !inside(byte) => {
                found.push(from..at);
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn lines(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    runs(text, |byte| byte != b'\n')
}

/// Changes numbers, words and lines, and sometimes bytes.
pub fn text(stream: &mut Stream, mut input: Vec<u8>, other: &[u8]) -> Vec<u8> {
    for _ in 0..=stream.index(3) {
        let words = |text: &[u8]| runs(text, |byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let list = match stream.index(8) {
            0..3 => numbers(&input),
            3 | 4 => words(&input),
            5 | 6 => lines(&input),
            _ => return bytes(stream, input, other),
        };
        if list.is_empty() {
            continue;
        }
        let here = one(stream, &list).clone();
        let there = one(stream, &list).clone();
        match stream.index(4) {
            // Replace it by another of its kind, add one, remove one, or insert a number that breaks programs.
            0 => {
                let copied = input[there].to_vec();
                input.splice(here, copied);
            }
            1 => {
                let mut copied = input[here.clone()].to_vec();
                copied.push(b'\n');
                input.splice(here.start..here.start, copied);
            }
            2 => {
                input.drain(here);
            }
            _ => {
                input.splice(here, one(stream, &NUMBERS).bytes());
            }
        }
    }
    input
}

/// Operators that replace others.
const OPERATORS: [&str; 22] = [
    "Add",
    "Cast",
    "Concat",
    "ConstantOfShape",
    "Conv",
    "Expand",
    "Flatten",
    "GRU",
    "Gather",
    "Gemm",
    "LSTM",
    "MatMul",
    "Pad",
    "ReduceMean",
    "Relu",
    "Reshape",
    "Slice",
    "Softmax",
    "Split",
    "Tile",
    "TopK",
    "Transpose",
];

/// Changes nodes, shapes and attributes; every fourth time bytes.
pub fn onnx(stream: &mut Stream, input: Vec<u8>, other: &[u8]) -> Vec<u8> {
    let Ok(mut model) = ModelProto::decode(input.as_slice()) else { return bytes(stream, input, other) };
    if stream.index(4) == 0 {
        return bytes(stream, input, other);
    }
    if let Some(graph) = &mut model.graph {
        for _ in 0..=stream.index(4) {
            graph_change(stream, graph);
        }
    }
    model.encode_to_vec()
}

fn graph_change(stream: &mut Stream, graph: &mut GraphProto) {
    let n = graph.node.len();
    match stream.index(8) {
        0 if n > 0 => {
            graph.node.remove(stream.index(n));
        }
        1 if n > 0 => {
            let node = graph.node[stream.index(n)].clone();
            graph.node.insert(stream.index(n + 1), node);
        }
        2 if n > 0 => graph.node[stream.index(n)].op_type = (*one(stream, &OPERATORS)).into(),
        3 if !graph.initializer.is_empty() => {
            let at = stream.index(graph.initializer.len());
            let dims = &mut graph.initializer[at].dims;
            match dims.len() {
                0 => dims.push(*one(stream, &WHOLE)),
                n => dims[stream.index(n)] = *one(stream, &WHOLE),
            }
        }
        4 if n > 0 => {
            let at = stream.index(n);
            for attribute in &mut graph.node[at].attribute {
                attribute.i = *one(stream, &WHOLE);
                attribute.ints.iter_mut().for_each(|number| *number = *one(stream, &WHOLE));
                attribute.f = [0.0, -1.0, f32::NAN, f32::INFINITY, 1e30][stream.index(5)];
            }
        }
        5 if n > 1 => {
            // Use another node's output as input.
            let name = graph.node[stream.index(n)].output.first().cloned().unwrap_or_default();
            let at = stream.index(n);
            if let Some(input) = graph.node[at].input.first_mut() {
                *input = name;
            }
        }
        6 => added(stream, graph),
        _ => {
            let inputs = graph.node.iter_mut().flat_map(|node| &mut node.input).collect::<Vec<_>>();
            let at = stream.index(inputs.len().max(1));
            if let Some(input) = inputs.into_iter().nth(at) {
                input.clear();
            }
        }
    }
}

/// Adds a node between the last node and its input.
fn added(stream: &mut Stream, graph: &mut GraphProto) {
    use tract_onnx::pb::{AttributeProto, attribute_proto::AttributeType};
    let sizes = (0..=stream.index(3)).map(|_| *one(stream, &WHOLE)).collect();
    let kind = AttributeType::Ints.into();
    let attribute =
        AttributeProto { name: "value_ints".into(), r#type: kind, ints: sizes, ..AttributeProto::default() };
    let name = format!("sizes{}", graph.node.len());
    let list = NodeProto {
        op_type: "Constant".into(),
        output: vec![name.clone()],
        attribute: vec![attribute],
        ..NodeProto::default()
    };
    let Some(last) = graph.node.last_mut() else { return };
    let taken = last.input.first().cloned().unwrap_or_default();
    let made = format!("{name}-used");
    if let Some(input) = last.input.first_mut() {
        input.clone_from(&made);
    }
    let operator = (*one(stream, &OPERATORS)).to_owned();
    let input = if operator == "ConstantOfShape" { vec![name] } else { vec![taken, name] };
    let user = NodeProto { op_type: operator, input, output: vec![made], ..NodeProto::default() };
    let at = graph.node.len() - 1;
    graph.node.splice(at..at, [list, user]);
}
