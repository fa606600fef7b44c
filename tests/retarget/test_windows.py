from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from retarget.solve.windows import windows


@given(total=st.integers(1, 5000), length=st.integers(20, 400), overlap=st.integers(0, 19))
def test_windows_cover_a_clip_and_overlap(total, length, overlap):
    found = windows(total, length, overlap)
    assert found[0].start == 0 and found[-1].end == total
    assert all(0 < len(stretch) <= length and stretch.total == total for stretch in found)
    for before, after in pairwise(found):
        assert before.end - after.start >= overlap and after.start > before.start
    assert len(found) == 1 or total > length
