//! Recurrent layers as nodes of an ONNX graph. In: the numbers of a layer in the order of PyTorch. Out: nodes whose state is an input and
//! an output of the graph. The gates are written as products and sums, which every runtime knows and which take any number of rows.

use super::{
    states::{STATE_IN, STATE_OUT},
    write::{node, rows_of, tensor},
};
use crate::policy::NetworkLayer;
use tract_onnx::pb::GraphProto;

/// Kind of a recurrent layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecurrentKind {
    /// Gates: input, forget, candidate, output.
    Lstm,
    /// Gates: reset, update, candidate. The reset gate multiplies the candidate's product with the state, bias included.
    Gru,
}

impl RecurrentKind {
    /// Returns the number of gates.
    pub fn gates(self) -> usize {
        match self {
            Self::Lstm => 4,
            Self::Gru => 3,
        }
    }
}

/// Recurrent layer. Columns of weights and biases are the gates one after the other, each with one column per unit.
#[derive(Clone, Debug, PartialEq)]
pub struct RecurrentLayer {
    /// Kind of the layer.
    pub kind: RecurrentKind,
    /// Product with the layer's inputs.
    pub input: NetworkLayer,
    /// Product with the layer's outputs of the decision before.
    pub state: NetworkLayer,
}

/// Layer of a policy with a memory.
#[derive(Clone, Debug, PartialEq)]
pub enum PolicyLayer {
    /// `y = x W + b`, followed by tanh in all dense layers but the last layer.
    Dense(NetworkLayer),
    /// Layer with a state.
    Recurrent(RecurrentLayer),
}

/// Reasons that a recurrent layer is inconsistent.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecurrentFault {
    /// The weights of the state do not fit the gates.
    #[error(
        "layer {layer} has {columns} columns and {rows} rows in the weights of its state; allowed: {gates} columns for each \
         row, one for each gate"
    )]
    State {
        /// Index of the layer, from 0.
        layer: usize,
        /// Length of the biases of the state.
        columns: usize,
        /// Rows of the weights of the state.
        rows: usize,
        /// Number of gates of a layer of this kind.
        gates: usize,
    },
}

impl PolicyLayer {
    /// Returns the number of outputs.
    pub fn outputs(&self) -> usize {
        match self {
            Self::Dense(layer) => layer.bias.len(),
            Self::Recurrent(layer) => layer.units(),
        }
    }
}

impl RecurrentLayer {
    fn units(&self) -> usize {
        self.state.weights.len()
    }

    /// Checks that the weights of input and state have a column for each unit of each gate; `layer` is the index in messages.
    ///
    /// # Errors
    /// A row or the biases have another number of columns.
    pub fn check(&self, layer: usize) -> Result<(), RecurrentFault> {
        let (rows, gates) = (self.units(), self.kind.gates());
        let all =
            [&self.state.bias, &self.input.bias].into_iter().chain(&self.state.weights).chain(&self.input.weights);
        match all.map(Vec::len).find(|columns| *columns != rows * gates) {
            Some(columns) => Err(RecurrentFault::State { layer, columns, rows, gates }),
            None => Ok(()),
        }
    }

    /// Appends the layer's nodes, which take the tensor `before`; returns the name of its output. `layer` is its index.
    pub(super) fn append(&self, graph: &mut GraphProto, before: &str, layer: usize) -> String {
        match self.kind {
            RecurrentKind::Lstm => self.append_lstm(graph, before, layer),
            RecurrentKind::Gru => self.append_gru(graph, before, layer),
        }
    }

