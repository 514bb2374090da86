"""Writes the parts of the sheet about materials: strengths of blocks, blocks that have yielded or cracked, lifts and temperature stage by stage."""

from quoin_tools.assess.assessment import cell
from quoin_tools.base import laws
from quoin_tools.base.flow import printed
from quoin_tools.base.language import N_, _
from quoin_tools.show.hypertext import head, more_rows, notes, small, table

LAWS = {"elastic": N_("no limit"), "mohr_coulomb": N_("yields"), "damage": N_("cracks")}


def cell_of(value, factor, digits):
    return "-" if not isinstance(value, (int, float)) else cell(value * factor, digits)


def materials_table(case, blocks_of, most=None):
    """Materials of the scene, of `most` groups; the law and what it needs only where a group has one. blocks_of: words for the blocks of a group."""
    header = [_("group"), _("blocks"), _("density [kg/m³]"), "E [GPa]", "ν", "f_t [kPa]", "f_c [kPa]", "c [kPa]", "φ [°]"]
    rows = [[name, blocks_of(case, name), cell(m.get("density"), 0), cell_of(m.get("young"), 1e-9, 2),
             cell_of(m.get("poisson"), 1, 2), cell_of(m.get("tension"), 1e-3, 0), cell_of(m.get("compression"), 1e-3, 0),
             cell_of(m.get("cohesion"), 1e-3, 0), cell_of(m.get("friction"), 1, 1)] for name, m in case.scene.materials.items()]  # fmt: skip
    more = [(_("dilation [°]"), "dilation", 1, 1, any(m.get("law") == "mohr_coulomb" for m in case.scene.materials.values())),
            ("G_f [N/m]", "fracture_energy", 1, 0, any(m.get("law") == "damage" for m in case.scene.materials.values())),
            (_("expansion [10⁻⁶/K]"), "expansion", 1e6, 2, any(m.get("expansion") for m in case.scene.materials.values()))]  # fmt: skip
    for title, key, factor, digits, wanted in more:
        if wanted:
            header.append(title)
            for row, m in zip(rows, case.scene.materials.values(), strict=True):
                row.append(cell_of(m.get(key), factor, digits))
    limits = any(m.get("law", "elastic") != "elastic" for m in case.scene.materials.values())
    if limits:
        header.insert(2, _("strength"))
        for row, m in zip(rows, case.scene.materials.values(), strict=True):
            row.insert(2, _(LAWS[m.get("law", "elastic")]))
    words = small(_("Strength: “yields” and “cracks” are limits of the blocks' stress; with “no limit” the strengths count for the local failure factors alone."))
    more = more_rows(len(rows) - most) if most and len(rows) > most else ""
    return table(header, rows[:most], range(3 if limits else 2, len(header))) + more + (words if limits else "")


def loaded_rows(case):
    """Returns (stage, groups placed, displacements, temperature) of stages that have any of these."""
    scene, rows = case.scene, []
    for s in case.results.summary["stages"]:
        keys, warmth = scene.stages.get(s["name"], {}), s.get("temperature")
        placed, reset = scene.placed(s["name"]), keys.get("displacements") == "reset"
        names = [name for name in keys.get("loads") or [] if scene.loads.get(name, {}).get("type") == "temperature"]
        if placed or reset or names:
            area = sum(area for name, area in laws.areas_of(case.results.mesh).items() if name in placed)
            rows.append((s["name"], ", ".join(placed) or "-", cell(area, 1) if placed else "-", _("count from here") if reset else _("go on"), ", ".join(names) or "-",
                         printed(warmth["min"] if warmth and names else None, "+.2f"), printed(warmth["max"] if warmth and names else None, "+.2f")))  # fmt: skip
    return rows


def history_part(case):
    """Lifts and temperature among the loads; nothing without."""
    rows = loaded_rows(case)
    if not rows:
        return ""
    return (head(_("Lifts and temperature"), 3)
            + table((_("stage"), _("placed as it begins"), _("their area [m²]"), _("displacements"), _("temperature"), _("least change [K]"), _("largest change [K]")), rows, (2, 5, 6))
            + small(_("What is placed is without stress, in the geometry that has settled; before, it has no weight, no contact and no water on it. Changes of "
              "temperature are those at the centres of blocks, against the temperature without stress; they load no joint as a whole, so the gravity method has "
              "none. In stages not listed nothing is placed and no temperature acts.")))  # fmt: skip


def law_rows(case, s):
    """Each group that can yield or crack, in one stage."""
    areas, rows = laws.areas_of(case.results.mesh), []
    cracks = laws.open_cracks(case.results.mesh, case.results.stage(s["name"]))
    for (group, facts), row in zip(laws.laws_of(s).items(), laws.rows(s), strict=True):
        mine = case.results.mesh.block_group == case.results.mesh.group_names.index(group) if group in case.results.mesh.group_names else []
        part = cell(100 * facts["area"] / areas[group], 1) if areas.get(group) else "-"
        rows.append((s["name"], *row[:6], part, row[6], cell(cracks[mine].sum(), 2) if "crack_width" in facts else "-", row[7]))
    return rows


def laws_part(case):
    """Lists the blocks that have yielded or cracked in each stage, and the energy there."""
    stages = [s for s in case.results.summary["stages"] if laws.laws_of(s)]
    if not stages:
        return ""
    rows = [row for s in stages for row in law_rows(case, s)]
    kinds = list(dict.fromkeys(kind for s in stages for kind, _ in laws.energies(s)))
    energies = [(s["name"], *(printed(dict(laws.energies(s)).get(kind), ".4g") for kind in kinds)) for s in stages]
    quiet = [] if any(facts["blocks"] for s in stages for facts in laws.laws_of(s).values()) else [_("No block has yielded or cracked: in all stages the answer is that of elastic blocks.")]
    header = (_("stage"), _("group"), _("measure"), _("largest"), _("at [m]"), _("blocks with any"), _("area [m²]"), _("of the group [%]"), _("widest crack [mm]"), _("open cracks [m]"), _("lost [J]"))
    return (head(_("Blocks that yield or crack")) + notes(quiet) + table(header, rows, (3, 5, 6, 7, 8, 9, 10)) + head(_("Energy by kind [J]"), 3)
            + table((_("stage"), *kinds), energies, range(1, 1 + len(kinds)))
            + small(_("Each block counts with the worst of its points. Plastic strain: sum of √(2/3 dε:dε), it never goes down. Damage: part of the stiffness across a crack "
              "that is gone. Open cracks: way through blocks whose damage is above 0.5, as far as they are open now; in bending and where cracks fan out a "
              "crack of the masonry counts in several blocks. Energies are of the whole slice at the end of the stage; what is lost is counted from the start "
              "of the run. In a stage of trials all is of the last stable one.")))  # fmt: skip
