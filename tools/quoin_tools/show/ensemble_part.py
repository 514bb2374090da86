"""Writes the page of the sheet about an ensemble: probability with interval, fragility, sensitivity, and limits of these numbers."""

import json
import os

from quoin_tools.base.flow import printed
from quoin_tools.base.language import N_, _, numeral
from quoin_tools.ensemble.variables import EnsembleError
from quoin_tools.show.hypertext import esc, file_picture, head, soft, table

LIMITS = (
    N_("The spread is that of the quantities listed here, in the distributions given; what is fixed, and what is not modelled, is not in it."),
    N_("The interval says how sure the count of samples is, not how sure the distributions are. Tails, where failure is, are the least known part of them."),
    N_("A probability of one section in two dimensions is not that of the dam."),
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


def beside(found, level):
    """Writes the danger level, and what the readings change: probability and danger level before and after them."""
    danger, after = found.get("danger"), found.get("after")
    if not after:
        return soft(_("Danger level, from which a sample fails: {0}.", said(danger))) if danger else ""
    pairs = zip(found["probabilities"], after["probabilities"], strict=True)
    rows = [(printed(p["level"], "g"), *(printed(one[key], ".3g") for one in (p, q) for key in ("value", "low", "high"))) for p, q in pairs]
    text = head(_("Before and after the readings"))
    text += table((level, _("before"), _("low"), _("high (95 %)"), _("after"), _("low"), _("high (95 %)")), rows, range(1, 7))
    if danger and after["danger"]:
        text += table(("", _("danger level, median"), _("low"), _("high (95 %)"), _("samples")), [(name, *ends(one), one["n"]) for name, one in ((_("before"), danger), (_("after"), after["danger"]))], range(1, 5))
    learnt = [(name, *(printed(row[key], ".4g") for key in ("prior_mean", "prior_sd", "mean", "sd", "low", "high", "ratio"))) for name, row in after["variables"].items()]
    text += table((_("variable"), _("mean before"), _("deviation"), _("mean after"), _("deviation"), _("low"), _("high (95 %)"), _("deviation after over before, of normal scores")), learnt, range(1, 8))
    text += soft(_("Where the last column is near 1, the readings say nothing of the variable: its distribution is what was assumed."))
    if after.get("unused"):
        text += soft(_("As in the scene stay {0}: the ensemble does not vary them.", ", ".join(after["unused"])))
    if after.get("warnings"):
        text += table(("", _("WARNING about the numbers after the readings")), after["warnings"].items())
    return text


def ends(danger):
    """Returns median and ends of a danger level as text; what lies beyond the levels that were looked at."""
    texts = []
    for key, part in (("median", 0.5), ("low", 0.025), ("high", 0.975)):
        beyond = _("below {0:g}", danger["least"]) if danger["always"] > part * danger["n"] else _("above {0:g}", danger["most"])
        texts.append(beyond if danger[key] is None else numeral(f"{danger[key]:.4g}"))
    return texts


def said(danger):
    return _("{0}, between {1} and {2} for 95 % of {3} samples", *ends(danger), danger["n"])


def ensemble_part(folder):
    """Nothing where no folder is given."""
    if folder is None:
        return ""
    found = read(folder)
    by = {"solver": _("runs of the block model"), "limit": _("limit analysis, an upper bound")}.get(found["judge"], found["judge"])
    rows = [(printed(p["level"], "g"), *(printed(p[key], form) for key, form in (("value", ".4g"), ("low", ".3g"), ("high", ".3g"))), p["n"], p["fails"], p["undecided"]) for p in found["probabilities"]]
    level = ", ".join(found["level_keys"]) or _("level")
    meant = _("Failure: {0}, stage {1}.", found["fail"], found["stage"]) if found["stage"] else _("Failure: {0}.", found["fail"])
    text = head(_("How likely it fails")) + "<p>" + esc(_("{0} samples by {1} ({2}, seed {3}), of scene {4}.", found["samples"], by, found["method"], str(found["seed"]), os.path.basename(found["scene"])) + f" {meant}") + "</p>"
    text += table((level, _("probability"), _("low"), _("high (95 %)"), _("samples"), _("fail"), _("undecided")), rows, range(1, 7))
    text += beside(found, level)
    curve = found["fragility"]
    if curve:
        text += soft(_("Lognormal curve through all levels: half fail at {0:.5g}, spread of the logarithm {1:.3g}.", curve["median"], curve["spread"]))
    text += table((_("what scatters"),), [(words,) for words in found["variables"]])
    if found["influence"]:
        text += table((_("variable"), _("rank correlation with the result"), _("samples")), [(name, numeral(f"{value:+.3f}"), n) for name, value, n in found["influence"]], (1, 2))
    if found.get("choices"):
        text += table((_("variable"), _("value"), level, _("samples"), _("fail"), _("undecided"), _("low"), _("high (95 %)")),
                      [(c["variable"], c["choice"], printed(c["level"], "g"), c["n"], c["fails"], c["undecided"], printed(c["low"], ".3g"), printed(c["high"], ".3g")) for c in found["choices"]], range(2, 8))  # fmt: skip
    text += "".join(soft(_(line)) for line in LIMITS)
    pictures = (("fragility.png", _("Probability of failure over the level")), ("samples.png", _("Samples by outcome")))
    return text + "".join(file_picture(os.path.join(folder, name), caption) for name, caption in pictures if os.path.exists(os.path.join(folder, name)))
