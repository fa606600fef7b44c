"""A description proposed for a model that has none: what geometry and the model say, what is guessed, what is open."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

from retarget.describe.anatomy import Anatomy, Limb, Question, find_anatomy
from retarget.describe.bodies import collision_pairs, fit_bodies, mirrored_point
from retarget.describe.given import Given
from retarget.describe.joint_limits import FoundLimits, actuated_joints, found_limits, joint_ranges
from retarget.describe.shapes import body_points
from retarget.describe.soles import find_sole
from retarget.describe.stance import Stance, start_pose
from retarget.describe.tree import Tree, base_bodies
from ros_free_stack.errors import InvalidFile, UnsupportedModel
from ros_free_stack.messages import Floats, Mount
from ros_free_stack.robot_model import compiled_spec
from ros_free_stack.robots import Attachment, Capsule

SIDES = ("left", "right")
WRIST_SHARE = 0.85
"""Where the wrist of an arm without wrist joints is, from the elbow to the end of its shapes."""
LEVEL = 2e-3
"""How level soles must be in the standing pose, m."""


@dataclass(frozen=True)
class Proposal:
    """What a description will say; `questions` are what keeps it from being one.

    Attributes:
        model: the compiled model, with the shapes that bodies collide with.
        standing_qpos: (nq,) the standing pose.
        soles: foot name to body name and (4, 3) corners.
        guessed: key of the description to words on what in it is a guess.
    """

    model: mujoco.MjModel
    mount: Mount
    root_body: str
    torso_body: str
    torso_lean: float
    attachments: dict[str, Attachment]
    soles: dict[str, tuple[str, Floats]]
    capsules: dict[str, tuple[Capsule, ...]]
    collision_pairs: dict[str, tuple[str, ...]]
    limits: FoundLimits
    standing: dict[str, float]
    standing_qpos: Floats
    questions: tuple[Question, ...]
    guessed: dict[str, str] = field(default_factory=dict[str, str])


def propose(
    spec: mujoco.MjSpec,
    path: Path,
    *,
    given: Given | None = None,
    progress: Callable[[list[int]], Iterable[int]] = iter,
) -> Proposal:
    """Propose a description of a model.

    Args:
        spec: the model; shapes that neither collide nor make inertia are deleted from it.
        path: its file, for messages.
        given: what the user says.
        progress: wraps the bodies that capsules are fitted to.

    Raises:
        InvalidFile: MuJoCo refuses the model, or it misses a mesh.
        UnsupportedModel: it has no joints, or kinds of joints that cannot be described.
    """
    given = given or Given()
    _check_meshes(spec, path)
    keep_colliding(spec)
    model = compiled_spec(spec, path)
    tree = Tree(model, _base(model, given))
    anatomy = find_anatomy(tree)
    questions = list(anatomy.questions)
    mount: Mount = given.mount or ("free" if tree.free else "fixed")
    if mount == "free" and anatomy.legs is None and not questions:
        questions.append(Question("mount", "a free robot without feet cannot stand; is it held?", ("fixed",)))
    start, key = start_pose(model)
    joints = actuated_joints(tree)
    ranges, swept = joint_ranges(tree, joints, [start, model.qpos0.copy()])
    tips = wrist_places(tree, anatomy)
    stance = Stance(tree, ranges, start)
    soles: dict[str, tuple[int, Floats]] = {}
    if mount == "free" and anatomy.legs:
        soles = _soles(tree, anatomy.legs, start)
        if soles:
            stance.stand(anatomy, (soles["left"][1], soles["right"][1]), keep_height=key is not None)
            questions += _standing_questions(tree, anatomy.legs, stance, soles)
        else:
            names = tuple(tree.name(leg.bodies[-1]) for leg in anatomy.legs)
            questions.append(Question("soles", "the feet have no flat underside that faces the floor", names))
    if key is None:
        stance.hang(anatomy, tips)
    capsules = {} if questions else fit_bodies(tree, progress)
    pairs = {} if questions else collision_pairs(tree, capsules, ranges, stance.qpos)
    used = sorted({*pairs, *(body for others in pairs.values() for body in others)})
    attachments = attach(tree, anatomy, tips) | given.attachments
    return Proposal(
        model=model,
        mount=mount,
        root_body=tree.name(tree.base),
        torso_body=given.torso_body or tree.name(anatomy.torso),
        torso_lean=0.5 if anatomy.torso == anatomy.pelvis else 1.0,
        attachments=attachments,
        soles={side: (tree.name(body), corners) for side, (body, corners) in soles.items()},
        capsules={tree.name(body): capsules[body] for body in used},
        collision_pairs={tree.name(a): tuple(tree.name(b) for b in others) for a, others in pairs.items()},
        limits=found_limits(tree, joints, ranges, swept),
        standing=_standing(model, joints, stance.qpos),
        standing_qpos=stance.qpos,
        questions=tuple(q for q in questions if not given.answers(q.key)),
        guessed=_guesses(anatomy, key, tips),
    )


def _check_meshes(spec: mujoco.MjSpec, path: Path) -> None:
    for mesh in spec.meshes:
        file = path.parent / spec.meshdir / mesh.file
        if mesh.file and not file.is_file():
            raise InvalidFile(path, f"lacks the mesh file {file.relative_to(path.parent)}")


def keep_colliding(spec: mujoco.MjSpec) -> None:
    """Delete meshes that are only seen, of bodies that have other shapes to collide with: they take seconds to read."""
    colliding = {geom.parent.id for geom in spec.geoms if geom.contype or geom.conaffinity}
    for geom in list(spec.geoms):
        seen = geom.type == mujoco.mjtGeom.mjGEOM_MESH and not (geom.contype or geom.conaffinity)
        if seen and geom.parent.explicitinertial and geom.parent.id in colliding:
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if (mesh.name or Path(mesh.file).stem) not in used:
            spec.delete(mesh)


def attach(tree: Tree, anatomy: Anatomy, tips: dict[str, tuple[int, Floats]]) -> dict[str, Attachment]:
    """Human joints on the bodies that were found to play them."""
    found = {"pelvis": Attachment(tree.name(anatomy.pelvis), _hips_centre(tree, anatomy))}
    for side, leg in zip(SIDES, anatomy.legs or (), strict=False):
        ankle = leg.bodies[-1] if leg.end is None else leg.end
        for joint, body in (("hip", leg.root), ("knee", leg.middle), ("ankle", ankle)):
            found[f"{side}_{joint}"] = Attachment(tree.name(body), (0.0, 0.0, 0.0))
    for side, arm in zip(SIDES, anatomy.arms or (), strict=False):
        body, offset = tips[side]
        for joint, place in (("shoulder", arm.root), ("elbow", arm.middle)):
            found[f"{side}_{joint}"] = Attachment(tree.name(place), (0.0, 0.0, 0.0))
        found[f"{side}_wrist"] = Attachment(tree.name(body), rounded(offset))
    if anatomy.head is not None:
        found["head"] = Attachment(tree.name(anatomy.head), (0.0, 0.0, 0.0))
    return found


def rounded(point: Floats) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 4) + 0.0 for value in point)
    return x, y, z


def _base(model: mujoco.MjModel, given: Given) -> int:
    bases = base_bodies(model)
    if not bases:
        raise UnsupportedModel("the model has no joints: there is nothing to move")
    names = [model.body(body).name for body in bases]
    if given.root_body in names:
        return bases[names.index(given.root_body)]
    if len(bases) > 1:
        raise UnsupportedModel(f"the model has several bases ({', '.join(names)}): name one as root_body with --given")
    if not names[0]:
        raise UnsupportedModel("the base of the robot has no name: name every body and joint of the model")
    return bases[0]


def wrist_places(tree: Tree, anatomy: Anatomy) -> dict[str, tuple[int, Floats]]:
    """Body and offset (3,) of each wrist: its own joint, else a place along the forearm; the right mirrors the left."""
    if anatomy.arms is None:
        return {}
    left, right = anatomy.arms
    if left.end is not None and right.end is not None:
        return {"left": (left.end, np.zeros(3)), "right": (right.end, np.zeros(3))}
    body, twin = left.bodies[-1], right.bodies[-1]
    points = _part_points(tree, body)
    if not len(points):  # no shapes: as far beyond the centre of mass as that is from the elbow
        points = 2 * (tree.centre[body] - tree.position[body])[None] @ tree.rotation[body]
    along = points.mean(axis=0) / np.linalg.norm(points.mean(axis=0))
    offset = WRIST_SHARE * float((points @ along).max()) * along
    return {"left": (body, offset), "right": (twin, mirrored_point(tree, offset, body, twin))}


def _part_points(tree: Tree, body: int) -> Floats:
    """(N, 3) corners of a moving body's shapes and of all that is rigidly part of it, in its frame, m."""
    found: list[Floats] = []
    for other in tree.part(body):
        world = tree.position[other] + body_points(tree.model, other) @ tree.rotation[other].T
        found.append((world - tree.position[body]) @ tree.rotation[body])
    return np.concatenate(found)


