"""Writes the load combinations of a guideline as loads and stages of a scene: a case for each whose numbers are known, a comment for each other.

    loads, stages = of_guideline("usace", Numbers(height=38.0, flood=38.5, tailwater=3.0))     lines of YAML
"""

import re
from dataclasses import dataclass, replace

import yaml

from quoin_tools.assess import guidelines, partial_factors

NUMBER = re.compile(r"^(?:\d+|[IVX]+A?|[A-G])\s+")  # before the name of a combination
FLOOD = re.compile(r"flood|highest")
OPERATING = re.compile(r"operating basis|\bOBE\b")
CLOGGED = re.compile(r"ineffective drains|drains out of work")
SHOCKS = ("obe", "quake")
LARGEST = 10.0  # k_h, as the solver takes it
RULE = "usace"  # of uplift at drains, where the guideline has none: any efficiency


@dataclass
class Numbers:
    """What a combination may need, in SI units; None: not known. obe, quake: k_h of the operating basis and of the largest earthquake."""

    height: float
    pool: float | None = None  # [m] normal level; None: the crest
    flood: float | None = None  # [m]
    tailwater: float | None = None  # [m]
    silt: float | None = None  # [m] its surface
    ice: float | None = None  # [N/m]
    drain: float | None = None  # [m] from the heel
    efficiency: float | None = None
    obe: float | None = None
    quake: float | None = None

    @property
    def level(self):
        return self.height if self.pool is None else self.pool

    def check(self):
        """Refuses numbers by which a case would be another one than its name says."""
        bounds = {"pool": (self.height, "up to the crest; water above it is --flood"), "tailwater": (self.level, "up to the pool"), "silt": (self.level, "up to the pool"), "ice": (None, "it pushes downstream"),
                  **dict.fromkeys(SHOCKS, (LARGEST, "the ground pushes the dam downstream; where a combination asks for it, upstream"))}  # fmt: skip
        for name, (most, why) in bounds.items():
            value = getattr(self, name)
            if value is not None and not (0 < value <= (most or value)) and (name, value) != ("tailwater", 0):
                raise guidelines.GuidelineError(f"--{name}: {value:g}: expected above 0" + (f" and not above {most:g}" if most else "") + f": {why}")
        if self.flood is not None and self.flood < self.level:
            raise guidelines.GuidelineError(f"--flood: {self.flood:g}: expected not below the pool, {self.level:g}")


@dataclass
class Made:
    """A case: its stage, the loads that act, where it starts from, its condition, what is missing, and what the guideline says."""

    name: str
    loads: list
    start: str
    condition: str
    missing: list
    says: str

    def line(self):
        if self.missing:
            return f"  # {self.says}\n  # - {self.name}: as {self.condition}; missing: {', '.join(self.missing)}"
        return f"  # {self.says}\n  - {self.name}: {{from: {self.start}, condition: {self.condition}, loads: [{', '.join(self.loads)}]}}"


def slug(name):
    return re.sub(r"\W+", "_", NUMBER.sub("", name).lower()).strip("_")


def made(guideline, one, numbers, start):
    """The case of a combination. start: the stage of the usual case, None for that case itself."""
    wants, never, asks = (set(one.get(key, ())) for key in ("with", "without", "asks"))
    says = f"{one['name']}: {one['loads']}"
    clogged = "drains" in never or bool(CLOGGED.search(says))
    flood, operating = bool(FLOOD.search(says)) and "earthquake" not in wants, bool(OPERATING.search(says))
    loads, missing = ["weight"], []

    def add(word, name, value, option):
        if value is not None:
            loads.append(name)
        elif word in wants | asks:
            missing.append(option)

    if "water" in wants:
        add("water", "flood" if flood else "water", numbers.flood if flood else numbers.level, "--flood")
        if "uplift" in wants | asks:
            loads.append(("uplift_flood" if flood else "uplift") + ("_clogged" if clogged else ""))
        if clogged and numbers.drain is None:
            missing.append("--drain (without drains the usual case is this one)")
        add("tailwater", "tail", numbers.tailwater, "--tailwater")
        add("silt", "silt", numbers.silt, "--silt")
        if "ice" in wants or ("ice" not in never and "ice" in one["loads"] and not flood):
            add("ice", "ice", numbers.ice, "--ice")
    if "earthquake" in wants:
        add("earthquake", ("obe" if operating else "quake") + ("_upstream" if "water" in never else ""), numbers.obe if operating else numbers.quake, "--obe" if operating else "--quake")
    conditions = [condition for condition in one["conditions"] if condition in guideline["conditions"]]
    condition = "earthquake" if "earthquake" in wants and "earthquake" in conditions else conditions[0]
    return Made(slug(one["name"]), loads, start if start and "water" in wants else "empty", condition, missing, says)


