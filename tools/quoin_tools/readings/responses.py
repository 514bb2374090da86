"""Reads out of a run what each instrument would read: displacement at a point, head or pressure of the water, discharge of a drain, opening of a joint.

    numbers(Results("out"), "full", sensors)        {name: number in SI, positive as the reading is}
"""

import numpy as np
import shapely

from quoin_tools.mesh import blockmesh
from quoin_tools.readings.sensors import ReadingsError

NEAR = 0.01  # of the height of the group of blocks: a vertex that is farther from its instrument is told
SAME = 1e-6  # [m] vertices so close are at one place
FAR = 2.0  # [m] an instrument in water that is farther from all joints with water has no reading of the model


def numbers(results, stage, sensors):
    """Returns {name: number} for the sensors ({name: Sensor}) at the end of a stage; ReadingsError where the model has no such number."""
    end = results.stage(stage)
    return {name: READ[sensor.quantity](results, end, sensor) for name, sensor in sensors.items()}


def displacement(results, end, sensor):
    """[m] along the direction, of the vertex nearest to the point."""
    if sensor.point is None or sensor.direction is None:
        raise ReadingsError(f"sensors.{sensor.name}: a displacement of the model needs point and direction")
    return float(end.displacement[nearest(results.mesh, sensor)[0]] @ sensor.direction)


def nearest(mesh, sensor):
    """Returns (the vertex nearest to the point, its distance [m], a block that has it, blocks with another vertex at the same place that are as near to the point): of vertices at one
    place that of the block in which the point lies, the first of several."""
    distance = np.hypot(*(mesh.vertices - sensor.point).T)
    there = np.flatnonzero(distance <= distance.min() + SAME)
    blocks, corners = np.nonzero(np.isin(mesh.blocks, there))
    away = shapely.distance(shapely.polygons(mesh.vertices[blockmesh.closed_rings(mesh)[blocks]]), shapely.Point(sensor.point))
    near = np.flatnonzero(away <= away.min() + SAME)
    vertex = mesh.blocks[blocks[near], corners[near]]
    first = int(np.argmin(vertex))
    return int(vertex[first]), float(distance[vertex[first]]), int(blocks[near[first]]), blocks[near[vertex != vertex[first]]]


def told(mesh, sensor):
    """Returns sentences on the vertex whose displacement is taken: far from the instrument; at one place with vertices of other blocks, from which a joint parts it."""
    vertex, distance, block, others = nearest(mesh, sensor)
    mine = mesh.block_group == mesh.block_group[block]
    height, (x, y) = float(np.ptp(mesh.vertices[blockmesh.closed_rings(mesh)[mine], 1])), mesh.vertices[vertex]
    said = [f"its displacement is that of the nearest vertex, [{x:.4g}, {y:.4g}], which is {distance:.3g} m away"] if distance > NEAR * height else []
    if len(others):
        names = [f"{one} ({mesh.group_names[mesh.block_group[one]]})" for one in (block, *others)]
        said.append(f"its point lies on a joint: its displacement is that of block {names[0]}, not of {', '.join(names[1:])}; a point 1 mm inside another block takes that one")
    return said


def water(_results, end, sensor):
    """[m] head at the foot of the perpendicular from the point on the nearest piece of joint that has water; [Pa] of this head at the elevation of the point, 0 above it."""
    flow = end.flow
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


def discharge(results, end, sensor):
    """[m2/s] of a drain, per metre of dam."""
    found = (results.stage_summary(end.name).get("flow") or {}).get("conditions", {})
    if sensor.drain not in found or not sensor.width:
        raise ReadingsError(f"sensors.{sensor.name}: a discharge of the model needs width [m], and drain, one of: {', '.join(found) or 'none, no water flows in joints'}")
    return float(found[sensor.drain]["discharge"])


def opening(results, end, sensor):
    """[m] between the ends of two contacts, linear; beyond the first and the last the nearest."""
    if sensor.point is not None:
        contacts = end.contacts
        mine = contacts.joint == results.mesh.joint_names.index(sensor.joint)
        distance = ((contacts.point[mine] - np.asarray(sensor.point)) ** 2).sum(axis=2)
        return float(contacts.opening[mine].ravel()[np.argmin(distance)])
    distance, _sigma, _tau, opened = results.joint_profile(end.name, sensor.joint, "opening")
    return float(np.interp(sensor.position, distance.ravel(), opened.ravel()))


READ = {"displacement": displacement, "piezometric head": water, "pressure": water, "discharge": discharge, "joint opening": opening}
