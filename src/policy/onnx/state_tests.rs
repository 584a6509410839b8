//! Recurrent networks: the state of each vehicle, its beginning, and the layers that are written. Expected numbers are those of the
//! equations of the layers, in 64 bits.

use super::{OnnxPolicy, PolicyLayer, RecurrentKind, RecurrentLayer, write_layers};
use crate::policy::{Action, Feature, Network, NetworkInput, NetworkLayer, Observation, Policy};
use prost::Message;
use tract_onnx::pb::{GraphProto, ModelProto, NodeProto};

/// Returns the meaning of a network that sees the speed, 0 to 10 m/s, and advises a speed, 0 to 10 m/s.
fn meaning() -> Network {
    let inputs = vec![NetworkInput { feature: Feature::Speed, from: 0.0, to: 10.0 }];
    Network { holds_s: [1.0, 1.0], ..Network::advising_speed(inputs, Vec::new()) }
}

fn layer(weights: &[&[f32]], bias: &[f32]) -> NetworkLayer {
    NetworkLayer { weights: weights.iter().map(|row| row.to_vec()).collect(), bias: bias.to_vec() }
}

/// Returns a layer of one unit with another number at each place.
fn one_unit(kind: RecurrentKind) -> RecurrentLayer {
    let numbers = |numbers: [f32; 4]| numbers[..kind.gates()].to_vec();
    RecurrentLayer {
        kind,
        input: NetworkLayer { weights: vec![numbers([0.5, -0.4, 0.8, 0.3])], bias: numbers([0.1, 0.2, -0.1, 0.4]) },
        state: NetworkLayer { weights: vec![numbers([0.7, 0.6, -0.5, 0.9])], bias: numbers([0.05, -0.3, 0.25, -0.2]) },
    }
}

fn read(bytes: &[u8]) -> OnnxPolicy {
    OnnxPolicy::from_bytes(bytes, None).unwrap_or_else(|fault| panic!("{fault}"))
}

/// Returns the outputs of a policy for scaled speeds, one decision after the other: its targets, -1 to 1.
fn outputs(policy: &mut dyn Policy, seen: &[f64]) -> Vec<f64> {
    let mut output = |scaled: f64| {
        let speed_mps = 5.0 + 5.0 * scaled;
        match policy.act(0.0, &Observation { speed_mps, hold_s: 1.0, ..Observation::default() }) {
            Action::Speed(mps) => mps / 5.0 - 1.0,
            Action::Acceleration(_) => panic!("a policy of speeds"),
        }
    };
    seen.iter().map(|scaled| output(*scaled)).collect()
}

fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

const SEEN: [f64; 5] = [0.3, -0.8, 0.9, 0.0, -0.1];
/// Rounding of a few operations with 24 binary digits on numbers of about 1.
const ROUNDING: f64 = 1e-6;

fn assert_near(given: &[f64], expected: &[f64]) {
    let is_near = given.iter().zip(expected).all(|(a, b)| (a - b).abs() < ROUNDING);
    assert!(given.len() == expected.len() && is_near, "{given:?} {expected:?}");
}

fn node(kind: &str, inputs: &[&str], output: &str) -> NodeProto {
    NodeProto {
        input: inputs.iter().map(|name| (*name).to_owned()).collect(),
        output: vec![output.into()],
        op_type: kind.into(),
        ..NodeProto::default()
    }
}

/// Returns a network that adds up what it sees: s' = s + x, action s', with the state named `state_in_sum` and `state_out_sum`.
fn summing(change: impl FnOnce(&mut ModelProto)) -> Vec<u8> {
    let one = PolicyLayer::Recurrent(one_unit(RecurrentKind::Gru));
    let mut model = ModelProto::decode(write_layers(&meaning(), &[one]).as_slice()).unwrap();
    let graph: &mut GraphProto = model.graph.as_mut().unwrap();
    graph.node = vec![
        node("Add", &["state_in_sum", "observation"], "state_out_sum"),
        node("Identity", &["state_out_sum"], "action"),
    ];
    graph.initializer.clear();
    graph.input[1].name = "state_in_sum".into();
    graph.output[1].name = "state_out_sum".into();
    change(&mut model);
    model.encode_to_vec()
}

