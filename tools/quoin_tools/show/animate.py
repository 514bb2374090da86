"""Makes a film of a dynamic stage from its frames, or of the mechanism of a stage that fails.

    quoin show --film FOLDER [--stage shake] [--scale 50] [--frames 120] [--speed 0.5] [--mp4]

writes FOLDER/animation_<stage>.gif (or .mp4, where ffmpeg is installed): the deformed section relative to the ground, joints that slip or are open,
the water, the motion of the ground and how far joints have slid, with a marker at the time of the picture. A dynamic stage needs
frames in its results (stages.<name>.frames of the scene); one that collapsed, or has trials of which one failed, shows how it fails.
"""

import argparse
import io
import os
import sys
import tempfile

import numpy as np
from matplotlib import pyplot
from matplotlib.animation import FFMpegWriter
from PIL import Image

from quoin_tools.base import scene
from quoin_tools.base.command import Parser
from quoin_tools.base.files import write_file
from quoin_tools.base.ground import of_run
from quoin_tools.base.integrity import signed_gif, signed_mp4
from quoin_tools.base.record import RecordError
from quoin_tools.base.results import Results, ResultsError
from quoin_tools.mesh.blockmesh import MeshError
from quoin_tools.mesh.of_run import mesh_of
from quoin_tools.show.film import mechanism_film, stage_film
from quoin_tools.show.style import STYLE

COLOURS = 96  # of a GIF
FASTEST, SLOWEST = 25.0, 4.0  # pictures a second
HELD = 1.5  # [s] the last picture stays


class AnimateError(ValueError):
    """A request is wrong; the message is one line."""


