"""Construction in lifts: a column and a dam whose groups are placed one after the other, without stress, on what has settled so far.

By hand: a column in n lifts. The dam: finite elements of the same mesh by another program, lift by lift."""

import numpy as np
from driver import changed
from quoin_tools.mesh.meshing import join, quad_patch, rectangle, renamed, split_triangles, structured

WHAT = "construction in lifts: a column by hand, a dam against another program (M06); joints, reset of displacements, trials, ranks, restart, refusals"
SOURCE = "settlement of a lift (g/E)[t (z - t) + t^2/2 + (H - z) z]; 12 x 12 quadrilaterals, lift by lift"
BY = "by hand; a program apart, not named there"

G, RHO, E, H = 9.81, 2400.0, 20e9, 30.0
GAMMA = RHO * G


def lifted(mesh, n, height=H):
    """The groups lift_1 .. lift_n, of equal height."""
    y = mesh.vertices[np.where(mesh.blocks < 0, mesh.blocks[:, :1], mesh.blocks)].mean(axis=1)[:, 1]
    mesh.group_names, mesh.group_rigid = [f"lift_{i + 1}" for i in range(n)], np.zeros(n, np.int32)
    mesh.block_group = np.minimum((y * n / height).astype(np.int32), n - 1)
    return mesh


