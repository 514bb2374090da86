"""Finds the level of water at the faces on which it presses, for pictures; its forces are the solver's (src/water/reservoir.c)."""

WATERS = ("reservoir", "overflow", "tailwater")  # types of loads that are water with a surface


def level_at_faces(load):
    """Elevation of the surface at the faces: an overflow falls by its velocity head, a tailwater is pushed away."""
    level = float(load["level"])
    if load.get("type") == "overflow":
        return level - float(load["velocity_head"])
    if load.get("type") == "tailwater" and float(load["effective"]) < 1:
        bottom = float(load["bottom"])
        return bottom + float(load["effective"]) * (level - bottom)
    return level
