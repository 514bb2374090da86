"""Reads out of a run what each instrument would read: displacement at a point, head or pressure of the water, discharge of a drain, opening of a joint.

    numbers(Results("out"), "full", sensors)        {name: number in SI, positive as the reading is}
"""

import numpy as np

from quoin_tools.readings.sensors import ReadingsError

FAR = 2.0  # [m] an instrument in water that is farther from all joints with water has no reading of the model


def numbers(results, stage, sensors):
    """Returns {name: number} for the sensors ({name: Sensor}) at the end of a stage; ReadingsError where the model has no such number."""
    return {name: READ[sensor.quantity](results, stage, sensor) for name, sensor in sensors.items()}


def displacement(results, stage, sensor):
    """[m] along the direction, of the vertex nearest to the point."""
    if sensor.point is None or sensor.direction is None:
        raise ReadingsError(f"sensors.{sensor.name}: a displacement of the model needs point and direction")
    vertex = np.argmin(((results.mesh.vertices - sensor.point) ** 2).sum(axis=1))
    return float(results.stage(stage).displacement[vertex] @ sensor.direction)


def water(results, stage, sensor):
    """[m] head at the foot of the perpendicular from the point on the nearest piece of joint that has water; [Pa] of this head at the elevation of the point, 0 above it."""
    flow = results.stage(stage).flow
    if flow is None or sensor.point is None:
        raise ReadingsError(f"sensors.{sensor.name}: a {sensor.quantity} of the model needs a point, and water that flows in joints (loads of type head)")
    start, along = flow.point[:, 0], flow.point[:, 1] - flow.point[:, 0]
    part = np.clip(((sensor.point - start) * along).sum(axis=1) / (along**2).sum(axis=1), 0, 1)
    distance = np.hypot(*(start + part[:, None] * along - sensor.point).T)
    piece = np.argmin(distance)
    if distance[piece] > FAR:
        raise ReadingsError(f"sensors.{sensor.name}.point: {distance[piece]:.3g} m from the nearest joint with water: expected at most {FAR:g} m")
    head, pressure, foot = (ends[0] + part[piece] * (ends[1] - ends[0]) for ends in (flow.head[piece], flow.pressure[piece], flow.point[piece, :, 1]))
    if sensor.quantity == "piezometric head":
        return float(head)
    return float(pressure * max(head - sensor.point[1], 0.0) / (head - foot)) if head > foot else 0.0


def discharge(results, stage, sensor):
    """[m2/s] of a drain, per metre of dam."""
    found = (results.stage_summary(stage).get("flow") or {}).get("conditions", {})
    if sensor.drain not in found or not sensor.width:
        raise ReadingsError(f"sensors.{sensor.name}: a discharge of the model needs width [m], and drain, one of: {', '.join(found) or 'none, no water flows in joints'}")
    return float(found[sensor.drain]["discharge"])


def opening(results, stage, sensor):
    """[m] between the ends of two contacts, linear; beyond the first and the last the nearest."""
    if sensor.point is not None:
        contacts = results.stage(stage).contacts
        mine = contacts.joint == results.mesh.joint_names.index(sensor.joint)
        distance = ((contacts.point[mine] - np.asarray(sensor.point)) ** 2).sum(axis=2)
        return float(contacts.opening[mine].ravel()[np.argmin(distance)])
    distance, _sigma, _tau, opened = results.joint_profile(stage, sensor.joint, "opening")
    return float(np.interp(sensor.position, distance.ravel(), opened.ravel()))


READ = {"displacement": displacement, "piezometric head": water, "pressure": water, "discharge": discharge, "joint opening": opening}
