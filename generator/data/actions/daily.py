"""Everyday deeds of the hands near the head and the chest; the legs stay free."""

from typing import Literal

from generator.data.actions.hands import around, look_at_hands, there_and_back
from generator.data.actions.registry import AnySide, Count, Hold, Speed, action
from generator.data.body import OTHER, SIDES, SIGN, Side, aim, hand_at
from generator.data.scene import Scene


@action("arms")
def eat(scene: Scene, t: float, *, side: Side = "right", count: Count = 2, speed: Speed = 1.0) -> float:
    """Take `count` bites: the hand goes from a plate in front to the mouth, the other one holds the plate."""
    plate, mouth = hand_at(0.30, 0.08, -0.26, 0.0), hand_at(0.21, 0.07, 0.05, 0.1)
    up, beat = scene.vary(0.7) / speed, scene.vary(1.15) / speed
    end = around(scene, t, side, (plate, mouth), count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.27, 0.06, -0.30), up=up, hold=end - t - 2 * up)
    look_at_hands(scene, t, end, down=20)
    return end


@action("arms")
def brush_teeth(scene: Scene, t: float, *, side: Side = "right", count: Count = 5, speed: Speed = 1.0) -> float:
    """Move a brush to and fro at the mouth."""
    keys = hand_at(0.20, 0.17, 0.05, 0.5), hand_at(0.21, 0.08, 0.06, 0.5)
    up, beat = scene.vary(0.85) / speed, scene.vary(0.34) / speed
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action("arms")
def comb_hair(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Draw a comb from the brow over the head to the neck."""
    brow, crown, nape = hand_at(0.17, 0.13, 0.24, 0.2), hand_at(0.05, 0.17, 0.33, 0.3), hand_at(-0.05, 0.20, 0.18, 0.4)
    up, beat = scene.vary(0.9) / speed, scene.vary(0.95) / speed
    back = hand_at(0.08, 0.25, 0.27, 0.3)
    return around(scene, t, side, (brow, crown, nape, back), count=count, up=up, beat=beat)


@action("arms")
def rub_hands(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Rub the hands against each other in front of the chest."""
    up, beat = scene.vary(0.65) / speed, scene.vary(0.42) / speed
    near, far = hand_at(0.27, 0.045, -0.24), hand_at(0.36, 0.045, -0.22)
    around(scene, t, "left", (near, far), count=count, up=up, beat=beat)
    end = around(scene, t, "right", (far, near), count=count, up=up, beat=beat)
    look_at_hands(scene, t, end)
    return end


@action("arms")
def check_watch(scene: Scene, t: float, *, side: Side = "left", hold: Hold = 0.9, speed: Speed = 1.0) -> float:
    """Lift a wrist before the chest, elbow out, and look at it."""
    up = scene.vary(0.7) / speed
    end = there_and_back(scene, t, side, hand_at(0.30, 0.0, -0.08, 0.7), up=up, hold=hold)
    look_at_hands(scene, t, end, left=4 * SIGN[side])
    return end


@action("arms")
def phone(scene: Scene, t: float, *, side: Side = "right", hold: Hold = 1.5, speed: Speed = 1.0) -> float:
    """Hold a telephone to the ear."""
    up = scene.vary(0.85) / speed
    end = there_and_back(
        scene, t, side, hand_at(0.11, 0.17, 0.08, -0.7), up=up, hold=hold, via=hand_at(0.28, 0.22, -0.15)
    )
    scene.move("gaze", t + 0.5 * up, (t + up, [0, 10]), (end - up, [0, 6]), (end, [0, 0]))
    return end


@action("arms")
def pray(scene: Scene, t: float, *, hold: Hold = 1.4, speed: Speed = 1.0) -> float:
    """Join the palms before the chest, the head bowed."""
    up = scene.vary(0.85) / speed
    end = there_and_back(scene, t, "both", hand_at(0.25, 0.04, -0.14, 0.2), up=up, hold=hold)
    look_at_hands(scene, t + 0.2, end, down=26)
    return end


@action("arms")
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


@action("arms")
def hug(scene: Scene, t: float, *, hold: Hold = 1.0, speed: Speed = 1.0) -> float:
    """Open the arms and close them around somebody in front."""
    up = scene.vary(1.1) / speed
    closed = {"left": hand_at(0.36, -0.02, -0.08, 0.3), "right": hand_at(0.32, -0.02, -0.16, 0.3)}
    for s in SIDES:
        there_and_back(scene, t, s, closed[s], up=up, hold=hold, via=aim(0.6, 0.8, -0.05, 0.95, 0.2))
    lean = [0, 6, 0]
    scene.move("spine", t, (t + up, lean), (t + up + hold, lean), (t + 1.8 * up + hold, [0, 0, 0]))
    return t + 2 * up + hold


@action("arms")
def flex(scene: Scene, t: float, *, side: AnySide = "both", hold: Hold = 1.0, speed: Speed = 1.0) -> float:
    """Show the biceps: upper arm out to the side, fist beside the head."""
    up = scene.vary(0.8) / speed
    via = hand_at(0.20, 0.42, -0.18, 0.1)
    return there_and_back(scene, t, side, hand_at(0.06, 0.34, 0.20, 0.35), up=up, hold=hold, via=via)
