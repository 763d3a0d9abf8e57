"""Trajectories through files."""

import csv

import numpy as np
import pytest

from horosphere.errors import InputError
from horosphere.io import load_trajectory, save_trajectory
from horosphere.scenes import Trajectory

NAMES = ("shoulder", "elbow, left", "wrist")


def some(seed, rates=2, names=NAMES):
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.01, 0.2, 7))
    blocks = rng.normal(size=(1 + rates, 7, 3)) * 10.0 ** rng.integers(-12, 12, size=(1 + rates, 7, 3))
    return Trajectory(time, *blocks, names=names)


@pytest.mark.parametrize("rates", [0, 1, 2])
@pytest.mark.parametrize("ending", ["npz", "csv", "mcap"])
@pytest.mark.parametrize("seed", range(3))
def test_round_trip(tmp_path, seed, ending, rates):
    if ending == "mcap":
        pytest.importorskip("mcap_ros2")
    trajectory = some(seed, rates)
    again = load_trajectory(save_trajectory(trajectory, tmp_path / f"t.{ending}"))
    for name in ("positions", "velocities", "accelerations"):
        x, y = getattr(trajectory, name), getattr(again, name)
        assert (x is None) == (y is None)
        assert x is None or np.array_equal(x, y)  # to the last bit
    if ending == "mcap":  # nanoseconds since the first waypoint
        np.testing.assert_allclose(again.time, trajectory.time - trajectory.time[0], atol=1e-9)
    else:
        assert np.array_equal(again.time, trajectory.time)
    assert again.names == NAMES
    assert [p.name for p in tmp_path.iterdir()] == [f"t.{ending}"]


def test_what_others_read(tmp_path):
    trajectory = some(0)
    with np.load(save_trajectory(trajectory, tmp_path / "t.npz")) as archive:  # numpy alone
        assert set(archive.files) == {"time", "q", "dq", "ddq", "names"}
    with open(save_trajectory(trajectory, tmp_path / "t.csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[3]["elbow, left.velocity"]) == trajectory.velocities[3, 1]


def test_mcap_is_ros_2(tmp_path):
    factory = pytest.importorskip("mcap_ros2.decoder").DecoderFactory()
    from mcap.reader import make_reader

    with open(save_trajectory(some(1), tmp_path / "t.mcap"), "rb") as file:
        ((schema, channel, _, message),) = make_reader(file, decoder_factories=[factory]).iter_decoded_messages()
    assert schema.name == "trajectory_msgs/msg/JointTrajectory" and channel.message_encoding == "cdr"
    assert list(message.joint_names) == list(NAMES)
    assert len(message.points) == 7


def test_files_of_other_planners(tmp_path):
    np.savez(tmp_path / "bare.npz", q=np.zeros((4, 2)))
    assert load_trajectory(tmp_path / "bare.npz").time.tolist() == [0, 1, 2, 3]
    (tmp_path / "windows.csv").write_bytes(b"\xef\xbb\xbftime,a,b\r\n0,1,2\r\n0.5,3,4\r\n\r\n")
    read = load_trajectory(tmp_path / "windows.csv")
    assert read.names == ("a", "b") and read.positions.tolist() == [[1, 2], [3, 4]]


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("", "", "empty"),
        ("0,1,2\n1,2,3\n", ":1", "no header"),
        ("time,a\n", ":1", "no waypoints"),
        ("time,a\n0,1\n1\n", ":3", "expected 2 values"),
        ("time,a\n0,1\n1,x\n", ":3:2", "a: expected a finite number, got 'x'"),
        ("time,a\n0,1\n1,nan\n", ":3:2", "got 'nan'"),
        ("time,a\n0,1\n0,2\n", ": time", "does not increase"),
        ("time,a,a\n0,1,2\n", ":1", "two columns are named 'a'"),
        ("time\n0\n", ":1", "no joint columns"),
        ("time,a,b,a.velocity\n0,1,2,3\n", ":1", "'b.velocity' is missing"),
        ("time;a;b\n0,5;1;2\n", ":2:1", "time: expected a finite number, got '0,5' .write decimal points"),
        ("0,5;1,5;2,5\n1;2;3\n", ":1", "no header"),
        ("time a b\n0 1 2\n", ":1", "one column, named 'time a b' .separate the columns"),
        ("a\n" + 99 * "x" + "\n", ":2:1", r"got 'x{57}\.\.\.'"),
    ],
)
def test_bad_csv(tmp_path, text, place, words):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        load_trajectory(path)
    assert caught.value.place == f"{path}{place}"