def scene(n, poisson=0.0, **more):
    names = [f"lift_{i + 1}" for i in range(n)]
    stages = [{f"s{i + 1}": {"loads": ["weight"]} | ({"build": [name]} if i else {})} for i, name in enumerate(names)]
    return {
        "relaxation": {"tolerance": 1e-11, "velocity_tolerance": 1e-11, "method": "explicit"}, "strain": "small",
        "materials": {name: {"density": RHO, "young": E, "poisson": poisson} for name in names},
        "joints": {"default": {"k_n": 1e10, "k_s": 1e10, "friction": 45}}, "supports": {"bottom": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight"}}, "stages": stages,
    } | more  # fmt: skip


def with_tops(mesh, n):
    """A point top_i on each lift, on its left."""
    for i in range(n):
        on_left = np.flatnonzero(np.isclose(mesh.vertices[:, 1], H * (i + 1) / n) & (mesh.vertices[:, 0] == 0.0))
        below = [v for v in on_left if (mesh.blocks[mesh.block_group == i] == v).any()]
        mesh.points[f"top_{i + 1}"] = int(below[0])
    return mesh


def tops(result, n, stage=None):
    return np.array([result.probe(stage or f"s{n}", f"top_{i + 1}")[1] for i in range(n)])


LONG = ("ranks_and_restart",)  # parts that the short form leaves out


def run(case):
    column(case)
    dam(case)
    superposed(case)
    soft(case)
    half_built(case)
    reset(case)
    anchored(case)
    ranks_and_restart(case)
    refused(case)


def column(case):
    """Settlements of the tops of all lifts since they were placed; stress as in one piece."""
    for n in case.some((1, 3, 6), 2):
        t, z = H / n, H / n * np.arange(1, n + 1)
        expected = -GAMMA / E * (t * (z - t) + t**2 / 2 + (H - z) * z)
        for element in ("full", "bending", "reduced"):
            for measure in ("small", "large"):
                for method in ("explicit", "preconditioned"):
                    mesh = with_tops(lifted(rectangle(0, 0, 2, H, 1, 12), n), n)
                    one = changed(scene(n), ("strain", measure), ("relaxation.method", method))
                    for material in one["materials"].values():
                        material["element"] = element
                    result = case.run(mesh, one)
                    relative = 1e-6 if measure == "small" else 2e-4
                    case.check(f"column in {n} lifts, {element}, {measure} strain, {method}: settlements [m]", tops(result, n), expected, relative=relative)
                    centre = mesh.vertices[mesh.blocks].mean(axis=1)[:, 1]
                    case.check("... stress as in one piece [Pa]", result.stage(f"s{n}").stress[:, 1], -GAMMA * (H - centre), relative=relative)


def dam_mesh(n):
    """Rows level, columns proportional: (0,0) (24,0) (4,30) (0,30)."""
    y = np.linspace(0, 30, 13)
    width = 24 - 20 * y / 30
    xy = np.stack([np.linspace(0, 1, 13)[None] * width[:, None], np.repeat(y[:, None], 13, axis=1)], axis=-1)
    return structured(xy)


def dam(case):
    expected = {1: (-0.6079e-3, -0.5819e-3, -773.8e3, -368.2e3), 2: (-0.5223e-3, -0.4409e-3, -773.2e3, -361.8e3), 3: (-0.3993e-3, -0.3206e-3, -773.1e3, -361.9e3),
                6: (-0.2140e-3, -0.1670e-3, -775.1e3, -358.4e3), 12: (-0.1066e-3, -0.0829e-3, -777.0e3, -357.3e3)}  # fmt: skip
    for n, numbers in expected.items():
        mesh = lifted(dam_mesh(n), n)
        mesh.points = {"crest": int(np.flatnonzero((mesh.vertices == [0, 30]).all(axis=1))[0])}
        mesh.face_sets = {"bottom": np.array([[i, 0] for i in range(12)], np.int32)}
        result = case.run(mesh, changed(scene(n, 0.2), ("relaxation.method", "preconditioned")))
        now = result.stage(f"s{n}")
        found = [*result.probe(f"s{n}", "crest"), now.stress[0, 1], now.stress[6 * 12, 1]]
        case.check(f"dam in {n} lifts: crest ux, uy [m], syy at the heel, of row 7 [Pa]", found, numbers, relative=1e-3)
        case.check("... reaction [N]", result.stage_summary(f"s{n}")["reaction"]["y"], 9888.48e3, relative=1e-6)


# ---- other meshes, large strain


def bodies(n, triangles):
    """Lifts that are bodies of their own, one on the other with a joint, or triangles of one body."""
    if triangles:
        return with_tops(split_triangles(lifted(rectangle(0, 0, 2, H, 2, 12), n)), n)
    parts = [rectangle(0, H / n * i, 2, H / n, 2 + i % 2, 4, group=f"lift_{i + 1}") for i in range(n)]
    return with_tops(join([renamed(part, {"bottom": "bottom"} if not i else {}, {}) for i, part in enumerate(parts)]), n)


def superposed(case):
    """What each lift adds is what its weight does to the lifts below it and to itself, in one piece: joints and triangles too."""
    n = 3
    for triangles in (False, True):
        added = []
        for k in range(1, n + 1):
            mesh = bodies(n, triangles)
            keep = mesh.block_group < k
            used = np.unique(mesh.blocks[keep][mesh.blocks[keep] >= 0])
            row = np.full(len(mesh.vertices) + 1, -1)
            row[used] = np.arange(len(used))
            faces = {name: f[keep[f[:, 0]]] for name, f in mesh.face_sets.items() if name == "bottom"}
            number = np.cumsum(keep) - 1
            mesh.blocks, mesh.block_group, mesh.vertices = row[mesh.blocks[keep]].astype(np.int32), mesh.block_group[keep], mesh.vertices[used]
            mesh.face_sets = {name: np.stack([number[f[:, 0]], f[:, 1]], 1).astype(np.int32) for name, f in faces.items()}
            mesh.points = {name: int(row[v]) for name, v in mesh.points.items() if row[v] >= 0}
            mesh.group_names, mesh.group_rigid = mesh.group_names[:k], mesh.group_rigid[:k]
            one = scene(k)
            one["loads"]["weight"]["groups"] = [f"lift_{k}"]
            result = case.run(mesh, changed(one, ("stages", [{"whole": {"loads": ["weight"]}}]), ("joints.default", {"k_n": 1e10, "k_s": 1e10, "law": "elastic"})))
            added.append([result.probe("whole", f"top_{i + 1}")[1] if i < k else 0.0 for i in range(n)])
        expected = [sum(added[k][i] for k in range(i, n)) for i in range(n)]
        for method in ("explicit", "preconditioned"):
            result = case.run(bodies(n, triangles), changed(scene(n), ("relaxation.method", method)))
            case.check(f"{'triangles' if triangles else 'lifts with joints between them'}, {method}: settlements [m]", tops(result, n), expected, relative=1e-6)
            if not triangles:
                now = result.stage(f"s{n}").contacts
                case.check("... the joints bear what is above them [N]", [-now.force[now.point[..., 1] == at, 0].sum() for at in (10.0, 20.0)], [20 * 2 * GAMMA, 10 * 2 * GAMMA], relative=1e-6)
                first = result.stage("s2").contacts
                case.check("... closed from the start: closure of the first one under one lift [m]", -first.opening, 10 * GAMMA / 1e10, relative=1e-6)


def soft(case):
    """A soft column of two lifts, one block each: F F_0^-1. The second one is as high as is left below its top, which is where it was planned."""
    t, young = H / 2, 5e6
    def stretch(force):
        return max(np.roots([young / 2, 0, -young / 2, force]).real)
    mesh = with_tops(lifted(rectangle(0, 0, 2, H, 1, 2), 2), 2)
    weight = GAMMA * t
    low = t * stretch(weight / 2)
    case.check("soft column: the first lift settles by more than 3 %", low < 0.97 * t, True)
    expected = [t * stretch(1.5 * weight) - t, t * stretch(1.5 * weight) + (2 * t - low) * stretch(weight / 2) - 2 * t]
    for method in ("explicit", "preconditioned"):
        one = changed(scene(2), ("strain", "large"), ("relaxation.method", method))
        for material in one["materials"].values():
            material["young"] = young
        case.check(f"... {method}: settlements [m]", tops(case.run(mesh, one), 2), expected, relative=1e-6)


# ---- what is not there, trials, displacements that are reset


def on_rock(joint=True):
    """A dam in three lifts on rock, the lowest one bonded to it by a joint."""
    parts = [renamed(rectangle(-10, -10, 30, 10, 12, 4, group="rock"), {"bottom": "bottom"})]
    for i, (w0, w1) in enumerate(((9, 7), (7, 5), (5, 3))):
        part = quad_patch((0, 4 * i), (w0, 4 * i), (w1, 4 * i + 4), (0, 4 * i + 4), 4, 3, group=f"lift_{i + 1}")
        parts.append(renamed(part, {"up": "left"}, {f"top_{i + 1}": "top_left"}))
    return join(parts)


def on_rock_scene(**more):
    soft = {"density": RHO, "young": 10e9, "poisson": 0.2}
    stages = [{"rock": {"loads": ["weight"]}}, {"first": {"loads": ["weight"], "build": ["lift_1"], "displacements": "reset"}},
              {"second": {"loads": ["weight"], "build": "lift_2"}}, {"third": {"loads": ["weight"], "build": ["lift_3"]}}, {"full": {"loads": ["weight", "water"]}},
              {"flood": {"type": "flood", "loads": ["weight", "water"], "step": 2, "limit": 15}}]  # fmt: skip
    return scene(3, materials={"rock": soft} | {f"lift_{i + 1}": soft for i in range(3)}, loads={"weight": {"type": "self_weight"}, "water": {"type": "reservoir", "faces": "up", "level": 11}},
                 joints={"default": {"k_n": 1e10, "k_s": 1e10, "friction": 35}}, relaxation={"tolerance": 1e-6, "velocity_tolerance": 1e-6, "method": "explicit"}, stages=stages, **more)  # fmt: skip


def half_built(case):
    """What is not built weighs nothing, is not wet, has no contacts; and the numbers of the stages before are those of a scene without it."""
    mesh = on_rock()
    whole = on_rock_scene()
    half = changed(whole, ("stages", [{"rock": {"loads": ["weight"]}}, {"first": {"loads": ["weight"], "build": ["lift_1"]}}, {"wet": {"loads": ["weight", "water"]}}, {"later": {"loads": ["weight", "water"], "build": ["lift_2", "lift_3"]}}]))
    result = case.run(mesh, half)
    rock, lift = 300 * GAMMA, 4 * 8 * GAMMA
    case.check("supports bear rock, then rock and the first lift [N]", [result.stage_summary(s)["reaction"]["y"] for s in ("rock", "first")], [rock, rock + lift], relative=1e-4)
    case.check("... water stands at the first lift only [N]", -result.stage_summary("wet")["reaction"]["x"], 1000 * G * (11**2 - 7**2) / 2, relative=1e-4)
    now = result.stage("wet")
    names = mesh.group_names
    case.check("... blocks that are there", now.built, np.isin(mesh.block_group, [names.index("rock"), names.index("lift_1")]).astype(float), absolute=0)
    case.check("... the others have no stress", bool(np.isnan(now.stress[now.built == 0]).all() and np.isfinite(now.stress[now.built == 1]).all()), True)
    case.check("... contacts at them", int((now.built[now.contacts.face[:, [0, 2]]] == 0).sum()), 0)
    case.check("... they stay where they are [m]", np.abs(result.probe("wet", "top_3")).max(), 0.0, absolute=0)


def reset(case):
    """Displacements count from zero, stresses stay."""
    whole = on_rock_scene()
    keep = changed(whole, ("stages", [{name: {k: v for k, v in keys.items() if k != "displacements"}} for stage in whole["stages"][:4] for name, keys in stage.items()]))
    anew, kept = case.run(on_rock(), changed(whole, ("stages", whole["stages"][:4]))), case.run(on_rock(), keep)
    case.check("reset: checksums and stresses are the same", [anew.stage_summary("second")["checksum"] == kept.stage_summary("second")["checksum"], bool(np.array_equal(anew.stage("second").stress, kept.stage("second").stress, equal_nan=True))], [True, True])
    before, a, k = kept.stage("rock").displacement, anew.stage("second"), kept.stage("second")
    case.check("... displacements count from the end of stage rock [m]", a.displacement, k.displacement - before, absolute=1e-15)
    mesh, c = anew.mesh, a.contacts
    at = [[np.flatnonzero(np.abs(mesh.vertices - p).max(axis=1) < 1e-9) for p in ends] for ends in c.point]
    same = [np.abs(a.displacement[v] - d).max(axis=1).min() for ends, moved in zip(at, c.displacement, strict=True) for v, d in zip(ends, moved, strict=True)]
    case.check("... points of joints move as the vertices there [m]", same, 0.0, absolute=1e-15)
    case.check("... probe, largest [m]", [anew.probe("second", "top_1")[1], anew.stage_summary("rock")["checksum"] == kept.stage_summary("rock")["checksum"]], [kept.probe("second", "top_1")[1], True], relative=1e-9)


def anchored(case):
    """Ties from the first lift to the second, which come with it: soft ones, so the settlements are those of the column by hand."""
    k, T, shares = 1e3, 5e5, 10 * GAMMA / E
    second = {5: -shares * 5, 15: -shares * 10 - GAMMA / E * (10 * 5 - 12.5)}  # what the second lift settles
    third = {y: -shares * y for y in second}
    def tie(**keys):
        return {"head": [1, 15], "root": [1, 5], "young": 200e9, "area": k * 10 / 200e9} | keys
    ties = {"bar": tie(compression=True, **{"from": "s2"}), "later": tie(compression=True, **{"from": "s3"}), "tendon": tie(prestress=T, lock="s2"),
            "bonded": tie(bond_stiffness=1e12, plate=True, segment=2.5, **{"from": "s2"})}  # fmt: skip
    mesh = lifted(renamed(rectangle(0, 0, 2, H, 1, 12, group="x"), {"bottom": "bottom"}), 3)
    whole = changed(scene(3, supports={"bottom": {"fix": "xy"}}), ("anchors", ties))
    folder = case.prepare(mesh, changed(whole, ("checkpoint", {"every": 2000, "keep": 1000})))
    for method in ("explicit", "preconditioned"):
        result = case.again(folder) if method == "explicit" else case.run(mesh, changed(whole, ("relaxation.method", method)))
        def force(stage, name, result=result):
            return result.stage_summary(stage)["anchors"][name]["force"]
        bare = case.run(mesh, changed(whole, ("anchors", {name: ties[name] for name in ("bar", "later")}), ("relaxation.method", method)))
        case.check(f"ties between lifts, {method}: they come with the second lift: states", [result.stage_summary("s1")["anchors"][name]["state"] for name in ties], ["absent"] * 4)
        case.check("... without the tendon: a bar presses as the second lift settles, then the third [N]", [force(stage, "bar", bare) for stage in ("s2", "s3")],
                   np.cumsum([k * (u[15] - u[5]) for u in (second, third)]), relative=1e-5)
        case.check("... one that comes with the third [N]", force("s3", "later", bare), k * (third[15] - third[5]), relative=1e-5)
        case.check("... a tendon that is stressed as the second comes [N]", force("s2", "tendon"), T, relative=1e-9)
        case.check("... loses as the third comes [N]", force("s3", "tendon") - T, k * (third[15] - third[5]), relative=1e-5)
    first = case.again(folder)
    sums = [stage["checksum"] for stage in first.summary["stages"]]
    for ranks in case.ranks(2, 3):
        case.check(f"... {ranks} ranks: checksums", [stage["checksum"] for stage in case.run(mesh, whole, ranks=ranks).summary["stages"]], sums)
    case.again(folder, "-output", "kept")
    kept = sorted((folder / "kept" / "checkpoints").iterdir())
    for at in (len(kept) // 2, len(kept) - 2):
        again = case.again(folder, "-restart", kept[at], ranks=2)
        case.check(f"... restart from checkpoint {at} of {len(kept)}: checksums", [stage["checksum"] for stage in again.summary["stages"]], sums)
        case.check("... forces", [stage["anchors"] for stage in again.summary["stages"]] == [stage["anchors"] for stage in first.summary["stages"]], True)
    for name, keys, key in (("bar", {"from": "s1"}, "head"), ("tendon", {"lock": "s1"}, "head"), ("bonded", {"from": "s1", "plate": False}, "")):
        result = case.run(mesh, changed(whole, ("anchors", {name: ties[name] | keys})))
        words = f"anchors.{name}{'.' * bool(key)}{key}: the group lift_2, which holds it, is not built yet in stage s1, from which on it is there"
        case.check(f"refused: {words}", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])


def ranks_and_restart(case):
    """The same bits on 1 to 4 ranks; restarts between lifts and within one, in trials behind them."""
    mesh = on_rock()
    for measure in ("small", "large"):
        one = changed(on_rock_scene(), ("strain", measure), ("checkpoint", {"every": 200, "keep": 1000}))
        folder = case.prepare(mesh, one)
        first = case.again(folder)
        case.again(folder, "-output", "kept")
        def answers(result):
            return [stage["checksum"] for stage in result.summary["stages"]], [result.stage(name).displacement.tobytes() for name in result.stages]
        case.check(f"{measure} strain: all stages run", {stage["verdict"] for stage in first.summary["stages"]}, {"converged"})
        for ranks in case.ranks(*((2, 3, 4) if measure == "small" else (2,))):
            case.check(f"... the same on {ranks} ranks", answers(case.run(mesh, one, ranks=ranks)) == answers(first), True)
        kept = sorted((folder / "kept" / "checkpoints").iterdir())
        for i, at in enumerate((len(kept) // 8, len(kept) // 4, len(kept) // 2, len(kept) - 2)):
            again = case.again(folder, "-restart", kept[at], ranks=1 + i % 2)
            case.check(f"... restart from checkpoint {at} of {len(kept)}: the same", answers(again) == answers(first), True)


def refused(case):
    """What only the mesh shows."""
    whole = on_rock_scene()
    stages = whole["stages"]
    second = {"second": {"loads": ["weight"], "build": ["lift_3"]}}
    for change, words in (
        (("stages", [stages[0], stages[1], second, {"third": {"loads": ["weight"], "build": ["lift_2"]}}]), "stages.second: group lift_3 hangs in the air (block"),
        (("stages", [*stages[:4], {"again": {"loads": ["weight"], "build": ["lift_1"]}}]), "stages.again: build: the group lift_1 is built twice"),
        (("materials.lift_2", {"density": RHO, "young": 1e10, "poisson": 0.2, "condensed": True}), "stages.second: build: the group lift_2 is condensed"),
        (("materials.lift_2", {"density": RHO, "rigid": True}), "stages.second: build: the group lift_2 is rigid"),
        (("stages", [*stages[:3], {"shake": {"type": "dynamic", "loads": ["weight"]}}, stages[3]]), "stages.shake: groups are not built yet: expected a static stage"),
        (("stages", [stages[0], {"wet": {"loads": ["weight", "water"]}}, *stages[1:4]]), "stages.wet: loads.water acts where groups are not built yet"),
        (("loads.water", {"type": "traction", "faces": "up", "value": [1, 0]}, ), None),
        (("stages", [stages[0], {"first": {"loads": ["weight"], "build": ["lift_9"]}}]), "stages.first.build: the mesh has no group 'lift_9'"),
    ):  # fmt: skip
        one = changed(whole, change)
        if words is None:
            one = changed(one, ("stages", [stages[0], stages[1], {"pulled": {"loads": ["weight", "water"]}}, *stages[2:4]]))
            words = "stages.pulled: loads.water acts where groups are not built yet"
        result = case.run(on_rock(), one)
        case.check(f"refused: {words}", [result.exit_code, words in result.stderr, result.stderr.count("\n")], [2, True, 1])
    result = case.run(on_rock(), changed(whole, ("strain", "large"), ("contact", {"connectivity": "variable"})))
    case.check("refused: variable connectivity", [result.exit_code, "connectivity is variable, and groups are built" in result.stderr], [2, True])
