"""Damping in time: Rayleigh's alpha and beta, by group, in both strains; joints that slip; the step that dampers leave; the step that chooses itself."""

import numpy as np
from driver import changed
from quoin_tools.mesh.blockmesh import BlockMesh
from quoin_tools.mesh.meshing import join, rectangle, renamed

WHAT = "damping in time: decrements and periods of Rayleigh's damping, beta by group, spin, energy, slip, the bound of the step"
SOURCE = "z = alpha / (2 w) + beta w / 2; decrement exp(-2 pi z / sqrt(1 - z^2)); dt^2 k + 2 dt c <= 4 m; Newmark"
BY = "closed forms of textbooks, by hand"

RHO, CS, HEIGHT = 2000.0, 1000.0, 40.0
ALPHA, BETA = 1.507964, 1.061033e-3  # 5 % at 3 and 12 Hz

SCENE = {
    "strain": "small",
    "materials": {"ground": {"density": RHO, "young": 2 * RHO * CS**2, "poisson": 0.0}},
    "joints": {"default": {"law": "elastic", "k_n": 1e9, "k_s": 1e9}},
    "supports": {"bottom": {"fix": "xy"}, "level": {"target": "ground", "fix": "y"}},
    "loads": {"side": {"type": "traction", "faces": "right", "value": [1e4, 0]}, "top": {"type": "traction", "faces": "top", "value": [-2e4, 0]}},
    "relaxation": {"history_every": 1, "tolerance": 1e-10},
    "stages": [{"pull": {"loads": ["side"]}}, {"swing": {"type": "dynamic", "loads": [], "duration": 0.9, "dt_factor": 0.3, "alpha": ALPHA, "beta": BETA}}],
}




def column(n=40, groups=("ground",)):
    """A column of n elements with a point at each level, in groups of equal height."""
    mesh = rectangle(0, 0, 1, HEIGHT, 1, n, group="ground")
    left = np.flatnonzero(mesh.vertices[:, 0] == 0.0)
    order = left[np.argsort(mesh.vertices[left, 1])]
    mesh.points.update({f"level_{i}": int(v) for i, v in enumerate(order)})
    mesh.group_names, mesh.group_rigid = list(groups), np.zeros(len(groups), np.int32)
    y = mesh.vertices[mesh.blocks].mean(axis=1)[:, 1]
    mesh.block_group = (y * len(groups) / HEIGHT).astype(np.int32)
    return mesh


def triangles(mesh):
    """Each quadrilateral cut in two; face sets keep their outer faces."""
    b, n = mesh.blocks, len(mesh.blocks)
    cut = np.concatenate([np.stack([b[:, 0], b[:, 1], b[:, 2], 0 * b[:, 0] - 1], 1), np.stack([b[:, 0], b[:, 2], b[:, 3], 0 * b[:, 0] - 1], 1)])
    sets = {name: np.where((f[:, 1] < 2)[:, None], f, np.stack([f[:, 0] + n, f[:, 1] - 1], 1)) for name, f in mesh.face_sets.items()}
    return BlockMesh(mesh.vertices, cut, np.tile(mesh.block_group, 2), mesh.group_names, mesh.group_rigid, sets, mesh.points)


def swing(result, stage="swing"):
    mine = (result.history["stage"] == stage) & np.isfinite(result.history["balance_J"])
    return {name: values[mine] for name, values in result.history.items() if name != "stage"}


def mode(h, k, n=40):
    """Part of mode k of the column in its motion."""
    shape = np.sin((2 * k - 1) * np.pi / 2 * np.arange(n + 1) / n)
    shape[-1] /= 2  # half a mass at the top
    return sum(s * h[f"level_{i}_ux_m"] for i, s in enumerate(shape))


def decay(t, x):
    """Ratio per cycle and period [s], from the zeros upwards and the highest points between them."""
    up = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    zeros = t[up] - x[up] * (t[up + 1] - t[up]) / (x[up + 1] - x[up])
    peaks = []
    for a, b in zip(up[:-1], up[1:], strict=True):
        i = a + 1 + np.argmax(x[a + 1:b])
        c = np.polyfit(t[i - 1:i + 2] - t[i], x[i - 1:i + 2], 2)
        peaks.append(c[2] - c[1]**2 / (4 * c[0]))
    return [(peaks[-1] / peaks[0])**(1 / (len(peaks) - 1)), (zeros[-1] - zeros[0]) / (len(zeros) - 1)]