def _soles(tree: Tree, legs: tuple[Limb, Limb], start: Floats) -> dict[str, tuple[int, Floats]]:
    """Body and corners of both soles; empty where the feet are not flat."""
    left, right = (leg.bodies[-1] for leg in legs)
    data = mujoco.MjData(tree.model)
    data.qpos[:] = start
    mujoco.mj_kinematics(tree.model, data)
    matrix = data.xmat[left].reshape(3, 3)
    corners = find_sole(_part_points(tree, left), matrix.T @ [0.0, 0.0, -1.0], matrix.T @ [1.0, 0.0, 0.0])
    if corners is None:
        return {}
    mirrored = np.stack([mirrored_point(tree, corner, left, right) for corner in corners])
    return {"left": (left, corners.round(4)), "right": (right, mirrored[[1, 0, 3, 2]].round(4))}


def _standing_questions(
    tree: Tree, legs: tuple[Limb, Limb], stance: Stance, soles: dict[str, tuple[int, Floats]]
) -> list[Question]:
    """Whether the pose that was found is one to stand in."""
    found: list[Question] = []
    corners = np.concatenate([stance.at(body, points) for body, points in soles.values()])
    if np.ptp(corners[:, 2]) > LEVEL:
        uneven = 1e3 * np.ptp(corners[:, 2])
        found.append(
            Question("standing", f"no pose within the limits has both soles on the floor ({uneven:.0f} mm off)")
        )
    ankle = legs[0].bodies[-1] if legs[0].end is None else legs[0].end
    if corners[:, 0].mean() < stance.data.xpos[ankle, 0] - LEVEL:
        found.append(Question("model", "the toes point backward: the robot must face x in the model's own pose"))
    com = stance.data.subtree_com[tree.base]
    if not corners[:, 0].min() < com[0] < corners[:, 0].max():
        found.append(Question("standing", "no pose within the limits has the centre of mass above the soles"))
    return found


