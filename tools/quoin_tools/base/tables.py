"""Makes tables of pandas from the results of a run (docs/results_format.md has the fields); attrs["units"] of a table has the unit of each column.

blocks = Results("out").table("blocks", "full")     # a row for each block: x, y, group, s1, s2, ...
blocks.attrs["units"]["s1"]                         # "Pa"
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

if TYPE_CHECKING:  # pandas is slow to load
    import pandas as pd

Table: TypeAlias = "pd.DataFrame"
KINDS = ("vertices", "blocks", "contacts", "history")
VECTORS = {"displacement": ("u", "m"), "mechanism": ("mechanism", "-")}  # of vertices, along x and y
OF_BLOCKS = {"s1": "Pa", "s2": "Pa", "angle": "rad", "rotation": "rad", "safety_factor": "-", "safety_mode": "-", "temperature": "K", "stress_z": "Pa", "built": "-",
             "plastic_strain": "-", "damage": "-", "crack_width": "m", "lost": "J"}  # fmt: skip
AT_ENDS = {"opening": "m", "sliding": "m", "slip": "m", "closure": "m", "sigma": "Pa", "tau": "Pa", "broken": "-", "state": "-"}  # of contacts, at both ends
SUFFIXES = {"_per_s": "1/s", "_s": "s", "_m": "m", "_N": "N", "_J": "J"}  # of columns of history.csv


class TableError(ValueError):
    """There is no such table; the message is one line."""


def table(results: Any, kind: str, stage: str | None) -> Table:
    """Table of a kind at the end of a stage, or in a frame of it; history: of the whole run. TableError: no such kind."""
    import pandas as pd

    if kind not in KINDS:
        raise TableError(f"no table '{kind}', there are: {', '.join(KINDS)}")
    if kind == "history":
        columns = {name: (column, unit_of(name)) for name, column in results.history.items()}
        index = None
    else:
        of_kind = {"vertices": of_vertices, "blocks": of_blocks, "contacts": of_contacts}[kind]
        columns, index = of_kind(results.mesh, results.stage(stage))
    made = pd.DataFrame({name: values for name, (values, _) in columns.items()}, index=index)
    made.attrs["units"] = {name: unit for name, (_, unit) in columns.items()}
    if kind != "history":
        made.attrs["stage"] = results.stage(stage).name
    return made


def unit_of(column: str) -> str:
    """Unit of a column of history.csv, by the end of its name."""
    return next((unit for suffix, unit in SUFFIXES.items() if column.endswith(suffix)), "")


def of_vertices(mesh, stage):
    """Rows are vertices, by their numbers in model.h5."""
    import pandas as pd

    columns = {"x": (mesh.vertices[:, 0], "m"), "y": (mesh.vertices[:, 1], "m")}
    for field, (name, unit) in VECTORS.items():
        values = getattr(stage, field)
        if values is not None:
            columns |= {f"{name}_{axis}": (values[:, k], unit) for k, axis in enumerate("xy")}
    return columns, pd.Index(mesh.vertex_file, name="vertex")


def of_blocks(mesh, stage):
    """Rows are blocks, by their numbers in model.h5; x, y are their centres."""
    import pandas as pd

    centres = mesh.centres()
    columns = {"x": (centres[:, 0], "m"), "y": (centres[:, 1], "m"), "group": (np.array(mesh.group_names)[mesh.block_group], "")}
    columns |= {f"s_{pair}": (stage.stress[:, k], "Pa") for k, pair in enumerate(("xx", "yy", "xy"))}
    columns |= {name: (values, unit) for name, unit in OF_BLOCKS.items() if (values := getattr(stage, name)) is not None}
    return columns, pd.Index(mesh.block_file, name="block")


def of_contacts(mesh, stage):
    """Rows are the two ends of contacts; force_n along the normal and force_s along the face have the signs of sigma and tau."""
    import pandas as pd

    contacts = stage.contacts
    n = len(contacts)
    columns = {"x": (contacts.point[..., 0].ravel(), "m"), "y": (contacts.point[..., 1].ravel(), "m"), "joint": (np.repeat(np.array(mesh.joint_names)[contacts.joint], 2), ""),
               "length": (np.repeat(contacts.length, 2), "m")}  # fmt: skip
    columns |= {name: (getattr(contacts, name).ravel(), unit) for name, unit in AT_ENDS.items()}
    columns |= {f"force_{name}": (contacts.force[..., k].ravel(), "N") for k, name in enumerate("ns")}
    return columns, pd.MultiIndex.from_product([range(n), (0, 1)], names=["contact", "end"])
