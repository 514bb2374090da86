"""Design spectra against hand calculations, what is wrong in their files, and sums of modes against closed forms."""

import numpy as np
import pytest
from quoin_tools.assess import design_spectrum, modal_sums
from quoin_tools.assess.design_spectrum import SpectrumError, read
from quoin_tools.show import motion

G = 9.80665
EUROCODE = "rule: eurocode8\ntype: 1\nground: B\na_g: 0.2\nunit: g\n"
ASCE = "rule: asce7\ns_ds: 1.0\ns_d1: 0.4\nt_l: 8\nunit: g\n"
TABLE = "rule: table\nfile: s.csv\ntable_damping: 0.05\nunit: m/s2\n"
ROWS = "period, S_a\n0, 2\n0.1, 5\n0.4; 5 # plateau\n2, 1\n"


def spectrum(tmp_path, text, rows=ROWS):
    (tmp_path / "s.csv").write_text(rows)
    (tmp_path / "spectrum.yaml").write_text(text)
    return read(str(tmp_path / "spectrum.yaml"))


def test_eurocode_by_hand(tmp_path):
    """S = 1.2, T_B, T_C, T_D = 0.15, 0.5, 2 s: at 0, half of T_B, on the plateau, at 1 and at 4 s; and with 20 % of damping, eta = sqrt(10/25)."""
    s = spectrum(tmp_path, EUROCODE)
    at = np.array([0, 0.075, 0.15, 0.5, 1.0, 4.0])
    assert s.horizontal(at) / G == pytest.approx(0.24 * np.array([1, 1.75, 2.5, 2.5, 1.25, 2.5 * 0.5 * 2 / 16]), rel=1e-12)
    low = 2.5 * np.sqrt(0.4)
    assert s.horizontal(at, 0.2) / G == pytest.approx(0.24 * np.array([1, (1 + low) / 2, low, low, low / 2, low / 16]), rel=1e-12)
    assert s.ground == pytest.approx(0.24 * G) and s.ground_vertical == 0 and s.vertical(0.1) == 0
    both = spectrum(tmp_path, EUROCODE + "vertical: true\ndamping: 0.02\n")
    assert both.vertical(np.array([0, 0.1, 0.3])) / G == pytest.approx(0.18 * np.array([1, 3 * np.sqrt(10 / 7), 1.5 * np.sqrt(10 / 7)]), rel=1e-12)
    assert float(design_spectrum.eta(0.9)) == 0.55


@pytest.mark.parametrize("kind", [1, 2])
@pytest.mark.parametrize("ground", "ABCDE")
def test_eurocode_has_no_steps(tmp_path, kind, ground):
    s = spectrum(tmp_path, f"rule: eurocode8\ntype: {kind}\nground: {ground}\na_g: 1\nunit: m/s2\nvertical: true\n")
    for corners, curve in ((design_spectrum.HORIZONTAL[kind][ground][1:], s.horizontal), (design_spectrum.VERTICAL[kind][1:], s.vertical)):
        assert curve(np.array(corners) * (1 - 1e-9)) == pytest.approx(curve(np.array(corners) * (1 + 1e-9)), rel=1e-7)


def test_asce_by_hand(tmp_path):
    """T_0 = 0.08, T_S = 0.4, T_L = 8 s; below T_0 from 0.4 S_DS."""
    s = spectrum(tmp_path, ASCE + "vertical: 0.5\n")
    assert s.horizontal(np.array([0, 0.04, 0.08, 0.4, 2, 16])) / G == pytest.approx([0.4, 0.7, 1, 1, 0.2, 0.4 * 8 / 256], rel=1e-12)
    assert s.vertical(0.2) / G == pytest.approx(0.5)
    assert s.horizontal(np.array([0, 0.04, 1.0]), 0.15) / G == pytest.approx([0.4, (0.4 + np.sqrt(0.5)) / 2, 0.4 * np.sqrt(0.5)], rel=1e-12)


@pytest.mark.parametrize("damping", [0.02, 0.05, 0.12, 0.3])
def test_a_table_has_the_damping_of_the_rule(tmp_path, damping):
    """A table of the numbers of Eurocode 8, or of ASCE 7, at 5 % has theirs at any damping, those on the way up to the plateau too: (3.2) is a line between ground and plateau."""
    at = np.linspace(0, 4, 401)
    for text in (EUROCODE, ASCE):
        own = spectrum(tmp_path, text)
        table = spectrum(tmp_path, TABLE, "\n".join(f"{t!r}, {s!r}" for t, s in zip(at.tolist(), own.horizontal(at, 0.05).tolist())))
        assert table.horizontal(at, damping) == pytest.approx(own.horizontal(at, damping), rel=1e-12)
        begins = at[(own.horizontal(at) > 0.999 * own.horizontal(at).max()).argmax()]
        rising, ends = at[at < begins], own.horizontal(np.array([0, begins]), damping)
        assert own.horizontal(rising, damping) == pytest.approx(np.interp(rising, [0, begins], ends), rel=1e-12)


