"""Condensed bodies against the whole elastic solution: a beam against a direct solution of the same elements, G1 with
an elastic and with a frictional base, one macroblock of condensed, deformable and rigid parts, a wall of all three kinds
of bodies on 1 to 4 ranks, a strength reduction, and where the assumptions end."""

import json
import re

import numpy as np
from driver import REFERENCE, changed, load
from quoin_tools.mesh.dam import dam_mesh
from quoin_tools.mesh.meshing import join, rectangle, renamed
from quoin_tools.mesh.stacks import block_grid, cantilever, column
from reference_mesh import from_reference
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

WHAT = "condensed bodies: the whole elastic solution from the vertices where bodies meet"
SOURCE = "direct solution of the same 4-node elements (scipy); the same scene without `condensed`"
BY = "independent direct solution of this project; Quoin itself, not condensed"

RHO, GRAVITY, E, NU = 2400.0, 9.81, 10e9, 0.2
SHEAR = 1e5  # [Pa] on the end of the beam
TIGHT = {"tolerance": 1e-12, "velocity_tolerance": 1e-12}
ELASTIC = {"density": RHO, "young": E, "poisson": NU}
BEAM = {
    "strain": "small",
    "relaxation": TIGHT,
    "materials": {"body": ELASTIC | {"condensed": True}},
    "supports": {"left": {"fix": "xy"}},
    "loads": {"weight": {"type": "self_weight"}, "push": {"type": "traction", "faces": "right", "value": [0, -SHEAR]}},
    "stages": [{"both": {"loads": ["weight", "push"]}}],
}


def run(case):
    beam(case)
    guilhofrei(case)
    shared_vertices(case)
    hardly_inside(case)
    wall_on_ranks(case)
    reduction(case)
    left_to_the_program(case)
    large_strain(case)
    begins_again(case)
    static_stages(case)
    ends_of_the_assumptions(case)


# ---- a beam, by hand

def element_stiffness(x):
    """(8,8) plane strain, 2 x 2 Gauss points; x: (4,2)."""
    D = E / (1 + NU) / (1 - 2 * NU) * np.array([[1 - NU, NU, 0], [NU, 1 - NU, 0], [0, 0, 0.5 - NU]])
    K, corners = np.zeros((8, 8)), np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for point in corners / np.sqrt(3):
        dN = corners * (1 + point * corners)[:, ::-1] / 4
        J = dN.T @ x
        dN = np.linalg.solve(J, dN.T)
        B = np.zeros((3, 8))
        B[0, 0::2], B[1, 1::2], B[2, 0::2], B[2, 1::2] = dN[0], dN[1], dN[1], dN[0]
        K += B.T @ D @ B * np.linalg.det(J)
    return K


def direct(mesh):
    """Displacements (n,2) of the beam, held at x = 0, under weight and end traction."""
    n, dofs = len(mesh.vertices), (2 * mesh.blocks[:, :, None] + [0, 1]).reshape(-1, 8)
    K = np.array([element_stiffness(mesh.vertices[block]) for block in mesh.blocks])
    K = coo_array((K.ravel(), (np.repeat(dofs, 8, axis=1).ravel(), np.tile(dofs, 8).ravel())), (2 * n, 2 * n)).tocsr()
    f, right = np.zeros(2 * n), np.flatnonzero(mesh.vertices[:, 0] > mesh.vertices[:, 0].max() - 1e-9)
    area = 10.0 * 1.0 / len(mesh.blocks)
    np.add.at(f, 2 * mesh.blocks.ravel() + 1, -RHO * GRAVITY * area / 4)
    ends = right[np.argsort(mesh.vertices[right, 1])]
    for a, b in zip(ends, ends[1:]):
        f[[2 * a + 1, 2 * b + 1]] -= SHEAR * (mesh.vertices[b, 1] - mesh.vertices[a, 1]) / 2
    free = np.flatnonzero(np.repeat(mesh.vertices[:, 0] > 1e-9, 2))
    u = np.zeros(2 * n)
    u[free] = spsolve(K[free][:, free], f[free])
    return u.reshape(-1, 2)