def design_of(guideline, case, known):
    """Returns (line of the stage that tries a case with design strengths and factored loads, {name of such a load: (load, its factor)}); (None, {}) where the guideline asks for none. known: as of loads_of.
    An action is taken as favourable or not by its kind: the sheet says where the dam has it the other way."""
    entry = guideline["conditions"].get(case.condition, {}).get("sliding_partial")
    if entry is None or case.missing or None in guidelines.partial_numbers(entry):
        return None, {}
    loads, raised = [], {}
    for load in case.loads:
        kind = partial_factors.kind_of(yaml.safe_load(known[load])[load])
        factor = partial_factors.pair(entry.get("actions") or {}, kind)[kind not in partial_factors.FAVOURABLE]
        loads.append(load if factor == 1 else f"{load}_x{factor:g}".replace(".", "p"))
        if factor != 1:
            raised[loads[-1]] = load, factor
    return f"  - {case.name}_design: {{from: {case.name}, loads: [{', '.join(loads)}], friction_factor: {entry['friction']:g}, cohesion_factor: {entry['cohesion']:g}}}", raised


def with_rest(case, cases):
    """A case with an earthquake, behind the stage of its loads without it where its uplift is not that of the stage from which it would start: the crack at rest is found there."""
    still = [load for load in case.loads if load.removesuffix("_upstream") not in SHOCKS]
    before = next((one.loads for one in cases if one.name == case.start), [])
    if case.missing or still == case.loads or {load for load in still if load.startswith("uplift")} <= set(before):
        return [case]
    rest = next((one for one in cases if one.loads == still and not one.missing), None)
    new = [] if rest else [Made(f"{case.name}_at_rest", still, case.start, "none", [], f"{case.name} before the earthquake")]
    return [*new, replace(case, start=(rest or new[0]).name)]


def after_a_shock(case, cases, numbers):
    """Cases of a combination that is judged after the earthquake: the state behind an earthquake among the cases before, or behind one that is not judged."""
    missing = case.missing + (["--quake"] if numbers.quake is None else [])
    shaken = next((before for before in cases if "quake" in before.loads), None)
    if shaken is None:
        shaken = Made("shaken", [*cases[0].loads, "quake"], cases[0].name, "none", missing, f"the earthquake before {case.says.split(':')[0]}; this guideline judges the state after it")
        cases = [shaken]
    else:
        cases = []
    name = case.name if case.name != "earthquake" else "after_earthquake"
    return [*cases, Made(name, case.loads, shaken.name, "after_earthquake", missing, case.says)]


