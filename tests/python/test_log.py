"""The log opens with a protobuf-aware MCAP reader, and its values are those of the CSV files."""

import csv
import json
import os
import subprocess
import sys
import tomllib
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_protobuf.decoder import DecoderFactory


@pytest.fixture(scope="session")
def log(run):
    """The messages by topic, each with its MCAP record: a list of (record, message)."""
    topics = defaultdict(list)
    with open(run / "log.mcap", "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, record, message in reader.iter_decoded_messages(log_time_order=False):
            topics[channel.topic].append((record, message))
    return topics


def table(path):
    """Column names and values of a CSV file."""
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, dtype=float)


def accepted(log, topic):
    return [message for _, message in log[topic] if message.accepted]


def test_histories_are_the_accepted_answers(run, log):
    header, values = table(run / "histories.csv")
    answers = {"dam": accepted(log, "/dam/answer"), "reservoir": accepted(log, "/reservoir/answer")}
    assert len(values) == len(answers["dam"]) == len(answers["reservoir"]) == 245
    compared = 0
    for column, name in enumerate(header):
        name = name.split(" [")[0]
        unit, _, quantity = name.partition(".")
        if unit not in answers:
            continue
        quantity, _, index = quantity.partition(".")
        fields = [getattr(answer, quantity) for answer in answers[unit]]
        if index:
            fields = [field[{"x": 0, "y": 1}.get(index) if index in "xy" else int(index)] for field in fields]
        np.testing.assert_array_equal(values[:, column], fields, err_msg=name)
        compared += 1
    assert compared >= 20
    times = [message.end_time for message in answers["dam"]]
    np.testing.assert_allclose(values[:, 0], times, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "unit, quantity",
    [("dam", "interface_displacement"), ("dam", "interface_acceleration"), ("reservoir", "interface_pressure")],
)
def test_wet_face_files_are_the_accepted_answers(run, log, unit, quantity):
    _, values = table(run / f"{unit}-{quantity}.csv")
    answers = np.array([getattr(answer, quantity) for answer in accepted(log, f"/{unit}/answer")])
    np.testing.assert_array_equal(values[:, 1:], answers)
    norms = [getattr(answer, f"{quantity}_norm") for answer in accepted(log, f"/{unit}/answer")]
    np.testing.assert_allclose(norms, np.linalg.norm(answers, axis=1), rtol=1e-12)


def test_every_iteration_is_there(log):
    steps = [message for _, message in log["/step"]]
    assert [message.step for message in steps] == list(range(245))
    assert all(message.converged for message in steps)
    for unit in ("dam", "reservoir"):
        requests, answers = log[f"/{unit}/request"], log[f"/{unit}/answer"]
        assert len(requests) == len(answers) == sum(message.iterations for message in steps[1:]) + 1
        for (sent, request), (came, answer) in zip(requests, answers):
            assert sent.sequence == came.sequence
            assert (request.step, request.iteration, request.accepted) == (
                answer.step,
                answer.iteration,
                answer.accepted,
            )
            assert request.end_time == request.start_time + request.communication_step
            assert sent.publish_time == round(request.end_time * 1e9)
            assert request.wall_time <= answer.wall_time


def test_each_unit_was_asked_what_the_other_answered(log):
    """Dam and reservoir receive what the other gave."""
    dam = {(m.step, m.iteration): m for _, m in log["/dam/answer"]}
    for _, request in log["/reservoir/request"]:
        if request.step:
            answer = dam[request.step, request.iteration]
            assert list(request.interface_acceleration) == list(answer.interface_acceleration)


def test_time_order(log):
    """Log time never decreases; within a step it is the step's end plus a counter, and never before the publish time."""
    ranges = defaultdict(list)
    for topic in ("/dam/request", "/dam/answer", "/reservoir/request", "/reservoir/answer", "/step"):
        times = [record.log_time for record, _ in log[topic]]
        assert times == sorted(times)
        for record, message in log[topic]:
            ranges[message.step].append(record.log_time)
            assert record.publish_time <= record.log_time
    for step, times in ranges.items():
        end = round(step * 0.0025 * 1e9)
        assert end <= min(times) and max(times) < end + 1000


def test_all_topics_are_there(log):
    exchanges = {f"/{unit}/{half}" for unit in ("dam", "reservoir") for half in ("request", "answer")}
    assert set(log) == exchanges | {"/scene", "/build", "/unit", "/ground_motion", "/log", "/iteration", "/step", "/checkpoint", "/end"}


def test_units_speak(log):
    """Messages have the type that Foxglove's log panel shows."""
    for record, message in log["/log"]:
        assert message.DESCRIPTOR.full_name == "foxglove.Log"
        assert (message.level, message.step, message.iteration) == (2, 0, 0)
        assert message.timestamp.seconds == 0 and record.publish_time == 0
    said = [(message.name, message.file) for _, message in log["/log"]]
    assert said == [
        ("dam", "cofferdam_dam::dam"),
        ("dam", "cofferdam_dam::dam::rest"),
        ("reservoir", "cofferdam_reservoir::reservoir"),
    ]
    assert "elements" in log["/log"][0][1].message
    levels = log["/log"][0][1].DESCRIPTOR.enum_types_by_name["Level"].values_by_name
    assert {name: value.number for name, value in levels.items()}["WARNING"] == 3


