"""`horosphere snake`: growth vectors, motions, steering and navigation of snake robots."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import App, Parameter

from . import _output as out
from ._snake_output import print_coordinates, said, write
from ._values import Whole

app = App(
    name="snake",
    help="Snake robots: exact controllability, motion along brackets, steering, navigation.\n\n"
    "Example: `horosphere snake growth --links 8`",
    help_format="markdown",
    default_parameter=Parameter(negative=(), show_default=out.shown_default),
)

Numbers = Annotated[str, Parameter(allow_leading_hyphen=True)]
Postures = Literal["generic", "straight", "circular", "alternating", "folded"]


def _numbers(text: str, name: str) -> list[float]:
    from ..errors import InputError

    try:
        return [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        raise InputError(f"expected numbers separated by commas, got {text!r}", place=name) from None


def _snake(links: int | None, length: float, lengths: str | None, wheel_fraction: float) -> Any:
    from ..snake import Snake

    if lengths is None:
        return Snake(links, length, wheel_fraction=wheel_fraction)
    return Snake(links, lengths=_numbers(lengths, "--lengths"), wheel_fraction=wheel_fraction)


def _named_posture(snake: Any, posture: str, seed: int) -> Any:
    import numpy as np

    q = np.zeros(snake.n)
    inner = q[4:-1]
    if posture == "generic":
        q[2:] = np.random.default_rng(seed).uniform(-1.2, 1.2, snake.links)
    elif posture == "circular":
        inner[:] = 0.3
    elif posture == "alternating":
        inner[:] = 0.3 * (-1.0) ** np.arange(len(inner))
    elif posture == "folded":
        inner[:] = np.pi
    return q


@app.command
def growth(
    *,
    links: Whole | None = None,
    length: float = 2.0,
    lengths: str | None = None,
    wheel_fraction: float = 0.5,
    posture: Postures | None = None,
    q: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    method: Literal["auto", "spectral", "words", "float"] = "auto",
    seed: Whole = 0,
    json: bool = False,
) -> int:
    """Growth vector, exactly: how many directions the brackets of each degree reach.

    Example: `horosphere snake growth --links 8`

    Without `--posture` and `--q`, a table of the special postures and a generic one.

    Parameters
    ----------
    links
        Number of links, 6 by default; the first and the last have no wheels.
    length
        Of every link, metres.
    lengths
        One length a link, separated by commas, instead.
    wheel_fraction
        Where the wheels stand along their link, from 0 (front joint, excluded) to 1; 0.5 is the midpoint.
    posture
        A named posture only: generic, straight, circular, alternating, folded.
    q
        A posture x, y, theta, Phi_1, ..; equal angles are read as equal, pi as pi.
    method
        auto; spectral (rational arithmetic, midpoint wheels); words (modulo primes, any wheels); float.
    seed
        Of the generic posture.
    json
        Print the result as JSON.
    """
    with out.working("computing brackets"):
        snake = _snake(links, length, lengths, wheel_fraction)
        if q is not None:
            cases = [("given", snake.growth(_numbers(q, "--q"), method))]
        else:
            names = [posture] if posture else ["generic", "circular", "straight", "alternating", "folded"]
            cases = [(name, snake.growth(_named_posture(snake, name, seed), method)) for name in names]
    rows = [
        {
            "posture": name,
            "vector": list(g.vector),
            "factor": list(g.factor),
            "weights": list(g.weights),
            "degree": g.degree,
            "controllable": g.complete,
            "dimension": g.dimension,
            "method": g.method,
            "certificate": g.certificate,
            "reason": g.reason,
        }
        for name, g in cases
    ]
    if json:
        out.print_json({"snake": repr(snake), "growth": rows})
        return out.DONE
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0), title=f"{snake!r}: {snake.n} coordinates", title_justify="left")
    for column in ("posture", "growth vector", "degree", "weights", "controllable"):
        table.add_column(column, overflow="fold")
    for row in rows:
        vector = "(" + ", ".join(map(str, row["vector"])) + ")"
        weights = ",".join(map(str, row["weights"]))
        reach = "yes" if row["controllable"] else f"no: {row['vector'][-1]} of {row['dimension']}"
        table.add_row(row["posture"], vector, str(row["degree"]), weights, reach)
    out.print_table(table)
    out.print_notes(dict.fromkeys([r["certificate"] for r in rows] + [r["reason"] for r in rows if r["reason"]]))
    return out.DONE


@app.command
def simulate(
    *,
    links: Whole | None = None,
    length: float = 2.0,
    wheel_fraction: float = 0.5,
    q: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    word: str | None = None,
    t: float = 0.3,
    gait: Literal["serpenoid", "shape"] | None = None,
    out_folder: Annotated[Path | None, Parameter(name="--out")] = None,
    json: bool = False,
) -> int:
    """Moves a snake along a bracket (`--word`) or by a gait, and says what came of it.

    Example: `horosphere snake simulate --links 7 --word 1212`

    Parameters
    ----------
    links
        Number of links, 6 by default.
    length
        Of every link, metres.
    wheel_fraction
        Where the wheels stand along their link; 0.5 is the midpoint.
    q
        The start x, y, theta, Phi_1, ..; a generic posture by default.
    word
        A bracket: "12", "1212" (right-normed) or "[1,[2,[1,2]]]"; the letters are the control fields g1 to g4.
    t
        Seconds of a leg of the word.
    gait
        serpenoid (the head runs along a serpenoid curve) or shape (two joints swing).
    out_folder
        Folder for trajectory.npz and motion.png.
    json
        Print the result as JSON.
    """
    import numpy as np

    from ..errors import InputError
    from ..io import output_folder
    from ..snake import bracket_figure, motion_figure, serpenoid, shape_gait, word_text

    if (word is None) == (gait is None):
        raise InputError("expected either --word or --gait", choices=("--word 12", "--gait serpenoid", "--gait shape"))
    with out.working("integrating"):
        snake = _snake(links, length, None, wheel_fraction)
        start = _named_posture(snake, "generic", 0) if q is None else snake.check(_numbers(q, "--q"), single=True)
        if word is not None:
            result = snake.bracket_motion(start, word, t)
            motion = result.motion
            data: dict[str, Any] = {
                "word": word_text(result.word),
                "degree": result.degree,
                "legs": len(result.legs),
                "predicted": result.predicted.tolist(),
                "measured": result.measured.tolist(),
                "order": result.order,
            }
            figure = bracket_figure(snake, start, word, t)
        else:
            done = serpenoid(snake, start) if gait == "serpenoid" else shape_gait(snake, start)
            motion = done.motion
            data = {"gait": gait, "displacement_per_period": done.displacement.tolist(), "reason": done.reason}
            figure = motion_figure(snake, motion)
        data |= {
            "end": motion.end.tolist(),
            "residual": motion.residual,
            "error": motion.error,
            "time": float(motion.time[-1]),
        }
        if out_folder is not None:
            folder = output_folder(out_folder)
            data["files"] = write(folder, snake, motion, figure)
    from ..numeric import at_most

    line, good = said(result if word is not None else done, word)
    if json:
        out.print_json(data)
        return out.DONE if good else out.FAILED
    out.print_verdict(line, good)
    print_coordinates(snake, motion, result.predicted if word is not None else None)
    rows = [("Snake", repr(snake)), ("Time", f"{motion.time[-1]:.2f} s")]
    if word is not None:
        rows.append(
            ("Order", f"{result.order:.3f}: the change grows as t^{result.order:.2f} with the seconds t of a leg")
        )
    elif len(done.displacement):
        x, y, theta = done.displacement[-1]
        rows.append(("Last period", f"head moved {x:.3f}, {y:.3f} m and turned {np.degrees(theta):.3g} degrees"))
    rows.append(("Sideways slip", f"at most {at_most(motion.residual, 2)} m/s at any wheel"))
    rows.append(("Integration error", f"{motion.error:.1e} (estimated)"))
    if out_folder is not None:
        rows.append(("Files", ", ".join(data["files"])))
    out.print_rows(rows)
    return out.DONE if good else out.FAILED


@app.command
def steer(
    start: Numbers,
    goal: Numbers,
    /,
    *,
    links: Whole | None = None,
    length: float = 2.0,
    wheel_fraction: float = 0.5,
    tolerance: float = 1e-9,
    seed: Whole = 0,
    out_folder: Annotated[Path | None, Parameter(name="--out")] = None,
    json: bool = False,
) -> int:
    """Steers a snake from one posture exactly to another one nearby.

    Example: `horosphere snake steer 0,0,0,0.2,0.3,-0.2,0.1,0 0.1,0,0,0.2,0.3,-0.2,0.1,0`

    Parameters
    ----------
    start
        Posture x, y, theta, Phi_1, .., separated by commas; the number of links follows from it.
    goal
        Posture to arrive at.
    links
        Number of links, if it is to be checked.
    length
        Of every link, metres.
    wheel_fraction
        Where the wheels stand along their link; 0.5 is the midpoint.
    tolerance
        Largest coordinate error at the end, metres or radians.
    seed
        Of the random starting paths.
    out_folder
        Folder for trajectory.npz, inputs.csv and motion.png.
    json
        Print the result as JSON.
    """
    from ..errors import InputError
    from ..io import output_folder
    from ..snake import motion_figure

    q0, q1 = _numbers(start, "START"), _numbers(goal, "GOAL")
    for name, q in (("START", q0), ("GOAL", q1)):
        if len(q) < 5 or len(q) != len(q0):
            wanted = f"{len(q0)} numbers as START has" if len(q0) >= 5 else "x, y, theta and at least two angles Phi"
            raise InputError(f"expected {wanted}, got {len(q)}", place=name)
    with out.working("steering"):
        snake = _snake(len(q0) - 2 if links is None else links, length, None, wheel_fraction)
        result = snake.steer(q0, q1, tolerance, seed=seed)
        data: dict[str, Any] = {
            "solved": result.solved,
            "reason": result.reason,
            "error": result.error,
            "path_length": result.path_length,
            "tries": result.tries,
            "duration": result.duration,
            "inputs": result.inputs.tolist(),
        }
        if out_folder is not None:
            folder = output_folder(out_folder)
            figure = motion_figure(snake, result.motion)
            data["files"] = write(folder, snake, result.motion, figure, result.inputs, result.duration)
    if json:
        out.print_json(data)
    else:
        out.print_verdict("Arrived" if result.solved else f"NOT SOLVED: {result.reason}", result.solved)
        rows: list[tuple[str, Any]] = [
            ("Error", f"{result.error:.2g} m or rad, the largest of all coordinates"),
            ("Way of joint 1", f"{result.path_length:.3g} m, there and back counted"),
            ("Starting paths tried", result.tries),
            ("Segments of constant input", len(result.inputs)),
        ]
        rows += [("Files", ", ".join(data["files"]))] if "files" in data else []
        out.print_rows(rows)
    return out.DONE if result.solved else out.FAILED


@app.command
def navigate(
    scene: str,
    /,
    *,
    weave: float | None = None,
    out_folder: Annotated[Path | None, Parameter(name="--out")] = None,
    json: bool = False,
) -> int:
    """Moves a snake from posture to posture among obstacles, with a certificate of the whole body's clearance.

    Example: `horosphere snake navigate snake-gap`

    Parameters
    ----------
    scene
        A scene file with a snake, or snake-gap, snake-slalom, snake-park.
    weave
        Metres; amplitude of a wave over the path that keeps the snake away from singular postures. By default it is laid where
        the posture would be singular; 0 for none.
    out_folder
        Folder for trajectory.npz and motion.png.
    json
        Print the result as JSON.
    """
    from ..io import output_folder
    from ..numeric import at_least
    from ..scenes import Scene
    from ..snake import Surroundings, motion_figure, navigate_scene, snake_of

    with out.working("navigating") as progress:
        problem = Scene.load(scene)
        out.announce_compiling(progress)
        result = navigate_scene(problem, weave=weave)
        snake = snake_of(problem)
        proof = result.certificate
        data: dict[str, Any] = {
            "scene": problem.name,
            "solved": result.solved,
            "failure": result.failure,
            "reason": result.reason,
            "clearance": None if proof is None else proof.clearance,
            "certified": bool(proof and proof.certified),
            "error": result.error,
            "attempts": [{"radius": r, "margin": m, "outcome": o} for r, m, o in result.attempts],
            "notes": list(result.notes),
        }
        if result.motion is not None:
            data["duration"] = float(result.motion.time[-1])
            data["residual"] = result.motion.residual
            if out_folder is not None:
                around = Surroundings.of(list(problem.obstacles), None)
                figure = motion_figure(snake, result.motion, around, result.path)
                data["files"] = write(output_folder(out_folder), snake, result.motion, figure)
    if json:
        out.print_json(data)
    else:
        out.print_verdict("Solved and certified" if result.solved else f"NOT SOLVED: {result.reason}", result.solved)
        if proof is not None and result.motion is not None:
            out.print_rows(
                [
                    ("Clearance, all times", f"at least {at_least(proof.clearance, 3)} m"),
                    ("Error at the goal", f"{result.error:.2g}"),
                    ("Duration", f"{result.motion.time[-1]:.1f} s"),
                    ("Plans tried", len(result.attempts)),
                ]
            )
        out.print_notes(result.notes)
    return out.DONE if result.solved else out.FAILED
