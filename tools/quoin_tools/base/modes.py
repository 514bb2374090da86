"""Reads small free vibrations of a stage of type modes from summary.json and results.h5."""

import numpy as np

from quoin_tools.base.language import _, numeral


def shapes_of(group):
    """Returns (n_modes, n_vertices, 2) [-] displacements; the largest component along x or y is 1."""
    return np.stack([np.array(group[f"mode_{number + 1}"]) for number in range(len(group))])


def modes_of(s):
    """Returns the modes in the summary of a stage, the slowest first; empty for a stage of another type."""
    return s.get("modes", {}).get("list", [])


def parts(s, mode):
    """[-] Returns the effective mass along x and y over all mass that can move."""
    all_mass = (s["modes"]["mass_x"], s["modes"]["mass_y"])
    return tuple(mass / whole if whole else 0.0 for mass, whole in zip((mode["mass_x"], mode["mass_y"]), all_mass, strict=True))


def number(value, form):
    """Formats a number; null of summary.json means no number: a motion that grows, or never comes back."""
    return "-" if value is None else numeral(f"{value:{form}}")


def mode_rows(s):
    rows = [(str(i + 1), number(m["f"], ".5g"), number(m["period"], ".5g"), *(number(100 * part, ".2f") for part in parts(s, m)),
             number(m["factor_x"], ".4f"), number(m["factor_y"], ".4f")) for i, m in enumerate(modes_of(s))]  # fmt: skip
    return rows + ([(_("all"), "-", "-", *(number(100 * s["modes"][sum_of], ".2f") for sum_of in ("sum_x", "sum_y")), "-", "-")] if rows else [])


SECTIONS = (("Free vibrations", "mode|f Hz|period s|mass x %|mass y %|participation x|participation y", mode_rows),)  # as the tables of results.py