def _standing(model: mujoco.MjModel, joints: list[int], qpos: Floats) -> dict[str, float]:
    values = {model.joint(joint).name: round(float(qpos[model.jnt_qposadr[joint]]), 4) for joint in joints}
    return {name: value for name, value in values.items() if abs(value) >= 1e-3}


def _hips_centre(tree: Tree, anatomy: Anatomy) -> tuple[float, float, float]:
    """The middle of the hips in the pelvis's frame."""
    if anatomy.legs is None:
        return 0.0, 0.0, 0.0
    middle = np.mean([tree.position[leg.root] for leg in anatomy.legs], axis=0)
    middle[1] = tree.position[tree.base, 1]
    return rounded(tree.rotation[anatomy.pelvis].T @ (middle - tree.position[anatomy.pelvis]))


def _guesses(anatomy: Anatomy, key: str | None, tips: dict[str, tuple[int, Floats]]) -> dict[str, str]:
    found = {
        "standing": "found: soles flat, knees bent, arms hanging"
        if key is None
        else f"the model's keyframe {key!r}, its soles made flat on the floor"
    }
    if anatomy.torso == anatomy.pelvis:
        found["torso_lean"] = "guessed: torso and pelvis are one body, which follows half of the human's bend"
    if any(np.any(offset) for _, offset in tips.values()):
        found["attachments"] = f"guessed: wrists, {WRIST_SHARE:.0%} of the way from the elbow to the end of the arm"
    return found
