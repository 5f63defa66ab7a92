"""Agents that ask a chat model, scripted: plain verdicts, what they are told, and what is kept of their exchange."""

import dataclasses
import json
from contextlib import nullcontext

import imageio.v3 as iio
import pytest

from physagent_jax.agents.protocols import Agents, ExecutorAgent, PlannerAgent, SemanticAgent
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.agents.trace import AgentError, FailedCall, Message, Reply, Trace
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.judging.progress import find_best_round
from physagent_jax.motion.schema import Judgement, Verdict
from physagent_jax.report.html import write_report
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.refused import RefusedReadings
from physagent_jax.scene.cost import Limits
from tests.run.specs import made, small

PROMPT = "push the robot to the left"


class ChatModel:
    """Answers from a script, counts tokens by words, and keeps what it was sent."""

    def __init__(self, *replies: str):
        self.replies = list(replies)

    def __call__(self, messages: list[Message]) -> tuple[str, int, int]:
        reply = self.replies.pop(0)
        return reply, sum(len(m.text.split()) + 85 * m.pictures for m in messages), len(reply.split())


class Chat:
    """The shared part of three chat agents: ask, validate, ask again with the error."""

    name = "scripted-chat-1"

    def __init__(self, *replies: str, tries: int = 5):
        self.model, self.contexts, self.tries = ChatModel(*replies), [], tries

    def ask(self, schema, context, text: str, pictures: int = 0) -> Reply:
        self.contexts.append(context)
        messages = [
            Message(role="system", text=context.skills.text),
            Message(role="user", text=text, pictures=pictures),
        ]
        spent, errors, repairs = [0, 0], [], []
        while True:
            raw, *tokens = self.model(messages)
            spent = [a + b for a, b in zip(spent, tokens)]
            try:
                value = schema.model_validate_json(raw.removeprefix("```json"))
            except ValueError as error:
                errors.append(str(error))
                if len(errors) == self.tries:
                    trace = Trace(
                        model="scripted-chat-1-2026", messages=tuple(messages), raw_reply=raw,
                        validation_errors=tuple(errors), input_tokens=spent[0], output_tokens=spent[1],
                        latency_seconds=0.5,
                    )  # fmt: skip
                    raise AgentError(f"{len(errors)} replies were refused", trace=trace, got=raw) from None
                messages += [Message(role="assistant", text=raw), Message(role="user", text=str(error))]
                continue
            if raw.startswith("```json"):
                repairs.append("The fence around the JSON was taken off.")
            trace = Trace(
                model="scripted-chat-1-2026", messages=tuple(messages), raw_reply=raw,
                validation_errors=tuple(errors), repairs=tuple(repairs),
                input_tokens=spent[0], output_tokens=spent[1], latency_seconds=0.25,
            )  # fmt: skip
            return Reply(value, trace)


class ChatSemantic(Chat, SemanticAgent):
    def compile(self, context):
        assert context.reading is None and context.rounds == ()
        return self.ask(SemanticReply, context, context.prompt)


class ChatPlanner(Chat, PlannerAgent):
    def judge(self, context, seen):
        frames = seen.key_frames.pick(3)
        assert [frame.frame for frame in frames] == [0, 4, 9]
        assert all(frame.png.startswith(b"\x89PNG") for frame in frames)
        return self.ask(Judgement, context, seen.report.text, pictures=len(frames))


class ChatExecutor(Chat, ExecutorAgent):
    def rewrite(self, context, failed):
        return self.ask(Rewrite, context, failed.judgement.suggestion)


def push(magnitude: float) -> str:
    action = {"action_type": "translation", "vector": [-1, 0, 0], "magnitude": magnitude}
    return json.dumps({"force_field": {"actions": [action]}})


def rewrite(magnitude: float) -> str:
    return json.dumps({**json.loads(push(magnitude)), "changes": ["pushed harder"]})


FAIL = '{"verdict": "FAIL", "suggestion": "Push harder: <b>it</b> hardly moves."}'
SUCCESS = '{"verdict": "SUCCESS"}'


def chat(semantic=(), planner=(), executor=()) -> Agents:
    return Agents(ChatSemantic(*semantic), ChatPlanner(*planner), ChatExecutor(*executor))