def test_table(tmp_path):
    s = spectrum(tmp_path, TABLE)
    assert s.horizontal(np.array([0, 0.05, 0.3, 1.2])) == pytest.approx([2, 3.5, 5, 3]) and s.ground == 2
    assert s.horizontal(0.3, 0.15) == pytest.approx(5 * np.sqrt(0.5)) and s.horizontal(0, 0.15) == 2
    assert spectrum(tmp_path, TABLE.replace("m/s2", "g")).ground == 2 * G
    with pytest.raises(SpectrumError, match="the table ends at 2 s; a period of 2.5 s"):
        s.horizontal(2.5)


def test_numbers_are_those_of_a_scene(tmp_path):
    """1e-3 without a point is a number, as the solver has it."""
    assert spectrum(tmp_path, EUROCODE.replace("0.2", "2e-1") + "rock_damping: 3e-2\n").ground == pytest.approx(0.24 * G)


@pytest.mark.parametrize("text, said", [
    (EUROCODE.replace("B", "F"), "ground: F: expected a ground type"), (EUROCODE.replace("type: 1", "type: 3"), "type: 3: expected 1 or 2"),
    (EUROCODE.replace("type: 1", "type: true"), "type: True: expected 1 or 2"), (EUROCODE.replace("ground: B", "ground: [A]"), r"ground: \['A'\]: expected"),
    (EUROCODE.replace("a_g: 0.2", "a_g: -1"), "a_g: -1: expected a number > 0"), (EUROCODE.replace("unit: g\n", ""), "unit: missing; expected the unit"),
    (EUROCODE.replace("unit: g", "unit: gal"), "unit: gal: expected the unit of all accelerations, g or m/s2"), (EUROCODE + "dampning: 1\n", "dampning: no such key; did you mean damping"),
    (EUROCODE + "damping: 5\n", "damping: 5: expected a ratio > 0 and < 0.5"),
    (EUROCODE + "s_ds: 2\n", "s_ds: no such key"), (ASCE + "vertical: true\n", "vertical: True|vertical: true: expected a number"), (ASCE.replace("t_l: 8", "t_l: 0.1"), "t_l: 0.1: expected no less"),
    ("rule: nbcc\n", "rule: nbcc: expected eurocode8, asce7 or table"), ("unit: g\n", "rule: missing"), ("- 1\n", "expected keys"), ("a: [", "spectrum.yaml: while parsing"),
    (TABLE.replace("s.csv", "none.csv"), "none.csv: No such file"),
])  # fmt: skip
def test_wrong_files(tmp_path, text, said):
    with pytest.raises(SpectrumError, match=said) as error:
        spectrum(tmp_path, text)
    assert "\n" not in str(error.value) and "spectrum.yaml" in str(error.value) or "none.csv" in str(error.value)


@pytest.mark.parametrize("rows, said", [
    ("0.1, 2\n1, 1\n", "the first with period 0"), ("0, 2\n0, 1\n", "line 2: period 0 after 0"), ("0, 2\n1, -1\n", "line 2: 1,-1"), ("T, S\n0, 2\n1, x\n", "line 3: 1,x"),
    ("0, 2, 3\n", "line 1: 0,2,3: expected two numbers"), ("", "two rows or more"),
])  # fmt: skip
def test_wrong_tables(tmp_path, rows, said):
    with pytest.raises(SpectrumError, match=said):
        spectrum(tmp_path, TABLE, rows)


# ---- sums of modes


def oscillators(frequencies, damping, seed, seconds=2000.0, step=0.002):
    """Mean square and mean products of the displacements of oscillators under white noise, times omega^2: what CQC estimates."""
    noise = np.random.default_rng(seed).standard_normal(int(seconds / step))
    omega = np.asarray(frequencies)
    line = np.fft.rfftfreq(len(noise), step) * 2 * np.pi
    swing = np.fft.irfft(np.fft.rfft(noise)[None] / (omega[:, None] ** 2 - line**2 + 2j * damping * omega[:, None] * line), axis=1)
    covariance = swing @ swing.T
    scale = np.sqrt(np.diag(covariance))
    return covariance / scale / scale[:, None]


