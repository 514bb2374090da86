"""Writes the page of the sheet about an ensemble: probability with interval, fragility, sensitivity, and limits of these numbers."""

import json
import os

from quoin_tools.ensemble.variables import EnsembleError
from quoin_tools.show.hypertext import esc, file_picture, table

LIMITS = (
    "The spread is that of the quantities listed here, in the distributions given; what is fixed, and what is not modelled, is not in it.",
    "The interval says how sure the count of samples is, not how sure the distributions are. Tails, where failure is, are the least known part of them.",
    "A probability of one section in two dimensions is not that of the dam.",
)


def read(folder):
    path = os.path.join(folder, "ensemble.json")
    try:
        with open(path, encoding="utf-8") as file:
            found = json.load(file)
        if not isinstance(found["probabilities"], list) or not isinstance(found["variables"], list):
            raise ValueError("no probabilities")
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise EnsembleError(f"{path}: not what quoin ensemble leaves: {error}") from error
    return found


def ensemble_part(folder):
    """Nothing where no folder is given."""
    if folder is None:
        return ""
    found = read(folder)
    by = {"solver": "runs of the block model", "limit": "limit analysis, an upper bound"}.get(found["judge"], found["judge"])
    rows = [("-" if p["level"] is None else f"{p['level']:g}", f"{p['value']:.4g}", f"{p['low']:.3g}", f"{p['high']:.3g}", p["n"], p["fails"], p["undecided"]) for p in found["probabilities"]]
    text = ("<h2>How likely it fails</h2>"
            + f"<p>{found['samples']} samples by {esc(by)} ({esc(found['method'])}, seed {found['seed']}), of scene {esc(os.path.basename(found['scene']))}. Failure: {esc(found['fail'])}"
            + (f", stage {esc(found['stage'])}" if found["stage"] else "") + ".</p>"
            + table((", ".join(found["level_keys"]) or "level", "probability", "low", "high (95 %)", "samples", "fail", "undecided"), rows, range(1, 7)))  # fmt: skip
    curve = found["fragility"]
    if curve:
        text += f"<p>Lognormal curve through all levels: half fail at {curve['median']:.5g}, spread of the logarithm {curve['spread']:.3g}.</p>"
    text += table(("what scatters",), [(words,) for words in found["variables"]])
    if found["influence"]:
        text += table(("variable", "rank correlation with the result", "samples"), [(name, f"{value:+.3f}", n) for name, value, n in found["influence"]], (1, 2))
    if found.get("choices"):
        text += table(("variable", "value", ", ".join(found["level_keys"]) or "level", "samples", "fail", "undecided", "low", "high (95 %)"),
                      [(c["variable"], c["choice"], "-" if c["level"] is None else f"{c['level']:g}", c["n"], c["fails"], c["undecided"], f"{c['low']:.3g}", f"{c['high']:.3g}") for c in found["choices"]], range(2, 8))  # fmt: skip
    text += "".join(f"<p class='soft'>{esc(line)}</p>" for line in LIMITS)
    pictures = (("fragility.png", "Probability of failure over the level"), ("samples.png", "Samples by outcome"))
    return text + "".join(file_picture(os.path.join(folder, name), caption) for name, caption in pictures if os.path.exists(os.path.join(folder, name)))
