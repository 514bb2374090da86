"""A rigid dam (0,0) (24,0) (4,32) (4,36) (0,36) on a base without tension, with a vertical anchor: by statics, per metre."""

from scipy.optimize import brentq

WIDTH, HEIGHT, STIFFNESS, ANCHOR = 24.0, 36.0, 10e9, 1.5  # [m], [m], [Pa/m] of the base, [m] from the heel
WEIGHT, CENTRE = 10924.42e3, 7.97701  # [N], [m] from the heel
WATER = 9810.0  # [N/m3]


def thrust(level):
    """Force [N] and moment about the heel [N m] of the water on the upstream face."""
    high = min(level, HEIGHT)
    return WATER * (level * high - high**2 / 2), WATER * (level * high**2 / 2 - high**3 / 3)


def base(T, level=None):
    """Open length [m], stress at the toe [Pa], opening at the anchor [m]; no level: no water. None: it overturns."""
    N = WEIGHT + T
    about_toe = WEIGHT * (WIDTH - CENTRE) + T * (WIDTH - ANCHOR) - (thrust(level)[1] if level is not None else 0.0)
    x = about_toe / N  # of the resultant, from the toe
    if x <= 0:
        return None
    if x >= WIDTH / 3:  # closed: stresses are linear over the whole base
        middle, more = N / WIDTH, 6 * N * (WIDTH / 2 - x) / WIDTH**2
        return 0.0, middle + more, -(middle + more * (2 * ANCHOR / WIDTH - 1)) / STIFFNESS
    toe = 2 * N / (3 * x)
    return WIDTH - 3 * x, toe, -toe * (1 - (WIDTH - ANCHOR) / (3 * x)) / STIFFNESS


def anchored(level, k=0.0, T0=0.0):
    """Open length [m], stress at the toe [Pa] and force [N]; the anchor, of stiffness k [N/m], was locked with T0 under self-weight."""
    T = T0
    if k:
        locked = base(T0)[2]
        least = brentq(lambda T: WEIGHT * (WIDTH - CENTRE) + T * (WIDTH - ANCHOR) - thrust(level)[1], -WEIGHT, 1e9)  # less: it overturns
        T = brentq(lambda T: T - T0 - k * (base(T, level)[2] - locked), max(T0 - 1e4, least + 1.0), T0 + 1.5e7, xtol=1e-3)
    found = base(T, level)
    return (*found[:2], T) if found else None


def comes_out(T, axial, bond, strength):
    """By how much one end of long grouted steel comes out under T [N]; axial: E A [N], bond [N/m2], strength [N/m] of the grout."""
    rate = (bond / axial) ** 0.5
    slips_at = axial * rate * strength / bond
    if slips_at >= T:
        return T / (axial * rate)
    length = (T - slips_at) / strength
    return strength / bond + (slips_at + strength * length / 2) * length / axial


def grouted(level, spacing, **grout):
    """As `anchored`, with passive bars that are grouted on both sides of the base: they carry what its opening pulls out of both."""
    locked = base(0.0)[2]
    about_toe = WEIGHT * (WIDTH - CENTRE) - thrust(level)[1]
    least = max(0.0, -about_toe / (WIDTH - ANCHOR) + 1.0)  # less: it overturns
    T = brentq(lambda T: base(T, level)[2] - locked - 2 * comes_out(T * spacing, **grout), least, 1e7, xtol=1e-3)
    return (*base(T, level)[:2], T)


def overturns(T=0.0):
    """Level [m] at which it overturns under a constant force."""
    return brentq(lambda level: WEIGHT * (WIDTH - CENTRE) + T * (WIDTH - ANCHOR) - thrust(level)[1], HEIGHT, 100)


def needed(level, factor, tan_phi=1.0):
    """Force [N] for a sliding factor (N tan(phi) over the thrust)."""
    return factor * thrust(level)[0] / tan_phi - WEIGHT


def slides(T=0.0, tan_phi=1.0):
    """Level [m] at which it slides under a constant force."""
    return brentq(lambda level: (WEIGHT + T) * tan_phi - thrust(level)[0], HEIGHT, 100)
