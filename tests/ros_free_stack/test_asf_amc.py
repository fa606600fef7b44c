import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.asf_amc import INCH, AsfSkeleton, positions, read_amc, read_asf

ASF = """# a thigh and a shank, in inches over 0.5
:version 1.10
:units
  mass 1.0
  length 0.5
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name thigh
    direction 0 -1 0
    length 8
    axis 0 0 20 XYZ
    dof rx rz
    limits (-160 20)
           (-70 70)
  end
  begin
    id 2
    name shank
    direction 0 -1 0
    length 6
    axis 0 0 0 XYZ
    dof rx
    limits (0 170)
  end
  begin
    id 3
    name sole
    direction 0 0 1
    length 2
    axis 0 0 0 XYZ
  end
:hierarchy
  begin
    root thigh
    thigh shank
    shank sole
  end
"""
AMC = """#!OML:ASF somewhere
:FULLY-SPECIFIED
:DEGREES
5
root 1 2 3 0 90 0
thigh 0 0
shank 0
6
root 1 2 3 0 0 0
thigh 90 0
shank -9.0e1
7
root 1 2 3 0 0 0
thigh 0 0
shank 4.5e-015
"""
UNIT = INCH / 0.5


@pytest.fixture
def skeleton(tmp_path: Path) -> AsfSkeleton:
    return read_asf(written(tmp_path, "s.asf", ASF))


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_skeleton(skeleton: AsfSkeleton) -> None:
    assert skeleton.names == ("root", "thigh", "shank", "sole")
    assert [bone.channels for bone in skeleton.bones[1:]] == [("rx", "rz"), ("rx",), ()]
    np.testing.assert_allclose(skeleton.bones[1].offset, (0, -8 * UNIT, 0))


def test_positions(tmp_path: Path, skeleton: AsfSkeleton) -> None:
    motion = read_amc(written(tmp_path, "s.amc", AMC), skeleton)
    assert {name: values.shape for name, values in motion.items()} == {"root": (3, 6), "thigh": (3, 2), "shank": (3, 1)}
    points = positions(skeleton, motion) / UNIT
    # Straight down from the root; the sole points where the root faces: after 90 degrees about y, along x.
    np.testing.assert_allclose(points[0], [[1, 2, 3], [1, -6, 3], [1, -12, 3], [3, -12, 3]], atol=1e-9)
    # The thigh turns about its own x axis, 20 degrees from the root's, and the shank turns back about the root's.
    c, s = np.cos(np.radians(20)), np.sin(np.radians(20))
    thigh = 8 * np.array([-s * c, -(s**2), -c])
    np.testing.assert_allclose(points[1, 1], thigh + np.array([1, 2, 3]), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=1), axis=-1), [[8, 6, 2]] * 3)
    np.testing.assert_allclose(points[2], [[1, 2, 3], [1, -6, 3], [1, -12, 3], [1, -12, 5]], atol=1e-9)


def test_windows_line_ends_read_the_same(tmp_path: Path, skeleton: AsfSkeleton) -> None:
    unix = read_amc(written(tmp_path, "s.amc", AMC), skeleton)
    dos = tmp_path / "dos.amc"
    dos.write_bytes(AMC.replace("\n", " \r\n").encode())
    np.testing.assert_array_equal(read_amc(dos, skeleton)["thigh"], unix["thigh"])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("shank -9.0e1", "shank x", "line 11: expected 'shank' and 1 finite numbers, found 'shank x'"),
        ("shank -9.0e1", "shank nan", "line 11: expected 'shank'"),
        ("shank -9.0e1\n", "", "line 11: expected 'shank' and 1 finite numbers, found '7'"),
        ("thigh 90 0", "thigh 90 0 1", "line 10: expected 'thigh' and 2"),
        ("7\nroot", "8\nroot", "line 12: expected frame number 7, found '8'"),
        ("shank 4.5e-015\n", "", "line 14: the file ends inside frame 7"),
        ("shank 4.5e-015", "sha", "line 15: expected 'shank'"),
        ("thigh", "femur", "bone 'femur' does not move in the skeleton"),
        (":DEGREES", ":RADIANS", "angles are not in degrees"),
    ],
)
def test_faults_in_a_motion_are_named(tmp_path: Path, skeleton: AsfSkeleton, old: str, new: str, message: str) -> None:
    with pytest.raises(InvalidFile) as caught:
        read_amc(written(tmp_path, "s.amc", AMC.replace(old, new)), skeleton)
    assert f"s.amc: {message}" in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("    length 8\n", "", "line 21: the bone that ends here has no valid 'length'"),
        ("length 8", "length long", "line 22: expected a number, found 'long'"),
        ("axis 0 0 20 XYZ", "axis 0 0 20 ZYX", "axis order ZYX"),
        ("dof rx rz", "dof rx tz", "degrees of freedom rx tz"),
        ("length 0.5", "length 0", "line 5: length unit 0.0"),
        ("orientation 0 0 0", "orientation 0 0", "line 11: expected three angles"),
        ("order TX", "order RX", "line 8: root order"),
        ("angle deg", "angle rad", "line 6: angles are not in degrees"),
        ("  shank sole\n", "", "bone 'sole' is not in the hierarchy"),
        ("    thigh shank\n", "", "'shank' has no parent yet"),
        (ASF[ASF.index(":hierarchy") :], "", "no section ':hierarchy' (truncated?)"),
        (ASF[ASF.index("  begin\n    id 3") : ASF.index(":hierarchy")], "", "no bone data of 'sole'"),
    ],
)
def test_faults_in_a_skeleton_are_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(InvalidFile) as caught:
        read_asf(written(tmp_path, "s.asf", ASF.replace(old, new)))
    assert message in str(caught.value)


def test_missing_and_empty_files(tmp_path: Path, skeleton: AsfSkeleton) -> None:
    with pytest.raises(InvalidFile, match="cannot be read"):
        read_asf(tmp_path / "none.asf")
    with pytest.raises(InvalidFile, match="no frames"):
        read_amc(written(tmp_path, "s.amc", ":DEGREES\n"), skeleton)


@given(st.data())
def test_damage_is_refused_or_harmless(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = tmp_path_factory.mktemp("damaged")
    asf, amc = (damaged(text, data) for text in (ASF, AMC))
    try:
        skeleton = read_asf(written(folder, "s.asf", asf))
        assert np.isfinite(positions(skeleton, read_amc(written(folder, "s.amc", amc), skeleton))).all()
    except InvalidFile:
        pass


def damaged(text: str, data: st.DataObject) -> str:
    """The text with a few words removed, repeated or replaced."""
    words = re.split(r"(\s+)", text)
    for _ in range(data.draw(st.integers(0, 3))):
        place = data.draw(st.integers(0, len(words) - 1))
        word = words[place]
        words[place] = data.draw(
            st.sampled_from(["", f"{word} {word}", f"{word}\n{word}", "x", "0", "nan", "1e999", "root", ":root"])
        )
    return "".join(words)
