"""The sheet in kip, ft, psi and pcf: every number of it is that of the sheet in SI by definitions of the units, in English and in Portuguese; ticks of pictures; whose choice wins."""

import hashlib
import itertools
import re
from contextlib import nullcontext

import matplotlib.pyplot as plt
import pytest
import yaml
from quoin_tools.assess import guidelines
from quoin_tools.base import language, sheet_units
from quoin_tools.show import report, style
from quoin_tools.show.spreadsheet import chapters_of
from test_what_if import LEVEL, SCENE, solve, solver

INCH, LBF, STANDARD = 0.0254, 0.45359237 * 9.80665, 9.80665  # m, N, m/s2
OURS = {"ft": 12 * INCH, "in": INCH * 1e3, "kip": LBF, "kip ft": LBF * 12 * INCH, "kip/ft": LBF / (12 * INCH), "psi": LBF / INCH**2 / 1e3, "ksi": LBF / INCH**2 / 1e6, "pcf": 0.45359237 / (12 * INCH) ** 3,
        "pci": LBF / INCH**3 / 1e9, "lbf": LBF, "ft lbf": LBF * 12 * INCH}  # fmt: skip
THEIRS = {"ft": "m", "in": "mm", "kip": "kN", "kip ft": "kN m", "kip/ft": "kN/m", "psi": "kPa", "ksi": "GPa", "pcf": "kg/m³", "pci": "GPa/m", "lbf": "N", "ft lbf": "J"}
MEGA = {"psi": "MPa"}
NUMBER = re.compile(r"(?<![\w.])[+\-−]?\d[\d\u202f]*(?:[.,]\d+)?(?:e[+\-]?\d+)?(?![\w])")
UNITS = "|".join(sorted(map(re.escape, OURS), key=len, reverse=True))
STAGES = [*SCENE["stages"], {"high": {"type": "flood", "loads": ["weight", "water", "uplift"], "step": 2, "limit": 40, "bracket": 0.5}}]
MATERIALS = {"dam": {"density": 2400, "young": 20e9, "poisson": 0.2, "tension": 1e6, "compression": 1.5e7}, "ground": {"density": 0, "rigid": True}}


def value_of(word):
    return float(word.replace("\u202f", "").replace("−", "-").replace(",", "."))


def half(word):
    """Half of the last figure of a number."""
    mantissa, _, power = word.partition("e")
    return 0.5 * 10.0 ** (int(power or 0) - len(re.split(r"[.,]", mantissa)[1] if re.search(r"[.,]", mantissa) else ""))


def agree(si, us, unit, other):
    factor = OURS[unit] / (1e3 if other == MEGA.get(unit) else 1)
    return abs(value_of(us) * factor - value_of(si)) <= 1.01 * (half(si) + half(us) * factor)


def unit_of_title(si, us):
    """Returns the two units of a title, checked; None: it has none that changes."""
    if si == us:
        assert not re.search(rf"\[({'|'.join(map(re.escape, THEIRS.values()))}|MPa)\]", si), si
        return None
    unit, other = re.search(r"\[([^\]]+)\]", us)[1], re.search(r"\[([^\]]+)\]", si)[1]
    assert other in (THEIRS[unit], MEGA.get(unit)), (si, us)
    return unit, other


def compare(si, us, pair):
    """Compares two cells or sentences. pair: units of the column; else those that stand behind the numbers. Returns how many numbers differ, all by their units."""
    numbers, count = [list(NUMBER.finditer(text)) for text in (si, us)], 0
    assert len(numbers[0]) == len(numbers[1]), (si, us)
    for one, other in zip(*numbers):
        own = pair
        behind = re.match(rf"(?:[^.]|\.\d)*?(?<=[ )])({UNITS})\b", us[other.end() :])
        if own is None and (named := re.search(rf"\[({UNITS})\]", us)):
            own = named[1], THEIRS[named[1]]
        elif own is None and behind:
            unit = behind[1]
            own = unit, MEGA[unit] if unit in MEGA and MEGA[unit] in si else THEIRS[unit]
        if own is None or (pair is None and one[0] == other[0]):
            assert one[0] == other[0], (si, us)
        else:
            assert agree(one[0], other[0], *own), (si, us, own)
            count += one[0] != other[0]
    return count


def check(si, us):
    """Compares two sheets. Returns how many of their numbers were in units."""
    pages, count, titles, of_title = [chapters_of(text) for text in (si, us)], 0, None, None
    assert [name for name, _ in pages[0]] == [name for name, _ in pages[1]]
    for (name, rows), (_, others) in zip(*pages):
        assert len(rows) == len(others), name
        for row, other in zip(rows, others):
            if row and row[0][1] == "head":
                titles = [unit_of_title(a, b) for (a, _), (b, _) in itertools.zip_longest(row, other)]
                continue
            of_row = None
            for k, ((a, kind), (b, _)) in enumerate(zip(row, other, strict=True)):
                if kind == "title":
                    of_title = unit_of_title(a, b) if "[" in a else None  # what the trials below have changed
                if kind in ("title", "note") or not titles or k >= len(titles):
                    count += compare(a, b, None) if "UTC" not in a else 0
                elif b in OURS and a in THEIRS.values():
                    of_row = b, a  # a column of units
                    assert THEIRS[b] == a
                elif "UTC" not in a and "keys" not in kind.split():
                    count += compare(a, b, None if re.search("[≤≥]", a) else titles[k] or (of_row if k > 1 else None) or (of_title if a != b and NUMBER.fullmatch(a) else None))  # a limit says its own unit
    return count


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("rectangle")
    assert solve(found, {"tendon_lost": {"anchors.tendon": "lost"}}, stages=STAGES, materials=MATERIALS).returncode == 0
    return found / "out"