/// Appends a line to the top of the description in the metadata.
fn described(model: &mut ModelProto, line: &str) {
    let text = &mut model.metadata_props[0].value;
    *text = format!("{line}\n{text}");
}

#[test]
fn each_engaged_policy_has_its_own_state_and_begins_with_zeros() {
    let source = read(&summing(|_| ()));
    let [mut one, mut other] = [source.engaged(0.1), source.engaged(0.1)];
    assert_near(&outputs(one.as_mut(), &[0.1, 0.2, -0.4]), &[0.1, 0.3, -0.1]);
    assert_near(&outputs(other.as_mut(), &[0.5]), &[0.5]);
    assert_near(&outputs(one.as_mut(), &[0.0]), &[-0.1]);
    // A policy engaged later does not inherit a state, neither from the file nor from a policy that was driven.
    assert_near(&outputs(source.engaged(0.1).as_mut(), &[0.2]), &[0.2]);
}

#[test]
fn a_state_begins_as_the_description_says() {
    let begun = |line: &str| OnnxPolicy::from_bytes(&summing(|model| described(model, line)), None);
    let mut policy = begun("initial_state = { state_in_sum = [0.5] }").unwrap().engaged(0.1);
    assert_near(&outputs(policy.as_mut(), &[0.1, 0.2]), &[0.6, 0.8]);
    for (line, expected) in [
        ("initial_state = { state_in_sum = [0.5, 0.1] }", "begins `state_in_sum` with 2 numbers; allowed: 1 finite"),
        ("initial_state = { state_in_sum = [nan] }", "begins `state_in_sum` with 1 numbers; allowed: 1 finite"),
        ("initial_state = { sum = [0.5] }", "has no state `sum` to begin with; its states are state_in_sum"),
    ] {
        let message = begun(line).err().unwrap().to_string();
        assert!(message.contains(expected), "{line}: {message}");
    }
}

#[test]
fn a_network_whose_state_is_lost_or_grows_without_end_is_refused() {
    let fault =
        |change: &dyn Fn(&mut ModelProto)| OnnxPolicy::from_bytes(&summing(change), None).err().unwrap().to_string();
    let lost = fault(&|model| model.graph.as_mut().unwrap().output.truncate(1));
    assert!(lost.contains("`state_in_sum` of a state and no output `state_out_sum`"), "{lost}");
    // 200 doublings of 1 exceed the range of 32 bits.
    let growing = fault(&|model| {
        described(model, "initial_state = { state_in_sum = [1.0] }");
        let graph = model.graph.as_mut().unwrap();
        graph.node = vec![
            node("Add", &["state_in_sum", "state_in_sum"], "state_out_sum"),
            node("Tanh", &["observation"], "action"),
        ];
    });
    assert!(growing.contains("gives inf for `state_out_sum`; allowed: 1 finite numbers"), "{growing}");
}

#[test]
fn a_written_lstm_follows_the_equations_of_an_lstm() {
    let bytes = write_layers(&meaning(), &[PolicyLayer::Recurrent(one_unit(RecurrentKind::Lstm))]);
    let (mut h, mut c) = (0.0, 0.0);
    let expected = SEEN.map(|x| {
        let sum = |gate: usize| {
            let (w, b) = ([0.5, -0.4, 0.8, 0.3][gate], [0.1, 0.2, -0.1, 0.4][gate]);
            let (u, d) = ([0.7, 0.6, -0.5, 0.9][gate], [0.05, -0.3, 0.25, -0.2][gate]);
            w * x + b + u * h + d
        };
        c = sigmoid(sum(1)) * c + sigmoid(sum(0)) * sum(2).tanh();
        h = sigmoid(sum(3)) * c.tanh();
        h
    });
    assert_near(&outputs(read(&bytes).engaged(0.1).as_mut(), &SEEN), &expected);
}

#[test]
fn a_written_gru_follows_the_equations_of_a_gru() {
    let bytes = write_layers(&meaning(), &[PolicyLayer::Recurrent(one_unit(RecurrentKind::Gru))]);
    let mut h = 0.0;
    let expected = SEEN.map(|x| {
        let r = sigmoid(0.5 * x + 0.1 + 0.7 * h + 0.05);
        let z = sigmoid(-0.4 * x + 0.2 + 0.6 * h - 0.3);
        let n = (0.8 * x - 0.1 + r * (-0.5 * h + 0.25)).tanh();
        h = (1.0 - z) * n + z * h;
        h
    });
    assert_near(&outputs(read(&bytes).engaged(0.1).as_mut(), &SEEN), &expected);
}

