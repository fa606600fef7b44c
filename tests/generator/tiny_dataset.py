"""A dataset of a few seconds, made on the fly in the on-disk format, for the tests of training."""

import json
from pathlib import Path

import numpy as np

from ros_free_stack.formats.features import encode
from ros_free_stack.skeleton import JOINT_COUNT, PARENTS

ACTIONS = {
    "a person waves with the left hand": ("left", 0.0),
    "a person waves with the right hand": ("right", 0.0),
    "a person walks forward": ("none", 0.04),
    "a person sways": ("sway", 0.0),
}

_OFFSETS = np.array([
    (0, 0, 0.95), (0, 0.1, -0.05), (0, -0.1, -0.05), (0, 0, 0.12), (0, 0, -0.4), (0, 0, -0.4), (0, 0, 0.14),
    (0, 0, -0.42), (0, 0, -0.42), (0, 0, 0.06), (0.12, 0, -0.06), (0.12, 0, -0.06), (0, 0, 0.21), (0, 0.08, 0.12),
    (0, -0.08, 0.12), (0.02, 0, 0.12), (0, 0.1, 0.02), (0, -0.1, 0.02), (0, 0.05, -0.25), (0, -0.05, -0.25),
    (0.05, 0, -0.25), (0.05, 0, -0.25),
])  # fmt: skip


def tiny_joints(actions: list[str], frames: int, rng: np.random.Generator) -> np.ndarray:
    """(T, 22, 3) a puppet that waves, sways or glides forward, the actions in turn for `frames` each."""
    total = frames * len(actions)
    offsets = np.tile(_OFFSETS, (total, 1, 1))
    for number, action in enumerate(actions):
        kind, speed = ACTIONS[action]
        rows = slice(number * frames, (number + 1) * frames)
        phase = np.sin(np.linspace(0, 4 * np.pi, frames) * rng.uniform(0.8, 1.2))
        if kind in ("left", "right"):
            for joint in (18, 20) if kind == "left" else (19, 21):
                offsets[rows, joint] = np.stack([0.1 + 0 * phase, 0.15 * phase, 0.2 + 0 * phase], axis=1)
        elif kind == "sway":
            offsets[rows, 3, 1] += 0.05 * phase
        offsets[rows, 0, 0] += speed * np.arange(frames)
        offsets[(number + 1) * frames :, 0, 0] += speed * frames
    joints = np.zeros((total, JOINT_COUNT, 3))
    for joint, parent in enumerate(PARENTS):
        joints[:, joint] = offsets[:, joint] + (joints[:, parent] if parent >= 0 else 0)
    return joints


def write_tiny_dataset(folder: Path, clips: int = 24, seed: int = 0, *, test_split: bool = False) -> Path:
    """Write `clips` clips of two or three actions of 28 frames each; every fourth is for validation, and on request
    every fourth for tests."""
    splits = ("train", "train", "val", "test" if test_split else "train")
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    rows, lines, start = [], [], 0
    for number in range(clips):
        actions = [str(action) for action in rng.choice(list(ACTIONS), 2 + number % 2)]
        features = encode(tiny_joints(actions, 28, rng)).astype(np.float16)
        segments = [
            {"text": text, "start": 28 * i, "end": min(28 * (i + 1), len(features)), "arms": "", "legs": "",
             "actions": [["act", {}]]}
            for i, text in enumerate(actions)
        ]  # fmt: skip
        lines.append({
            "id": f"{number:06d}", "split": splits[number % 4], "start": start,
            "length": len(features), "source": "authored", "weight": 1.0, "segments": segments,
            "captions": [{"text": ", then ".join(actions), "segments": actions}],
        })  # fmt: skip
        rows.append(features)
        start += len(features)
    np.save(folder / "features.npy", np.concatenate(rows))
    (folder / "clips.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    (folder / "manifest.json").write_text(json.dumps({"seed": seed, "clips": clips, "minutes": 1, "version": 1}))
    return folder
