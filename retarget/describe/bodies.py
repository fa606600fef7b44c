"""Capsules for every body of a robot, left and right mirrored, and the pairs of bodies to keep apart."""

from collections.abc import Callable, Iterable
from itertools import combinations, product

import mujoco
import numpy as np

from retarget.describe.capsules import distance_outside, exact_capsule, fit_capsules, hull_surface
from retarget.describe.shapes import body_points, collides
from retarget.describe.tree import Tree
from ros_free_stack.couplings import joint_couplings, settle
from ros_free_stack.messages import Floats
from ros_free_stack.robots import Capsule

LEAST_BODY = 0.01
"""Bodies smaller than this, in sizes of the robot, collide with nothing that their neighbours do not."""
SPLIT_ROOM = 0.04
"""A body is covered by several capsules where one reaches this far beyond its thinner sides, in sizes of the robot."""
SAMPLES, LEAST_MEETINGS, NEAR = 2000, 8, 0.05
"""Random poses in which pairs are looked at, and in how many of them, or of the mirrored ones, they must come near each
other, in sizes of the robot: random limbs seldom touch."""


def fit_bodies(tree: Tree, progress: Callable[[list[int]], Iterable[int]]) -> dict[int, tuple[Capsule, ...]]:
    """Capsules of every body that collides; the right limbs' are the mirrored left ones.

    Where hardly any body of a model collides, what is seen of them counts.
    """
    bodies = [body for body in tree.bodies if _extent(tree, body) > LEAST_BODY * tree.size]
    colliding = [body for body in bodies if collides(tree.model, body)]
    bodies = colliding if len(colliding) > len(tree.children) / 3 else bodies
    twins = mirrored_bodies(tree)
    found: dict[int, tuple[Capsule, ...]] = {}
    for body in progress([body for body in bodies if body not in twins]):
        exact = exact_capsule(tree.model, body)
        found[body] = (exact,) if exact else _cover(hull_surface(tree.model, body, 0.008), SPLIT_ROOM * tree.size)
    for right, left in twins.items():
        if left in found:
            found[right] = tuple(mirrored_capsule(tree, capsule, left, right) for capsule in found[left])
    return dict(sorted(found.items()))


def mirrored_bodies(tree: Tree) -> dict[int, int]:
    """Body of the right side to its twin on the left, along every pair of limbs."""
    return {right: left for pair in tree.pairs() for left, right in zip(pair.left, pair.right, strict=True)}


def mirrored_point(tree: Tree, point: Floats, left: int, right: int) -> Floats:
    """A point (3,) of a body on the left as the mirrored one of its twin on the right, each in its body's frame."""
    plane = tree.position[tree.base, 1]
    world = (tree.position[left] + tree.rotation[left] @ point) * [1, -1, 1] + [0, 2 * plane, 0]
    return tree.rotation[right].T @ (world - tree.position[right])


def mirrored_capsule(tree: Tree, capsule: Capsule, left: int, right: int) -> Capsule:
    start, end = (_rounded(mirrored_point(tree, np.array(p), left, right)) for p in (capsule.start, capsule.end))
    return Capsule(start, end, capsule.radius)


def collision_pairs(
    tree: Tree, capsules: dict[int, tuple[Capsule, ...]], ranges: Floats, standing: Floats, seed: int = 0
) -> dict[int, tuple[int, ...]]:
    """Pairs of bodies that meet in some random poses but are apart in the standing one, and are no neighbours.

    A pair counts where its mirror image does: random poses are not symmetric.
    """
    carriers = {body: tree.carrier(body) for body in capsules}
    pairs = [(a, b) for a, b in combinations(capsules, 2) if carriers[a] != carriers[b] and not _neighbours(tree, a, b)]
    chosen = [(k, a, b) for k, (a, b) in enumerate(pairs) for _ in product(capsules[a], capsules[b])]
    ends = [(a, c, b, d) for a, b in pairs for c, d in product(capsules[a], capsules[b])]
    if not ends:
        return {}
    meetings = np.zeros(len(pairs), dtype=int)
    index = np.array([k for k, _, _ in chosen])
    rng, data = np.random.default_rng(seed), mujoco.MjData(tree.model)
    couplings = joint_couplings(tree.model)
    moving = [joint for body in tree.children if body != tree.base for joint in tree.joints(body)]
    at = tree.model.jnt_qposadr[moving]
    room = np.zeros(len(pairs))
    for sample in range(SAMPLES):
        data.qpos[:] = standing
        if sample:
            data.qpos[at] = rng.uniform(*ranges[moving].T)
        settle(tree.model, couplings, data.qpos)
        mujoco.mj_kinematics(tree.model, data)
        distances = np.full(len(pairs), np.inf)
        np.minimum.at(distances, index, _distances(data, ends))
        if sample:
            meetings += distances < NEAR * tree.size
        else:
            room = distances
    twins = mirrored_bodies(tree)
    twins |= {left: right for right, left in twins.items()}
    mates = _mates(tree)
    number = {pair: k for k, pair in enumerate(pairs)}
    table: dict[int, tuple[int, ...]] = {}
    for k, (first, second) in enumerate(pairs):
        twin = number[_sorted(twins.get(first, first), twins.get(second, second))]
        close = meetings[k] + (meetings[twin] if twin != k else 0)
        if (close >= LEAST_MEETINGS or (first, second) in mates) and min(room[k], room[twin]) > 0:
            table[first] = (*table.get(first, ()), second)
    return table


