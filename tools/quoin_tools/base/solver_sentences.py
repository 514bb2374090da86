"""Says sentences of the solver, which summary.json has in English, in the language of the sheet.

A sentence of several parts has "; " between them. Each part is found in the table below, the special ones before the general; its holes are
numbers, sentences again, or names, {0!s}, which stay. A part that the table lacks stays English, and is counted as missing.
"""

import functools
import re

from quoin_tools.base import sheet_units
from quoin_tools.base.language import N_, _, numeral

SENTENCES = (
    N_("unbalanced ratio {0} <= {1}, increment {2} <= {3}"),
    N_("unbalanced ratio {0} <= {1}"),
    N_("slip kept as it came: by the law a ratio of {0}, the way off by {1}"),
    N_("about {0} %"),
    N_("an unknown part"),
    N_("{0} steps of creep, joints moved by up to {1} of a face"),
    N_("{0} steps of creep, from {1} to {2} m long: ratio from {3} to {4}, motion from {5} to {6} m a cycle"),
    N_("a mechanism that has moved faces by {0} of their length, cosine {1}"),
    N_("over 3 chunks of {0} cycles: median ratio from {1} to {2}, motion from {3} to {4} m a cycle, cosine {5}, no end"),
    N_("over 3 chunks of {0} cycles: median ratio from {1} to {2}, motion from {3} to {4} m a cycle, cosine {5}, {6} m to go"),
    N_("macroblock {0} has slid along macroblock {1} by {2} m, {3} of a length of {4} m, at x = {5} m, y = {6} m"),
    N_("macroblock {0} has parted from macroblock {1} by {2} m, {3} of a length of {4} m, at x = {5} m, y = {6} m"),
    N_("macroblock {0} has moved {1} m since the stage began, more than half its size of {2} m"),
    N_("macroblock {0} has moved most, by {1} m since the stage began"),
    N_("macroblock {0} has moved most, by {1} m since the trial began"),
    N_("contact.connectivity auto found contacts again, as one at x = {0} m, y = {1} m had moved by {2} of its length"),
    N_("macroblock {0} has lost its last contact and falls: {1} m along its loads since the stage began"),
    N_("macroblock {0} and what sticks to it, at x = {1} m, y = {2} m, are not held against {3} N of the {4} N that they are loaded with"),
    N_("displacement {0} m is a thousand times the model"),
    N_("a force or displacement is not a finite number, first in {0}"),
    N_("block {0} of group {1!s}"),
    N_("no block"),
    N_("{0} cycles: ratio {1} > {2} or increment {3} > {4}"),
    N_("no load acts or has acted: the unbalanced force has nothing to be compared with"),
    N_("raise max_cycles to know more"),
    N_("it falls: raise max_cycles, or try relaxation.method: preconditioned"),
    N_("the ratio no longer falls: try relaxation.method: preconditioned"),
    N_("no memory for the factor: it takes about {0} GB, {1} GB were available"),
    N_("blocks moved against the loads (work {0} J, energy at the start {1} J): a stress model without a potential made energy"),
    N_("use pt or tptm"),
    N_("blocks moved against the loads (work {0} J, energy at the start {1} J): the cycles make energy"),
    N_("kinetic energy exceeds the work of the loads, {0} J, and the energy at the start, {1} J, also with half the step and more damping: the cycles make energy"),
    N_("try relaxation.method: preconditioned"),
    N_("try relaxation.method: explicit"),
    # trials
    N_("trial {0} is {1}: {2}"),
    N_("{0} m from where the trial began, and it goes on: more than twice the displacement_limit, {1} m"),
    N_("{0} m from where the stage began, displacement_limit {1} m: {2}"),
    N_("{0} trials: stable at {1}, fails at {2}, where it rests but beyond displacement_limit"),
    N_("{0} trials: stable at {1}, fails at {2}, no verdict at {3}"),
    N_("{0} trials: stable at {1}, fails at {2}"),
    N_("{0} trials: stable at {1}, no verdict at {2}"),
    N_("{0} trials: stable at {1}, the limit"),
    N_("{0} trials: stable at {1}"),
    N_("nothing fails"),
    N_("factor {0} to {1}"),
    N_("no single factor: the joints that slide had different angles, use what: strengths"),
    N_("k_{0!s} of {1!s} {2} to {3}"),
    N_("{0!s} needs no more than {1} kN"),
    N_("{0!s} needs {1} to {2} kN"),
    N_("moved {0} m since the stage began"),
    N_("moved {0} m since the stage began (displacement_limit {1} m, 1 % of the size)"),
    N_("moved {0} m since the stage began (no displacement_limit: what has found another seat counts as stable)"),
    N_("moved {0} m since the stage began (displacement_limit {1} m, 1 % of the size): {2}"),
    N_("moved {0} m since the stage began: {1}"),
    N_("{0} degree"),
    N_("{0} of the prestress"),
    # dynamic, modes
    N_("{0} s in {1} steps"),
    N_("energy balance {0} J, finding contacts again {1} J of {2} J moved"),
    N_("contacts verified {0} times, {1} made, {2} lost"),
    N_("{0}: macroblock {1} ({2!s}) at {3} s"),
    N_("{0}: {1} macroblocks, first {2} ({3!s}) at {4} s"),
    N_("overturned"),
    N_("fallen"),
    N_("slid out of its place"),
    N_("the energy account is out by {0} of the {1} J moved (balance {2} J, finding contacts again {3} J, loss in joints {4} J): {5}"),
    N_("change the stress model to pt, or {0}"),
    N_("raise k_n, so that blocks overlap less (docs/deviations.md, v), or {0}"),
    N_("give dt_factor a small number"),
    N_("lower dt_factor"),
    N_("t = {0} s: a block has moved {1} m in {2} steps, the thinnest is {3} m: it may have passed through others: the step is too large ({4})"),
    N_("t = {0} s: a contact is pressed in by {1} times what can be, a tenth of its length or a quarter of the thinner block: the step is too large ({2}) or k_n too low"),
    N_("t = {0} s: {1}: connectivity is fixed, bodies pass through each other: use contact.connectivity: variable"),
    N_("blocks {0} and {1} of different macroblocks overlap by {2} m (tolerance {3} m)"),
    N_("t = {0} s: displacements are {1}: the step is too large ({2})"),
    N_("a thousand times the model"),
    N_("not finite"),
    N_("t = {0} s: a force or displacement is not a finite number, first in {1}: the step is too large ({2})"),
    N_("t = {0} s: contacts of macroblock {1} begin with {2} J from nothing where it and what it meets have {3} J: the step is too large ({4}) or k_n too low"),
    N_("{0} modes, and none is missing among them"),
    N_("{0} mode, and none is missing among them"),
    N_("{0} modes"),
    N_("{0} mode"),
    N_("slower ones may be missing"),
    N_("{0} grow: no stable state"),
    N_("{0} grows: no stable state"),
    N_("by the modes that condensed bodies lack, frequencies are too high by up to {0} % (mode {1})"),
    N_("by the modes that condensed bodies lack, frequencies are too high by up to {0} % (mode {1}), of {2} it is not known: raise highest_frequency"),
    # water
    N_("after {0} s of the water, {1} steps: {2}"),
    N_("in the step to {0} s of the water, {1} steps: {2}"),
    N_("cracked base of {0!s} {1}: open over {2} m of {3} m, {4} m before, after {5} rounds"),
    N_("runs away"),
    N_("still changes"),
    N_("raise crack_tolerance of this load"),
    N_("water and openings do not agree: after {0} rounds pressures still change by {1} of the largest, flow.tolerance {2}"),
    N_("raise flow.rounds"),
    N_("water and openings do not agree in this step, and with the water at rest at its levels blocks fall ({0})"),
    N_("water and openings do not agree: blocks stand without water in joints, and with the water that has come to rest at these levels, but the trapped water lifts them in the iteration of water and openings: neither a collapse nor an equilibrium is found"),
    N_("blocks stand with the water that has come to rest at these levels"),
    N_("let the level change in more time ({0})"),
    N_("water does not balance: joints hold {0} m2 {1} than flowed in, {2} of what moved, at most {3} is allowed: use shorter steps, time_step"),
    N_("more"),
    N_("less"),
    # pushover
    N_("{0} of {1} increments"),
    N_("largest force {0} N at {1} m"),
    N_("at the end {0} N at {1} m"),
    N_("largest factor {0}, at the end {1}"),
    N_("increments without equilibrium: {0}, ratio up to {1} at {2} m"),
    # why a stage took its method
    N_("preconditioned: {0} degrees of freedom, no contact can fail"),
    N_("preconditioned: {0} degrees of freedom, {1} bodies at contacts that can fail, at most {2}"),
    N_("explicit: {0} degrees of freedom, fewer than {1}"),
    N_("explicit: {0} bodies at contacts that can fail, more than {1}"),
    N_("stiffness_mass: {0} stones of rubble that can slip, {1} or more, four-fold order {2}"),
    N_("stiffness_mass: {0} stones that can slip, {1} or more"),
    N_("stiffness_mass: blocks can crack, {0} bodies at contacts that can fail, at most {1}"),
    N_("explicit: contacts are found anew as blocks move"),
    N_("explicit: relaxation.damping is not adaptive"),
    N_("explicit: blocks can yield"),
    N_("explicit: joints can break or be crushed"),
    N_("explicit: water in joints changes with time"),
    N_("explicit: a given displacement is followed cycle by cycle"),
    N_("preconditioned: the trials that were left by explicit cycles"),
    N_("stiffness_mass: the trials after those that it left by explicit cycles"),
    N_("{0} times it found no equilibrium in the work of {1} explicit cycles, and those went on"),
    N_("{0} time it found no equilibrium in the work of {1} explicit cycles, and those went on"),
    N_("its factor could not be made, and explicit cycles went on"),
    N_("{0} times explicit cycles began again, after a jump of blocks ({1}), a divergence ({2}) or no end ({3})"),
    N_("{0} time explicit cycles began again, after a jump of blocks ({1}), a divergence ({2}) or no end ({3})"),
    N_("explicit cycles went on after {0} cycles, at the first stall"),
    N_("stiffness_mass went on after {0} cycles, where slip was let go"),
    N_("relaxation.method fixes it"),
    # stopped
    N_("{0} at ratio {1}"),
    N_("signal {0}"),
    N_("wall time is near its limit, {0} min"),
    N_("go on with -restart {0!s}"),
)
WORDS = (  # of summary.json besides: verdicts, outcomes of trials, how joints move, why blocks fail, flow, methods
    N_("converged"), N_("collapsed"), N_("diverged"), N_("undecided"), N_("interrupted"), N_("completed"), N_("stable"), N_("fails"), N_("slides"), N_("opens"), N_("slides and opens"),
    N_("tension"), N_("compression"), N_("shear"), N_("steady"), N_("transient"), N_("frozen"), N_("explicit"), N_("preconditioned"), N_("preconditioned, then explicit"),
    N_("stiffness_mass"), N_("stiffness_mass, then explicit"), N_("explicit, then stiffness_mass"), N_("fixed"), N_("variable"), N_("fixed, then variable"))  # fmt: skip
NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?( m)?")


@functools.cache
def patterns():
    """Returns rows of a sentence, the expression that finds it, and "!s" for each hole that is a name."""
    return [(sentence, re.compile(re.sub(r"\\{\d(!s)?\\}", "(.+?)", re.escape(sentence))), re.findall(r"{\d(!s)?}", sentence)) for sentence in (*SENTENCES, *WORDS)]


def solver_says(text):
    return "; ".join(said(part) or _(part) for part in text.split("; "))


def said(text):
    """Returns a part of a sentence, or what fills a hole, in the language of the sheet; None: it is neither a number nor in the table."""
    if NUMBER.fullmatch(text):
        number, metres = text.removesuffix(" m"), text.endswith(" m")
        return sheet_units.said(numeral(number), "m") if metres else numeral(number)
    for sentence, pattern, names in patterns():
        if found := pattern.fullmatch(text):
            return _(sentence, *(part if name else said(part) or part for part, name in zip(found.groups(), names)))
    return None