def beam(case):
    mesh = cantilever(40, 6)
    result = case.run(mesh, BEAM)
    u, wanted = result.stage("both").displacement, direct(mesh)
    size = abs(wanted).max()
    case.check("beam of 240 blocks, four corners kept: displacements over the largest", u / size, wanted / size, absolute=1e-9)
    stage = result.stage_summary("both")
    total = RHO * GRAVITY * 10 + SHEAR
    case.check("... reaction inside the body and applied force [N]", [stage["reaction"]["y"], -stage["applied"]["y"]], total,
               relative=1e-9)
    case.check("... degrees of freedom", result.summary["n_dofs"], 8)


# ---- G1

def condensed(scene, *groups):
    return changed(scene, *((f"materials.{group}.condensed", True) for group in groups))


def compare(case, what, whole, reduced, stage, tolerance):
    """Displacements and stresses of all blocks, joint stresses and resultants, over the largest of the whole solution."""
    a, b = whole.stage(stage), reduced.stage(stage)
    for name, ours, wanted in (("displacements", b.displacement, a.displacement), ("stresses", b.gauss_stress, a.gauss_stress),
                               ("joint stresses", b.contacts.sigma, a.contacts.sigma), ("slip", b.contacts.sliding, a.contacts.sliding)):
        size = np.nanmax(abs(wanted))
        case.check(f"{what}: {name}, over the largest", np.nan_to_num(ours) / size, np.nan_to_num(wanted) / size,
                   absolute=tolerance)
    forces = [[run.stage_summary(stage)[kind][axis] for kind in ("applied", "reaction") for axis in "xy"] for run in (whole, reduced)]
    size = abs(np.array(forces[0])).max()
    case.check(f"{what}: applied force and reaction, over the largest", np.array(forces[1]) / size,
               np.array(forces[0]) / size, absolute=max(tolerance, 1e-8))


def guilhofrei(case):
    g1 = load("guilhofrei")
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    tight = ("relaxation", g1.SCENE["relaxation"] | {"tolerance": 1e-11, "velocity_tolerance": 1e-11})
    elastic, friction = changed(g1.SCENE, tight), changed(g1.FRICTION, tight)
    newton = ("relaxation.method", "preconditioned")
    jobs = [elastic, condensed(elastic, "dam", "rock"), condensed(elastic, "rock"),
            friction, condensed(friction, "dam", "rock"),
            changed(condensed(elastic, "dam", "rock"), newton), changed(friction, newton),
            changed(condensed(friction, "dam", "rock"), newton)]
    whole, both, rock, slipping, both_slip, direct_solve, slip_newton, both_newton = case.run_all([(mesh, scene) for scene in jobs])
    for stage in ("SW", "HP", "SWHP_el"):
        compare(case, f"G1, dam and rock, {stage}", whole, both, stage, 1e-8)
    compare(case, "G1, rock only, SWHP_el", whole, rock, "SWHP_el", 1e-8)
    compare(case, "G1, dam and rock, Newton's method, SWHP_el", whole, direct_solve, "SWHP_el", 1e-8)
    compare(case, "G1, frictional base, Newton's method on both", slip_newton, both_newton, "SWHP_nl", 1e-8)
    compare(case, "G1, frictional base, explicit", slipping, both_slip, "SWHP_nl", 1e-4)  # the slip depends on the way there
    with open(REFERENCE / "guilhofrei_g1.json", encoding="utf-8") as file:
        reference = json.load(file)["12"]
    case.check("G1, SW, HP, SW+HP: crest u_x [mm] (implicit finite elements)",
               [both.probe(stage, "crest_upstream")[0] * 1e3 for stage in ("SW", "HP", "SWHP_el")],
               [reference[stage]["crest"] for stage in ("SW", "HP", "SWHP_el")], relative=1e-5)


# ---- bodies of several kinds

