"""Tests of docs/python.md: runs each example that needs neither a model of another library nor a recording."""

import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLES = re.findall(r"^```python\n((?:.*\n)*?)```$", (ROOT / "docs/python.md").read_text(encoding="utf-8"), re.MULTILINE)
#: Examples that test_sb3, test_policy_file, test_read and test_sweep cover.
ELSEWHERE = re.compile(r"\bmodel\b|codrive_sim\.read\(|codrive_sim\.sweep")


def test_the_page_has_examples_that_can_run_alone():
    assert len([example for example in EXAMPLES if not ELSEWHERE.search(example)]) == 7


@pytest.mark.parametrize("example", [example for example in EXAMPLES if not ELSEWHERE.search(example)])
def test_examples_do_what_is_written(example, tmp_path, monkeypatch):
    # Examples name a leader who drives 15 m/s for seven minutes.
    rows = "".join(f"{second},15.0\n" for second in range(421))
    (tmp_path / "leader.csv").write_text(f"time_s,speed_mps\n{rows}")
    monkeypatch.chdir(tmp_path)
    made = {}
    exec(compile(f"import codrive_sim\n{example}", "docs/python.md", "exec"), made)
    for env in (made.get("env"), made.get("envs")):
        if env is not None:
            env.reset(seed=1)
            of_agents = callable(env.action_space)
            env.step({agent: env.action_space(agent).sample() for agent in env.agents} if of_agents else env.action_space.sample())
            env.close()
