# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # How reliable is it?
#
# **The question.** What becomes of a run that is killed, of a file that is damaged, of a disk that
# is full, of an argument that makes no sense, of any solid on any other; and of memory, in a run
# that lasts?
#
# ## What is promised
#
# - A run that is killed at any moment goes on from its last checkpoint, **to the same bits** as the
#   run that nobody killed.
# - A directory holds two checkpoints with checksums: where the newer one is damaged, the older one
#   goes on. What cannot be mended is refused by the name of its file.
# - What is given is built, or refused by an `InputError` that **names the argument**, or the one
#   that it contradicts; no other exception, no NaN in a run that says it finished.
# - A step costs no memory but its row of the history.
#
# Here each promise is tried, and counted. The tests try the same and more of it
# (`tests/test_history.py`, `test_reliability.py`, `test_fuzz.py`, `test_pairs.py`).

# %%
import errno
import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import fenicsx_contact
import fenicsx_contact.steps.run as running
from fenicsx_contact import (
    Circle,
    Contact,
    Discrete,
    ElasticSolid,
    GeneralisedAlpha,
    HalfSpace,
    History,
    HyperelasticSolid,
    InputError,
    RigidSolid,
    Scene,
    ThetaScheme,
    mesh_from_gmsh,
    neo_hookean,
    read_history,
)
from fenicsx_contact.output.report import quick_asked, write_summary

RESULTS = Path("results") / "reliability"
FLOOR = HalfSpace(point=(0, 0), normal=(0, 1))
UNTIL, DT = 0.3, 1e-3  # s

# %% [markdown]
# ## The scene
#
# A soft elastic block, thrown obliquely at the floor: it strikes, slips, sticks and leaves.


# %%
def scene(friction: float = 0.3) -> Scene:
    """A block that is thrown at the floor."""
    mesh = mesh_from_gmsh("block.geo", width=0.4, height=0.4, n_width=4, n_height=4)
    block = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -9.81),
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0] + 0.006]),
        velocity=lambda x: np.stack([0.5 + 0 * x[0], -1.0 - 0.2 * x[0]]),
    )
    return Scene([block], [Contact(block, "base", FLOOR, friction=friction, name="c")])


def run(until: float = UNTIL, **others: Any) -> History:
    """Its history, with a checkpoint after each step if it is written."""
    running.CHECKPOINT_EVERY = 0.0
    return scene().run(until, DT, progress=False, **others)


def same(history: History, whole: History) -> bool:
    """Whether they are the same to the bit."""
    return history.finished and np.array_equal(history.rows(), whole.rows())


# %% [markdown]
# ## Kills
#
# Another process runs the scene; it is killed by a signal that no program can catch, at moments
# that are spread at random over the run. What it left is read, then resumed.


# %%
def kills(count: int, whole: History, rng: np.random.Generator) -> list[dict[str, Any]]:
    """For each kill: how many steps there were, and whether the run went on to the same bits."""
    found: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as place:
        start = time.perf_counter()
        run(directory=Path(place) / "whole")
        lasts = time.perf_counter() - start
        for k in itertools.count():
            if len(found) == count or k == 3 * count:  # some come too late
                break
            directory = Path(place) / str(k)
            path = os.pathsep.join([str(Path(fenicsx_contact.__file__).parents[1]), *sys.path])
            command = [sys.executable, __file__, "--child", str(directory)]
            child = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": path})
            while child.poll() is None and not (directory / "state.npz").is_file():
                time.sleep(1e-3)
            time.sleep(0.8 * lasts * rng.random())
            child.kill()
            if child.wait() != -signal.SIGKILL:
                continue
            part = read_history(directory)
            good = np.array_equal(part.rows(), whole.rows()[: len(part)])
            resumed = run(directory=directory, resume=True)
            found.append({"steps": part.steps, "survived": bool(good and same(resumed, whole))})
    return found


