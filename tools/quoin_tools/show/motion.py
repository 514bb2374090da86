"""Describes a record of ground motion: its largest values, how it ends, its response spectrum; Newmark's block on it; and the motion of points of a model.

    quoin motion quake.csv [more.AT2 ...]              records of accelerations, as docs/reference/motions.md has them
    quoin motion out/dam --points base crest           points of the mesh in a dynamic stage of a run, over the first of them
    quoin motion out/dam --record [--points crest]     the record that shook the run; points over it; Newmark's block with the
                                                                       yield coefficient of the run, beside the slip of its joint
    quoin motion quake.csv --ky 0.2 [0.4]              a block that slides: yield coefficients each way
    quoin motion quake.csv --friction 25 --slope 10    or on a plane that falls to +x
    quoin motion quake.csv --design spectrum.yaml      beside a design spectrum (docs/safety.md)

prints a table and writes NAME_motion.png, NAME_spectrum.csv and, of a block, NAME_slip.csv into --to. Accelerations of points are second
differences of history.csv: relaxation.history_every must leave twenty rows and more in the shortest period looked at.
"""

import argparse
import os
import sys

import numpy as np
from matplotlib import pyplot

from quoin_tools.assess import design_spectrum, newmark, spectrum
from quoin_tools.assess.shaken import block_of
from quoin_tools.base import ground, record, scene
from quoin_tools.base.command import Parser
from quoin_tools.base.files import save_figure
from quoin_tools.base.record import RecordError
from quoin_tools.base.results import Results
from quoin_tools.base.time_series import TimeSeries, dynamic_stages
from quoin_tools.show import style
from quoin_tools.show.export import write
from quoin_tools.show.shaking import draw_ratio, even_rows, period_axis, ratio_of

ROWS = 20  # in the shortest period of the spectrum of a point
CLOSED = 0.01  # of the largest velocity: velocity allowed at the end of a record


def number_or_folder(text):
    if os.path.isdir(text):
        return text
    try:
        return float(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"'{text}': expected a number, or the output folder of a run") from error


