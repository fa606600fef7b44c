import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.bvh import Bvh, Joint, positions, with_offsets, write_bvh
from ros_free_stack.formats.bvh_reader import read_bvh

BVH = """HIERARCHY
ROOT hip
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT knee
  {
    OFFSET 0 -40 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -30 0
    }
  }
  JOINT chest
  {
    OFFSET 0 50 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 20 0
    }
  }
}
MOTION
Frames:\t3
Frame Time:\t0.05
0 90 0 0 0 0 0 0 0 0 0 0
1 90 0 0 90 0 0 0 0 0 0 0
0 90 0 0 0 0 0 -90 90 90 0 0
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "a.bvh"
    path.write_text(text, encoding="utf-8")
    return path


def test_positions(tmp_path: Path) -> None:
    data = read_bvh(written(tmp_path, BVH))
    assert data.names == ("hip", "knee", "knee_end", "chest", "chest_end")
    assert data.fps == pytest.approx(20)
    points = positions(data)
    down = [[0, 90, 0], [0, 50, 0], [0, 20, 0], [0, 140, 0], [0, 160, 0]]
    np.testing.assert_allclose(points[0], down, atol=1e-9)
    np.testing.assert_allclose(points[1], np.array(down) + np.array([1, 0, 0]), atol=1e-9)
    # Channels apply from the left: the shank turns by -90 degrees about x (the y turn before it does nothing),
    # the head by 90 about z.
    np.testing.assert_allclose(points[2, 2], (0, 50, 30), atol=1e-9)
    np.testing.assert_allclose(points[2, 4], (-20, 140, 0), atol=1e-9)


def test_windows_line_ends_read_the_same(tmp_path: Path) -> None:
    unix = read_bvh(written(tmp_path, BVH))
    path = tmp_path / "dos.bvh"
    path.write_bytes(BVH.replace("\n", " \r\n").encode())
    np.testing.assert_array_equal(read_bvh(path).values, unix.values)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1 90 0 0 90", "1 90 0 0 x", "line 29: expected a finite number, found 'x'"),
        ("1 90 0 0 90", "1 90 0 90", "line 29: expected 12 numbers, found 11"),
        ("1 90 0 0 90", "1 inf 0 0 90", "line 29: expected a finite number, found 'inf'"),
        ("Frames:\t3", "Frames: many", "line 26: expected 'Frames: NUMBER'"),
        (BVH[BVH.index("0 90 0 0 0") :], "", "holds 0 frames of 12 channels"),
        ("0 90 0 0 0 0 0 -90 90 90 0 0\n", "0 90 0 0 0", "line 30: expected 12 numbers, found 5 (truncated?)"),
        ("Frame Time:\t0.05\n", "", "line 27: expected 'Frame Time: NUMBER', found '0 90 0"),
        ("OFFSET 0 -40 0", "OFFSET 0 -40", "line 8: expected a finite number, found 'CHANNELS'"),
        ("JOINT knee", "JOINT", "line 6: unexpected 'JOINT'"),
        ("ROOT hip", "JOINT hip", "line 2: unexpected 'JOINT hip'"),
        ("JOINT knee\n  {", "JOINT knee\n", "line 8: expected '{', found 'OFFSET'"),
        ("OFFSET 0 -40 0", "OFFSET 0 -40 y", "line 8: expected a finite number, found 'y'"),
        (
            "CHANNELS 3 Zrotation Xrotation Yrotation\n    End",
            "CHANNELS 3 Zrotation\n    End",
            "line 9: expected a count",
        ),
        (
            "CHANNELS 3 Zrotation Xrotation Yrotation\n    End",
            "CHANNELS 2 Zrotation Zrotation\n    End",
            "line 9: expected a",
        ),
        (BVH[BVH.index("}\nMOTION") : BVH.index("MOTION")], "", "the hierarchy is not closed"),
        (BVH[BVH.index("MOTION") :], "", "no line 'MOTION'"),
    ],
)
def test_faults_are_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(InvalidFile) as caught:
        read_bvh(written(tmp_path, BVH.replace(old, new)))
    assert message in str(caught.value)


CHANNELS = "CHANNELS 3 Zrotation Xrotation Yrotation"
VARIANTS = {
    "lower case": lambda text: text.lower(),
    "upper case": lambda text: text.upper(),
    "channels in mixed case": lambda text: text.replace("Xposition", "XPosition").replace("Zrotation", "zRotation"),
    "blank lines": lambda text: (
        text.replace("MOTION\n", "\nMOTION\n\n").replace("3\n", "3\n\n").replace("0\n", "0\n \n")
    ),
    "braces on the joint's line": lambda text: re.sub(r"\n\s*\{", " {", text),
    "end site in one word's case": lambda text: text.replace("End Site", "END SITE"),
    "named end sites": lambda text: text.replace("End Site", "End Site toe"),
    "channels before offset": lambda text: re.sub(r"(OFFSET.*)(\s+)(CHANNELS.*)", r"\3\2\1", text),
    "channels over two lines": lambda text: text.replace(CHANNELS, CHANNELS.replace(" X", "\n X")),
    "spaces around the colon": lambda text: text.replace("Frames:\t3", "Frames : 3").replace("Time:\t", "Time :"),
    "no colon": lambda text: text.replace("Frames:\t", "Frames ").replace("Frame Time:\t", "FrameTime: "),
    "decimal comma": lambda text: text.replace("0.05", "0,05").replace("-90 90", "-90,0 90"),
    "rows over two lines": lambda text: text.replace(" 0 0 0 0 0 0 0\n", "\n0 0 0 0 0 0 0\n"),
    "ctrl-Z at the end": lambda text: text + "\x1a",
    "zeros at the end": lambda text: text + "\x00\x00\n",
}


@pytest.mark.parametrize("name", VARIANTS)
def test_variants_that_other_programs_read(tmp_path: Path, name: str) -> None:
    plain, variant = read_bvh(written(tmp_path, BVH)), read_bvh(written(tmp_path, VARIANTS[name](BVH)))
    np.testing.assert_array_equal(positions(variant), positions(plain))
    assert (variant.fps, variant.notes) == (plain.fps, ())
    assert [joint.lower() for joint in variant.names] == list(plain.names)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1"])
def test_text_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "a.bvh"
    path.write_bytes(BVH.replace("chest", "Brüstkorb").replace("\n", "\r\n").encode(encoding))
    assert read_bvh(path).names[3] == "Brüstkorb"
    path.write_bytes(BVH.replace("chest", "Bru\u0308stkorb").encode())
    assert read_bvh(path).names[3] == "Brüstkorb"
    path.write_bytes(b"\xff\xfe" + BVH.encode())
    with pytest.raises(InvalidFile, match=r"no line 'MOTION'|is not the utf-16 text"):
        read_bvh(path)


def test_names_with_spaces_are_one_name(tmp_path: Path) -> None:
    text = (
        BVH.replace("JOINT knee", "JOINT Bip01  L Calf").replace("JOINT chest", "JOINT 左腕 {").replace("{\n  {", "{")
    )
    assert read_bvh(written(tmp_path, text)).names == ("hip", "Bip01 L Calf", "Bip01 L Calf_end", "左腕", "左腕_end")


@pytest.mark.parametrize("count", [0, 2, 4, 300])
def test_rows_win_over_the_frame_counter(tmp_path: Path, count: int) -> None:
    data = read_bvh(written(tmp_path, BVH.replace("Frames:\t3", f"Frames: {count}")))
    np.testing.assert_array_equal(data.values, read_bvh(written(tmp_path, BVH)).values)
    assert data.notes == (f"the header counts {count} frames, the file holds 3: all of these are read",)


def test_text_after_the_frames_is_left_out_and_said(tmp_path: Path) -> None:
    data = read_bvh(written(tmp_path, BVH + "made by hand\n1 2\n"))
    assert len(data.values) == 3
    assert data.notes == ("line 31: text after the frames is left out",)


@pytest.mark.parametrize("time", ["0", "-0.05"])
def test_a_frame_time_that_is_none_gives_no_rate(tmp_path: Path, time: str) -> None:
    assert read_bvh(written(tmp_path, BVH.replace("0.05", time))).fps == 0


@pytest.mark.parametrize("pulled", [0.0, 1.5])
def test_position_channels_that_do_not_replace_the_offset(tmp_path: Path, pulled: float) -> None:
    plain = read_bvh(written(tmp_path, BVH))
    channels = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
    rows = [np.insert(row, [6, 6, 6, 9, 9, 9], [pulled, 0, 0] * 2) for row in plain.values]
    text = BVH.replace(CHANNELS, channels)
    text = text[: text.index("0 90 0 0 0")] + "\n".join(" ".join(map(str, row)) for row in rows)
    data = with_offsets(read_bvh(written(tmp_path, text)))
    expected = positions(plain)
    assert np.linalg.norm(positions(data) - expected, axis=-1).max() == pytest.approx(pulled)
    assert ("its offset stands" if not pulled else "added to it") in data.notes[0]
    assert with_offsets(data).notes == data.notes
    assert with_offsets(plain) is plain


def test_single_joints_at_zero_get_their_offset(tmp_path: Path) -> None:
    """Position channels in place of the offset, but for a joint whose channels were never filled."""
    moves = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
    plain = read_bvh(written(tmp_path, BVH))
    rows = [np.insert(row, [6, 6, 6, 9, 9, 9], [0, 0, 0, 0, 50, 0]) for row in plain.values]
    text = BVH.replace(CHANNELS, moves)
    text = text[: text.index("0 90 0 0 0")] + "\n".join(" ".join(map(str, row)) for row in rows)
    data = with_offsets(read_bvh(written(tmp_path, text)))
    np.testing.assert_allclose(positions(data), positions(plain), atol=1e-9)
    assert data.notes == ("the position channels of knee are zero: its offset stands",)


def test_some_joints_alone_lie_where_they_do_among_all(tmp_path: Path) -> None:
    data = read_bvh(written(tmp_path, BVH))
    np.testing.assert_array_equal(positions(data, [4, 1]), positions(data)[:, [4, 1]])


def test_a_file_of_too_many_joints_is_refused(tmp_path: Path) -> None:
    leaf = "JOINT a\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n"
    text = BVH.replace("  JOINT chest", leaf * 5000 + "}" * 5000 + "\n  JOINT chest")
    with pytest.raises(InvalidFile, match="holds 5005 joints and end sites, expected at most 5000"):
        read_bvh(written(tmp_path, text))


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match="cannot be read"):
        read_bvh(tmp_path / "none.bvh")


@given(st.data())
def test_damage_is_refused_or_harmless(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    path = written(tmp_path_factory.mktemp("damaged"), damaged(BVH, data))
    with suppress(InvalidFile):
        assert np.isfinite(positions(read_bvh(path))).all()


def damaged(text: str, data: st.DataObject) -> str:
    """The text with a few words removed, repeated or replaced."""
    words = re.split(r"(\s+)", text)
    for _ in range(data.draw(st.integers(0, 3))):
        place = data.draw(st.integers(0, len(words) - 1))
        word = words[place]
        words[place] = data.draw(
            st.sampled_from(["", f"{word} {word}", f"{word}\n{word}", "x", "0", "nan", "1e999", "}", "Xrotation"])
        )
    return "".join(words)


def test_position_channels_stand_in_place_of_the_offset(tmp_path: Path) -> None:
    moves = "Xposition Yposition Zposition"
    text = BVH.replace("OFFSET 0 0 0", "OFFSET 7 8 9").replace(
        "CHANNELS 3 Zrotation Xrotation Yrotation\n    End Site\n    {\n      OFFSET 0 -30 0",
        f"CHANNELS 6 {moves} Zrotation Xrotation Yrotation\n    End Site\n    {{\n      OFFSET 0 -30 0",
    )
    text = re.sub(r"^(0|1) 90 0 0 0 0 0", r"\1 90 0 0 0 0 1 -35 2 0", text, flags=re.MULTILINE)
    text = text.replace("1 90 0 0 90 0 0", "1 90 0 0 90 0 1 -35 2 0")
    data = read_bvh(written(tmp_path, text))
    np.testing.assert_allclose(positions(data)[0, :2], [[0, 90, 0], [1, 55, 2]], atol=1e-9)


@st.composite
def trees(draw: st.DrawFn) -> Bvh:
    """Random trees in depth-first order, random channels in random order, random end sites."""
    joints: list[Joint] = []
    vector = st.lists(st.integers(-5000, 5000).map(lambda value: value / 100), min_size=3, max_size=3)

    def grow(parent: int, depth: int) -> None:
        place = len(joints)
        kinds = draw(st.sampled_from([("rotation",), ("position", "rotation")]))
        channels = draw(st.permutations([f"{axis}{kind}" for kind in kinds for axis in "XYZ"]))
        joints.append(Joint(f"joint{place}", parent, np.array(draw(vector)), tuple(channels)))
        for _ in range(draw(st.integers(0, 3 if depth < 3 else 0))):
            grow(place, depth + 1)
        if len(joints) == place + 1 and draw(st.booleans()):
            joints.append(Joint(f"joint{place}_end", place, np.array(draw(vector)), ()))

    grow(-1, 0)
    width = sum(len(joint.channels) for joint in joints)
    rows = draw(st.integers(1, 4))
    values = np.random.default_rng(draw(st.integers(0, 10**6))).uniform(-180, 180, (rows, width)).round(6)
    return Bvh(tuple(joints), values, draw(st.sampled_from([20.0, 30.0, 59.94, 120.0])))


@given(trees())
def test_what_is_written_reads_the_same(tmp_path_factory: pytest.TempPathFactory, bvh: Bvh) -> None:
    path = tmp_path_factory.mktemp("bvh") / "a.bvh"
    write_bvh(path, bvh)
    back = read_bvh(path)
    assert back.names == bvh.names
    for old, new in zip(bvh.joints, back.joints, strict=True):
        assert (old.parent, old.channels) == (new.parent, new.channels)
        np.testing.assert_allclose(new.offset, old.offset)
    np.testing.assert_array_equal(back.values, bvh.values)
    assert back.fps == pytest.approx(bvh.fps, rel=1e-6)
    np.testing.assert_allclose(positions(back), positions(bvh), atol=1e-9)
