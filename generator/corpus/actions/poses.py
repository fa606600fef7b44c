"""Arms held still: praying, covering, hugging, flexing."""

from typing import Literal

from generator.corpus.actions.hands import look_at_hands, there_and_back
from generator.corpus.actions.record import AnySide, Hold, Speed, action
from generator.corpus.body import SIDES, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter, within


def _cover_words(params: Params) -> Slots:
    return {"target": {"face": ("face", "face", "eyes"), "ears": ("ears",), "mouth": ("mouth",)}[params["target"]]}


@action(
    "arms",
    Entry(
        lambda d: {"hold": d.hold(0.6, 1.8), "speed": d.speed()},
        (
            "<pray>",
            "<fold> {poss} hands in prayer",
            "<put> {poss} hands together in prayer",
            "<put> {poss} palms together in front of {poss} chest",
            "<clasp> {poss} hands together",
            "<hold> {poss} hands together in front of {poss} chest",
            "<place> both hands together in front",
        ),
        arms="<join> both hands before the chest",
        weight=0.7,
        paced=False,
    ),
    Probe(
        "hands",
        {
            "gap_low": below(0.2),
            "hand.extension": below(0.7),
            "hand.hold": above(0.5),
            "hand.lift": within(-0.6, 0.0),
            "claps": below(1),
        },
    ),
)
def pray(scene: Scene, t: float, *, hold: Hold = 1.4, speed: Speed = 1.0) -> float:
    """Join the palms before the chest, the head bowed."""
    up = scene.vary(0.85) / speed
    end = there_and_back(scene, t, "both", hand_at(0.25, 0.04, -0.14, 0.2), up=up, hold=hold)
    look_at_hands(scene, t + 0.2, end, down=26)
    return end


@action(
    "arms",
    Entry(
        lambda d: {"target": d.pick("face", "ears", "mouth"), "hold": d.hold(0.5, 1.4), "speed": d.speed()},
        (
            "<cover> {poss} {target} with both hands",
            "<cover> {poss} {target}",
            "<put> both hands over {poss} {target}",
            "<hold> {poss} hands over {poss} {target}",
            "<bring> both hands up to {poss} {target}",
            "<place> {poss} hands on {poss} {target}",
            "<raise> both hands to {poss} {target}",
        ),
        slots=_cover_words,
        arms="<cover> the {target} with both hands",
        weight=0.8,
    ),
    Probe(
        "hands",
        {"hand.head_mid": below(0.55), "hand.extension": below(0.58), "gap_low": below(0.9)},
        {
            "face": {"hand.still_x": above(0.3)},
            "ears": {"hand.still_x": below(0.32)},
            "mouth": {"hand.still_x": above(0.3)},
        },
        wanted=parameter("target"),
    ),
)
def cover(
    scene: Scene,
    t: float,
    *,
    target: Literal["face", "ears", "mouth"] = "face",
    hold: Hold = 1.2,
    speed: Speed = 1.0,
) -> float:
    """Cover face, ears or mouth with both hands, the head lowered."""
    up = scene.vary(0.75) / speed
    place = {
        "face": hand_at(0.20, 0.06, 0.06, -0.2),
        "ears": hand_at(0.10, 0.16, 0.13, 0.1),
        "mouth": hand_at(0.20, 0.06, 0.00, -0.1),
    }[target]
    end = there_and_back(scene, t, "both", place, up=up, hold=hold, via=hand_at(0.30, 0.20, -0.12))
    scene.move("gaze", t, (t + up, [0, 16]), (end - up, [0, 16]), (end, [0, 0]))
    return end


@action(
    "arms",
    Entry(
        lambda d: {"hold": d.hold(0.5, 1.4), "speed": d.speed()},
        (
            "<hug> someone",
            "<give> someone a hug",
            "<give> a hug",
            "<embrace> someone",
            "<wrap> {poss} arms around someone",
            "<hug> a friend",
            "<open> {poss} arms for a hug",
        ),
        arms="<hug> someone",
        weight=0.6,
        paced=False,
    ),
    Probe("hands", {"hand.range_y": above(0.9), "gap_low": below(0.6), "hand.lift": within(-0.6, 0.3)}),
)
def hug(scene: Scene, t: float, *, hold: Hold = 1.0, speed: Speed = 1.0) -> float:
    """Open the arms and close them around somebody in front."""
    up = scene.vary(1.1) / speed
    closed = {"left": hand_at(0.36, -0.02, -0.08, 0.3), "right": hand_at(0.32, -0.02, -0.16, 0.3)}
    for s in SIDES:
        there_and_back(scene, t, s, closed[s], up=up, hold=hold, via=aim(0.6, 0.8, -0.05, 0.95, 0.2))
    lean = [0, 6, 0]
    scene.move("spine", t, (t + up, lean), (t + up + hold, lean), (t + 1.8 * up + hold, [0, 0, 0]))
    return t + 2 * up + hold


@action(
    "arms",
    Entry(
        lambda d: {"side": d.sides(0.5), "hold": d.hold(0.4, 1.4), "speed": d.speed()},
        (
            "<flex> {arm}",
            "<flex> {poss} muscles",
            "<flex> {poss} arm muscles",
            "<flex> {poss} biceps",
            "<flex> {poss} biceps with {arm}",
            "<pose> like a bodybuilder",
            "<raise> {arm} to flex {poss} muscles",
        ),
        arms="<flex> {arm}",
        weight=0.6,
    ),
    Probe("hand", {"hand.extension": below(0.58), "hand.y": above(0.24), "hand.lift": above(0.1)}),
)
def flex(scene: Scene, t: float, *, side: AnySide = "both", hold: Hold = 1.0, speed: Speed = 1.0) -> float:
    """Show the biceps: upper arm out to the side, fist beside the head."""
    up = scene.vary(0.8) / speed
    via = hand_at(0.20, 0.42, -0.18, 0.1)
    return there_and_back(scene, t, side, hand_at(0.06, 0.34, 0.20, 0.35), up=up, hold=hold, via=via)
