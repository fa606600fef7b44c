"""A sentence to human motion: split it into segments, generate, save and draw.

python examples/1_text_to_motion.py "a person waves, then bows" out/
"""

import sys
from pathlib import Path

from generator.corpus.draw import draw_motion
from generator.performer import Performer
from generator.registry import SHARED_WEIGHTS
from generator.text.understanding import Understanding
from ros_free_stack.files import make_folder, save_motion


def main(prompt: str, folder: Path) -> None:
    segments, _ = Understanding(SHARED_WEIGHTS).segments(prompt)
    motion = Performer.load().generate(prompt, segments, seed=0)[0]
    for segment in motion.segments:
        print(f"{segment.start_s:5.2f} to {segment.end_s:5.2f} s  {segment.text}")
    make_folder(folder)
    save_motion(folder / "human_motion.npz", motion)
    draw_motion(motion.joints, folder / "human_motion.png", prompt)
    print(f"wrote {folder}/human_motion.npz and .png")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "a person waves, then bows", Path(*sys.argv[2:3] or ["out"]))
