"""Temperature in blocks with a law: those that yield or crack as they become warmer or colder.

Elastic blocks that become warmer are in the case temperature, laws without temperature in yielding and cracking."""

import numpy as np
from driver import changed, check_restarts, checksums
from quoin_tools.mesh.meshing import join, rectangle, renamed, split_triangles
from quoin_tools.mesh.stacks import quad_patch

WHAT = "blocks with a law that become warmer: held blocks that yield, a bar that cracks in the cold, strong blocks as elastic ones, free across the plane, account, ranks, restarts"
SOURCE = "E alpha T/(1 - 2 nu) and its like to the strength of the law, then the return by hand; a crack as wide as alpha T L less what the bar is stretched"
BY = "by hand"

E, NU, ALPHA = 20e9, 0.2, 1e-5
ELASTIC = {"density": 2400, "young": E, "poisson": NU, "expansion": ALPHA}
YIELDS = ELASTIC | {"law": "mohr_coulomb", "cohesion": 0.5e6, "friction": 30, "tension": 0.4e6}
Q = 2 * 0.5e6 * np.cos(np.pi / 6) / (1 - np.sin(np.pi / 6))  # what it bears along one side, pressed
ELEMENTS = ("bending", "full", "reduced", "triangles")


def block(element, n=2):
    """A unit square; its inner vertex is off the centre, so that blocks are distorted."""
    mesh = rectangle(0, 0, 1, 1, n, n, group="stone")
    inner = np.all((mesh.vertices > 1e-9) & (mesh.vertices < 1 - 1e-9), axis=1)
    mesh.vertices[inner] += (0.06, -0.04)
    return split_triangles(mesh) if element == "triangles" else mesh


def of(material, element):
    return {"stone": material if element == "triangles" else material | {"element": element}}


def scene(material, changes, supports, **more):
    """A stage for each change [K]; 0: nothing acts."""
    loads = {f"t{i}": {"type": "temperature", "change": t} for i, t in enumerate(changes)}
    return {"strain": "small", "relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 100}, "materials": material, "supports": supports,
            "loads": loads, "stages": [{f"s{i}": {"loads": [f"t{i}"]}} for i in range(len(changes))]} | more  # fmt: skip


def run(case):
    held(case)
    pressed(case)
    bar(case)
    strong(case)
    lifts(case)
    in_time(case)
    ranks_and_restart(case)


def points(stage):
    found = stage.gauss_stress.reshape(-1, 3)
    return found[~np.isnan(found[:, 0])]


def held(case):
    """Held all round: E alpha T/(1 - 2 nu) until all principal stresses are at the cut-off; pressed from all sides it never yields."""
    around = {side: {"fix": "xy"} for side in ("bottom", "top", "left", "right")}
    still = {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "method": "preconditioned"}  # by cycles there is no motion that a motion could be compared with
    first, free = E * ALPHA / (1 - 2 * NU), E * ALPHA / (1 + NU) / (1 - 2 * NU)
    for element in ELEMENTS:
        result = case.run(block(element), scene(of(YIELDS, element), (-1, -6, -5, 12), around, relaxation=still))
        # 0.333 MPa; 2 at 0.4; warmer by 1 K it is pressed elastically from there on
        expected = [first, 0.4e6, 0.4e6 - first, 0.4e6 - 18 * first]
        for i, s in enumerate(expected):
            case.check(f"held all round, {element}, {('below the strength', 'cooled to it', 'warmed', 'heated')[i]}: s_x, s_y [Pa]", points(result.stage(f"s{i}"))[:, :2], s, absolute=20)
        told = result.stage_summary("s3")["laws"]["stone"]
        case.check("... energy lost [J]: the strength along the plastic strain in three directions", told["lost"], 3 * 0.4e6 * (6 * ALPHA - 0.4e6 * (1 - 2 * NU) / E), relative=1e-6)
        result = case.run(block(element), scene(of(YIELDS | {"free_across": True}, element), (-1, -6), around, relaxation=still))
        for i, s in enumerate((free, 0.4e6)):
            case.check("... free across the plane: s_x, s_y [Pa]", points(result.stage(f"s{i}"))[:, :2], s, absolute=20)
    elastic = case.run(block("bending"), scene(of(ELASTIC | {"free_across": True}, "bending"), (-1,), around, relaxation=still)).stage("s0")
    case.check("... elastic: s_x, s_z [Pa]", [elastic.stress[:, 0].mean(), elastic.stress_z.mean()], [free, 2 * NU * free], relative=1e-12)