    fn append_lstm(&self, graph: &mut GraphProto, before: &str, layer: usize) -> String {
        let (hidden, cell) = (self.state(graph, "h", layer), self.state(graph, "c", layer));
        let name = |what: &str| format!("{what}{layer}");
        let bends = ["Sigmoid", "Sigmoid", "Tanh", "Sigmoid"];
        for (gate, (what, bend)) in ["input", "forget", "candidate", "output"].into_iter().zip(bends).enumerate() {
            let of_input = product(graph, &self.input, gate, self.units(), before, &name(&format!("{what}_by_input")));
            let of_state =
                product(graph, &self.state, gate, self.units(), &hidden[0], &name(&format!("{what}_by_state")));
            let sum = name(&format!("{what}_sum"));
            graph.node.push(node("Add", &[&of_input, &of_state], &sum));
            graph.node.push(node(bend, &[&sum], &name(what)));
        }
        // c' = f c + i g, h' = o tanh(c').
        for (kind, inputs, output) in [
            ("Mul", vec![name("forget"), cell[0].clone()], name("kept")),
            ("Mul", vec![name("input"), name("candidate")], name("added")),
            ("Add", vec![name("kept"), name("added")], cell[1].clone()),
            ("Tanh", vec![cell[1].clone()], name("bent")),
            ("Mul", vec![name("output"), name("bent")], hidden[1].clone()),
        ] {
            graph.node.push(node(kind, &inputs.iter().map(String::as_str).collect::<Vec<_>>(), &output));
        }
        hidden[1].clone()
    }

    fn append_gru(&self, graph: &mut GraphProto, before: &str, layer: usize) -> String {
        let hidden = self.state(graph, "h", layer);
        let name = |what: &str| format!("{what}{layer}");
        for (gate, what) in ["reset", "update", "candidate"].into_iter().enumerate() {
            product(graph, &self.input, gate, self.units(), before, &name(&format!("{what}_by_input")));
            product(graph, &self.state, gate, self.units(), &hidden[0], &name(&format!("{what}_by_state")));
        }
        // n = tanh(x + r h), h' = (1 - z) n + z h = n + z (h - n).
        for (kind, inputs, output) in [
            ("Add", vec![name("reset_by_input"), name("reset_by_state")], name("reset_sum")),
            ("Sigmoid", vec![name("reset_sum")], name("reset")),
            ("Add", vec![name("update_by_input"), name("update_by_state")], name("update_sum")),
            ("Sigmoid", vec![name("update_sum")], name("update")),
            ("Mul", vec![name("reset"), name("candidate_by_state")], name("kept")),
            ("Add", vec![name("candidate_by_input"), name("kept")], name("candidate_sum")),
            ("Tanh", vec![name("candidate_sum")], name("candidate")),
            ("Sub", vec![hidden[0].clone(), name("candidate")], name("difference")),
            ("Mul", vec![name("update"), name("difference")], name("step")),
            ("Add", vec![name("candidate"), name("step")], hidden[1].clone()),
        ] {
            graph.node.push(node(kind, &inputs.iter().map(String::as_str).collect::<Vec<_>>(), &output));
        }
        hidden[1].clone()
    }

    /// Adds a state of the layer to the graph; returns the names of its input and its output.
    fn state(&self, graph: &mut GraphProto, what: &str, layer: usize) -> [String; 2] {
        let names = [STATE_IN, STATE_OUT].map(|beginning| format!("{beginning}{what}{layer}"));
        graph.input.push(rows_of(&names[0], self.units()));
        graph.output.push(rows_of(&names[1], self.units()));
        names
    }
}

/// Appends the product of the tensor `before` with the columns of one gate; returns its name. One product per gate, so that no result has
/// to be split.
fn product(graph: &mut GraphProto, all: &NetworkLayer, gate: usize, units: usize, before: &str, name: &str) -> String {
    let columns = |row: &Vec<f32>| row[gate * units..][..units].to_vec();
    let (weights, bias) = (format!("{name}_weights"), format!("{name}_bias"));
    let dims = [all.weights.len() as i64, units as i64];
    graph.initializer.push(tensor(&weights, &dims, all.weights.iter().flat_map(columns).collect()));
    graph.initializer.push(tensor(&bias, &dims[1..], columns(&all.bias)));
    graph.node.push(node("Gemm", &[before, &weights, &bias], name));
    name.to_owned()
}