def of_guideline(name, numbers, file=None):
    """Returns the lines of the loads and of the stages of all combinations of a guideline; the usual case is the first. file: of the user, with guidelines."""
    numbers.check()
    guideline = guidelines.read(file)[name]
    rows = sorted(guideline.get("combinations") or (), key=lambda one: "usual" not in one["conditions"])
    if not rows:
        raise guidelines.GuidelineError(f"--guideline {name}: its load combinations are to be filled in; those there are: {', '.join(key for key, one in guidelines.read(file).items() if one.get('combinations'))}")
    usual = made(guideline, rows[0], numbers, None)
    cases = [usual]
    for one in rows[1:]:
        case = made(guideline, one, numbers, usual.name)
        behind = "after_earthquake" in one["conditions"] and "after_earthquake" in guideline["conditions"]
        cases += after_a_shock(case, cases, numbers) if behind else with_rest(case, cases)
    free = guideline.get("uplift", RULE) in ("usace", "ferc")
    if numbers.drain is not None and (numbers.efficiency is None) == free:
        raise guidelines.GuidelineError("--drain: --efficiency of the drains is missing, which this guideline does not give" if free else f"--efficiency: rule {guideline['uplift']} of this guideline fixes it at 2/3")
    if numbers.ice is not None and numbers.level >= numbers.height:
        raise guidelines.GuidelineError(f"--ice: it needs a face behind it, and the water stands at the crest: --pool below {numbers.height:g} m")
    known = loads_of(guideline, numbers)
    designs = [design_of(guideline, case, known) for case in cases]
    raised = {name: load for _line, loads in designs for name, load in loads.items()}
    used = {load for case in cases if not case.missing for load in case.loads}
    loads = [line for load, line in known.items() if load in used] + [factored(known[load], load, name, factor) for name, (load, factor) in raised.items()]
    return loads, [line for case, (design, _raised) in zip(cases, designs) for line in (case.line(), design) if line], usual


def factored(line, load, name, factor):
    """The line of a load under another name, with its partial factor."""
    head, _bracket, rest = line.rpartition("}")
    return f"{head}, partial_factor: {factor:g}}}{rest}".replace(f"  {load}:", f"  {name}:", 1)


def loads_of(guideline, numbers):
    """Every load that a case may have, as a line of YAML."""
    shaken = guidelines.in_crack(guideline, "earthquake", {})[0]
    in_crack = "cracked: false" if guidelines.in_crack(guideline, "at_rest", {})[0] == "unchanged" else f"cracked: true{f', in_earthquake: {shaken}' if shaken else ''}"
    def uplift(level, drained):
        drain = f", rule: {guideline.get('uplift', RULE)}" + (f", drain: {numbers.drain:g}" + (f", efficiency: {numbers.efficiency:g}" if numbers.efficiency is not None else "") if drained and numbers.drain is not None else "")
        tail = f", tailwater: {numbers.tailwater:g}" if numbers.tailwater is not None else ""
        return f"{{type: uplift, faces: base, level: {level:g}{tail}{drain}, {in_crack}}}"

    def quake(k, water):
        return f"{{type: pseudo_static, coefficient: [{k:g}, 0], groups: [dam]{f', faces: upstream, level: {numbers.level:g}' if water else ''}}}"

    known = {"weight": "{type: self_weight, groups: [dam]}     # rock does not weigh: its settlement is older than the dam",
             "water": f"{{type: reservoir, faces: upstream, level: {numbers.level:g}}}", "uplift": uplift(numbers.level, True), "uplift_clogged": uplift(numbers.level, False)}  # fmt: skip
    if numbers.flood is not None:
        kind = "overflow" if numbers.flood > numbers.height else "reservoir"
        known |= {"flood": f"{{type: {kind}, faces: upstream, level: {numbers.flood:g}}}", "uplift_flood": uplift(numbers.flood, True), "uplift_flood_clogged": uplift(numbers.flood, False)}
    if numbers.tailwater is not None:
        known["tail"] = f"{{type: tailwater, faces: downstream, level: {numbers.tailwater:g}}}"
    if numbers.silt is not None:
        known["silt"] = f"{{type: silt, faces: upstream, level: {numbers.silt:g}, density: 900, friction: 28}}     # submerged density [kg/m3], friction [degree]: yours"
    if numbers.ice is not None:
        known["ice"] = f"{{type: ice, faces: upstream, level: {numbers.level:g}, force: {numbers.ice:g}}}"
    for name, k in (("obe", numbers.obe), ("quake", numbers.quake)):
        if k is not None:
            known |= {name: quake(k, True), f"{name}_upstream": quake(-k, False)}
    return {name: f"  {name}: {line}" for name, line in known.items()}