def shared_vertices(case):
    """A beam whose left third is deformable, the middle condensed, the end rigid: they share vertices."""
    mesh = cantilever(30, 4, 6.0)
    mesh.group_names, mesh.group_rigid = ["root", "middle", "end"], np.array([0, 0, 1], dtype=np.int32)
    mesh.block_group = np.minimum(mesh.centres()[:, 0] // 2.0, 2).astype(np.int32)
    end = {"density": RHO, "rigid": True}
    scene = changed(BEAM, ("materials", {"root": ELASTIC, "middle": ELASTIC | {"condensed": True}, "end": end}))
    whole = case.run(mesh, changed(scene, ("materials.middle", ELASTIC)))
    for ranks in (1, 2):
        compare_moved(case, f"one macroblock of three kinds, {ranks} ranks", whole, case.run(mesh, scene, ranks=ranks), 1e-8)


def hardly_inside(case):
    """A beam one block high whose vertices are all kept but for two: MUMPS guesses its work space by these two."""
    mesh = cantilever(40, 1)
    mesh.face_sets["kept"] = np.array([(block, side) for side in (0, 2) for block in range(len(mesh.blocks)) if not (side and 20 <= block < 23)], dtype=np.int32)
    scene = changed(BEAM, ("joints", {"kept": {"law": "elastic", "k_n": 1e10, "k_s": 1e10}}))
    # the row keeps vertices of a condensed body; beside a body that is not condensed a row without contacts is refused
    whole = case.run(mesh, changed(BEAM, ("materials.body.condensed", False), ("relaxation.method", "preconditioned")))
    compare_moved(case, "a beam with two vertices inside", whole, case.run(mesh, scene), 1e-7)


def compare_moved(case, what, whole, reduced, tolerance):
    a, b = whole.stage(), reduced.stage()
    size, most = abs(a.displacement).max(), np.nanmax(abs(a.stress))
    case.check(f"{what}: displacements over the largest", b.displacement / size, a.displacement / size, absolute=tolerance)
    case.check(f"{what}: stresses over the largest", np.nan_to_num(b.stress) / most, np.nan_to_num(a.stress) / most,
               absolute=tolerance)
    for kind in ("applied", "reaction"):
        sums = [[run.stage_summary(run.summary["stages"][-1]["name"])[kind][axis] for axis in "xy"] for run in (whole, reduced)]
        case.check(f"{what}: {kind} [N]", sums[1], sums[0], absolute=1e-6 * abs(np.array(sums)).max())


def wall():
    """6 x 6 bodies of 5 x 4 blocks: rows of condensed, deformable and rigid ones in turn, friction between."""
    mesh = block_grid(6, 6, 5, 4, triangle_every=5)
    row = np.minimum(mesh.centres()[:, 1].astype(int), 5)
    mesh.block_group = (row % 3).astype(np.int32)
    mesh.group_names, mesh.group_rigid = ["rock", "dam", "top"], np.array([0, 0, 1], dtype=np.int32)
    grid = load("ranks").GRID
    materials = {"rock": ELASTIC | {"condensed": True}, "dam": ELASTIC, "top": {"density": RHO, "rigid": True}}
    return mesh, changed(grid, ("materials", materials), ("stages", [{"weight": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}}]),
                         ("loads.push.value", [5e3, -1e5]), ("relaxation", {"tolerance": 1e-9, "ramp": 2000}))


def wall_on_ranks(case):
    mesh, scene = wall()
    results = [case.run(mesh, scene, ranks=ranks) for ranks in case.ranks(1, 2, 3, 4)]
    checksums = [" ".join(stage["checksum"] for stage in result.summary["stages"]) for result in results]
    slip = abs(results[0].stage().contacts.slip).max()
    cycles = sum(stage["cycles"] for stage in results[0].summary["stages"])
    case.check(f"wall of condensed, deformable and rigid bodies, 1 to 4 ranks ({cycles} cycles, slip {slip:.1e} m): checksums",
               json.dumps(sorted(set(checksums))), json.dumps([checksums[0]]))
    with_stress = [json.dumps(result.summary["stages"][-1]["stress"]) for result in results]
    case.check("... different extremes of the recovered stresses", len(set(with_stress)), 1)
    whole = case.run(mesh, changed(scene, ("materials.rock.condensed", False)))
    # large strain in the scene, small in the condensed bodies: strains are some 1e-5
    compare_moved(case, "... against the same wall, nothing condensed", whole, results[0], 1e-3)


