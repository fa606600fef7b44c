"""What the legs do on the spot, besides marching and jogging."""

from generator.data.vocabulary.entry import Entry

ENTRIES = (
    Entry(
        "bounce",
        lambda d: {"count": d.count(2, 6), "speed": d.speed()},
        (
            "<bounce> up and down {reps}",
            "<bounce> up and down",
            "<bounce> in place",
            "<bounce> {reps}",
            "<bend> {poss} knees slightly {times}",
            "<bob> up and down",
            "<bounce> on {poss} feet",
        ),
        legs="<bounce> up and down",
        weight=1.0,
    ),
    Entry(
        "swing_leg",
        lambda d: {"side": d.side(), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<swing> {leg} {times}",
            "<swing> {leg} back and forth {reps}",
            "<swing> {leg} forward and back {times}",
            "<swing> {leg} forwards and backwards",
            "<move> {leg} back and forth {reps}",
            "<stand> on one leg and <swing> the other",
            "<kick> {leg} back and forth",
        ),
        legs="<swing> {leg} forward and back",
        weight=0.9,
    ),
)
