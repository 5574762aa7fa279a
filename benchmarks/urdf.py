"""Robots described by URDF files, with their joints turning, as an importer makes them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

import bmesh
import bpy
import numpy as np
from bpy.types import Mesh, Object
from mathutils import Euler, Matrix, Vector

_SWING = 0.3
"""Largest angle by which a joint turns to either side [rad]."""


def add_robot(path: Path, place: Sequence[float], shapes: str, frames: int, seed: int) -> None:
    """Add the links of the robot in a file as an empty each, with its meshes as children; its
    ``shapes`` are ``visual`` or ``collision``. The joints turn at random within ``frames``."""
    robot, random = ElementTree.parse(path).getroot(), np.random.default_rng(seed)
    links = {
        link.get("name", ""): _add_link(
            link, path, f"{robot.get('name')}.{link.get('name')}", shapes
        )
        for link in robot.findall("link")
    }
    for joint in robot.findall("joint"):
        parent, child = (
            links[end.get("link", "")]
            for end in (joint.find("parent"), joint.find("child"))
            if end is not None
        )
        child.parent = parent
        _turn(joint, child, frames, random)
    for link in links.values():
        if link.parent is None:
            link.location = place


def _add_link(link: Element, path: Path, name: str, shapes: str) -> Object:
    empty = bpy.data.objects.new(name, None)
    bpy.context.scene.collection.objects.link(empty)
    for number, part in enumerate(link.findall(shapes)):
        geometry = part.find("geometry")
        assert geometry is not None
        obj = bpy.data.objects.new(f"{name}.{number}", _mesh(geometry[0], path))
        bpy.context.scene.collection.objects.link(obj)
        obj.parent, obj.matrix_basis = empty, _pose(part)
    return empty


def _turn(joint: Element, child: Object, frames: int, random: np.random.Generator) -> None:
    pose, axis, limit = _pose(joint), joint.find("axis"), joint.find("limit")
    child.matrix_basis = pose
    if joint.get("type") not in ("revolute", "continuous") or axis is None:
        return
    low, high = (
        float(default if limit is None else limit.get(end, default))
        for end, default in (("lower", "-1"), ("upper", "1"))
    )
    child.rotation_mode = "QUATERNION"
    for step, side in enumerate((0, 1, -1, 1, 0)):
        angle = (low + high) / 2 + side * min(_SWING, (high - low) / 2) * random.uniform(0.5, 1)
        turn = Matrix.Rotation(angle, 3, Vector(_numbers(axis, "xyz", "1 0 0")))
        child.rotation_quaternion = (pose.to_3x3() @ turn).to_quaternion()
        child.keyframe_insert("rotation_quaternion", frame=1 + step * (frames - 1) // 4)


def _numbers(element: Element, name: str, default: str) -> list[float]:
    return [float(number) for number in element.get(name, default).split()]


def _pose(element: Element) -> Matrix:
    origin = element.find("origin")
    if origin is None:
        return Matrix()
    turn = Euler(_numbers(origin, "rpy", "0 0 0")).to_matrix().to_4x4()
    return Matrix.Translation(_numbers(origin, "xyz", "0 0 0")) @ turn


def _mesh(shape: Element, path: Path) -> Mesh:
    mesh = bpy.data.meshes.new(shape.get("filename", shape.tag))
    if shape.tag == "mesh":
        file = path.parent / shape.get("filename", "").removeprefix("package://")
        lines = [line.split() for line in file.read_text().splitlines()]
        points = np.array([line[1:4] for line in lines if line[:1] == ["v"]], dtype=np.float64)
        faces = [
            [int(corner.split("/")[0]) - 1 for corner in line[1:]]
            for line in lines
            if line[:1] == ["f"]
        ]
        mesh.from_pydata(points * _numbers(shape, "scale", "1 1 1"), [], faces)
        return mesh
    work = bmesh.new()
    match shape.tag:
        case "box":
            size = Matrix.Diagonal([*_numbers(shape, "size", "1 1 1"), 1])
            bmesh.ops.create_cube(work, size=1.0, matrix=size)
        case "cylinder":
            (radius,), (depth,) = _numbers(shape, "radius", "1"), _numbers(shape, "length", "1")
            bmesh.ops.create_cone(
                work, cap_ends=True, segments=32, radius1=radius, radius2=radius, depth=depth
            )
        case "sphere":
            (radius,) = _numbers(shape, "radius", "1")
            bmesh.ops.create_uvsphere(work, u_segments=16, v_segments=8, radius=radius)
    work.to_mesh(mesh)
    work.free()
    return mesh