@pytest.fixture
def bare(monkeypatch):
    monkeypatch.setattr(report.plots, "drawing", lambda *_, **__: nullcontext(list))


def sheet(folder, *arguments):
    assert report.main([str(folder), *arguments]) == 0
    return (folder / "report.html").read_text(encoding="utf-8")


@solver
@pytest.mark.parametrize("name", ["en", "pt"])
def test_every_number_is_that_of_si(name, folder, bare):
    arguments = ["--guideline", "usace", "--given", "tests=with", "--path", "cut=0,5,8,5", "--language", name, "--what-if", "0"]
    before = hashlib.sha256((folder / "results.h5").read_bytes()).hexdigest()
    si, us = sheet(folder, *arguments), sheet(folder, *arguments, "--units", "us")
    assert check(si, us) > 300
    assert hashlib.sha256((folder / "results.h5").read_bytes()).hexdigest() == before
    level = f"{LEVEL / 0.3048:.2f}"
    assert (level if name == "en" else level.replace(".", ",")) + " ft" in us


def test_the_check_sees_a_wrong_number():
    page = "<h2>A</h2><table><tr><th>N [{}]</th></tr><tr><td>{}</td></tr></table>"
    assert check(page.format("kN", "14059"), page.format("kip", "3160.6")) == 1
    with pytest.raises(AssertionError):
        check(page.format("kN", "14059"), page.format("kip", "3161.6"))
    with pytest.raises(AssertionError):
        check(page.format("kN", "14059"), page.format("kN", "3160.6"))


@pytest.mark.parametrize("message, values, said", [
    ("open over {0:.2f} m, from {1:.2f} to {2:.2f} m", (1.0, 2.0, 3.048), "open over 3.28 ft, from 6.56 to 10.00 ft"),
    ("({0:.1f}, {1:.1f}) kN, cosine {2}, {3} m to go", (100.0, -50.0, "0.5", "3.048"), "(22.48, -11.24) kip, cosine 0.5, 10.000 ft to go"),
    ("joint {0} of {1} items in {2:.2f} s", ("a1", 3, 2.0), "joint a1 of 3 items in 2.00 s"),
    ("{0} kN at {1} mm", ("12\u202f345.0", "−25.4"), "2775.27 kip at −1.000 in"),
    ("{0:.2f} to {1:.2f} MPa", (1.0, -2.0), "145 to -290 psi"),
    ("largest {0} (ring), {1:.4g} m² have yielded", ("0.1", 0.3048**2), "largest 0.1 (ring), 1 ft² have yielded"),
])  # fmt: skip
def test_sentences(message, values, said):
    with sheet_units.shown("us"):
        assert language._(message, *values) == said
    assert language._("{0:.2f} m", 1.0) == "1.00 m"


def test_ticks_of_pictures(tmp_path):
    figure, axes = plt.subplots()
    axes.plot([0, 30], [0, -4000])
    axes.set_xlabel("y [m]")
    axes.set_ylabel("force [kN]")
    beside = axes.secondary_yaxis("right", functions=(lambda x: 2 * x, lambda x: x / 2))
    beside.set_ylabel("head [m of water]")
    with sheet_units.shown("us"):
        style.unit_axes(figure)
    figure.canvas.draw()
    assert (axes.get_xlabel(), axes.get_ylabel(), beside.get_ylabel()) == ("y [ft]", "force [kip]", "head [ft of water]")
    for axis, size in ((axes.xaxis, 0.3048), (axes.yaxis, LBF), (beside.yaxis, 0.3048)):
        labels = [(place, value_of(label.get_text())) for place, label in zip(axis.get_ticklocs(), axis.get_ticklabels())]
        assert len(labels) > 3 and all(place == pytest.approx(value * size, abs=1e-9) for place, value in labels)
        assert all(value % 5 == 0 for _, value in labels)
    plt.close(figure)


@solver
def test_whose_choice_wins(folder, bare, tmp_path, monkeypatch):
    """The command before the guideline's file; SI where nobody says it."""
    own = tmp_path / "ours.yaml"
    own.write_text(yaml.safe_dump({"guidelines": {"usace": {"units": "us"}}}), encoding="utf-8")
    assert guidelines.read(str(own))["usace"]["units"] == "us"
    arguments = ["--guideline", "usace", "--given", "tests=with", "--guidelines", str(own), "--what-if", "0"]
    monkeypatch.setattr(report, "page", lambda *_: (sheet_units.current, []))
    assert sheet(folder, *arguments).startswith("us") and sheet(folder, *arguments, "--units", "si").startswith("si") and sheet(folder, *arguments[:4], "--what-if", "0").startswith("si")
