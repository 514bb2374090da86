"""Transient water in the base of a dam: a curtain, drains, a level that falls or rises. The balance of water and that of forces by hand; ranks, methods,
connectivity, mirror images, a base cut finer, and the state of rest that the water goes to."""

import numpy as np
from methods import with_vertices
from quoin_tools.mesh.meshing import join, rectangle, renamed
from runs import Scene, Way, changed, elastic, frame, relative, solved
from twins import mirror

G, BALANCED = 9.81, 1e-6


def body(places, height, rigid, rows):
    """A block on rock, with nodes at these places of its base."""
    n = len(places) - 1
    rock = rectangle(0, -0.3 * height, n, 0.3 * height, n, 1, "rock", True)
    block = rectangle(0, 0, n, height, n, rows, "block", rigid)
    parts = [with_vertices(part, np.column_stack([np.interp(part.vertices[:, 0], np.arange(n + 1), places), part.vertices[:, 1]])) for part in (rock, block)]
    return join([renamed(parts[0], {"base": "top"}), renamed(parts[1], {"base": "bottom", "upstream": "left", "downstream": "right"}, {"crest": "top_left"})])


def transient(rng):
    rigid, width = bool(rng.random() < 0.6), float(rng.uniform(20, 40))
    height = float(width * rng.uniform(0.8, 1.3))
    n = int(rng.integers(4, 14))
    places = np.sort(np.concatenate([[0, width], rng.uniform(0.02, 0.98, n - 1) * width])) if rng.random() < 0.4 else np.linspace(0, width, n + 1)
    levels = [float(value * height) for value in rng.uniform(0.1, 0.75, 2)]
    k_n = float(10 ** rng.uniform(9, 10))
    row = {"k_n": k_n, "k_s": 0.5 * k_n, "friction": 60.0, "aperture": float(10 ** rng.uniform(-3.7, -3)), "aperture_residual": 1e-5}
    row["aperture"] += 2400 * G * height / k_n  # as wide under the weight
    if rng.random() < 0.5:
        row["aperture_max"] = row["aperture"] * 2
    loads = {"weight": {"type": "self_weight", "groups": ["block"]}, "toe": {"type": "head", "faces": "downstream", "level": float(rng.choice([0.0, 0.05 * height]))}}
    if loads["toe"]["level"]:
        loads["tail"] = {"type": "tailwater", "faces": "downstream", "level": loads["toe"]["level"]}
    for when, level in zip(("before", "after"), levels):
        loads |= {f"pool_{when}": {"type": "reservoir", "faces": "upstream", "level": level}, f"head_{when}": {"type": "head", "faces": "upstream", "level": level}}
    loads |= {"pool": {"type": "reservoir", "faces": "upstream", "level": levels[0], "levels": "levels.csv"}, "head": {"type": "head", "faces": "upstream", "level": levels[0], "levels": "levels.csv"}}
    more = ["toe"] + (["tail"] if "tail" in loads else [])
    edges = []
    if rng.random() < 0.7:
        at, wide = float(rng.uniform(0.05, 0.3) * width), float(rng.uniform(0.02, 0.08) * width)
        edges = [at - 0.5 * wide, at + 0.5 * wide]
        loads["curtain"] = {"type": "curtain", "from": [at, -1], "to": [at, 1], "width": wide, "factor": float(10 ** rng.uniform(-1.5, -0.2))}
        more.append("curtain")
    if rng.random() < 0.5:
        loads["drain"] = {"type": "drain", "joint": "base", "distance": float(rng.uniform(0.35, 0.6) * width), "gallery": float(rng.uniform(0, 0.1) * height)}
        if rng.random() < 0.6:
            loads["drain"]["conductance"] = float(10 ** rng.uniform(-7, -4))
        more.append("drain")
    duration = float(10 ** rng.uniform(1, 4.5))
    fast = float(rng.choice([0.01, 0.5, 1.0])) * duration
    go = {"type": "transient", "duration": duration, "loads": ["weight", "pool", "head", *more]}
    if rng.random() < 0.4:
        go["time_step"] = duration / int(rng.integers(5, 30))
    end = ["weight", "pool_after", "head_after", *more]
    keys = frame(materials={"rock": {"density": 0}, "block": {"density": 2400.0} if rigid else elastic(rng)}, joints={"default": row}, supports={"rock": {"fix": "xy"}}, loads=loads,
                 stages=[{"full": {"loads": ["weight", "pool_before", "head_before", *more]}}, {"go": go}, {"end": {"loads": end}}])
    keys["flow"] = {"tolerance": 1e-7}
    mesh = body(places, height, rigid, 1 if rigid else max(2, n // 2))
    files = {"levels.csv": f"0, {levels[0]}\n{fast}, {levels[1]}\n"}
    weight = 2400 * G * width * height
    def by_hand(run):
        for name, stage in run.stages().items():
            if stage["verdict"] != "converged":
                continue
            flow = stage["flow"]
            if "volume_error" in flow:
                yield f"{name}: balance of water {flow['volume_error']:.2g}", 0.0 if abs(flow["volume_error"]) <= BALANCED else np.inf
            row = next(iter(stage["joints"].values()))
            up = sum(part["uplift"] for part in flow["joints"].values())
            yield f"{name}: N and uplift against the weight", abs(row["N"] + up - weight) / weight
            p = run.results.stage(name).flow.pressure
            top = 1000 * G * max(*levels, loads["toe"]["level"], loads.get("drain", {}).get("gallery", 0.0))
            yield f"{name}: pressures within the heads", max(0.0, float(p.max() - top), float(-p.min())) / top
    scene = solved(Scene("transient", mesh, keys, by_hand=by_hand, files=files), ranks=(2, 3) if rng.random() < 0.3 else (2,))
    scene.ways["mirrored"] = mirror(scene)
    scene.ways["to rest at once"] = Way(keys=changed(keys, stages=[keys["stages"][0], keys["stages"][2]], loads={name: load for name, load in loads.items() if name not in ("pool", "head")}), last=True, slipped=False)
    if rigid:
        finer = np.unique(np.concatenate([places, [x for x in edges if 0 < x < width]]))
        finer = np.unique(np.concatenate([finer, 0.5 * (finer[1:] + finer[:-1])]))
        scene.ways["finer base"] = Way(mesh=body(finer, height, True, 1), compare=forces, agree=0.02)  # 4 contacts are coarse for a front
    return scene


def forces(one, other):
    """N, uplift, displacement of the crest at the end of each stage."""
    theirs = other.stages()
    for name, stage in one.stages().items():
        twin = theirs.get(name, {"verdict": "no"})
        if "undecided" in (stage["verdict"], twin["verdict"]):
            return
        if stage["verdict"] != twin["verdict"]:
            yield f"{name}: {stage['verdict']} against {twin['verdict']}", np.inf
            return
        numbers = [[*next(iter(s["probes"].values())).values()][:2] for s in (stage, twin)]
        yield f"{name}: crest", relative(*numbers, max(map(abs, numbers[0])))
        lifts = [sum(part["uplift"] for part in s["flow"]["joints"].values()) for s in (stage, twin)]
        yield f"{name}: uplift", relative(*lifts, max(abs(lifts[0]), 1.0))


KINDS = (transient,)