def pressed(case):
    """Held along x, free along y: pressed in x and z until the edge of the strength; cooled, it comes back elastically with what it has lost."""
    supports = {"left": {"fix": "x"}, "right": {"fix": "x"}, "bottom": {"fix": "y"}}
    yields = Q * (1 - NU) / E / ALPHA  # K
    warm = [0.9 * yields, 3 * yields, 2.5 * yields]
    sx = [-0.9 * Q, -Q, -0.5 * Q]
    plastic = -2 * yields * ALPHA  # along x and z; along y it is -2 of it, without dilation
    ey = [ALPHA * warm[i] - 2 * NU * sx[i] / E - (2 * plastic if i else 0) for i in range(3)]
    both = [(element, "small", method) for element in ELEMENTS for method in ("explicit", "preconditioned")]
    for element, strain, method in [*both, ("bending", "large", "explicit"), ("full", "large", "preconditioned"), ("triangles", "large", "explicit")]:
        what = f"held along x, {element}, {strain} strain, {method}"
        relax = {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "ramp": 100, "method": method}
        result = case.run(block(element), scene(of(YIELDS, element), warm, supports, strain=strain, relaxation=relax))
        found = [result.stage(f"s{i}") for i in range(3)]
        case.check(f"{what}: e_y below the strength, at it, cooled", [s.displacement[:, 1].max() for s in found], ey, relative=1e-6 if strain == "small" else 2e-3)
        case.check("... s_x at all points [Pa]", [abs(points(s)[:, 0] / x - 1).max() for s, x in zip(found, sx, strict=True)], 0, absolute=1e-6 if strain == "small" else 6e-3)
        case.check("... s_y", [abs(points(s)[:, 1] / Q).max() for s in found], 0, absolute=2e-5)
        case.check("... by one method, and nothing of a step that is too long", [[s["method"] for s in result.summary["stages"]], "depends on the way" in result.stderr], [[method] * 3, False])
    free = case.run(block("bending"), scene(of(YIELDS | {"free_across": True}, "bending"), [0.9 * yields * (1 + NU), 5 * yields], supports))
    case.check("held along x, free across: s_x below the strength, at it", [points(free.stage(f"s{i}"))[:, 0].mean() for i in range(2)], [-0.9 * Q, -Q], relative=1e-6)


# ---- a bar that cracks


FT, GF, L, N = 1e6, 200.0, 1.0, 5


