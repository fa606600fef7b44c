"""What joints' names say: the side and the part of the body, whatever program the rig comes from.

A name is cut into words (`mixamorigLeftUpLeg`, `upper_arm.L.001`, `LFArm`, `J_Bip_C_UpperChest`, `lShldr`), words that
most names of a file share are dropped, sides and numbers are taken off, and the rest is looked up.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

PARTS: Final[dict[str, tuple[str, ...]]] = {
    "pelvis": ("hips", "hip", "pelvis", "hipcenter", "hipscenter", "spinebase", "下半身"),
    "spine": (
        *("spine", "chest", "abdomen", "ab", "abs", "torso", "waist", "stomach", "thorax", "belly", "trunk", "back"),
        *("upperchest", "upperback", "lowerback", "lumbar", "ribcage", "spinenaval", "spinechest", "spinemid"),
        *("abdomenlower", "abdomenupper", "chestlower", "chestupper", "上半身"),
    ),
    "neck": ("neck", "necklower", "neckbase", "necktwist", "lowerneck", "shouldercenter", "spineshoulder", "首"),
    "head": ("head", "face", "skull", "頭"),
    "thigh": ("upleg", "upperleg", "uleg", "thigh", "femur", "thighbend", "legupper", "upperthigh", "hip", "足"),
    "leg": ("leg",),
    "shin": ("shin", "calf", "lowerleg", "lowleg", "knee", "tibia", "shank", "leglower", "lolegs", "loleg", "ひざ"),
    "ankle": ("ankle", "足首"),
    "foot": ("foot",),
    "toe": ("toe", "toes", "toebase", "ball", "toesbase", "toeroot", "forefoot", "つま先"),
    "collar": ("collar", "clavicle", "scapula", "clav", "collarbone", "shoulderblade"),
    "shoulder": ("shoulder", "肩"),
    "arm": ("arm", "upperarm", "uparm", "uarm", "shldr", "humerus", "shldrbend", "armupper", "腕"),
    "forearm": ("forearm", "lowerarm", "lowarm", "farm", "elbow", "radius", "forearmbend", "armlower", "ひじ"),
    "wrist": ("wrist", "手首"),
    "hand": ("hand",),
}
"""Names of each part; `hip` is a pelvis without side and a thigh with one. Which of `leg`, `foot`, `shoulder`, `hand`
is which joint, their neighbours tell."""

SIDED: Final = ("thigh", "leg", "shin", "ankle", "foot", "toe", "collar", "shoulder", "arm", "forearm", "wrist", "hand")

_PART: Final = {(word, part in SIDED): part for part, words in PARTS.items() for word in words}
_SIDED_WORDS: Final = {word for word, sided in _PART if sided}
_WORD: Final = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+|[^\W\d_a-zA-Z]+")
_SIDES: Final = {"l": "left", "r": "right", "left": "left", "right": "right", "左": "left", "右": "right"}
_FILLERS: Final = frozenset(
    {"c", "m", "def", "org", "j", "bip", "jnt", "bone", "b", "base", "cc", "avg", "valve", "biped"}
)
_SHARED: Final = 0.5
"""Words in more than this share of a file's names say nothing."""


@dataclass(frozen=True)
class Name:
    """What a joint's name says: the side ("left", "right" or ""), the part ("" where unknown) and the number in it."""

    side: str
    part: str
    number: int | None


def understand(names: Sequence[str]) -> list[Name]:
    """What each of a file's joint names says; end sites (`..._end`) say nothing."""
    cut = [[] if name.endswith("_end") else _words(name) for name in names]
    counts = Counter(word for words in cut for word in set(words))
    filled = sum(bool(words) for words in cut)
    shared = {word for word, count in counts.items() if count > max(_SHARED * filled, 2) and word not in _SIDES}
    return [_name([word for word in words if word not in shared]) for words in cut]


def _name(words: list[str]) -> Name:
    sides = {_SIDES[word] for word in words if word in _SIDES}
    rest = [word for word in words if word not in _SIDES]
    numbers = [int(word) for word in rest if word.isdecimal()]
    text = [word for word in rest if not word.isdecimal()]
    side = sides.pop() if len(sides) == 1 else ""
    for kept in (text, [word for word in text if word not in _FILLERS]):
        part = _PART.get(("".join(kept), bool(side)))
        if part:
            return Name(side, part, numbers[-1] if numbers else None)
    return Name(side, "", None)


def _words(name: str) -> list[str]:
    """Words of a name in lower case, sides as words of their own."""
    words: list[str] = []
    for word in _WORD.findall(name):
        if len(word) == 2 and word[0] in "LR" and word.isupper():  # LUArm, RFArm
            words += [word[0].lower(), word[1].lower()]
        else:
            words += _without_side(word.lower())
    return words


def _without_side(word: str) -> list[str]:
    if word in _SIDES or word in _SIDED_WORDS or (word, False) in _PART:
        return [word]
    for side in ("left", "right", "左", "右"):
        if word.startswith(side):
            return [side, word.removeprefix(side)]
        if word.endswith(side):
            return [word.removesuffix(side), side]
    if word[0] in "lr" and word[1:] in _SIDED_WORDS:  # lfemur, rshin
        return [word[0], word[1:]]
    return [word]