def parser():
    words = Parser(prog="quoin motion", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("sources", nargs="+", metavar="FILE|FOLDER", help="records, or one output folder")
    words.add_argument("--direction", choices=("x", "y"), default="x", help="component of tables that have two, and of points (x)")
    words.add_argument("--scale", type=float, default=1.0, help="factor on records (1)")
    words.add_argument("--pga", type=float, help="[m/s2] in place of it: scale to this largest acceleration")
    words.add_argument("--points", nargs="+", metavar="NAME", help="of an output folder: points of the mesh, the first one on the ground")
    words.add_argument("--record", action="store_true", help="of an output folder: the record that shook it, before its points")
    words.add_argument("--stage", help="of an output folder: its dynamic stage (the only one)")
    words.add_argument("--damping", type=float, default=spectrum.DAMPING, help="of the oscillators (0.05)")
    words.add_argument("--periods", type=float, nargs=2, default=(0.02, 4.0), metavar=("FROM", "TO"), help="[s] of the spectrum (0.02 4)")
    words.add_argument("--design", metavar="FILE", help="a design spectrum to draw beside them, with their damping (docs/safety.md)")
    words.add_argument("--gravity", type=float, default=newmark.G, help="[m/s2] (9.81)")
    words.add_argument("--ky", type=number_or_folder, nargs="+", metavar="K", help="yield coefficient of a block, or one for sliding to +x and one for back; with --record "
                       "that of the run, one way, or of another run whose output folder is given")  # fmt: skip
    words.add_argument("--friction", type=float, metavar="PHI", help="[degree] in place of --ky: of a block on a plane")
    words.add_argument("--slope", type=float, default=0.0, help="[degree] of that plane, which falls to +x (0)")
    words.add_argument("--to", metavar="FOLDER", help="for the picture and the tables (that of the run, else the working directory)")
    return words


# ---- records and points


def stage_of(results, stage):
    """The dynamic stage that was asked for, or the only one."""
    dynamic = dynamic_stages(results)
    if stage is None and len(dynamic) == 1:
        stage = dynamic[0]
    if stage is not None and stage not in results.stages:
        raise RecordError(f"{results.folder}: no stage '{stage}', there are: {', '.join(results.stages)}")
    if stage not in dynamic:
        raise RecordError(f"{results.folder}: expected --stage, a dynamic one: {', '.join(dynamic) or 'there is none'}")
    return stage


def points_of(results, stage, options):
    """Returns records of points of a run, with no more rows than the shortest period [s] needs."""
    c, names = TimeSeries(results, stage), options.points or ([] if options.record else [""])
    for name in names:
        if name not in c.probes:
            raise RecordError(f"{results.folder}: expected --points of the mesh: {', '.join(c.probes) or 'it has none'}")
    t = even_rows(c.time)
    few = slice(None, None, max(1, int(options.periods[0] / (2 * ROWS * max(np.ptp(t), 1e-300)) * len(t))))
    return [record.from_history(t[few], c.probe(name, options.direction)[few], name) for name in names]


def record_of(results, options):
    """Returns (the records that shook a run along the direction, Newmark's block of the run where the user asks for no other one, or None)."""
    used = scene.of_run(results.folder, results.summary)
    shakings = ground.of_run(results, used)
    strongest = ground.strongest(shakings, options.direction)
    if strongest is None:
        raise RecordError(f"{results.folder}: no record shakes it along {options.direction}")
    other = other_run(options)
    own = (options.ky is None or other) and options.friction is None and options.direction == "x"
    return replace_name(strongest.record, f"record {strongest.record.name}"), block_of(results, used, shakings, other) if own else None


def other_run(options):
    """Output folder that was given in place of a yield coefficient."""
    return options.ky[0] if options.ky and isinstance(options.ky[0], str) else None


def replace_name(r, name):
    return record.Record(name, r.t, r.a)


def of_folder(folder, options):
    """Records of a run, and Newmark's block with its yield coefficient."""
    results = Results(folder)
    stage = stage_of(results, options.stage)
    first, block = record_of(results, options) if options.record else (None, None)
    return ([first] if first else []) + points_of(results, stage, options), block, joints_beside(results, stage, block)


def joints_beside(results, stage, block):
    """Returns words and series of the joints that slid where Newmark's block would: the joints of its mechanism, or the joint that slid farthest."""
    if block is None:
        return []
    c = TimeSeries(results, stage)
    names = [name for name in block.joints if name in c.joints] or c.sliding(1)
    return [(f"joint {name} of the run", c.joints[name]) for name in names]


def records_of(options):
    folders = [path for path in options.sources if os.path.isdir(path)]
    if folders and len(options.sources) > 1:
        raise RecordError(f"{folders[0]}: an output folder: expected no other source beside it")
    if folders:
        return of_folder(folders[0], options)
    if options.points or options.record:
        raise RecordError(f"{options.sources[0]}: a record has no points: expected an output folder")
    found = [record.read(path, options.direction, options.scale) for path in options.sources]
    if options.pga is not None:
        if options.scale != 1.0 or options.pga <= 0 or not all(r.pga for r in found):
            raise RecordError(f"--pga {options.pga:g}: expected a value > 0, no --scale, and records with an acceleration")
        found = [r.scaled(options.pga / r.pga) for r in found]
    return found, None, []


def periods_of(records, options):
    shortest, longest = options.periods
    if not 0 < shortest < longest:
        raise RecordError(f"--periods {shortest:g} {longest:g}: expected two times > 0 that ascend")
    if not 0 <= options.damping < 1:
        raise RecordError(f"--damping {options.damping:g}: expected a ratio from 0 to less than 1")
    if options.points:
        points = records[options.record :]  # a record is linear between its rows, a point is only known at its rows
        shortest = max(shortest, ROWS * max(np.median(np.diff(r.t)) for r in points))
        if shortest >= longest:
            raise RecordError(f"{options.sources[0]}: rows of history.csv are too far apart for periods up to {longest:g} s (relaxation.history_every)")
    return spectrum.periods(shortest, longest)


def block_asked(options):
    """Returns the sliding block that the options describe; None: they describe none."""
    if options.ky is not None and any(isinstance(k, str) for k in options.ky):
        if len(options.ky) > 1 or not options.record or options.friction is not None:
            raise RecordError(f"--ky {' '.join(map(str, options.ky))}: expected the folder of one run, and --record")
        return None
    if options.ky is None and options.friction is None:
        return None
    if options.ky is not None and (options.friction is not None or len(options.ky) > 2):
        raise RecordError("expected --ky with one or two numbers, or --friction and --slope")
    if options.ky is not None:
        return newmark.yielding(*options.ky, g=options.gravity)
    return newmark.incline(options.friction, options.slope, options.gravity)


# ---- terminal


def describe(r, g):
    """Lines (what, value, unit) of a record."""
    first, last = r.significant()
    yield "from, to", f"{r.t[0]:g}, {r.t[-1]:g}", "s"
    yield "PGA", f"{r.pga:.4f}", f"m/s2, {r.pga / g:.4f} g at {r.t[np.abs(r.a).argmax()]:g} s"
    yield "PGV", f"{r.pgv:.4f}", "m/s"
    yield "PGD", f"{r.pgd:.4f}", "m"
    yield "Arias intensity", f"{r.arias(g)[-1]:.4f}", "m/s"
    yield "significant duration", f"{last - first:.3f}", f"s, 5 to 95 % of it, from {first:.3f} s"
    yield "ends with", f"{r.v[-1]:.3g}", f"m/s{', not closed: baseline' if abs(r.v[-1]) > CLOSED * r.pgv else ''}"
    yield "ends moved by", f"{r.u[-1]:.3g}", "m"


def describe_slip(slip, reach):
    yield "block: final slip", f"{slip.final:.5f}", "m"
    yield "largest each way", f"{reach[0]:.5f}, {reach[1]:.5f}", "m"
    if slip.phases:
        yield "first, last motion", "{:.4f}, {:.4f}".format(*slip.ends()), f"s, {len(slip.phases)} slips"


def print_records(records, slips, g):
    for i, r in enumerate(records):
        print(r.name)
        rows = [*describe(r, g), *(describe_slip(*slips[i]) if i < len(slips) else ())]
        for what, value, unit in rows:
            print(f"  {what:<22}{value:>18} {unit}")


# ---- files


def spectrum_table(records, spectra, over, design=None):
    """Returns header and rows of a table of spectra. over: points of a run, whose spectra are also divided by that of the first point; design: (title, S_a [m/s2])."""
    header = ["period [s]"]
    columns = [spectra[0].period]
    for r, s in zip(records, spectra):
        header += [f"{r.name} S_d [m]", f"{r.name} S_v [m/s]", f"{r.name} S_a [m/s2]"]
        columns += [s.displacement, s.velocity, s.acceleration]
    if over:
        header += [f"{r.name} over {records[0].name}" for r in records[1:]]
        columns += [ratio_of(s, spectra[0]) for s in spectra[1:]]
    if design:
        header, columns = [*header, f"{design[0]} S_a [m/s2]"], [*columns, design[1]]
    return header, np.array(columns).T


def slip_table(r, slip):
    return (f"t [s] ({r.name})", "slip [m]", "velocity [m/s]"), np.array([slip.t, slip.slip, slip.velocity]).T


def draw(records, spectra, slips, damping, over, beside, design):
    panels = [("acceleration\n[m/s$^2$]", "a"), ("velocity\n[m/s]", "v"), ("displacement\n[m]", "u")]
    with pyplot.rc_context(style.STYLE):
        figure = pyplot.figure(figsize=(11, 6.2))
        grid = figure.add_gridspec(len(panels) + bool(slips), 2, width_ratios=(1.35, 1))
        upper = None
        for row, (label, name) in enumerate(panels):
            axes = upper = figure.add_subplot(grid[row, 0], sharex=upper)
            for r, colour in zip(records, colours(records)):
                axes.plot(r.t, getattr(r, name), color=colour, linewidth=0.8, label=r.name)
            dress(axes, label, last=row + 1 == len(panels) and not slips)
        if slips:
            axes = figure.add_subplot(grid[-1, 0], sharex=upper)
            for (slip, _), colour in zip(slips, colours(records)):
                axes.plot(slip.t, slip.slip, color=colour, linewidth=1.0, label="block" if beside else None)
            for words, series in beside:
                axes.plot(series["time"], series["slip"] - series["slip"][0], color=style.LINES[3], linewidth=1.0, linestyle="--", label=words)
            dress(axes, "slip of the\nblock [m]", last=True)
            if beside:
                axes.legend(fontsize=8)
        right = figure.add_subplot(grid[:-1, 1] if over else grid[:, 1])
        draw_spectra(right, records, spectra, damping, design)
        if over:
            right.set_xlabel("")
            pairs = [(f"{r.name} over {records[0].name}", colour, s, spectra[0]) for r, s, colour in list(zip(records, spectra, colours(records)))[1:]]
            draw_ratio(figure.add_subplot(grid[-1, 1], sharex=right), pairs)
            figure.axes[-1].set_xlabel("period [s]")
    return figure


def colours(records):
    return [style.LINES[i % len(style.LINES)] for i in range(len(records))]


def dress(axes, label, last):
    axes.set_ylabel(label)
    axes.axhline(0, color=style.GREY, linewidth=0.5)
    axes.margins(x=0)
    axes.grid(alpha=0.3, linewidth=0.5)
    if last:
        axes.set_xlabel("t [s]")
    else:
        axes.tick_params(labelbottom=False)


def draw_spectra(axes, records, spectra, damping, design):
    for r, s, colour in zip(records, spectra, colours(records)):
        axes.plot(s.period, s.acceleration, color=colour, linewidth=1.3, label=r.name)
    if design:
        axes.plot(spectra[0].period, design[1], color="black", linewidth=1.3, linestyle="--", label=design[0])
    axes.set_xscale("log")
    axes.set_ylim(0, axes.get_ylim()[1] * (1 + 0.05 * len(axes.lines)))  # room for the legend
    axes.set_xlim(spectra[0].period[[0, -1]])
    period_axis(axes)
    axes.set_xlabel("period [s]")
    axes.set_ylabel("pseudo-acceleration [m/s$^2$]")
    axes.set_title(f"response spectrum, damping {100 * damping:g} %")
    axes.grid(alpha=0.3, linewidth=0.5, which="both")
    axes.legend(loc="upper right")


def designed(options, period):
    """Returns (title, S_a [m/s2]) of the design spectrum that the options name, None: they name none."""
    if options.design is None:
        return None
    asked = design_spectrum.read(options.design)
    return asked.title, (asked.horizontal if options.direction == "x" else asked.vertical)(period, options.damping)


def main(arguments=None):
    options = parser().parse_args(arguments)
    block = block_asked(options)
    records, own, beside = records_of(options)
    spectra = [spectrum.of(r, periods_of(records, options), options.damping) for r in records]
    design = designed(options, spectra[0].period)
    slips = [newmark.slide(r, block) for r in records] if block else [(own.slip, (own.slip.slip.min(), own.slip.slip.max()))] if own else []
    over = (options.record or bool(options.points)) and len(records) > 1
    print_records(records, slips, options.gravity)
    if own:
        print(f"  {'k_y of the run':<22}{abs(own.stable):>18.4g} stage {own.from_stage}, along {'+x' if own.way > 0 else '-x'}")
    for words, series in beside:
        print(f"  {words:<22}{series['slip'][-1] - series['slip'][0]:>18.5f} m, mean slip at the end")
    source = options.sources[0].rstrip("/")
    folder = options.to or (source if os.path.isdir(source) else ".")
    name = os.path.join(folder, os.path.splitext(os.path.basename(source))[0])
    written = [f"{name}_motion.png", write(f"{name}_spectrum.csv", *spectrum_table(records, spectra, over, design))]
    figure = draw(records, spectra, slips, options.damping, over, beside, design)
    save_figure(figure, written[0])
    pyplot.close(figure)
    if slips:
        written.append(write(f"{name}_slip.csv", *slip_table(records[0], slips[0][0])))
    print("\n".join(written))
    return 0


if __name__ == "__main__":
    sys.exit(main())