def keys(**swing_keys):
    return "stages", [SCENE["stages"][0], {"swing": SCENE["stages"][1]["swing"] | swing_keys}]


LONG = ("formulations", "ranks_and_restart")  # parts that the short form leaves out


def run(case):
    decrements(case)
    by_ratio(case)
    by_group(case)
    formulations(case)
    spin(case)
    bound(case)
    slip(case)
    cracked(case)
    ranks_and_restart(case)


def decrements(case):
    """VS07: modes 1 and 2 of a shear column die away as Rayleigh's damping has them, and the account closes."""
    for name, mesh in (("quadrilaterals", column()), ("triangles", triangles(column()))):
        for strain in ("small", "large"):
            result = case.run(mesh, changed(SCENE, ("strain", strain)))
            h = swing(result)
            found = [*decay(h["time_s"], mode(h, 1)), *decay(h["time_s"], mode(h, 2))]
            case.check(f"VS07, {name}, {strain} strain: ratio and period [s] of modes 1 and 2", found, [0.77745, 0.16014, 0.6480, 0.05348], relative=2e-3)
            start = h["kinetic_J"][0] + h["strain_J"][0]
            case.check("... balance over the energy at the start", h["balance_J"] / start, 0.0, absolute=1e-10 if strain == "small" else 1e-6)
            end = result.stage_summary("swing")["energy"]
            case.check("... damped and left over that", (end["damping"] + end["kinetic"] + end["strain"]) / start, 1.0, relative=1e-6)
            case.check("... damped over it: 1 - ratio^(2 T / period), of mode 1, most of it", end["damping"] / start, 1 - 0.77745**(2 * 0.9 / 0.16014), absolute=0.01)


def by_ratio(case):
    """A ratio at two frequencies is alpha and beta."""
    w = 2.0 * np.pi * np.array([3.0, 12.0])
    alpha, beta = 2.0 * 0.05 * w[0] * w[1] / (w[0] + w[1]), 2.0 * 0.05 / (w[0] + w[1])
    case.check("5 % at 3 and 12 Hz: alpha [1/s], beta [s]", [alpha, beta], [ALPHA, BETA], relative=1e-6)
    given = case.run(column(), changed(SCENE, keys(alpha=float(alpha), beta=float(beta), duration=0.05)))
    ratio = {"type": "dynamic", "loads": [], "duration": 0.05, "dt_factor": 0.3, "damping_ratio": 0.05, "damping_frequencies": [3, 12]}
    asked = case.run(column(), changed(SCENE, ("stages", [SCENE["stages"][0], {"swing": ratio}])))
    case.check("... by damping_ratio: same bits", asked.stage_summary("swing")["checksum"], given.stage_summary("swing")["checksum"])
    case.check("... it says so", "damping 0.05 at 3 and 12 Hz: alpha 1.50796 1/s, beta 0.00106103 s" in asked.stdout, True)


def chain(betas, n=40):
    """Slowest decaying pair of the column as a chain of masses: ratio per cycle, period [s]."""
    k, m = RHO * CS**2 * n / HEIGHT, np.full(n, RHO * HEIGHT / n)
    m[-1] /= 2
    K, C = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    for e in range(n):
        pair = np.ix_([e, e + 1], [e, e + 1])
        K[pair] += k * np.array([[1, -1], [-1, 1]])
        C[pair] += betas[e * len(betas) // n] * k * np.array([[1, -1], [-1, 1]])
    K, C = K[1:, 1:] / m[:, None], C[1:, 1:] / m[:, None]
    s = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-K, -C]]))
    s = s[(s.imag > 1)]
    s = s[np.argmin(s.imag)]
    period = 2 * np.pi / s.imag
    return [np.exp(s.real * period), period]