def test_correlation_is_that_of_white_noise():
    """Der Kiureghian's coefficients are those of two oscillators under white noise; checked in the frequency domain, and by their limits."""
    omega, xi = np.array([10.0, 10.5, 20.0]), 0.05
    found = modal_sums.correlation(omega, xi)
    assert found == pytest.approx(oscillators(omega, xi, 1), abs=0.04)
    line = np.linspace(1e-3, 4000, 2_000_000)
    h = [1 / (w**2 - line**2 + 2j * z * w * line) for w, z in ((10.0, 0.03), (11.0, 0.08))]
    product = (h[0] * np.conj(h[1])).real.sum() / np.sqrt((abs(h[0]) ** 2).sum() * (abs(h[1]) ** 2).sum())
    assert modal_sums.correlation([10.0, 11.0], [0.03, 0.08])[0, 1] == pytest.approx(product, rel=1e-5)
    assert np.diag(found) == pytest.approx(1, rel=1e-14) and found == pytest.approx(found.T, rel=1e-13)


def test_two_close_modes():
    """Two masses with close frequencies: equal and opposite parts nearly cancel by CQC, not by SRSS; equal ones nearly add."""
    omega, parts = [10.0, 10.1], np.array([[1.0, 1.0], [-1.0, 1.0]])
    rho = modal_sums.correlation(omega, 0.05)[0, 1]
    assert rho == pytest.approx(0.99020, abs=2e-5)  # by hand: 8 xi^2 (1 + r) r^1.5 / ((1 - r^2)^2 + 4 xi^2 r (1 + r)^2), r = 1.01
    assert modal_sums.quadratic(parts, omega, 0.05) == pytest.approx([np.sqrt(2 - 2 * rho), np.sqrt(2 + 2 * rho)])
    assert modal_sums.quadratic(parts, omega, 0.05, "srss") == pytest.approx(np.sqrt(2) * np.ones(2))


def shear_beam(n):
    """Base shear and moment over mass and mass times height of the modes of a uniform shear beam, per unit of acceleration; sums 1 and 1/2."""
    k = (2 * np.arange(1, n + 1) - 1) * np.pi / 2
    shear = 2 / k**2  # 8 / (pi^2 (2n - 1)^2)
    return np.array([shear, shear * np.sin(k) / k]).T, k


def test_shear_beam():
    """Modes of a uniform shear beam in closed form: masses add up to 1, and a spectrum above that of the ground gives the sum by hand."""
    parts, omega = shear_beam(400)
    assert parts.sum(axis=0) == pytest.approx([1, 0.5], abs=6e-4)
    few, w = parts[:2], omega[:2]
    by_hand = np.sqrt((few[0, 0] ** 2 + few[1, 0] ** 2) * (9 - 1) + 1)  # S_a = 3, A = 1; all of the mass with the ground
    assert modal_sums.combine(few, [1, 0.5], [3, 3], 1.0, w, 0.05, "srss")[0] == pytest.approx(by_hand)


def test_rigid_limit_is_the_coefficient():
    """Where S_a is the acceleration of the ground the answer is that of the coefficient, whatever modes were found."""
    parts, omega = shear_beam(3)
    for rule in ("cqc", "srss"):
        assert modal_sums.combine(parts, [1, 0.5], np.full(3, 2.0), 2.0, omega, 0.05, rule) == pytest.approx([2, 1], rel=1e-15)
    assert modal_sums.quadratic(2 * parts, omega, 0.05, "srss")[0] == pytest.approx(1.63, abs=0.01)  # sums of squares alone would give less


def test_beside_a_record(tmp_path):
    """`quoin motion --design` has the design spectrum as the last column of its table, with the damping of the oscillators."""
    spectrum(tmp_path, EUROCODE)
    (tmp_path / "quake.csv").write_text("\n".join(f"{0.01 * i}, {np.sin(0.12 * i):.6f}" for i in range(200)))
    assert motion.main([str(tmp_path / "quake.csv"), "--design", str(tmp_path / "spectrum.yaml"), "--damping", "0.15", "--to", str(tmp_path)]) == 0
    period, *_, designed = np.loadtxt(tmp_path / "quake_spectrum.csv", delimiter=",", skiprows=1).T
    assert designed / G == pytest.approx(0.24 * (np.where(period < 0.15, 1 + period / 0.15 * (2.5 * np.sqrt(0.5) - 1), 2.5 * np.sqrt(0.5) * np.where(period < 2, 0.5 / np.maximum(period, 0.5), 1 / period**2))), rel=1e-9)
