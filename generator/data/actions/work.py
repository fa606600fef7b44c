"""Work of the hands on things in front; the legs stay free."""

from typing import Literal

from generator.data.actions.hands import around, look_at_hands, there_and_back
from generator.data.actions.registry import AnySide, Count, Hold, Speed, action
from generator.data.body import OTHER, SIGN, Side, aim, hand_at
from generator.data.scene import Scene


@action("arms")
def wipe_table(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Wipe a table in level circles, the trunk bent a little over it."""
    ring = (
        hand_at(0.36, 0.36, -0.36),
        hand_at(0.46, 0.18, -0.34),
        hand_at(0.38, 0.00, -0.36),
        hand_at(0.28, 0.18, -0.38),
    )
    up, beat = scene.vary(0.75) / speed, scene.vary(1.05) / speed
    end = around(scene, t, side, ring, count=count, up=up, beat=beat)
    bend = [0, 18, 0]
    scene.move("spine", t, (t + up, bend), (end - 0.75, bend), (end, [0, 0, 0]))
    look_at_hands(scene, t, end, left=6 * SIGN[side])
    return end


@action("arms")
def stir(scene: Scene, t: float, *, side: Side = "right", count: Count = 4, speed: Speed = 1.0) -> float:
    """Stir in a pot that the other hand holds: `count` small level circles."""
    ring = (
        hand_at(0.33, 0.12, -0.20),
        hand_at(0.40, 0.05, -0.19),
        hand_at(0.33, -0.02, -0.20),
        hand_at(0.26, 0.05, -0.21),
    )
    up, beat = scene.vary(0.75) / speed, scene.vary(0.75) / speed
    end = around(scene, t, side, ring, count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.28, 0.17, -0.32), up=up, hold=end - t - 2 * up)
    look_at_hands(scene, t, end)
    return end


@action("arms")
def chop(scene: Scene, t: float, *, side: Side = "right", count: Count = 4, speed: Speed = 1.0) -> float:
    """Cut on a board in front, up and down, the other hand holding what is cut."""
    up, beat = scene.vary(0.75) / speed, scene.vary(0.5) / speed
    keys = hand_at(0.32, 0.08, -0.18), hand_at(0.34, 0.08, -0.34)
    end = around(scene, t, side, keys, count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.30, 0.08, -0.34), up=up, hold=end - t - 2 * up)
    look_at_hands(scene, t, end)
    return end


@action("arms")
def hammer(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Swing a hammer from beside the head down in front."""
    up, beat = scene.vary(0.8) / speed, scene.vary(0.8) / speed
    keys = hand_at(0.12, 0.28, 0.16, 0.1), hand_at(0.40, 0.14, -0.22)
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action("arms")
def knock(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Knock at a door in front at the height of the shoulder."""
    up, beat = scene.vary(0.75) / speed, scene.vary(0.36) / speed
    keys = hand_at(0.28, 0.15, 0.02, 0.1), hand_at(0.40, 0.13, 0.00, 0.1)
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action("arms")
def open_door(scene: Scene, t: float, *, side: Side = "right", speed: Speed = 1.0) -> float:
    """Take a handle at the height of the waist and pull the door open past the own side."""
    reach, pull = scene.vary(0.8) / speed, scene.vary(0.95) / speed
    handle, past = hand_at(0.42, 0.16, -0.28), hand_at(0.12, 0.42, -0.26, -0.2)
    grasp = t + reach + 0.2
    end = grasp + pull + 0.8 / speed
    scene.move(f"arm_{side}", t, (t + reach, handle), (grasp, handle), (grasp + pull, past), (end, scene.rest[side]))
    turn = [0, 0, 14 * SIGN[side]]
    scene.move("spine", t, (t + reach, [0, 6, 0]), (grasp, [0, 6, 0]), (grasp + pull, turn), (end, [0, 0, 0]))
    scene.move("gaze", t, (t + 0.5 * reach, [0, 20]), (grasp, [0, 16]), (grasp + pull, [0, 0]))
    return end


@action("arms")
def pour(scene: Scene, t: float, *, side: Side = "right", hold: Hold = 0.8, speed: Speed = 1.0) -> float:
    """Tilt a jug, elbow lifted, over a cup that the other hand holds."""
    up = scene.vary(0.9) / speed
    tilted = hand_at(0.30, 0.10, -0.06, 0.6)
    end = there_and_back(scene, t, side, tilted, up=up, hold=hold, via=hand_at(0.32, 0.20, -0.24))
    there_and_back(scene, t, OTHER[side], hand_at(0.32, 0.06, -0.28), up=up, hold=hold)
    look_at_hands(scene, t, end)
    return end


@action("arms")
def pull(scene: Scene, t: float, *, side: AnySide = "both", count: Count = 2, speed: Speed = 1.0) -> float:
    """Reach out in front and pull something to the waist, the trunk leaning back, `count` times."""
    up, beat = scene.vary(0.7) / speed, scene.vary(1.15) / speed
    keys = aim(1, -0.1, -0.12, 0.96), hand_at(0.14, 0.24, -0.26, 0.1)
    end = around(scene, t, side, keys, count=count, up=up, beat=beat)
    lean = [(t + up, [0, 10, 0])]
    for i in range(count):
        lean += [(t + up + (i + 0.5) * beat, [0, -6, 0]), (t + up + (i + 1) * beat, [0, 8, 0])]
    scene.move("spine", t, *lean, (end, [0, 0, 0]))
    return end


@action("arms")
def carry(scene: Scene, t: float, *, hold: Hold = 2.0, speed: Speed = 1.0) -> float:
    """Hold a box before the belly with both hands."""
    up = scene.vary(0.8) / speed
    return there_and_back(scene, t, "both", hand_at(0.34, 0.17, -0.28, 0.1), up=up, hold=hold)


@action("arms")
def lift_weights(
    scene: Scene,
    t: float,
    *,
    style: Literal["curl", "press"] = "curl",
    side: AnySide = "both",
    count: Count = 3,
    speed: Speed = 1.0,
) -> float:
    """Lift weights: "curl" folds the elbows, "press" goes from the shoulders to overhead, `count` times."""
    low, high = {
        "curl": (aim(0.35, 0.08, -0.94, 0.96), hand_at(0.20, 0.19, -0.04, 0.0)),
        "press": (hand_at(0.15, 0.25, 0.02, 0.0), aim(0.10, 0.12, 0.98, 0.97, 0.4)),
    }[style]
    up, beat = scene.vary({"curl": 0.45, "press": 0.8}[style]) / speed, scene.vary(1.15) / speed
    return around(scene, t, side, (low, high), count=count, up=up, beat=beat)
