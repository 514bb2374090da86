"""Friction at which the full dam fails, by cohesion: stones with joints beside a continuum with the strength of the joints, and planes by hand.

    PYTHONPATH=tools python examples/guilhofrei_continuum/friction.py OUTPUT

OUTPUT has stones_<seed>.h5 and continuum.h5 of mesh.py. Prints a row for each cohesion, writes OUTPUT/friction.csv and friction.png."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import planes
from matplotlib import pyplot
from quoin_tools.base.files import save_figure
from quoin_tools.base.results import Results
from quoin_tools.show.style import LINES, STYLE

HERE = Path(__file__).parent
QUOIN = os.environ.get("QUOIN", "build/quoin")
STONES = (0.0, 12.5e3, 25e3, 50e3, 75e3)  # cohesions [Pa]
CONTINUUM = (50e3, 75e3, 100e3, 125e3, 150e3, 175e3)
STRONGEST, WEAKEST = 59.0, 1.0  # friction that is tried [degree]
CLOSE = 1.0


def run(scene, model, output, *options):
    done = subprocess.run([QUOIN, "-options_file", HERE / scene, "-model", model, "-output", output, *options], check=False, capture_output=True, text=True)
    if done.returncode not in (0, 3, 4, 6):  # it collapsed, or found no equilibrium: a result
        sys.exit(f"friction: {done.stderr.strip()}")
    return Results(output)


def stones(model, output, cohesion):
    """Friction [degree] of the last trial that stands and of the first that fails; (WEAKEST, None): nothing fails."""
    found = run("scene.yaml", model, output, "-joints_default_cohesion", repr(cohesion), "-joints_default_cohesion_residual", repr(cohesion))
    found = found.stage_summary("reduction")["strength_reduction"]
    return found["stable"], found["failing"]


def continuum(model, output, cohesion):
    """Likewise, by bisection; each friction is a run of its own. (None, STRONGEST): it never stands."""
    def stands(friction):
        strength = [word for group in ("dam", "facing") for word in (f"-materials_{group}_cohesion", repr(cohesion), f"-materials_{group}_friction", repr(friction))]
        return run("scene_continuum.yaml", model, f"{output}/{friction:g}", *strength).stage_summary("swhp")["verdict"] == "converged"

    if not stands(STRONGEST):
        return None, STRONGEST
    high, low = STRONGEST, WEAKEST
    while high - low > CLOSE:
        middle = round(0.5 * (high + low), 2)
        high, low = (middle, low) if stands(middle) else (high, middle)
    return high, low


def rows_of(folder, seeds=(1, 2, 3), of_stones=STONES, of_continuum=CONTINUUM):
    """Cohesion [Pa] to what fails at which friction."""
    needed = planes.forces()
    rows = {c: {"by hand": planes.friction_needed(c, needed)} for c in sorted({*of_stones, *of_continuum})}
    for cohesion in of_stones:
        for seed in seeds:
            rows[cohesion][f"seed {seed}"] = stones(f"{folder}/stones_{seed}.h5", f"{folder}/stones/{seed}_{cohesion:g}", cohesion)
    for cohesion in of_continuum:
        rows[cohesion]["continuum"] = continuum(f"{folder}/continuum.h5", f"{folder}/continuum/{cohesion:g}", cohesion)
    return rows


def words(found):
    if found is None:
        return ""
    if isinstance(found, float):
        return f"{found:.1f}"
    stable, failing = found
    return f"above {failing:.0f}" if stable is None else f"below {stable:.0f}" if failing is None else f"{failing:.1f}"


def draw(rows, path):
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(figsize=(7.5, 4.6))
        names = [name for name in ("seed 1", "seed 2", "seed 3", "continuum") if any(name in row for row in rows.values())]
        for colour, name in zip(LINES, names):
            found = [(c / 1e3, *row[name]) for c, row in rows.items() if name in row]
            label = name if name == "continuum" else f"stones, {name}"
            axes.plot([c for c, *_ in found], [STRONGEST if stable is None else WEAKEST if failing is None else failing for _, stable, failing in found],
                      marker="o", ms=4, lw=2.2 if name == "continuum" else 1.3, color=colour, label=label)  # fmt: skip
            for c, stable, failing in found:
                if stable is None or failing is None:  # beyond what was tried
                    axes.plot(c, STRONGEST if stable is None else WEAKEST, marker="^" if stable is None else "v", ms=9, color=colour)
        axes.plot([c / 1e3 for c in rows], [row["by hand"] for row in rows.values()], "k--", lw=1.2, label="worst plane through a continuum, by hand")
        axes.plot([], [], "k^", ms=7, ls="none", label="fails also with 59 degrees")
        axes.plot([], [], "kv", ms=7, ls="none", label="stands also with 1 degree")
        axes.set_xlabel("cohesion, of joints or continuum [kPa]; no tension")
        axes.set_ylabel("friction at failure [degree]")
        axes.set_ylim(0, 60)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
        axes.set_title("Full reservoir: friction at which the dam fails")
        save_figure(figure, path)
        pyplot.close(figure)


def main(folder):
    rows = rows_of(folder)
    names = ("seed 1", "seed 2", "seed 3", "continuum", "by hand")
    with open(f"{folder}/friction.csv", "w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([("cohesion_kPa", *names), *((c / 1e3, *(words(row.get(name)) for name in names)) for c, row in rows.items())])
    for cohesion, row in rows.items():
        print("| " + " | ".join([f"{cohesion / 1e3:g}", *(words(row.get(name)) for name in names)]) + " |")
    draw(rows, f"{folder}/friction.png")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