def parser():
    words = Parser(prog="quoin show --film", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("folder", help="output folder of a run; the film goes there too")
    words.add_argument("--stage", help="a stage with frames, or one that fails (the last one with frames, else the last that fails)")
    words.add_argument("--scale", type=float, help="factor of the displacements (chosen by their size)")
    words.add_argument("--frames", type=int, default=120, metavar="N", help="no more pictures than these (120)")
    words.add_argument("--speed", type=float, help="seconds of the stage in a second of the film (1, or what 4 to 25 pictures a second allow)")
    words.add_argument("--whole", action="store_true", help="show the whole model, also the large group (rock)")
    words.add_argument("--mp4", action="store_true", help="MP4 in place of GIF; needs ffmpeg")
    return words


# ---- which stage


def checked(options):
    if options.frames < 2:
        raise AnimateError(f"--frames {options.frames}: expected 2 or more")
    for name in ("scale", "speed"):
        value = getattr(options, name)
        if value is not None and not 0 < value < np.inf:
            raise AnimateError(f"--{name} {value:g}: expected a number > 0")
    if options.mp4 and not FFMpegWriter.isAvailable():
        raise AnimateError("--mp4: ffmpeg is not installed; without --mp4 the film is a GIF")
    return options


def stage_of(results, name):
    """The stage that was asked for, or the last one that can be shown."""
    if name is not None:
        if name not in results.stages:
            raise AnimateError(f"{results.folder}: no stage '{name}', there are: {', '.join(results.stages)}")
        return name
    framed = [stage for stage in results.stages if moves_in_time(results, stage)]
    failed = [stage for stage in results.stages if results.stage(stage).mechanism is not None]
    if not framed + failed:
        raise AnimateError(f"{results.folder}: no stage with frames (stages.<name>.frames of a dynamic stage) and none that fails")
    return (framed or failed)[-1]


def moves_in_time(results, stage):
    return bool(results.frames(stage)) and "balance" in results.stage_summary(stage)["energy"]


def shakings_of(results, used):
    """Returns the records that moved the ground; warns where they are not known."""
    try:
        return of_run(results, used)
    except (OSError, RecordError) as error:
        print(f"show: the motion of the ground is left out: {error}", file=sys.stderr)
        return []


def film_of(results, options):
    used = scene.of_run(results.folder, results.summary)
    stage = stage_of(results, options.stage)
    try:
        mesh = mesh_of(results, used)[0]
    except (OSError, MeshError, ResultsError) as error:
        print(f"show: the water is left out: {error}", file=sys.stderr)
        mesh = None
    if moves_in_time(results, stage):
        return stage_film(results, used, mesh, stage, shakings_of(results, used), options.frames, options.scale, options.whole)
    if results.stage(stage).mechanism is None:
        raise AnimateError(f"{results.folder}: stage '{stage}' has no frames in time (stages.{stage}.frames of a dynamic stage) and does not fail")
    return mechanism_film(results, used, mesh, stage, options.frames, options.whole)


# ---- pictures to a file


def pace(film, speed):
    """Returns pictures per second, and seconds of the stage per second of the film (None: no time passes)."""
    if film.time is None:
        return 12.0, None
    step = np.diff(film.time).mean()
    rate = (speed or np.clip(1.0, SLOWEST * step, FASTEST * step)) / step
    if not 0.2 <= rate <= 100:
        raise AnimateError(f"--speed {speed:g}: would be {rate:.3g} pictures a second of the {len(film.time)} that there are: expected 0.2 to 100")
    return rate, rate * step


def pictures(film, speed):
    """RGB pictures of a film, one after another."""
    with pyplot.rc_context(STYLE | {"figure.dpi": 88}):
        screen = film.open(speed)
        for frame in range(film.n):
            screen.show(frame)
            screen.figure.canvas.draw()
            yield Image.fromarray(np.asarray(screen.figure.canvas.buffer_rgba())[..., :3])
        pyplot.close(screen.figure)


def gif(images, rate):
    """Returns the bytes of the film; all pictures share the colours of a few of them, so that parts at rest do not flicker."""
    some = images[:: max(1, len(images) // 6)]
    sheet = Image.new("RGB", (some[0].width, some[0].height * len(some)))
    for i, image in enumerate(some):
        sheet.paste(image, (0, i * image.height))
    palette = sheet.quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    white = np.array(palette.getpalette()).reshape(-1, 3)
    white[white.sum(axis=1).argmax()] = 255  # a mean of near whites else
    palette.putpalette(white.ravel().tolist())
    first, *others = (image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images)
    lasts = [max(20, round(1000 / rate))] * len(images)
    lasts[-1] += int(1000 * HELD)
    data = io.BytesIO()
    first.save(data, "GIF", save_all=True, append_images=others, duration=lasts, loop=0, disposal=1, optimize=False)
    return signed_gif(data.getvalue())


def mp4(images, rate):
    """Bytes, by ffmpeg; sides of even length, as its coder wants them."""
    width, height = (side - side % 2 for side in images[0].size)
    figure = pyplot.figure(figsize=(width / 100, height / 100), dpi=100)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "film.mp4")
        shown = figure.figimage(np.asarray(images[0])[:height, :width])
        writer = FFMpegWriter(fps=rate, codec="h264", extra_args=["-pix_fmt", "yuv420p"])
        with writer.saving(figure, path, dpi=100):
            for image in images + [images[-1]] * int(HELD * rate):
                shown.set_data(np.asarray(image)[:height, :width])
                writer.grab_frame()
        pyplot.close(figure)
        with open(path, "rb") as file:
            return signed_mp4(file.read())


def animate(results, options):
    """Path of the film."""
    film = film_of(results, options)
    rate, speed = pace(film, options.speed)
    images = list(pictures(film, speed))
    path = os.path.join(results.folder, f"animation_{film.stage}.{'mp4' if options.mp4 else 'gif'}")
    write_file(path, (mp4 if options.mp4 else gif)(images, rate))
    return path


def main(arguments=None):
    options = checked(parser().parse_args(arguments))
    print(animate(Results(options.folder), options))
    return 0