# ---- many stages, one factor

def reduction(case):
    g1 = load("guilhofrei")
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    stages = [{"swhp": {"loads": ["weight", "water"]}},
              {"s1": {"type": "strength_reduction", "what": "friction", "loads": ["weight", "water"], "step": 5,
                      "limit": 10, "bracket": 0.1}}]
    scene = changed(g1.FRICTION, ("stages", stages), ("relaxation", {"tolerance": 1e-8}))
    whole, reduced = case.run_all([(mesh, scene), (mesh, condensed(scene, "dam", "rock"))])
    ends = [[run.stage_summary("s1")["strength_reduction"][end] for end in ("stable", "failing")] for run in (whole, reduced)]
    case.check("strength reduction: last stable and first failing angle [degree]", ends[1], ends[0], relative=1e-12)
    case.check("... crest u_x of the last stable state [m]", reduced.probe("s1", "crest_upstream")[0],
               whole.probe("s1", "crest_upstream")[0], relative=1e-3)
    a, b = whole.stage("s1").mechanism, reduced.stage("s1").mechanism
    case.check("... mechanism, over the largest velocity", b, a, absolute=0.02)
    case.check("... factors", reduced.summary["condensed"]["factors"], 2)


def left_to_the_program(case):
    """A scene that leaves the key out: condensed where it pays and changes nothing, with the bits of condensed: true; else with those of false."""
    g1 = load("guilhofrei")
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    trials = {"type": "strength_reduction", "what": "friction", "loads": ["weight", "water"], "step": 10, "limit": 25, "bracket": 2}
    scene = changed(g1.FRICTION, ("strain", "small"), ("stages", [{"swhp": {"loads": ["weight", "water"]}}, {"s1": trials}]),
                    ("relaxation", {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "method": "explicit"}), ("checkpoint", {"every": 500, "keep": 100}))
    both = [("materials.dam.condensed", True), ("materials.rock.condensed", True)]
    folder = case.prepare(mesh, scene)
    open_ = case.again(folder)
    given, whole = case.run_all([(mesh, changed(scene, *both)), (mesh, changed(scene, *((key, False) for key, _ in both)))])

    def bits(run):
        return [stage["checksum"] for stage in run.summary["stages"]]

    case.check("left to the program: condensed", [open_.summary["condensed_groups"], open_.summary["condensed_choice"].split(",")[0], "chosen: condensed: dam, rock" in open_.stdout],
               [["dam", "rock"], "condensed: dam", True])
    case.check("... with the bits of condensed: true", bits(open_), bits(given))
    case.check("... and on 2 ranks", bits(case.run(mesh, scene, ranks=2)), bits(open_))
    compare(case, "... against the blocks", whole, open_, "swhp", 1e-4)  # slip depends on the way there
    brackets = [[run.stage_summary("s1")["strength_reduction"][end] for end in ("stable", "failing")] for run in (whole, open_)]
    case.check("... last stable and first failing angle [degree]", brackets[1], brackets[0])
    files = sorted((folder / "out" / "checkpoints").glob("*.h5"))
    again = case.again(folder, "-restart", str(files[len(files) // 2]), ranks=2)
    case.check("... a restart goes on with them", [bits(again), again.summary["condensed_choice"]], [bits(open_), open_.summary["condensed_choice"]])
    newton = case.run(mesh, changed(scene, ("relaxation.method", "auto")))
    case.check("... method: auto counts their inner degrees of freedom", [stage["method"] for stage in newton.summary["stages"]], ["explicit", "preconditioned"])
    stages = [{"swhp": {"loads": ["weight", "water"]}}]
    for change, why in ((("stages", stages), "fewer than 1500"),
                        (("stages", [*stages, {"modes": {"type": "modes", "count": 1}}]), "stage modes is neither static nor of trials")):
        kept = [("relaxation.tolerance", 1e-3), ("relaxation.velocity_tolerance", 1e-3), ("stages", stages), change]
        left, false = case.run_all([(mesh, changed(scene, *kept)), (mesh, changed(scene, *kept, *((key, False) for key, _ in both)))])
        case.check(f"left as they are: {why}", [why in left.summary["condensed_choice"], bits(left)], [True, bits(false)])


def large_strain(case):
    """The same in large strain: corrected at each equilibrium, the bodies have the answer of their blocks."""
    g1 = load("guilhofrei")
    mesh = from_reference(REFERENCE / "mesh_guilhofrei_g1_n12.json")
    trials = {"type": "strength_reduction", "what": "friction", "loads": ["weight", "water"], "step": 10, "limit": 10, "bracket": 0.5}
    tight = {"tolerance": 1e-10, "velocity_tolerance": 1e-10, "method": "preconditioned"}
    scene = changed(g1.FRICTION, ("strain", "large"), ("stages", [{"swhp": {"loads": ["weight", "water"]}}, {"s1": trials}]), ("relaxation", tight))
    false, true = ([(f"materials.{group}.condensed", key) for group in ("dam", "rock")] for key in (False, True))
    whole, small, open_ = case.run_all([(mesh, changed(scene, *false)), (mesh, changed(scene, *true)), (mesh, scene)])
    case.check("large strain, left to the program: condensed, and said to be corrected", [open_.summary["condensed_groups"], open_.summary["condensed"]["large_strain"]],
               [["dam", "rock"], 1])
    compare(case, "... against the blocks, swhp", whole, open_, "swhp", 1e-8)
    compare(case, "... against the blocks, s1", whole, open_, "s1", 1e-5)  # slip depends on the way there
    off = abs(small.stage("swhp").displacement - whole.stage("swhp").displacement).max() / abs(whole.stage("swhp").displacement).max()
    case.check("... where bodies that are not corrected are off by more than 1e-4", bool(off > 1e-4), True)
    brackets = [[run.stage_summary("s1")["strength_reduction"][end] for end in ("stable", "failing")] for run in (whole, open_)]
    case.check("... last stable and first failing angle [degree]", brackets[1], brackets[0])
    explicit = changed(scene, ("relaxation", {"method": "explicit"}), ("checkpoint", {"every": 500, "keep": 100}))
    folder = case.prepare(mesh, explicit)
    once = case.again(folder)
    bits = [stage["checksum"] for stage in once.summary["stages"]]
    for ranks in (2, 3):  # one of three has no body
        case.check(f"... explicit cycles on {ranks} ranks: bits", [stage["checksum"] for stage in case.run(mesh, explicit, ranks=ranks).summary["stages"]], bits)
    files = sorted((folder / "out" / "checkpoints").glob("*.h5"))
    again = case.again(folder, "-restart", str(files[3 * len(files) // 4]), ranks=2)
    case.check("... and after a restart among the trials", [stage["checksum"] for stage in again.summary["stages"]], bits)


def begins_again(case):
    """A wall that tips: its condensed form cannot bear that, so the run begins again, and ends with the bits of its blocks."""
    ground = renamed(rectangle(-1.0, -1.0, 3.0, 1.0, 14, 3, "base", False), {"bottom": "bottom"})
    block = renamed(rectangle(0.0, 0.0, 1.0, 8.0, 6, 40, "block", False), {"left": "left"})
    rise = {"type": "load_factor", "loads": ["weight", "push"], "raises": ["push"], "step": 1, "limit": 200, "bracket": 1}
    scene = {"materials": {"block": ELASTIC, "base": ELASTIC}, "joints": {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 35}}, "supports": {"bottom": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "traction", "faces": "left", "value": [1e3, 0]}},
             "stages": [{"sw": {"loads": ["weight"]}}, {"rise": rise}]}  # fmt: skip
    false = [(f"materials.{group}.condensed", False) for group in ("block", "base")]
    whole, open_ = case.run_all([(join([ground, block]), changed(scene, *false)), (join([ground, block]), scene)])
    soft = changed(scene, ("relaxation", {"method": "explicit"}), ("materials.block.young", 1e8), ("stages", [scene["stages"][0], {"rise": rise | {"step": 0.4, "limit": 1.4}}]))
    ranks = case.run(join([ground, block]), soft, ranks=2)
    case.check("a wall that tips: the run begins again with its blocks", ["the run begins again, nothing condensed" in open_.stdout, open_.summary["condensed_choice"].split(":")[0]],
               [True, "not condensed"])
    case.check("... with their bits", [stage["checksum"] for stage in open_.summary["stages"]], [stage["checksum"] for stage in whole.summary["stages"]])
    brackets = [[run.stage_summary("rise")["load_factor"][end] for end in ("stable", "failing")] for run in (whole, open_)]
    case.check("... and their bracket", brackets[1], brackets[0])
    case.check("... on 2 ranks, where a soft wall turns far and stands", ["a body turns or strains too far" in ranks.stdout, ranks.stage_summary("rise")["load_factor"]["stable"]], [True, 1.4])
    case.check("... and a history without the first attempt", len(open_.history["stage"]), len(whole.history["stage"]))


def static_stages(case):
    """Stages without trials: a dam on its rock has the answer of its blocks, and one that slides off has their bits."""
    water = {"type": "reservoir", "faces": "upstream", "level": 30.0, "density": 1000}
    scene = {"relaxation": {"tolerance": 1e-10, "velocity_tolerance": 1e-10}, "materials": {"dam": ELASTIC, "rock": ELASTIC},
             "joints": {"default": {"k_n": 10e9, "k_s": 4e9, "friction": 45}}, "supports": {"rock_sides": {"fix": "x"}, "rock_bottom": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight", "groups": ["dam"]}, "water": water}, "stages": [{"sw": {"loads": ["weight"]}}, {"full": {"loads": ["weight", "water"]}}]}  # fmt: skip
    false, mesh = [(f"materials.{group}.condensed", False) for group in ("dam", "rock")], dam_mesh(columns=24)
    for strain, tolerance in (("small", 1e-8), ("large", 1e-7)):
        of = changed(scene, ("strain", strain))
        whole, open_ = case.run_all([(mesh, changed(of, *false)), (mesh, of)])
        case.check(f"static stages in {strain} strain: condensed", open_.summary["condensed_groups"], ["dam", "rock"])
        for stage in ("sw", "full"):
            compare(case, f"... against the blocks, {stage}", whole, open_, stage, tolerance)
    slides = changed(scene, ("strain", "large"), ("relaxation", {}), ("joints.default.friction", 15))
    whole, open_ = case.run_all([(mesh, changed(slides, *false)), (mesh, slides)])
    case.check("a dam that slides off: verdict", open_.stage_summary("full")["verdict"], "collapsed")
    case.check("... begins again with its blocks, and has their bits", ["the run begins again, nothing condensed" in open_.stdout, open_.stage_summary("full")["checksum"]],
               [True, whole.stage_summary("full")["checksum"]])  # fmt: skip


# ---- refusals

def refused(case, what, mesh, scene, words, *options):
    result = case.run(mesh, scene, *options)
    case.check(what, result.verdict if words in result.stderr else result.stderr, "bad input")


def ends_of_the_assumptions(case):
    mesh = column(1, rigid=False)
    scene = changed(load("stack").SCENE, ("materials.block.condensed", True))
    refused(case, "condensed and rigid", mesh, changed(scene, ("materials.block.rigid", True)), "choose one")
    dynamic = [{"fall": {"type": "dynamic", "duration": 0.1, "loads": ["weight"]}}]
    refused(case, "a dynamic stage", mesh, changed(scene, ("stages", dynamic)), "highest_frequency is missing")
    turned(case)
    leans(case)
    new_contact(case)


def turned(case):
    """A slender cantilever bends; over the rotations, the strain of linear rotation is reported, then refused."""
    mesh = cantilever(40, 2, 10.0, 0.2)
    scene = changed(BEAM, ("strain", "large"), ("relaxation", {"tolerance": 1e-8}), ("loads", {"push": BEAM["loads"]["push"]}),
                    ("stages", [{"push": {"loads": ["push"]}}]))
    told = case.run(mesh, changed(scene, ("loads.push.value", [0, -1e2])))
    case.check("a body turned a little: the run says so and goes on",
               [told.verdict, "linear rotation falsifies" in told.stderr], ["converged", True])
    refused(case, "a body turned too far", mesh, changed(scene, ("loads.push.value", [0, -1e5])),
            "more than 1 %: nothing of this stage is kept; do not condense its group")
    small = case.run(mesh, changed(scene, ("loads.push.value", [0, -1e5]), ("strain", "small")))
    case.check("... but not when the whole scene is in small strain", small.verdict, "converged")


def leans(case):
    """A slender column under its weight, pushed: weights act where condensed blocks were, which the run tells with its figure."""
    material = {"density": RHO, "young": 4e9, "poisson": 0.2}
    scene = {"relaxation": {"tolerance": 1e-9, "velocity_tolerance": 1e-9, "max_cycles": 400000},
             "materials": {"block": material, "base": {"density": RHO}},
             "joints": {"default": {"law": "elastic", "k_n": 4e9, "k_s": 2.5e9}}, "supports": {"base": {"fix": "xy"}},
             "loads": {"weight": {"type": "self_weight", "groups": ["block"]}, "push": {"type": "point_force", "point": "top", "value": [1e3, 0]}},
             "stages": [{"sw": {"loads": ["weight"]}}, {"pushed": {"loads": ["weight", "push"]}}]}
    for n, says in ((8, True), (3, False)):
        mesh = renamed(column(n, rigid=False, height=1.5), {}, {"top": f"block_{n}"})
        whole, part = case.run_all([(mesh, scene), (mesh, changed(scene, ("materials.block.condensed", True)))])
        way = [run.probe("pushed", "top")[0] - run.probe("sw", "top")[0] for run in (whole, part)]
        off, said = abs(way[1] / way[0] - 1), re.search(r"displacements are off by about (\S+) %", part.stderr)
        case.check(f"column of {n} condensed blocks, large strain: reported that weights act where blocks were", bool(said), says)
        if said:
            case.check("... by how much [%]: of the run without", float(said[1]), 100 * off, relative=0.1)
        else:
            case.check("... off by less than 0.3 %", bool(off < 0.003), True)


def new_contact(case):
    """A block on a condensed base is pushed along it, off the faces that the base keeps."""
    ground = renamed(rectangle(-2.0, -1.0, 5.0, 1.0, 50, 4, "base", False), {"bottom": "bottom"})
    block = renamed(rectangle(0.0, 0.0, 1.0, 1.0, 1, 1, "block", True), {"left": "left"})
    scene = {
        "contact": {"connectivity": "variable"}, "relaxation": {"tolerance": 1e-6, "ramp": 500, "max_cycles": 20000},
        "materials": {"block": {"density": RHO, "rigid": True}, "base": ELASTIC | {"condensed": True}},
        "joints": {"default": {"k_n": 10e9, "k_s": 3e9, "friction": 10}},
        "supports": {"bottom": {"fix": "xy"}},
        "loads": {"weight": {"type": "self_weight", "groups": ["block"]},
                  "push": {"type": "traction", "faces": "left", "value": [1e4, 0]}},
        "stages": [{"weight": {"loads": ["weight"]}}, {"push": {"loads": ["weight", "push"]}}],
    }
    refused(case, "a contact on a face that is not kept", join([ground, block]), scene, "a contact has come to")
