"""Units of length of drawings and meshes of other programs."""

UNITS = {"mm": 1e-3, "cm": 1e-2, "dm": 0.1, "m": 1.0, "km": 1e3, "in": 0.0254, "ft": 0.3048, "ft_us": 1200 / 3937, "yd": 0.9144}  # [m]; ft_us: of surveys