def by_group(case):
    """Two groups with a beta each; one of them that of the stage."""
    mesh, betas = column(groups=("low", "high")), (2e-3, 5e-4)
    ground = SCENE["materials"]["ground"]
    change = [("supports", {"bottom": {"fix": "xy"}, "low": {"fix": "y"}, "high": {"fix": "y"}}), keys(alpha=0, beta=0, duration=2.0)]
    both = case.run(mesh, changed(SCENE, *change, ("materials", {"low": ground | {"beta": betas[0]}, "high": ground | {"beta": betas[1]}})))
    h = swing(both)
    late = h["time_s"] > 0.6  # the other modes are gone
    case.check("beta 2 ms below, 0.5 ms above: ratio and period [s] of what stays", decay(h["time_s"][late], h["top_left_ux_m"][late]), chain(betas), relative=1e-3)
    one = case.run(mesh, changed(SCENE, change[0], keys(alpha=0, beta=betas[1], duration=2.0), ("materials", {"low": ground | {"beta": betas[0]}, "high": ground})))
    case.check("... above that of the stage: same bits", one.stage_summary("swing")["checksum"], both.stage_summary("swing")["checksum"])
    start = h["kinetic_J"][0] + h["strain_J"][0]
    case.check("... balance over the energy at the start", h["balance_J"] / start, 0.0, absolute=1e-10)


def formulations(case):
    """Blocks of one point: a cantilever that bends; what is damped is booked, and it is the same motion."""
    mesh = rectangle(0, 0, 1, 8, 2, 16, group="ground")
    material = {"density": RHO, "young": 1e10, "poisson": 0.2, "beta": 1e-3}
    for element in ("full", "bending", "reduced"):
        for strain in ("small", "large"):
            result = case.run(mesh, changed(SCENE, ("strain", strain), ("materials.ground", material | {"element": element}), ("supports", {"bottom": {"fix": "xy"}}), ("relaxation.history_every", 4),
                                            ("stages", [{"pull": {"loads": ["side"]}}, {"swing": {"type": "dynamic", "loads": [], "duration": 1.5, "dt_factor": 0.3}}])))
            h = swing(result)
            w = 2 * np.pi / decay(h["time_s"][h["time_s"] > 0.4], h["top_left_ux_m"][h["time_s"] > 0.4])[1]
            z = 0.5 * 1e-3 * w / np.sqrt(1 + (0.5e-3 * w)**2)
            late = h["time_s"] > 0.4
            case.check(f"cantilever, {element}, {strain} strain: ratio per cycle, by its own period", decay(h["time_s"][late], h["top_left_ux_m"][late])[0],
                       np.exp(-2 * np.pi * z / np.sqrt(1 - z**2)), relative=3e-3)
            start = h["kinetic_J"][0] + h["strain_J"][0]
            case.check("... balance over the energy at the start", h["balance_J"] / start, 0.0, absolute=1e-10 if strain == "small" else 1e-5)


def spin(case):
    """A damped block that spins: its vibration dies away, its turning does not."""
    for name, mesh in (("quadrilaterals", rectangle(0, 0, 1, 2, 3, 6, group="ground")), ("triangles", triangles(rectangle(0, 0, 1, 2, 3, 6, group="ground")))):
        material = {"density": RHO, "young": 1e8, "poisson": 0.2, "beta": 1e-3, "spin": 30.0}
        scene = changed(SCENE, ("strain", "large"), ("materials.ground", material), ("supports", {}), ("relaxation", {"allow_floating": True, "history_every": 1}),
                        ("stages", [{"swing": {"type": "dynamic", "loads": [], "duration": 1.0, "dt_factor": 0.5}}]))
        h = swing(case.run(mesh, scene))
        energy, damped = h["kinetic_J"] + h["strain_J"], h["damping_J"]
        case.check(f"spinning block, {name}: damped at first, over its energy", bool(damped[-1] / energy[0] > 1e-5), True)
        half = len(energy) // 2
        case.check("... two turns later, over its energy", (energy[-1] - energy[half]) / energy[0], 0.0, absolute=1e-9)


