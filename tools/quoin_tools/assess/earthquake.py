"""Finds the factor on the loads of a pseudo-static earthquake at which the part above a base yields, by the gravity method.

    factor, why = yield_factor(hand_of, found.strength)     # hand_of(factor) is the Hand under so many times the earthquake
"""

from quoin_tools.assess.strength import factors

MOST = 1000.0  # times the loads: beyond it nothing gives way
ROUNDS = 60


def loads_of(case, stage):
    """Pseudo-static loads of a stage: name to keys."""
    return {name: load for name, load in case.scene.stage_loads(stage).items() if load.get("type") == "pseudo_static"}


def gives_way(hand, strength):
    """Returns how the part above moves: "overturns", "slides", or "" where it stands."""
    if hand.crack is None:
        return "overturns" if hand.N > 0 else "is lifted"
    peak = factors(hand, strength)["peak"]
    return "slides" if peak is not None and peak < 1 else ""


def yield_factor(hand_of, strength):
    """Returns (factor, how it gives way), or (None, why there is no factor)."""
    if gives_way(hand_of(0.0), strength):
        return None, "it does not stand without the earthquake"
    low, high = 0.0, 1.0
    while not gives_way(hand_of(high), strength):
        low, high = high, 2 * high
        if high > MOST:
            return None, f"it stands under {MOST:g} times the earthquake"
    for _ in range(ROUNDS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if gives_way(hand_of(middle), strength) else (middle, high)
    return low, gives_way(hand_of(high), strength)


def of_run(case, load):
    """Returns (stable, failing) k_h or k_v of a load by the trials of the run that raise it; None: there are none."""
    for facts in case.results.summary["stages"]:
        raised = (facts.get("load_factor") or {}).get("raises", {}).get(load)
        if raised:
            which = "k_h" if case.scene.loads[load]["coefficient"][0] else "k_v"
            return raised[f"{which}_stable"], raised[f"{which}_failing"]
    return None


def yields(case, stage, forces, hand_of, strength):
    """Rows (load, k_h or k_v, its coefficient as the part gives way or None, how or why not, (stable, failing) of the run or None).

    forces: (X, Y, M) of each load of the stage; hand_of(forces) is the Hand under their sum."""
    loads = loads_of(case, stage)
    if not loads or strength.get("friction") is None:
        return []
    shaken = sum((forces[name] for name in loads), start=0.0)
    still = sum(forces.values(), start=0.0) - shaken
    factor, how = yield_factor(lambda times: hand_of(still + times * shaken), strength)
    rows = []
    for name, load in loads.items():
        x = 0 if load["coefficient"][0] else 1
        rows.append((name, ("k_h", "k_v")[x], None if factor is None else factor * float(load["coefficient"][x]), how, of_run(case, name)))
    return rows