# %% [markdown]
# ## Faults
#
# Each is put into the directory of a run that was stopped half way. It is **mended** if the run
# goes on to the same bits, **refused** if the message names the file or the directory.


# %%
def damaged(name: str, how: Callable[[bytes], bytes | None]) -> Callable[[Path], None]:
    """A file is changed, or taken away."""

    def inject(directory: Path) -> None:
        content = how((directory / name).read_bytes())
        if content is None:
            (directory / name).unlink()
        else:
            (directory / name).write_bytes(content)

    return inject


def flipped(content: bytes) -> bytes:
    """With one bit the other way."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 4]) + content[middle + 1 :]


DAMAGES: dict[str, Callable[[Path], None]] = {
    f"{name} {what}": damaged(name, how)
    for name in ("state.npz", "history.f64", "history.json")
    for what, how in {
        "empty": lambda content: b"",
        "cut": lambda content: content[:-8],
        "with a flipped bit": flipped,
        "missing": lambda content: None,
    }.items()
}


@contextmanager
def full_disk(writes: int) -> Iterator[None]:
    """A disk that takes so many files more, and some of the next."""
    sync, done = os.fsync, itertools.count()

    def fsync(file: int) -> None:
        if next(done) >= writes:
            os.ftruncate(file, os.fstat(file).st_size - 8)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(file)

    os.fsync = fsync
    try:
        yield
    finally:
        os.fsync = sync


def outcome(directory: Path, whole: History, go_on: Callable[[], History]) -> str:
    """What became of it."""
    try:
        resumed = go_on()
    except InputError as refusal:
        return "refused" if str(directory) in str(refusal) else f"unclear: {refusal}"
    except Exception as error:  # what this looks for
        return f"{type(error).__name__}: {error}"
    return "mended" if same(resumed, whole) else f"different: {resumed.reason}"


def faults(whole: History) -> dict[str, str]:
    """What became of each fault."""
    found: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as place:
        for k, (name, inject) in enumerate(DAMAGES.items()):
            directory = Path(place) / str(k)
            run(0.1, directory=directory)
            inject(directory)
            found[name] = outcome(
                directory, whole, lambda d=directory: run(directory=d, resume=True)
            )
        for writes in (9, 10):  # in the midst of rows, and of a checkpoint
            directory = Path(place) / f"full {writes}"
            with full_disk(writes):
                stopped = run(directory=directory)
            told = "No space left" in stopped.reason and str(directory) in stopped.reason
            becomes = outcome(directory, whole, lambda d=directory: run(directory=d, resume=True))
            found[f"full disk, {writes} writes"] = becomes if told else f"says {stopped.reason}"
        directory = Path(place) / "rival"
        rivals: list[str] = []

        def rival() -> float:
            if not rivals:
                rivals.append(outcome(directory, whole, lambda: run(directory=directory)))
            return 0.0

        run(0.01, directory=directory, probes={"rival": rival})
        found["second run in one directory"] = rivals[0]
        directory = Path(place) / "other"
        run(0.1, directory=directory)
        found["directory of another scene"] = outcome(
            directory,
            whole,
            lambda: scene(friction=0.4).run(UNTIL, DT, directory=directory, resume=True),
        )
    return found


# %% [markdown]
# ## Input
#
# Every argument of some constructors is given every value of a list that is seldom right.

# %%
SELDOM_RIGHT: list[Any] = [
    float("nan"), float("inf"), -float("inf"), 0, -1, 2.5, 1e300, 1e-300, 10**400, True, None, "",
    "0.3", b"a", 1j, [], {}, (1.0, 2.0), (1.0, float("nan")), (1.0, 2.0, 3.0), [[1], [1, 2]],
    np.eye(2), np.zeros(0), object(), float, len, lambda: 1.0, lambda x: "much", FLOOR,
]  # fmt: skip


def inputs() -> dict[str, int]:
    """How many were built, refused by name, and anything else."""
    mesh = mesh_from_gmsh("block.geo")
    rigid = {"mass": 1.0, "gravity": (0, -9.81), "rotation": 0.0, "velocity": (0, 0), "force": None}
    material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1.0, "gravity": (0, 0)}
    on_floor = {"friction": 0.3, "formulation": "gap", "gap_tolerance": 0.0, "facets": "base"}
    block = RigidSolid(mesh, mass=1.0)
    makers: list[tuple[Callable[..., Any], dict[str, Any]]] = [
        (lambda **k: RigidSolid(mesh, **k), rigid | {"springs": None, "held": (), "name": "a"}),
        (lambda **k: ElasticSolid(mesh, **k), material | {"fixed": (), "degree": 1}),
        (lambda **k: Contact(block, master=FLOOR, **k), on_floor),
        (HalfSpace, {"point": (0, 0), "normal": (0, 1)}),
        (Circle, {"center": (0, 0), "radius": 1.0, "inside": False}),
        (Discrete, {"stiffness": 1.0, "damping": 0.0}),
        (ThetaScheme, {"theta": 0.5, "forces": "theta"}),
        (GeneralisedAlpha, {"rho_inf": 0.5}),
    ]
    count = {"built": 0, "refused by name": 0, "anything else": 0}
    for make, right in makers:
        for name, value in itertools.product(right, SELDOM_RIGHT):
            try:
                make(**{**right, name: value})
                count["built"] += 1
            except InputError as refusal:
                named = any(each in str(refusal) for each in right)  # it, or what it contradicts
                count["refused by name" if named else "anything else"] += 1
            except Exception:  # what this looks for
                count["anything else"] += 1
    return count


# %% [markdown]
# ## Pairs
#
# Each kind of solid on each kind of master, by each law, friction and scheme: three steps, which
# finish, or the scene is refused when it is built.


# %%
def solid(kind: str, mesh: Any, name: str, **held: Any) -> Any:
    """One of 1000 kg/m³."""
    common = {"density": 1000.0, "gravity": (0, -9.81), "name": name}
    if kind == "rigid":
        return RigidSolid(mesh, **common)
    if kind == "elastic":
        return ElasticSolid(mesh, youngs_modulus=1e7, poisson_ratio=0.3, **common, **held)
    return HyperelasticSolid(mesh, energy=neo_hookean(1e7, 0.3), **common, **held)


def pair(slave: str, master: str, law: Any, friction: float, scheme: Any) -> str:
    """What became of one."""
    upper = mesh_from_gmsh("block.geo", width=0.4, height=0.2, n_width=2, n_height=1)
    up = solid(slave, upper, "up")
    try:
        if master == "obstacle":
            made = Scene([up], [Contact(up, "base", FLOOR, law, friction)], scheme)
        else:
            lower = mesh_from_gmsh("block.geo", width=0.6, height=0.3, n_width=3)
            lower.mesh.geometry.x[:, 1] -= 0.3
            low = solid(master, lower, "low", **({} if master == "rigid" else {"fixed": ["base"]}))
            contacts = [Contact(up, "base", (low, "top"), law, friction)]
            if master == "rigid":
                ground = HalfSpace(point=(0, -0.3), normal=(0, 1))
                contacts.append(Contact(low, "base", ground, law, friction))
            made = Scene([low, up], contacts, scheme)
    except InputError:
        return "refused"
    history = made.run(3e-3, 1e-3, progress=False)
    sound = history.finished and np.isfinite(history.rows()).all()
    return "run" if sound else f"{slave} on {master}: {history.reason}"


def pairs(every: int) -> list[str]:
    """What became of one of so many."""
    kinds = ["rigid", "elastic", "hyperelastic"]
    laws = ["velocity", "gap", "lagrange", Discrete(1e8)]
    schemes = [ThetaScheme(), ThetaScheme(1.0), GeneralisedAlpha(0.8)]
    all_of_them = list(itertools.product(kinds, ["obstacle", *kinds], laws, [0.0, 0.3], schemes))
    return [pair(*each) for each in all_of_them[::every]]


# %% [markdown]
# ## Memory
#
# The run again, longer; what the process holds is read as it goes. A row of the history is some
# hundred bytes.


# %%
def memory(steps: int) -> dict[str, list[float]]:
    """Steps, and what the process held then, MB."""
    held: dict[str, list[float]] = {"steps": [], "megabytes": []}

    def look() -> float:
        if not len(held["steps"]) or done[0] % (steps // 50) == 0:
            pages = int(Path("/proc/self/statm").read_text().split()[1])
            held["steps"].append(done[0])
            held["megabytes"].append(pages * os.sysconf("SC_PAGE_SIZE") / 1e6)
        done[0] += 1
        return 0.0

    done = [0]
    scene().run(steps * DT, DT, probes={"look": look}, progress=False)
    return held


def growth(held: dict[str, list[float]]) -> float:
    """Of the second half of the run, bytes a step."""
    steps, size = (np.array(held[name]) for name in ("steps", "megabytes"))
    late = steps >= steps[-1] / 2
    return float(np.polyfit(steps[late], size[late], 1)[0] * 1e6)


def draw(struck: list[dict[str, Any]], held: dict[str, list[float]]) -> None:
    """Where kills struck, and what was held."""
    from fenicsx_contact.output import plots

    fig, (left, right) = plots.grid(1, 2, (9, 3.2))
    for survived, colour in ((True, "tab:green"), (False, "tab:red")):
        at = [k["steps"] for k in struck if k["survived"] is survived]
        left.plot(at, np.zeros(len(at)), "|", color=colour, markersize=40)
    left.set_xlim(0, UNTIL / DT)
    left.set_yticks([])
    left.set_xlabel("steps that a kill left (green: went on to the same bits)")
    right.plot(held["steps"], held["megabytes"])
    right.set_ylim(0, None)
    right.set_xlabel("steps")
    right.set_ylabel("memory [MB]")
    plots.save(fig, RESULTS / "reliability.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    whole = run()
    struck = kills(2 if quick else 30, whole, np.random.default_rng(0))
    found, counted = faults(whole), inputs()
    tried, held = pairs(24 if quick else 1), memory(500 if quick else 20_000)
    summary: dict[str, Any] = {
        "kills": len(struck),
        "kills_survived": sum(k["survived"] for k in struck),
        "faults": found,
        "faults_withstood": sum(what in ("mended", "refused") for what in found.values()),
        "inputs": counted,
        "pairs": len(tried),
        "pairs_run": tried.count("run"),
        "pairs_refused": tried.count("refused"),
        "pairs_failed": [what for what in tried if what not in ("run", "refused")],
        "memory_steps": held["steps"][-1],
        "memory_bytes_a_step": growth(held),
    }
    write_summary(RESULTS, summary)
    draw(struck, held)
    print(
        f"kills survived {summary['kills_survived']} of {len(struck)}; faults withstood "
        f"{summary['faults_withstood']} of {len(found)}; inputs {sum(counted.values())}, of which "
        f"{counted['anything else']} neither built nor refused by name; pairs {len(tried)}, of "
        f"which {len(summary['pairs_failed'])} failed; memory "
        f"{summary['memory_bytes_a_step']:+.0f} bytes a step"
    )
    return summary


# %%
if __name__ == "__main__":
    if "--child" in sys.argv:
        run(directory=sys.argv[sys.argv.index("--child") + 1])
    else:
        main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - A law, an obstacle or a solid of your own in `pair`: does it run with all others?
# - A bit flipped at every place of `state.npz`: is there one that nobody sees?
# - `solver="iterative"` in `scene`: its runs resume to round-off, not to the bit. Why?
#
# ## Sources
#
# - `fenicsx_contact/output/storage.py`: checkpoints, checksums and the lock.
# - T. S. Pillai et al., *All File Systems Are Not Created Equal*, OSDI 2014: what a crash leaves.