def bound(case):
    """dt^2 k + 2 dt c <= 4 m: the step that beta leaves, said. It is that of the reference state: stretched by 2 % a column
    needs a step 6 % shorter, so it flies apart, and the run says so; pressed by 2 % it stands."""
    mesh = rectangle(0, 0, 1000, HEIGHT, 1, 40, group="ground")  # so wide that the row sums are those of a chain
    beta, dt_0, young = BETA, HEIGHT / 40 / CS, RHO * CS**2
    change = [("materials.ground.young", young), ("supports.level.fix", "x"), ("joints.default", {"law": "elastic", "k_n": 1.0, "k_s": 1.0}), ("strain", "large"),
              ("relaxation", {"history_every": 50, "tolerance": 1e-6})]

    def moved(stretch, **more):
        f = 1 + stretch
        pull = ("loads.top.value", [0, young * f * 0.5 * (f**2 - 1)])
        stages = ("stages", [{"pull": {"loads": ["top"]}}, {"swing": {"type": "dynamic", "loads": ["top"], "duration": 2.0, "alpha": ALPHA, "beta": beta, "dt_factor": 1.0} | more}])
        return case.run(mesh, changed(SCENE, *change, pull, stages))

    result = moved(1e-6)
    case.check("VS07: the step at the bound with beta [s]", result.stage_summary("swing")["dt"], np.sqrt(beta**2 + dt_0**2) - beta, relative=0.003)
    case.check("... exit code", result.exit_code, 0)
    case.check("... it says what set the step", "less by dampers; set by beta of group ground at x = " in result.stdout, True)
    small = moved(1e-6, dt_factor=0.3, duration=0.05).stage_summary("swing")["dt"]
    case.check("... 0.3 of the bound without beta is less than that, and is taken [s]", small, 0.3 * dt_0, relative=0.003)
    stretched, pressed = moved(0.02), moved(-0.02)
    case.check("... stretched by 2 %, pressed by 2 %: exit codes", [stretched.exit_code, pressed.exit_code], [3, 0])
    case.check("... it says so", "the step is too large" in stretched.stdout or "energy account is out" in stretched.stdout, True)
    rigid = case.run(renamed(rectangle(0, 0, 1, 1, group="ground", rigid=True), {}), changed(SCENE, ("materials.ground", {"density": RHO, "rigid": True, "beta": 1e-3})))
    case.check("beta of a rigid group: exit code, and why", [rigid.exit_code, "beta damps strain, and a rigid group has none" in rigid.stderr], [2, True])


def slip(case):
    """VS08 with a dashpot in the joint, 5 % at 30 Hz, which does not act along it; the step by auto."""
    t = np.linspace(0, 0.4, 401)
    rows = "".join(f"{a:.9g}, {b:.17g}, 0\n" for a, b in zip(np.append(t, [0.4, 4.0]), np.append(0.5 * 9.81 * np.sin(np.pi * t / 0.4), [0.0, 0.0]), strict=True))
    table = renamed(rectangle(-2, -1, 8, 1, group="table", rigid=True), {}, {"ground": "top_left"})
    block = renamed(rectangle(0, 0, 1, 0.25, group="block", rigid=True), {}, {"at": "bottom_left"})
    stiffness = 2400 * 0.25 * (2 * np.pi * 30)**2
    scene = {"materials": {"table": {"density": 2400}, "block": {"density": 2400}}, "supports": {"table": {"fix": "xy", "motion": "quake.csv", "quantity": "acceleration"}},
             "joints": {"default": {"stress_model": "tptm", "k_n": 100 * stiffness, "k_s": stiffness, "friction": float(np.degrees(np.arctan(0.2))), "damping": 0.1 / (2 * np.pi * 30)}},
             "contact": {"connectivity": "variable", "tolerance": 0.005}, "relaxation": {"history_every": 10}, "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
             "stages": [{"rest": {"loads": ["weight"]}}, {"swing": {"type": "dynamic", "loads": ["weight"], "duration": 1.0, "dt_factor": "auto"}}]}
    folder = case.prepare(join([table, block]), scene)
    (folder / "quake.csv").write_text(rows)
    result = case.again(folder)
    h = swing(result)
    case.check("VS08, joint of 30 Hz with a dashpot of 5 %, auto: slip [m]", abs(h["at_ux_m"] - h["ground_ux_m"])[-1], 0.1808, relative=0.01)
    case.check("... the step of auto, and how far down it may go", ["(0.9 of the stability bound" in result.stdout, "down to 1/16 of it" in result.stdout], [True, True])