def test_bad_files(tmp_path):
    for name, words in (("x.txt", "ending '.txt'"), ("x.npz", "no such file"), (".", "ending ''")):
        with pytest.raises(InputError, match=words):
            load_trajectory(tmp_path / name)
    (tmp_path / "bad.npz").write_bytes(b"PK\x03\x04 but no archive")
    with pytest.raises(InputError, match="not a readable NPZ"):
        load_trajectory(tmp_path / "bad.npz")
    np.savez(tmp_path / "other.npz", positions=np.zeros((2, 2)))
    with pytest.raises(InputError, match="no array 'q' in it, only positions"):
        load_trajectory(tmp_path / "other.npz")
    np.savez(tmp_path / "object.npz", q=np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError, match="not a readable NPZ"):  # nothing is unpickled
        load_trajectory(tmp_path / "object.npz")
    np.savez(tmp_path / "shape.npz", q=np.zeros(3))
    with pytest.raises(InputError, match="expected 2 axes"):
        load_trajectory(tmp_path / "shape.npz")
    (tmp_path / "bad.mcap").write_bytes(b"nothing")
    with pytest.raises(InputError, match="not a readable MCAP"):
        load_trajectory(tmp_path / "bad.mcap")
    (tmp_path / "bad.csv").write_bytes(b"time,a\n0,\xff\n")
    with pytest.raises(InputError, match=r"byte 9 is not UTF-8 \(save it as UTF-8\)"):
        load_trajectory(tmp_path / "bad.csv")


@pytest.mark.parametrize("separator", [";", "\t"])
def test_csv_with_other_separators(tmp_path, separator):
    trajectory = some(4, names=("a", "b", "c"))
    file = save_trajectory(trajectory, tmp_path / "t.csv")
    file.write_text(file.read_text().replace(",", separator))
    again = load_trajectory(file)
    assert again.names == trajectory.names and np.array_equal(again.positions, trajectory.positions)
    assert np.array_equal(again.accelerations, trajectory.accelerations)


@pytest.mark.parametrize("ending", ["npz", "mcap"])
def test_a_file_that_was_cut_off_is_refused_or_whole(tmp_path, ending):
    """The message of an MCAP file may be complete where only its index is gone."""
    if ending == "mcap":
        pytest.importorskip("mcap_ros2")
    trajectory = some(2)
    data = save_trajectory(trajectory, tmp_path / f"t.{ending}").read_bytes()
    refused = 0
    for cut in np.linspace(1, len(data) - 1, 40).astype(int):
        (tmp_path / f"cut.{ending}").write_bytes(data[:cut])
        try:
            found = load_trajectory(tmp_path / f"cut.{ending}")
        except InputError as error:
            refused += 1
            assert "cut." in str(error)
        else:
            assert np.array_equal(found.positions, trajectory.positions)
    assert refused > 30


def test_an_mcap_file_with_several_motions(tmp_path):
    """Certified would be one of them only."""
    pytest.importorskip("mcap_ros2")
    from mcap_ros2.writer import Writer

    from horosphere.io import _mcap

    with open(tmp_path / "two.mcap", "wb") as file:
        writer = Writer(file)
        schema = writer.register_msgdef(_mcap._TYPE, _mcap._SCHEMA)
        point = {
            "positions": [0.0],
            "velocities": [],
            "accelerations": [],
            "effort": [],
            "time_from_start": {"sec": 0, "nanosec": 0},
        }
        header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
        for topic in ("/plan", "/other"):
            writer.write_message(
                topic, schema, {"header": header, "joint_names": ["a"], "points": [point]}, log_time=0, publish_time=0
            )
        writer.finish()
    with pytest.raises(InputError, match=r"2 trajectory_msgs.* messages in it, on /plan, /other"):
        load_trajectory(tmp_path / "two.mcap")