@pytest.fixture(scope="module")
def told(tmp_path_factory, robot_path):
    """A run that fails plainly twice and then succeeds; the semantic agent needs a second try."""
    agents = chat(
        semantic=[push(9.0), push(0.5)],
        planner=[FAIL, FAIL, "```json" + SUCCESS],
        executor=[rewrite(0.8), rewrite(1.2)],
    )
    out = tmp_path_factory.mktemp("chat") / "run"
    return made(small(robot_path, PROMPT), out, agents), agents


def trace_of(path) -> Trace:
    return Trace.model_validate_json(path.read_bytes())


def test_plain_verdicts_run_the_loop(told):
    store, _ = told
    manifest = store.manifest
    assert (manifest.iterations, manifest.best_iteration, manifest.verdict) == (3, 2, "SUCCESS")
    fields = [store.read(f"iterations/{k}/force_field.json", ForceField) for k in range(3)]
    assert [field.actions[0].magnitude for field in fields] == [0.5, 0.8, 1.2]


def test_every_exchange_is_kept_with_its_round(told):
    store, _ = told
    semantic = trace_of(store.path / "semantic_trace.json")
    assert semantic.model == "scripted-chat-1-2026" and semantic.raw_reply == push(0.5)
    assert "magnitude" in semantic.validation_errors[0]
    assert [m.role for m in semantic.messages] == ["system", "user", "assistant", "user"]
    last = trace_of(store.round_folder(2) / "planner_trace.json")
    assert last.repairs == ("The fence around the JSON was taken off.",)
    assert last.messages[1].pictures == 3
    assert trace_of(store.round_folder(1) / "executor_trace.json").raw_reply == rewrite(1.2)
    assert not (store.round_folder(2) / "executor_trace.json").exists()
    files = set(store.manifest.files)
    assert {
        "semantic_trace.json",
        "iterations/0/planner_trace.json",
        "iterations/0/executor_trace.json",
    } <= files


def test_tokens_are_summed_in_the_manifest(told):
    store, _ = told
    traces = {
        "semantic": [store.path / "semantic_trace.json"],
        "planner": [store.round_folder(k) / "planner_trace.json" for k in range(3)],
        "executor": [store.round_folder(k) / "executor_trace.json" for k in range(2)],
    }
    for cost in store.manifest.agents:
        own = [trace_of(path) for path in traces[cost.agent]]
        assert cost.implementation == "scripted-chat-1" and cost.calls == len(own)
        assert cost.input_tokens == sum(trace.input_tokens for trace in own) > 0
        assert cost.output_tokens == sum(trace.output_tokens for trace in own) > 0


def test_agents_are_told_of_all_earlier_rounds(told):
    _, agents = told
    assert [len(context.rounds) for context in agents.planner.contexts] == [0, 1, 2]
    assert [len(context.rounds) for context in agents.executor.contexts] == [0, 1]
    last = agents.planner.contexts[-1]
    assert last.prompt == PROMPT and last.brief.object_name == "robot"
    assert last.reading.force_field.actions[0].magnitude == 0.5
    first = last.rounds[0]
    assert first.judgement.verdict is Verdict.FAIL and "body length" in first.report.text
    assert first.force_field.actions[0].magnitude == 0.5
    assert "impulse" in last.skills.text and "actions" in last.skills.json_schema["properties"]


def test_key_frames_are_the_rounds_pictures(told):
    _, agents = told
    pictures = agents.planner.contexts[-1].rounds[0].key_frames.pick(2)
    assert [frame.frame for frame in pictures] == [0, 9]
    assert iio.imread(pictures[1].png).shape == (96, 96, 3)


def test_the_report_tells_the_exchange(told):
    store, _ = told
    page = write_report(store.path).read_text()
    for text in (
        "scripted-chat-1-2026",
        "The fence around the JSON was taken off.",
        "Replies that were refused",
    ):
        assert text in page
    assert page.count("How the planner came to it") == 3 and page.count("How the executor came to it") == 2
    assert "How the semantic agent came to it" in page
    assert "<b>it</b>" not in page and "\u2014 of 1" not in page and "<b>—</b>" not in page
    assert "without single checks" in page


