"""A first scene for a section: it runs, it has the names of the mesh, and says which of its values are examples."""

import numpy as np
import shapely

from quoin_tools.mesh.blockmesh import face_ends


def draft(plan, mesh, model, title=""):
    """Writes a scene (docs/scene.md). plan: of which the mesh was made; model: its path."""
    joints = list(dict.fromkeys(line.name for line in plan.lines if line.joint and line.name in mesh.face_sets))
    rock = [name for name in mesh.group_names if name in ("rock", "ground", "foundation")]
    rows = [f"# A draft: it runs, but its values are examples. Put yours in.\ntitle: {title or 'Draft'}\nmodel: {model}", "materials:"]
    for name, rigid in zip(mesh.group_names, mesh.group_rigid):
        rows.append(f"  {name}: {{density: {2600 if name in rock else 2400}" + ("}" if rigid else ", young: 20e9, poisson: 0.2}") + "  # example")
    rows += ["joints:", "  default: {k_n: 10e9, k_s: 4e9, friction: 45}  # example"]
    rows += [f"  {name}: {{friction: 45, cohesion: 0, tension: 0}}  # example{within}" for name, within in joint_rows(mesh, joints)]
    rows += ["supports:", *supports(mesh)]
    level, stages = water_level(mesh), [("weight", ["weight"])]
    rows += ["loads:", f"  weight: {{type: self_weight, groups: [{', '.join(name for name in mesh.group_names if name not in rock)}]}}"]
    if level is not None:
        rows.append(f"  water: {{type: reservoir, faces: upstream, level: {level:.6g}}}  # example: up to the crest")
        stages.append(("full", ["weight", "water"]))
        if "base" in joints:
            rows.append(f"  uplift: {{type: uplift, faces: base, level: {level:.6g}{drain_words(plan, mesh)}}}")
            stages.append(("uplifted", ["weight", "water", "uplift"]))
    if plan.anchors:
        rows.append("anchors:")
        rows += [f"  {name}: {{head: {point(a)}, root: {point(b)}, area: 3e-3, young: 195e9, yield: 1670e6, spacing: 3}}  # example" for name, (a, b) in plan.anchors.items()]
    rows += ["stages:", *(f"  - {name}: {{loads: [{', '.join(loads)}]}}" for name, loads in stages)]
    return "\n".join(rows) + "\n"


def joint_rows(mesh, names):
    """Returns (name, words about the sets within it) of each joint that is no part of another one: the solver refuses a row without contacts."""
    sets = {name: set(map(tuple, mesh.face_sets[name].tolist())) for name in names}
    outer = [name for k, name in enumerate(names) if not any(sets[name] < sets[other] or (sets[name] == sets[other] and n < k) for n, other in enumerate(names))]
    rows = []
    for name in outer:
        parts = [other for other in names if sets[other] < sets[name]]
        remark = f"; {parts[0]} to {parts[-1]} are parts of it:" if len(parts) > 2 else f"; {' and '.join(parts)} {'are parts' if len(parts) > 1 else 'is part'} of it:"
        rows.append((name, f"{remark} a row of a part counts before this one" if parts else ""))
    return rows


def point(xy):
    return f"[{xy[0]:.6g}, {xy[1]:.6g}]"


def supports(mesh):
    """Sides on rollers, bottom held; without rock the base; else the lowest outline has to be named by hand."""
    sides = [name for name in mesh.face_sets if name.endswith("_sides")]
    bottoms = [name for name in mesh.face_sets if name.endswith("_bottom")]
    if bottoms:
        return [f"  {name}: {{fix: x}}" for name in sides] + [f"  {name}: {{fix: {'y' if sides else 'xy'}}}" for name in bottoms]
    held = "base" if "base" in mesh.face_sets else next(iter(mesh.face_sets), "base")
    return [f"  {held}: {{fix: xy}}  # example: what holds the model"]


def water_level(mesh):
    """Top of the face set upstream."""
    rows = mesh.face_sets.get("upstream", ())
    return float(mesh.vertices[face_ends(mesh, rows)][..., 1].max()) if len(rows) else None


def drain_words(plan, mesh):
    """Keys of the drain nearest to the heel that crosses the base, with its distance along it from the end on the side of the face set upstream."""
    base = np.concatenate([np.asarray(line.points) for line in plan.lines if line.name == "base"])
    base = shapely.LineString(base[np.argsort(base[:, 0], kind="stable")])
    wet = mesh.vertices[face_ends(mesh, mesh.face_sets.get("upstream", ()))][..., 0]
    base = base.reverse() if wet.size and wet.mean() > base.centroid.x else base
    found = [base.project(cut.centroid) for ends in plan.drains.values() if not (cut := base.intersection(shapely.LineString(ends))).is_empty]
    return f", rule: npb, drain: {min(found):.6g}" if found else ""
