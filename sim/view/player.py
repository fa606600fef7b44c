"""The clock of a viewer: play, pause, scrub, speed."""

from dataclasses import dataclass

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0)


@dataclass
class Player:
    """Where a viewer is in a motion of `frames` frames at `fps`; it begins anew after the end."""

    frames: int
    fps: float
    time_s: float = 0.0
    playing: bool = True
    speed: float = 1.0

    @property
    def end_s(self) -> float:
        """Time of the last frame."""
        return (self.frames - 1) / self.fps

    @property
    def frame(self) -> int:
        """The frame that is on."""
        return min(self.frames - 1, round(self.time_s * self.fps))

    def advance(self, seconds: float) -> None:
        """Let time pass by the wall."""
        if not self.playing:
            return
        self.time_s += seconds * self.speed
        if self.time_s > self.end_s:
            self.time_s = 0.0

    def scrub(self, time_s: float) -> None:
        """Go to a time, kept within the motion, and stay there."""
        self.playing = False
        self.time_s = min(max(time_s, 0.0), self.end_s)

    def step(self, frames: int) -> None:
        """Go some frames on or back, and stay there."""
        self.scrub((self.frame + frames) / self.fps)

    def toggle(self) -> None:
        """Play or pause."""
        self.playing = not self.playing

    def faster(self, steps: int) -> None:
        """Go up (or down) the ladder of speeds."""
        at = SPEEDS.index(self.speed) + steps
        self.speed = SPEEDS[min(max(at, 0), len(SPEEDS) - 1)]
