"""Reads time series of a dynamic stage: joints, supports, points and energies, from history.csv and joint_history.csv.

    for name in dynamic_stages(results): c = Courses(results, name); c.time, c.joints["base"]["slip"], c.probe("crest", "x"), c.shear("x")
"""

import numpy as np

FACTOR_CUT = 1e3  # sliding factors beyond: the joint carries no shear


def dynamic_stages(results):
    """Returns the names of dynamic stages that have an energy account."""
    return [s["name"] for s in results.summary["stages"] if "balance" in (s.get("energy") or ())]


def is_shaken(facts):
    """Tells whether supports move in a stage, or waves come in (its part of summary.json)."""
    return bool(facts.get("motion")) or bool((facts.get("energy") or {}).get("incoming"))


class TimeSeries:
    """Arrays over the rows of a stage; forces belong to one step before the time of their row."""

    def __init__(self, results, stage):
        self.stage, history = stage, results.history
        rows = np.flatnonzero(history["stage"] == stage) if len(history.get("stage", ())) else np.zeros(0, int)
        self.columns = {name: values[rows] for name, values in history.items() if name != "stage"}
        self.time = self.columns.get("time_s", np.zeros(0))
        self.joints = {}
        for name, columns in results.joint_history.items():
            mine = columns["stage"] == stage
            if mine.any():
                self.joints[name] = {key: values[mine] for key, values in columns.items() if key != "stage"}

    def names(self, end):
        return [name.removesuffix(end) for name in self.columns if name.endswith(end)]

    @property
    def probes(self):
        return self.names("_ux_m")

    def probe(self, name, axis, relative=False):
        """[m] Displacement along x or y; relative to the ground: None where nothing moves the ground."""
        return self.columns.get(f"{name}_{'r' if relative else 'u'}{axis}_m")

    @property
    def supports(self):
        return self.names("_fx_N")

    def shear(self, axis):
        """[N] Force of all supports on the model; None: the run is older than these columns."""
        mine = [self.columns[f"{name}_f{axis}_N"] for name in self.supports]
        return np.sum(mine, axis=0) if mine else None

    def sliding(self, most=None):
        """Returns the joints that can slide, the one with the longest slip first."""
        able = {name: reach(c) for name, c in self.joints.items() if np.isfinite(c["factor_peak"]).any()}
        return sorted(able, key=able.get, reverse=True)[:most]


def reach(joint):
    """[m] Returns the largest slip of a joint from its slip at the start of the stage."""
    return np.abs(joint["slip"] - joint["slip"][0]).max()