def test_without_scores_a_failed_run_ends_with_its_last_round(tmp_path, robot_path):
    agents = chat([push(0.5)], [FAIL, FAIL], [rewrite(0.8)])
    store = made(small(robot_path, PROMPT, rounds=2), tmp_path / "run", agents)
    assert (store.manifest.best_iteration, store.manifest.verdict) == (1, "FAIL")
    assert write_report(store.path).is_file()


def test_what_was_spent_before_a_stop_stays_counted(tmp_path, robot_path):
    asked, out = small(robot_path, PROMPT), tmp_path / "run"
    with pytest.raises(IndexError):  # the planner has no second answer
        made(asked, out, chat([push(0.5)], [FAIL], [rewrite(0.8)]))
    before = Manifest.model_validate_json((tmp_path / "run" / "manifest.json").read_bytes())
    assert {cost.agent: cost.calls for cost in before.agents} == {"semantic": 1, "planner": 1, "executor": 1}
    agents = chat([], [SUCCESS], [])
    store = made(asked, out, agents)
    assert {cost.agent: cost.calls for cost in store.manifest.agents} == {
        "semantic": 1,
        "planner": 2,
        "executor": 1,
    }
    assert [cost.input_tokens > 0 for cost in store.manifest.agents] == [True] * 3
    (context,) = agents.planner.contexts
    assert len(context.rounds) == 1 and len(context.rounds[0].key_frames.pick()) == 6
    assert trace_of(store.path / "semantic_trace.json").raw_reply == push(0.5)


GOOD = {"semantic": push(0.5), "planner": FAIL, "executor": rewrite(0.8)}
KIND = {"semantic": ChatSemantic, "planner": ChatPlanner, "executor": ChatExecutor}
PLACE = {"semantic": "", "planner": "iterations/0/", "executor": "iterations/0/"}


def failing(role: str) -> Agents:
    """Agents of which one has only refused replies, and gives up after two."""
    bad = KIND[role]("what?", "<b>no</b>", tries=2)
    return dataclasses.replace(chat([push(0.5)], [FAIL], [rewrite(0.8)]), **{role: bad})


def costs_of(out):
    manifest = Manifest.model_validate_json((out / "manifest.json").read_bytes())
    return {cost.agent: cost for cost in manifest.agents}


@pytest.mark.parametrize("role", KIND)
def test_an_agent_that_fails_for_good_leaves_what_it_tried_and_the_run_goes_on_later(
    role, tmp_path, robot_path
):
    asked, out = small(robot_path, PROMPT, rounds=2), tmp_path / "run"
    spent = 0
    for count in (1, 2):  # twice in a row
        with pytest.raises(AgentError, match=f"the {role} .*gave no answer: 2 replies were refused"):
            made(asked, out, failing(role))
        path = out / f"{PLACE[role]}{role}_failed_{count}.json"
        call = FailedCall.model_validate_json(path.read_bytes())
        assert call.trace.raw_reply == "<b>no</b>" and len(call.trace.validation_errors) == 2
        assert [m.role for m in call.trace.messages] == ["system", "user", "assistant", "user"]
        spent += call.trace.input_tokens
        cost = costs_of(out)[role]
        assert (cost.calls, cost.failed_calls, cost.input_tokens) == (count, count, spent)
    assert (out / "run.json").is_file() and call.trace.latency_seconds == 0.5
    page = write_report(out).read_text()  # of what there is so far
    name = "semantic agent" if role == "semantic" else role
    assert page.count(f"A call of the {name} that gave no answer") == 2
    assert "&lt;b&gt;no" in page and "<b>no" not in page

    good = chat([push(0.5)], [SUCCESS], []) if role != "executor" else chat([], [SUCCESS], [rewrite(0.8)])
    store = made(asked, out, good)
    assert store.manifest.complete and store.manifest.verdict == "SUCCESS"
    cost = {cost.agent: cost for cost in store.manifest.agents}[role]
    assert (cost.calls, cost.failed_calls) == (3, 2) and cost.input_tokens > spent
    assert path.is_file() and path.relative_to(out).as_posix() in store.manifest.files
    assert "2 failed" in write_report(out).read_text()