def bar(case):
    """Ends held, cooled: the weak block cracks, and what the others shrink opens it. Warmed it closes, and is pressed with its whole stiffness."""
    young, e0, h = 10e9, 0.999 * FT / 10e9, L / N
    B = GF / (h * 0.999 * FT) - e0 / 2

    def shrinks(stress):  # alpha T L at which the weak block, on its way down, bears this part of FT
        kappa = e0 - B * np.log(stress / 0.999)
        return (L - h) * stress * FT / young + h * kappa

    stone = {"density": 240, "young": young, "poisson": 0, "law": "damage", "tension": FT, "fracture_energy": GF, "expansion": ALPHA, "free_across": True}
    levels = (0.8, 0.5, 0.2, 0.02)
    changes = [-0.9 * FT / young / ALPHA, *(-shrinks(s) / ALPHA / L for s in levels), -shrinks(0.5) / ALPHA / L, 5.0]
    mesh = rectangle(0, 0, L, 1, N, 1, group="stone")
    mesh.group_names, mesh.group_rigid = ["stone", "weak"], np.zeros(2, dtype=np.int32)
    mesh.block_group[N // 2] = 1
    supports = {"left": {"fix": "x"}, "right": {"fix": "x"}, "bottom": {"fix": "y"}}
    for element, strain, method in (("bending", "small", "explicit"), ("full", "small", "explicit"), ("triangles", "small", "explicit"), ("bending", "small", "preconditioned"), ("bending", "large", "explicit")):
        more = {} if element == "triangles" else {"element": element}
        both = {"stone": stone | more, "weak": stone | more | {"tension": 0.999 * FT}}
        relax = {"tolerance": 1e-8, "velocity_tolerance": 1e-8, "ramp": 1000, "method": method}
        result = case.run(split_triangles(mesh) if element == "triangles" else mesh, scene(both, changes, supports, strain=strain, relaxation=relax))
        what = f"bar that cracks in the cold, {element}, {strain} strain, {method}"
        case.check(f"{what}: all stages converge", [s["verdict"] for s in result.summary["stages"]], ["converged"] * len(changes))
        stress = [points(result.stage(f"s{i}"))[:, 0].mean() for i in range(len(changes))]
        expected = [0.9 * FT, *(s * FT for s in levels), None, -young * 5 * ALPHA]
        kappa = e0 - B * np.log(0.02 / 0.999)
        secant = 0.02 * FT / kappa  # of the weak block
        expected[5] = shrinks(0.5) / ((L - h) / young + h / secant)
        case.check("... stress before it cracks, at 0.8, 0.5, 0.2, 0.02 ft, warmer again, pressed [Pa]", stress, expected, relative=2e-3 if strain == "small" else 1e-2)
        weak = [result.stage_summary(f"s{i}")["laws"]["weak"] for i in range(len(changes))]
        width = [max(0, -changes[i] * ALPHA * L - expected[i] * L / young) for i in range(len(changes))]
        case.check("... crack width: alpha T L less what the bar is stretched [um]", [1e6 * w["crack_width"] for w in weak], 1e6 * np.array(width), absolute=0.3 if strain == "small" else 1.5)
        bears = 0.02 / 0.999
        case.check("... energy lost in the crack [J]: all of Gf but what is left at 0.02 ft", weak[-1]["lost"], GF - h * (B * 0.999 * FT * bears + 0.5 * 0.02 * FT * kappa), relative=2e-3 if strain == "small" else 5e-3)
        case.check("... in the other blocks", result.stage_summary("s6")["laws"]["stone"]["lost"], 0, absolute=0.05)


# ---- as elastic blocks


def strong(case):
    """Blocks that are far from their strength are elastic ones, in any temperature: forces, stresses and energies, bending within a block included; in time too."""
    (case.folder / "gradient.csv").write_text("0, 0, 9\n2, 0, -6\n0, 6, 3\n2, 6, -12\n1, 3, 4\n")
    laws = {"mohr_coulomb": {"cohesion": 1e9, "friction": 20, "tension": 1e9}, "damage": {"tension": 1e8, "fracture_energy": 1e9}}
    for element, strain, across in (("bending", "small", False), ("bending", "large", True), ("full", "large", False), ("reduced", "small", True), ("triangles", "large", True)):
        mesh = rectangle(0, 0, 2, 6, 2, 5, group="stone")
        mesh.vertices += 0.03 * np.sin(7 * mesh.vertices[:, ::-1])
        mesh = split_triangles(mesh) if element == "triangles" else mesh
        one = scene(None, (), {"bottom": {"fix": "xy"}}, strain=strain)
        one["relaxation"]["method"] = "explicit"  # `auto` takes another method for blocks that crack
        one |= {
            "loads": {"warm": {"type": "temperature", "points": str(case.folder / "gradient.csv")}, "more": {"type": "temperature", "change": 4}},
            "stages": [{"still": {"loads": ["warm"]}}, {"both": {"loads": ["warm", "more"]}}, {"shaken": {"type": "dynamic", "loads": ["more"], "duration": 0.002}}]}  # fmt: skip
        plain = case.run(mesh, changed(one, ("materials", of(ELASTIC | {"free_across": across}, element))))
        for law, keys in laws.items():
            other = case.run(mesh, changed(one, ("materials", of(ELASTIC | keys | {"free_across": across, "law": law}, element))))
            for name in ("still", "both", "shaken"):
                ours, theirs = other.stage(name), plain.stage(name)
                what = f"{law} far from its strength, {element}, {strain} strain, stage {name}"
                scale = np.abs(theirs.displacement).max()
                case.check(f"{what}: displacements of elastic blocks, over the largest", (ours.displacement - theirs.displacement) / scale, 0, absolute=1e-7)
                scale = np.abs(points(theirs)).max()
                # a block of one point has one stress, and its bending is not in it; the elastic one gives the same
                case.check("... stresses", (points(ours) - points(theirs)) / scale, 0, absolute=1e-6)
                energies = [r.stage_summary(name)["energy"]["strain"] for r in (other, plain)]
                case.check("... strain energy", energies[0] / energies[1], 1, absolute=1e-6)


def lifts(case):
    """A group that is not built yet does nothing to what stands, however warm; with a law as without."""
    mesh = rectangle(0, 0, 1, 2, 2, 4, group="low")
    mesh.group_names, mesh.group_rigid = ["low", "high"], np.zeros(2, dtype=np.int32)
    mesh.block_group[mesh.vertices[mesh.blocks[:, :4]][..., 1].mean(axis=1) > 1] = 1
    both = {"stages": [{"one": {"loads": ["t0"]}}, {"two": {"loads": ["t0"], "build": ["high"]}}]}
    middle, found = np.abs(mesh.vertices[:, 1] - 1) < 1e-9, []
    for law in ({"element": "bending"}, {"law": "mohr_coulomb", "cohesion": 1e8, "friction": 30}):
        result = case.run(mesh, scene({"low": ELASTIC | law, "high": ELASTIC | law}, (10.0,), {"bottom": {"fix": "y"}, "left": {"fix": "x"}}) | both)
        found.append(result.stage("two").displacement)
        case.check(f"lift that is not built, {law.get('law', 'elastic')}: those below it, free, rise by [m]", result.stage("one").displacement[middle, 1], (1 + NU) * ALPHA * 10, relative=1e-6)
    case.check("... built: blocks with a law as elastic ones, over the largest", (found[1] - found[0]) / np.abs(found[0]).max(), 0, absolute=1e-6)


def in_time(case):
    """A cold shock: the account closes while blocks yield and crack."""
    mesh = rectangle(0, 0, 4, 1, 8, 2, group="stone")
    cracks = ELASTIC | {"law": "damage", "tension": 1e6, "fracture_energy": 200, "free_across": True}
    for name, material in (("yields", YIELDS), ("cracks", cracks)):
        for strain in ("small", "large"):
            one = scene({"stone": material}, (-30,), {"left": {"fix": "xy"}, "right": {"fix": "xy"}}, strain=strain) | {"stages": [{"shock": {"type": "dynamic", "loads": ["t0"], "duration": 0.02, "dt_factor": 0.2}}]}
            result = case.run(mesh, one)
            energy = result.stage_summary("shock")["energy"]
            scale = 0.5 * E * (30 * ALPHA) ** 2 * 4
            case.check(f"cold shock, {name}, {strain} strain: balance over the energy of the bar held", energy["balance"] / scale, 0, absolute=1e-3)
            case.check("... it runs to its end, and energy is lost in blocks", [result.verdict, bool(result.stage_summary("shock")["yielded"] > 0.01 * scale)], ["converged", True])


# ---- ranks, restart


def wall():
    """A wall of two bodies on its ground, water and a winter: the ground yields, the wall cracks."""
    mesh = join([renamed(rectangle(-2, -2, 8, 2, 6, 2, group="ground"), {"bottom": "bottom"}, {}),
                 renamed(quad_patch((0, 0), (3, 0), (2, 6), (0, 6), 4, 5, group="stone"), {"upstream": "left"}, {})])  # fmt: skip
    weak = {"density": 2400, "young": 10e9, "poisson": 0.2, "law": "damage", "tension": 5e4, "fracture_energy": 10, "expansion": 1e-5, "free_across": True}
    ground = {"density": 2400, "young": 10e9, "poisson": 0.2, "law": "mohr_coulomb", "cohesion": 1e5, "friction": 30, "tension": 2e4, "expansion": 1e-5, "element": "full"}
    return mesh, {
        "strain": "large", "materials": {"ground": ground, "stone": weak},
        "joints": {"default": {"k_n": 2e10, "k_s": 1e10, "friction": 60, "cohesion": 1e6, "tension": 1e6}},
        "supports": {"bottom": {"fix": "xy"}}, "relaxation": {"max_cycles": 40000, "ramp": 500},
        "loads": {"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "upstream", "level": 4}, "winter": {"type": "temperature", "change": -6.0, "groups": ["ground", "stone"]},
                  "wave": {"type": "temperature", "amplitude": 8, "day": 182, "faces": "upstream", "groups": ["stone"]}},
        "stages": [{"own": {"loads": ["weight"]}}, {"winter": {"loads": ["weight", "water", "winter", "wave"]}}, {"spring": {"loads": ["weight", "water"]}},
                   {"shaken": {"type": "dynamic", "loads": ["weight", "water", "winter"], "duration": 0.01}}]}  # fmt: skip


def ranks_and_restart(case):
    mesh, one = wall()
    folder = case.prepare(mesh, changed(one, ("checkpoint", {"every": 300, "keep": 1000})))
    first = case.again(folder)
    case.check("wall in winter: all stages end well", [s["verdict"] for s in first.summary["stages"]], ["converged"] * 3 + ["completed"])
    lost = {name: [first.stage_summary(s["name"])["laws"][name]["lost"] for s in first.summary["stages"]] for name in ("ground", "stone")}
    case.check("... in winter ground yields and wall cracks; before neither does", [[rows[0] == 0, rows[1] > 0] for rows in lost.values()], [[True, True]] * 2)
    for ranks in case.ranks(2, 3, 4):
        case.check(f"... checksums on {ranks} ranks", checksums(case.run(mesh, one, ranks=ranks)), checksums(first))
    check_restarts(case, folder, first)
