"""Writes files beside their place, flushes them to the disk, and only then renames them; a failure leaves the file from before. Opens HDF5 files.
And HDF5 files that they read and write."""

import contextlib
import errno
import io
import os
import tempfile

import h5py
import numpy as np

from quoin_tools.base.terminal import doing


@contextlib.contextmanager
def reading(path):
    """An HDF5 file; a fault of the disk is an OSError, at its end too."""
    try:
        with h5py.File(path, "r") as file:
            yield file
    except RuntimeError as error:
        raise OSError(errno.EIO, str(error), os.fspath(path)) from error


def write_file(path, data):
    """Bytes or text under a name; OSError names it. A device or a pipe (/dev/stdout, /dev/full) is written to, not replaced."""
    data = data.encode("utf-8") if isinstance(data, str) else data
    path = os.fspath(path)
    folder, name = os.path.split(path)
    folder = folder or "."
    try:
        stream = os.path.islink(path) and os.path.abspath(folder) == "/dev"  # /dev/stdout, whatever it leads to
        if stream or (os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)):
            with open(path, "wb") as file:
                file.write(data)
            return
        os.makedirs(folder, exist_ok=True)
        handle, part = tempfile.mkstemp(dir=folder, prefix=f".{name}.", suffix=".part")
        try:
            with open(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(part, 0o666 & ~mask)  # mkstemp gives 0600
            os.replace(part, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(part)
            raise
        sync(folder)
    except OSError as error:
        raise OSError(error.errno, error.strerror, path) from error


@contextlib.contextmanager
def writing(path):
    """A new HDF5 file: made in memory, since HDF5 cannot go on from a write that fails, then written as one."""
    with h5py.File(os.fspath(path), "w", driver="core", backing_store=False) as file:
        yield file
        file.flush()
        image = file.id.get_file_image()
    write_file(path, image)


def sync(folder):
    """Makes the new names in it outlast a loss of power."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def trimmed(figure, margin):
    """Returns the pixels (rows, columns, 3) of what is drawn, with so much round it [inch]; None: it goes on beyond the edge of the figure."""
    figure.canvas.draw()
    seen = np.asarray(figure.canvas.buffer_rgba())
    pixels = seen.view(np.uint32)[:, :, 0]
    ink = pixels != pixels[0, 0]
    rows, columns = (np.flatnonzero(ink.any(axis=other)) for other in (1, 0))
    if not len(rows) or min(rows[0], columns[0]) == 0 or rows[-1] == len(seen) - 1 or columns[-1] == seen.shape[1] - 1:
        return None
    room = round(margin * figure.dpi)
    drawn = seen[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return np.stack([np.pad(drawn[:, :, c], room, constant_values=seen[0, 0, c]) for c in range(3)], axis=2)  # far faster than all colours at once


def save_figure(figure, path, margin=None, **options):
    """A picture of matplotlib; its format follows from the name. margin: a PNG of what is drawn and so much round it [inch]. matplotlib's "tight" asks each letter for its place for that."""
    picture = io.BytesIO()
    with doing(f"draws {os.path.basename(path)}"):
        if margin is not None and (pixels := trimmed(figure, margin)) is not None:
            from PIL import Image

            Image.fromarray(pixels).save(picture, "png", compress_level=3, dpi=(figure.dpi, figure.dpi))  # as small as 6, and faster
        else:
            options |= {"bbox_inches": "tight", "pad_inches": margin} if margin is not None else {}
            figure.savefig(picture, format=os.path.splitext(path)[1][1:] or "png", **options)
    write_file(path, picture.getvalue())