def cracked(case):
    """A block that deforms rocks and slides on a shaken base: auto against a fine step."""
    table = renamed(rectangle(-4, -1, 14, 1, group="table", rigid=True), {}, {"ground": "top_left"})
    block = renamed(rectangle(0, 0, 4, 10, 4, 10, group="block"), {}, {"at": "bottom_left", "crest": "top_left"})
    t = np.linspace(0, 2.0, 401)
    rows = "".join(f"{a:.9g}, {b:.17g}, 0\n" for a, b in zip(np.append(t, 6.0), np.append(0.55 * 9.81 * np.sin(np.pi * t / 2)**2 * np.sin(2 * np.pi * 2 * t), 0.0), strict=True))
    scene = {"materials": {"table": {"density": 2400}, "block": {"density": 2400, "young": 5e9, "poisson": 0.2}},
             "supports": {"table": {"fix": "xy", "motion": "quake.csv", "quantity": "acceleration"}}, "relaxation": {"history_every": 10, "tolerance": 1e-8},
             "joints": {"default": {"stress_model": "tptm", "k_n": 1e10, "k_s": 4e9, "friction": 35}}, "loads": {"weight": {"type": "self_weight", "groups": ["block"]}},
             "stages": [{"rest": {"loads": ["weight"]}}, {"swing": {"type": "dynamic", "loads": ["weight"], "duration": 2.5, "dt_factor": "auto", "beta": 2e-4}}]}
    found = {}
    for factor in ("auto", 0.05):
        folder = case.prepare(join([table, block]), changed(scene, ("stages", [scene["stages"][0], {"swing": scene["stages"][1]["swing"] | {"dt_factor": factor}}])))
        (folder / "quake.csv").write_text(rows)
        found[factor] = case.again(folder)
    crest = [abs(swing(r)["crest_ux_m"] - swing(r)["ground_ux_m"]).max() for r in found.values()]
    case.check("block that deforms rocks and slides, auto against 0.05: largest crest displacement [m]", crest[0], crest[1], relative=1e-3)
    steps = [r.stage_summary("swing")["cycles"] for r in found.values()]
    case.report("... steps over those of 0.05", steps[0] / steps[1], 0.2)
    case.check("... at most 0.3", bool(steps[0] < 0.3 * steps[1]), True)
    case.check("... it says what it takes", "of the stability bound" in found["auto"].stdout and all("hinge" in line for line in found["auto"].stdout.splitlines() if "warning" in line), True)
    folder = case.prepare(join([table, block]), changed(scene, ("stages", [scene["stages"][0], {"swing": {"type": "dynamic", "loads": ["weight"], "duration": 0.01, "dt_factor": "auto"}}])))
    (folder / "quake.csv").write_text(rows)
    def warned(*options):
        return "joint default, and nothing damps high frequencies" in case.again(folder, *options).stdout
    case.check("... without beta and without a dashpot: a warning; with one: none", [warned(), warned("-joints_default_damping", "1e-4")], [True, False])


def ranks_and_restart(case):
    for strain in ("small", "large"):
        mesh = rectangle(0, 0, 4, 20, 4, 20, group="ground")
        scene = changed(SCENE, ("strain", strain), ("supports", {"bottom": {"fix": "xy"}}), ("checkpoint", {"every": 50, "keep": 100}), ("relaxation", {"history_every": 25, "tolerance": 1e-6}),
                        ("materials.ground.beta", 2e-4), keys(duration=0.04))
        folder = case.prepare(mesh, scene)
        sums = [case.again(folder, ranks=n).stage_summary("swing")["checksum"] for n in case.ranks(2, 3, 4)]
        whole = case.again(folder)
        case.check(f"{strain} strain: checksums on 1 to 4 ranks", len({*sums, whole.stage_summary("swing")["checksum"]}), 1)
        case.again(folder, "-output", "kept")
        files = sorted((folder / "kept" / "checkpoints").iterdir())[-4:]
        same = []
        for number, file in enumerate(files):
            again = case.again(folder, "-restart", file, ranks=1 + number % 2).stage_summary("swing")
            same.append(again["checksum"] == whole.stage_summary("swing")["checksum"])
            same.append(number % 2 or again["energy"]["damping"] == whole.stage_summary("swing")["energy"]["damping"])
        case.check("... restart from checkpoints, on 1 and 2 ranks: same bits, same damping", [len(files) > 2, bool(np.all(same))], [True, True])