def test_an_agent_that_fails_in_a_coarse_round_ends_the_run(tmp_path, robot_path):
    asked, out = small(robot_path, PROMPT, particles=1800, cells=None, probe=True), tmp_path / "run"
    with pytest.raises(AgentError):
        made(asked, out, failing("planner"))
    assert (out / "probe/iterations/0/planner_failed_1.json").is_file()
    assert not (out / "iterations").exists() and costs_of(out)["planner"].failed_calls == 1


def test_a_failed_call_is_kept_when_what_comes_next_is_refused(tmp_path, robot_path, monkeypatch):
    from physagent_jax.run import rounds

    asked, out = small(robot_path, PROMPT), tmp_path / "run"
    with pytest.raises(AgentError):
        made(asked, out, failing("semantic"))

    def refuse(*_, **__):
        raise UserError("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(rounds, "write_rollout", refuse)
        with pytest.raises(UserError, match="disk"):
            made(asked, out, chat([push(0.5)]))
    assert costs_of(out)["semantic"].calls == 2 and (out / "semantic_failed_1.json").is_file()


def read_refused(out):
    return RefusedReadings.model_validate_json((out / "refused.json").read_bytes()).readings


TIGHT = Limits(memory=0.1)


def test_a_sentence_whose_run_is_refused_for_its_cost_is_kept_and_not_asked_again(tmp_path, robot_path):
    asked, out = small(robot_path, PROMPT, rounds=1), tmp_path / "run"
    with pytest.raises(UserError, match=r"max-memory.*refused\.json"):
        made(asked, out, chat([push(9.0), push(0.5)]), limits=TIGHT)
    (kept,) = read_refused(out)
    assert kept.prompt == PROMPT and "--max-memory" in kept.error
    assert kept.trace.raw_reply == push(0.5) and len(kept.trace.validation_errors) == 1
    (cost,) = kept.agents
    assert (cost.agent, cost.calls, cost.failed_calls) == ("semantic", 1, 0)
    assert cost.input_tokens == kept.trace.input_tokens > 0
    with pytest.raises(UserError, match="max-memory"):  # once more: nobody is asked, nothing is counted twice
        made(asked, out, chat(), limits=TIGHT)
    assert read_refused(out) == (kept,)

    store = made(asked, out, chat([], [SUCCESS]))
    assert store.manifest.complete and not (out / "refused.json").exists()
    assert {cost.agent: cost.calls for cost in store.manifest.agents} == {"semantic": 1, "planner": 1}
    assert costs_of(out)["semantic"].input_tokens == cost.input_tokens
    assert trace_of(out / "semantic_trace.json") == kept.trace


def test_a_refused_run_does_not_hold_the_folder_against_another(tmp_path, robot_path):
    out = tmp_path / "run"
    with pytest.raises(UserError, match="max-memory"):
        made(small(robot_path, PROMPT), out, chat([push(0.5)]), limits=TIGHT)
    other = small(robot_path, "push the robot up", rounds=1)
    store = made(other, out, chat([push(0.4)], [SUCCESS]))
    assert store.manifest.complete and "refused.json" not in store.manifest.files
    assert costs_of(out)["semantic"].calls == 1
    assert [each.prompt for each in read_refused(out)] == [PROMPT]
    page = write_report(out).read_text()
    assert "A sentence that was read, and its run refused" in page and "--max-memory" in page


def test_a_finished_run_stands_when_the_one_that_is_to_replace_it_is_refused(tmp_path, robot_path):
    out = tmp_path / "run"
    first = made(small(robot_path, PROMPT, rounds=1), out, chat([push(0.5)], [SUCCESS]))
    video, other = (
        (first.path / "perception.mp4").read_bytes(),
        small(robot_path, "push the robot up", rounds=1),
    )
    with pytest.raises(UserError, match="max-memory"):
        made(other, out, chat([push(0.4)]), limits=TIGHT, overwrite=True)
    assert (out / "perception.mp4").read_bytes() == video and not (out / ".previous").exists()
    assert made(small(robot_path, PROMPT, rounds=1), out, chat()).manifest.complete
    again = made(other, out, chat([], [SUCCESS]), overwrite=True)
    assert again.manifest.prompt == "push the robot up" and not (out / "refused.json").exists()


def test_a_reading_is_kept_when_the_first_round_is_refused(tmp_path, robot_path, monkeypatch):
    from physagent_jax.run import rounds

    asked, out = small(robot_path, PROMPT, rounds=1), tmp_path / "run"

    def refuse(*_, **__):
        raise UserError("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(rounds, "write_rollout", refuse)
        with pytest.raises(UserError, match="disk"):
            made(asked, out, chat([push(0.5)]))
    assert not (out / "manifest.json").exists() and len(read_refused(out)) == 1
    assert made(asked, out, chat([], [SUCCESS])).manifest.complete


def test_a_file_of_refused_readings_that_is_none_is_not_written_over(tmp_path, robot_path):
    out = tmp_path / "run"
    out.mkdir()
    (out / "refused.json").write_text("mine")
    with pytest.raises(UserError, match=r"refused\.json"):
        made(small(robot_path, PROMPT), out, chat([push(0.5)]))
    assert [path.name for path in out.iterdir()] == ["refused.json"]


def test_a_run_that_is_to_be_replaced_stands_until_the_agent_answers(tmp_path, robot_path):
    out = tmp_path / "run"
    first = made(small(robot_path, PROMPT, rounds=1), out, chat([push(0.5)], [SUCCESS]))
    video = (first.path / "perception.mp4").read_bytes()
    with pytest.raises(AgentError):
        made(small(robot_path, "push the robot up", rounds=1), out, failing("semantic"), overwrite=True)
    assert (out / ".previous" / "perception.mp4").read_bytes() == video
    again = made(small(robot_path, "push the robot up", rounds=1), out, chat([push(0.5)], [SUCCESS]))
    assert again.manifest.complete and not (out / ".previous").exists()


def test_a_failed_call_is_one_line_of_the_terminal(tmp_path, robot_path, monkeypatch, capsys):
    from physagent_jax.cli import main
    from physagent_jax.run import chosen_agents

    monkeypatch.setattr(chosen_agents, "open_agents", lambda *_, **__: nullcontext(failing("semantic")))
    command = ["run", "--object", str(robot_path), "--prompt", PROMPT, "--out", str(tmp_path / "run")]
    assert main(command) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if "gave no answer" in line]
    assert len(lines) == 1 and "The same command asks again" in lines[0]
    assert str(tmp_path / "run" / "semantic_failed_1.json") in lines[0]


def test_rules_and_models_take_turns(tmp_path, robot_path):
    """Rules read and rewrite, a model judges: without checks the rules have nothing to mend, and the run ends."""
    agents = dataclasses.replace(make_agents(), planner=ChatPlanner(FAIL))
    store = made(small(robot_path, PROMPT), tmp_path / "run", agents)
    assert (store.manifest.iterations, store.manifest.verdict) == (1, "FAIL")
    assert trace_of(store.path / "semantic_trace.json").is_empty
    assert trace_of(store.round_folder(0) / "executor_trace.json").is_empty


def test_the_rules_alone_make_no_pictures(tmp_path, robot_path, monkeypatch):
    from physagent_jax.run import key_frames

    monkeypatch.setattr(key_frames, "read_video", lambda path: pytest.fail("a picture was asked for"))
    store = made(small(robot_path, PROMPT, rounds=1), tmp_path / "run", make_agents())
    page = write_report(store.path).read_text()
    assert store.manifest.complete and "came to it" not in page


def test_agents_are_chosen_by_name():
    assert set(make_agents().names.values()) == {"GrammarSemanticAgent", "RulePlanner", "RuleExecutor"}
    with pytest.raises(UserError, match="agents.planner"):
        make_agents(planner="rulse")


def verdicts(*pairs):
    return [Judgement(verdict=verdict, score=score) for verdict, score in pairs]


@pytest.mark.parametrize(
    ("judgements", "best"),
    [
        (verdicts(("FAIL", 0.2), ("FAIL", 0.7), ("FAIL", 0.7)), 1),
        (verdicts(("FAIL", None), ("FAIL", None)), 1),
        (verdicts(("FAIL", None), ("SUCCESS", None), ("FAIL", None)), 1),
        (verdicts(("FAIL", 0.9), ("FAIL", None)), 1),  # one score cannot be compared with none
        (verdicts(("SUCCESS", None)), 0),
    ],
)
def test_the_best_round(judgements, best):
    assert find_best_round(judgements) == best
