"""Makes torch-legacy.onnx, torch-dynamo.onnx and torch-answers.json: run by hand with torch, onnx and onnxscript."""

import json
import pathlib

import onnx
import torch

HERE = pathlib.Path(__file__).parent
DESCRIPTION = """action = "speed"
limits = [0.0, 10.0]
holds_s = [1.0, 1.0]
inputs = [
  { feature = "speed", from = 0.0, to = 10.0 },
  { feature = "leader_speed", from = 0.0, to = 10.0 },
  { feature = "gap", from = 0.0, to = 300.0 },
  { feature = "circumference", from = 200.0, to = 300.0 },
]
"""


class Policy(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.body = torch.nn.Sequential(torch.nn.Linear(4, 16), torch.nn.Tanh(), torch.nn.Linear(16, 16), torch.nn.Tanh())
        self.mean = torch.nn.Linear(16, 1)

    def forward(self, observation):
        return torch.clamp(self.mean(self.body(observation)), -1.0, 1.0)


torch.manual_seed(1)
policy = Policy().eval()
rows = torch.tensor([[-1.0, -0.5, 0.2, 0.0], [0.3, 0.8, -0.9, 1.0], [0.0, 0.0, 0.0, 0.0]])
example = (rows[:2],)
names = {"input_names": ["observation"], "output_names": ["action"]}
torch.onnx.export(policy, example, HERE / "torch-legacy.onnx", dynamo=False,
                  dynamic_axes={"observation": {0: "batch"}, "action": {0: "batch"}}, **names)
torch.onnx.export(policy, example, HERE / "torch-dynamo.onnx", dynamo=True, external_data=False,
                  dynamic_shapes=({0: torch.export.Dim("batch")},), **names)
model = onnx.load(HERE / "torch-dynamo.onnx")
for node in model.graph.node:
    # Stack traces name the files of whoever made it.
    del node.metadata_props[:]
for value in [*model.graph.input, *model.graph.output, *model.graph.value_info]:
    del value.metadata_props[:]
del model.graph.metadata_props[:]
onnx.save(model, HERE / "torch-dynamo.onnx")
answers = torch.cat([rows, policy(rows).detach()], dim=1)
(HERE / "torch-answers.json").write_text(json.dumps(answers.tolist()) + "\n")
for kind in ["legacy", "dynamo"]:
    (HERE / f"torch-{kind}.onnx.toml").write_text(DESCRIPTION)