#[test]
fn dense_layers_around_a_recurrent_one_bend_all_but_the_last() {
    // Two units: the gates of the second unit are the second columns.
    let gru = RecurrentLayer {
        kind: RecurrentKind::Gru,
        input: layer(&[&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0], &[0.0, 0.0, 0.0, 0.0, 0.0, 2.0]], &[0.0; 6]),
        state: layer(&[&[0.0; 6], &[0.0; 6]], &[0.0; 6]),
    };
    let first = layer(&[&[0.5, -1.0]], &[0.1, 0.0]);
    let last = layer(&[&[0.4], &[-0.3]], &[0.05]);
    let layers = [PolicyLayer::Dense(first), PolicyLayer::Recurrent(gru), PolicyLayer::Dense(last)];
    let mut policy = read(&write_layers(&meaning(), &layers)).engaged(0.1);
    // All gates are open by half: h' = (n + h) / 2.
    let (mut h, mut k) = (0.0, 0.0);
    let expected = SEEN.map(|x| {
        h = 0.5 * h + 0.5 * (0.5 * x + 0.1).tanh().tanh();
        k = 0.5 * k + 0.5 * (2.0 * (-x).tanh()).tanh();
        0.4 * h - 0.3 * k + 0.05
    });
    assert_near(&outputs(policy.as_mut(), &SEEN), &expected);
}

#[test]
fn an_lstm_node_takes_its_memory_from_states() {
    let ints =
        |name: &str, i: i64| tract_onnx::pb::AttributeProto { name: name.into(), r#type: 2, i, ..Default::default() };
    let written = one_unit(RecurrentKind::Lstm);
    let mut model =
        ModelProto::decode(write_layers(&meaning(), &[PolicyLayer::Recurrent(written.clone())]).as_slice()).unwrap();
    let graph = model.graph.as_mut().unwrap();
    // ONNX orders the gates input, output, forget, candidate.
    let ordered = |row: &[f32]| [0, 3, 1, 2].map(|gate| row[gate]).to_vec();
    let numbers = |name: &str, dims: &[i64], numbers: Vec<f32>| super::write::tensor(name, dims, numbers);
    graph.initializer = vec![
        numbers("w", &[1, 4, 1], ordered(&written.input.weights[0])),
        numbers("r", &[1, 4, 1], ordered(&written.state.weights[0])),
        numbers("b", &[1, 8], [ordered(&written.input.bias), ordered(&written.state.bias)].concat()),
        tract_onnx::pb::TensorProto {
            data_type: 7,
            raw_data: 1i64.to_le_bytes().repeat(3),
            ..numbers("shape3", &[3], Vec::new())
        },
        tract_onnx::pb::TensorProto {
            data_type: 7,
            raw_data: 1i64.to_le_bytes().repeat(2),
            ..numbers("shape2", &[2], Vec::new())
        },
    ];
    let mut lstm = node("LSTM", &["x", "w", "r", "b", "", "h", "c"], "y");
    lstm.output.extend(["h1".into(), "c1".into()]);
    lstm.attribute = vec![ints("hidden_size", 1)];
    graph.node = vec![
        node("Reshape", &["observation", "shape3"], "x"),
        node("Reshape", &["state_in_h0", "shape3"], "h"),
        node("Reshape", &["state_in_c0", "shape3"], "c"),
        lstm,
        node("Reshape", &["h1", "shape2"], "state_out_h0"),
        node("Reshape", &["c1", "shape2"], "state_out_c0"),
        node("Identity", &["state_out_h0"], "action"),
    ];
    let own = write_layers(&meaning(), &[PolicyLayer::Recurrent(written)]);
    let expected = outputs(read(&own).engaged(0.1).as_mut(), &SEEN);
    assert_near(&outputs(read(&model.encode_to_vec()).engaged(0.1).as_mut(), &SEEN), &expected);
}