def _mates(tree: Tree) -> set[tuple[int, int]]:
    """Bodies of the outer halves of the same limb, left and right: hands and feet meet, however seldom by chance."""
    return {
        _sorted(left, right)
        for pair in tree.pairs()
        for left, right in product(*(chain[len(chain) // 2 :] for chain in (pair.left, pair.right)))
    }


def _sorted(first: int, second: int) -> tuple[int, int]:
    return (first, second) if first < second else (second, first)


def _neighbours(tree: Tree, first: int, second: int) -> bool:
    """Whether two bodies are within two joints of each other on one chain: their ranges keep them apart."""
    a, b = tree.carrier(first), tree.carrier(second)
    return b in _above(tree, a)[:3] or a in _above(tree, b)[:3]


def _above(tree: Tree, body: int) -> list[int]:
    """A moving body and those it hangs from, nearest first."""
    chain = [body]
    while chain[-1] != tree.base:
        chain.append(tree.carrier(int(tree.model.body_parentid[chain[-1]])))
    return chain


def _distances(data: mujoco.MjData, ends: list[tuple[int, Capsule, int, Capsule]]) -> Floats:
    def world(bodies: list[int], points: list[tuple[float, float, float]]) -> Floats:
        matrices = data.xmat[bodies].reshape(-1, 3, 3)
        return np.einsum("nij,nj->ni", matrices, np.array(points)) + data.xpos[bodies]

    first, second = [a for a, _, _, _ in ends], [b for _, _, b, _ in ends]
    a, b = world(first, [c.start for _, c, _, _ in ends]), world(first, [c.end for _, c, _, _ in ends])
    c, d = world(second, [e.start for *_, e in ends]), world(second, [e.end for *_, e in ends])
    radii = np.array([one.radius + other.radius for _, one, _, other in ends])
    return segment_distances(a, b, c, d) - radii


def segment_distances(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """(M,) distances of segments from a to b and from c to d, (M, 3) each.

    Ericson 2005, "Real-Time Collision Detection", 5.1.9.
    """
    u, v, w = b - a, d - c, a - c
    uu, vv = (np.maximum(_dot(x, x), 1e-12) for x in (u, v))
    uv, uw, vw = _dot(u, v), _dot(u, w), _dot(v, w)
    s = np.clip((uv * vw - uw * vv) / np.maximum(uu * vv - uv * uv, 1e-18), 0, 1)
    t = np.clip((uv * s + vw) / vv, 0, 1)
    s = np.clip((uv * t - uw) / uu, 0, 1)
    return np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)


def _dot(x: Floats, y: Floats) -> Floats:
    return np.einsum("mi,mi->m", x, y)


def _cover(surface: Floats, room: float) -> tuple[Capsule, ...]:
    """One capsule, or two or four where one would be wider than the body by more than `room` m."""
    one = fit_capsules(surface)
    thin, middle, long = np.sort(np.ptp(surface, axis=0))
    if one[0].radius - thin / 2 < room:
        return one
    order = np.argsort(np.ptp(surface, axis=0))
    cells = np.ones(3, dtype=int)
    cells[order[1]] = 2
    if long < 1.5 * middle:
        cells[order[2]] = 2
    few = fit_capsules(surface, (int(cells[0]), int(cells[1]), int(cells[2])))
    return few if few and distance_outside(surface, few).max() < 1e-3 else one


def _extent(tree: Tree, body: int) -> float:
    points = body_points(tree.model, body)
    return float(np.ptp(points, axis=0).max()) if len(points) > 3 else 0.0


def _rounded(point: Floats) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 4) + 0.0 for value in point)
    return x, y, z