def test_units_list_their_variables(log):
    for _, unit in log["/unit"]:
        for half, variables in (("request", unit.inputs), ("answer", unit.outputs)):
            _, first = log[f"/{unit.name}/{half}"][0]
            for variable in variables:
                values = getattr(first, variable.name)
                assert (len(values) if variable.array else 1) == variable.size
    (_, dam), (_, reservoir) = log["/unit"]
    assert [variable.name for variable in dam.inputs][0] == "interface_pressure"
    assert [(v.name, v.unit) for v in reservoir.outputs][0] == ("interface_pressure", "Pa")


def test_the_log_says_what_was_run(run, log):
    manifest = tomllib.loads((run / "manifest.toml").read_text())
    (scene,) = [message for _, message in log["/scene"]]
    assert tomllib.loads(scene.toml) == manifest["scene"]
    (build,) = [message for _, message in log["/build"]]
    assert build.commit == manifest["build"]["commit"]
    units = [(message.name, message.fingerprint) for _, message in log["/unit"]]
    assert units == [(unit["name"], unit["fingerprint"]) for unit in manifest["units"]]
    assert [name for name, _ in units] == ["dam", "reservoir"] and len(units[0][1]) == 64
    (ground,) = [message for _, message in log["/ground_motion"]]
    assert ground.interval == pytest.approx(0.01) and len(ground.acceleration) == 51
    (end,) = [message for _, message in log["/end"]]
    assert end.status == "completed"


def cofferdam(*arguments):
    """Exit status of the program, and what it says."""
    done = subprocess.run([os.environ["COFFERDAM"], *arguments], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def doctor(path):
    """What pymcap-cli finds wrong in a file: its findings by code, without those that are only information."""
    command = [Path(sys.executable).parent / "pymcap-cli", "doctor", "--format", "jsonl", path]
    done = subprocess.run(command, capture_output=True, text=True)
    *findings, summary = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 0 and summary["type"] == "summary" and summary["complete"], done.stderr
    found = defaultdict(int)
    for finding in findings:
        if finding["severity"] != "info":
            found[finding["code"]] += 1
    assert summary["errors"] + summary["warnings"] == 0 or found
    return dict(found)


def test_a_doctor_of_mcap_files_finds_nothing(run, tmp_path):
    """Neither in a finished log, nor in those recovered from one that was cut and one that was damaged."""
    assert doctor(run / "log.mcap") == {}
    content = (run / "log.mcap").read_bytes()
    damaged = bytearray(content)
    damaged[len(content) // 3] ^= 1
    for name, broken in (("cut", content[: len(content) * 3 // 5]), ("damaged", bytes(damaged))):
        (tmp_path / name).write_bytes(broken)
        recovered = tmp_path / f"{name}.mcap"
        status, said = cofferdam("log", "recover", tmp_path / name, "--output", recovered)
        assert status == 0 and "missing " in said, said
        assert doctor(recovered) == {}
        status, said = cofferdam("log", "info", recovered)
        assert status == 0 and "missing " in said, said


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE])
def test_a_log_that_another_program_wrote_anew_is_the_same(run, tmp_path, compression):
    copy = tmp_path / "copy.mcap"
    with open(run / "log.mcap", "rb") as file, open(copy, "wb") as output:
        writer = Writer(output, compression=compression, chunk_size=1 << 16)
        writer.start(library="another")
        channels = {}
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            if channel.id not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, number)
            times = {"log_time": message.log_time, "publish_time": message.publish_time}
            writer.add_message(channels[channel.id], data=message.data, sequence=message.sequence, **times)
        writer.finish()
    assert (b"zstd" in copy.read_bytes()) == (compression is CompressionType.ZSTD)
    for command in (("diff", run / "log.mcap", copy), ("info", copy)):
        status, said = cofferdam("log", *command)
        assert status == 0, said
    status, said = cofferdam("log", "recover", copy, "--output", tmp_path / "again.mcap")
    assert status == 0 and "missing" not in said, said
    status, said = cofferdam("log", "diff", run / "log.mcap", tmp_path / "again.mcap")
    assert status == 0, said


def test_what_another_program_recovers_is_read(run, tmp_path):
    """pymcap-cli copies chunks, and writes schemas and channels between them."""
    recovered = tmp_path / "recovered.mcap"
    command = [Path(sys.executable).parent / "pymcap-cli", "recover", run / "log.mcap", recovered]
    subprocess.run(command, check=True, capture_output=True)
    status, said = cofferdam("log", "diff", run / "log.mcap", recovered)
    assert status == 0, said
    status, said = cofferdam("log", "info", recovered)
    assert status == 0, said
