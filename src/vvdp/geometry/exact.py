"""Solids with exact or NURBS surfaces, made with Open CASCADE, and STEP files of them. Needs the `cad` extra.

Cylinders, tori and spheres are what they are; helical flanks, nozzles and channels are polynomial surfaces through
the same points that the facets have, see `DEGREE`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vvdp.base.errors import RunError, unusable
from vvdp.geometry.kernel import Floats, Placed

if TYPE_CHECKING:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_BooleanOperation
    from OCP.Geom import Geom_BezierSurface
    from OCP.gp import gp_Trsf
    from OCP.StepData import StepData_StepModel
    from OCP.TopoDS import TopoDS_Shape

DEGREE = 9
"""Of the polynomials along curved edges; on a flank that goes a sixth of a turn round they are 1e-12 radii off."""
MILLI = 1e-3
"""Open CASCADE counts in millimetres: its tolerances are absolute."""
TIMELESS = "1970-01-01T00:00:00"
SEWN = 1e-6
"""Gap between neighbouring faces of one body that is closed [mm]."""


@dataclass(frozen=True)
class Body:
    """The union of shapes, which is only calculated when it is asked for: cutting a union cuts each of its parts."""

    shapes: "tuple[TopoDS_Shape, ...]"

    def __add__(self, other: "Body") -> "Body":
        return Body(self.shapes + other.shapes)

    def __sub__(self, other: "Body") -> "Body":
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

        return Body(tuple(_combine(BRepAlgoAPI_Cut(), [shape], other.shapes) for shape in self.shapes))

    def __and__(self, other: "Body") -> "Body":
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Common

        whole = other.shape()
        return Body(tuple(_combine(BRepAlgoAPI_Common(), [shape], [whole]) for shape in self.shapes))

    def rotate(self, angle: float) -> "Body":
        """Turned about the axis [rad]."""
        from OCP.gp import gp, gp_Trsf

        motion = gp_Trsf()
        motion.SetRotation(gp.OZ_s(), float(angle))
        return self._put(motion)

    def translate(self, z: float) -> "Body":
        """Moved along the axis [m]."""
        from OCP.gp import gp_Trsf, gp_Vec

        motion = gp_Trsf()
        motion.SetTranslation(gp_Vec(0.0, 0.0, float(z) / MILLI))
        return self._put(motion)

    def mirror(self, z: float = 0.0) -> "Body":
        """Mirrored at the plane at `z` [m]."""
        from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf

        motion = gp_Trsf()
        motion.SetMirror(gp_Ax2(gp_Pnt(0.0, 0.0, float(z) / MILLI), gp_Dir(0.0, 0.0, 1.0)))
        return self._put(motion)

    def _put(self, motion: "gp_Trsf") -> "Body":
        from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform

        return Body(tuple(BRepBuilderAPI_Transform(shape, motion, True).Shape() for shape in self.shapes))

    def shape(self) -> "TopoDS_Shape":
        """The union as one shape. Raises RunError where the kernel fails."""
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

        if len(self.shapes) == 1:
            return self.shapes[0]
        return _combine(BRepAlgoAPI_Fuse(), self.shapes[:1], self.shapes[1:])


def _combine(
    operation: "BRepAlgoAPI_BooleanOperation",
    arguments: "Iterable[TopoDS_Shape]",
    tools: "Iterable[TopoDS_Shape]",
) -> "TopoDS_Shape":
    from OCP.collections import List_TopoDS_Shape

    for shapes, give in ((arguments, operation.SetArguments), (tools, operation.SetTools)):
        listed = List_TopoDS_Shape()
        for shape in shapes:
            listed.Append(shape)
        give(listed)
    operation.Build()
    if not operation.IsDone():
        raise RunError(f"Open CASCADE could not combine two solids: {type(operation).__name__} failed")
    return operation.Shape()


class Exact:
    """Kernel of Open CASCADE. Patches have no meaning here."""

    def cylinder(self, _patch: str, radius: float, low: float, high: float) -> Body:
        """A cylinder about the axis."""
        return self._cylinder(radius, (0.0, 0.0, low), (0.0, 0.0, 1.0), high - low)

    def radial_cylinder(self, _patch: str, radius: float, angle: float, near: float, far: float, z: float) -> Body:
        """A cylinder whose axis is the ray at `angle`, from `near` to `far`."""
        cos, sin = float(np.cos(angle)), float(np.sin(angle))
        return self._cylinder(radius, (near * cos, near * sin, z), (cos, sin, 0.0), far - near)

    def _cylinder(self, radius: float, foot: Sequence[float], along: Sequence[float], length: float) -> Body:
        from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
        from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

        axes = gp_Ax2(gp_Pnt(*(float(x) / MILLI for x in foot)), gp_Dir(*along))
        return Body((BRepPrimAPI_MakeCylinder(axes, float(radius) / MILLI, float(length) / MILLI).Shape(),))

    def ring(self, _patch: str, centre_radius: float, radius: float, z: float) -> Body:
        """A torus about the axis, its centre line at `z`."""
        from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus
        from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

        axes = gp_Ax2(gp_Pnt(0.0, 0.0, float(z) / MILLI), gp_Dir(0.0, 0.0, 1.0))
        return Body((BRepPrimAPI_MakeTorus(axes, float(centre_radius) / MILLI, float(radius) / MILLI).Shape(),))

    def bent_rod(self, _patch: str, centre_radius: float, radius: float, begin: float, end: float) -> Body:
        """An arc of a torus about the axis, in the plane z = 0, with a hemisphere at either end."""
        from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere, BRepPrimAPI_MakeTorus
        from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

        far, r = float(centre_radius) / MILLI, float(radius) / MILLI
        start = gp_Dir(float(np.cos(begin)), float(np.sin(begin)), 0.0)
        arc = BRepPrimAPI_MakeTorus(gp_Ax2(gp_Pnt(), gp_Dir(0.0, 0.0, 1.0), start), far, r, float(end - begin))
        parts = [arc.Shape()]
        for angle, forward in ((begin, -1.0), (end, 1.0)):
            cos, sin = float(np.cos(angle)), float(np.sin(angle))
            axes = gp_Ax2(gp_Pnt(far * cos, far * sin, 0.0), gp_Dir(-forward * sin, forward * cos, 0.0))
            parts.append(BRepPrimAPI_MakeSphere(axes, r, 0.0, 0.5 * np.pi).Shape())
        return Body((Body(tuple(parts)).shape(),))

    def mapped_box(self, _patch: str, placed: Placed, _lengths: Sequence[float]) -> Body:
        """The unit cube with every point moved to where `placed` puts it, its six faces polynomials."""
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
        from OCP.TopoDS import TopoDS

        sewing = BRepBuilderAPI_Sewing(SEWN)
        degrees = [1 if _is_straight(placed, axis) else DEGREE for axis in range(3)]
        for fixed in range(3):
            first, second = (axis for axis in range(3) if axis != fixed)
            for side in (0.0, 1.0):
                u, v = np.meshgrid(_nodes(degrees[first]), _nodes(degrees[second]), indexing="ij")
                place = [np.empty(0)] * 3
                place[fixed], place[first], place[second] = np.full(u.size, side), u.ravel(), v.ravel()
                points = placed(*place).reshape(*u.shape, 3) / MILLI
                sewing.Add(BRepBuilderAPI_MakeFace(_polynomial_surface(points), SEWN).Face())
        sewing.Perform()
        if sewing.NbFreeEdges():
            raise RunError(f"the faces of a solid do not meet within {SEWN:g} mm")
        body = BRepBuilderAPI_MakeSolid(TopoDS.Shell(sewing.SewedShape())).Solid()
        return Body((body if shape_volume(body) > 0.0 else body.Reversed(),))


def _is_straight(placed: Placed, axis: int) -> bool:
    """Whether equal steps along an axis of the unit cube are equal steps in space, along three lines."""
    place = [np.repeat([0.0, 0.37, 1.0], 4)] * 3
    place[axis] = np.tile([0.0, 0.25, 0.5, 1.0], 3)
    points = placed(*place).reshape(3, 4, 3)
    start, end = points[:, :1], points[:, -1:]
    straight = start + np.array([0.0, 0.25, 0.5, 1.0])[:, None] * (end - start)
    return bool(abs(points - straight).max() < 1e-12 * abs(points).max())


def _nodes(degree: int) -> Floats:
    """Where a polynomial takes the surface's values: both ends, and between them as Chebyshev has it."""
    return 0.5 - 0.5 * np.cos(np.pi * np.arange(degree + 1) / degree)


def _bernstein(degree: int) -> Floats:
    """The Bernstein polynomials of a degree at its nodes, in columns."""
    from math import comb

    t = _nodes(degree)[:, None]
    i = np.arange(degree + 1)
    return np.array([comb(degree, k) for k in i], float) * t**i * (1.0 - t) ** (degree - i)


def _polynomial_surface(points: Floats) -> "Geom_BezierSurface":
    """The Bezier surface through a grid of points at the nodes [mm]."""
    from OCP.collections import Array2_gp_Pnt
    from OCP.Geom import Geom_BezierSurface
    from OCP.gp import gp_Pnt

    rows, columns, _ = points.shape
    along = np.linalg.inv(_bernstein(rows - 1)), np.linalg.inv(_bernstein(columns - 1))
    poles = np.einsum("ki,lj,ijx->klx", *along, points)
    array = Array2_gp_Pnt(1, rows, 1, columns)
    for i in range(rows):
        for j in range(columns):
            array.SetValue(i + 1, j + 1, gp_Pnt(*poles[i, j].tolist()))
    return Geom_BezierSurface(array)


def shape_volume(shape: "TopoDS_Shape") -> float:
    """Volume that a shape encloses [m^3], negative where it is inside out."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass()) * MILLI**3


def is_valid(shape: "TopoDS_Shape") -> bool:
    """Whether Open CASCADE finds nothing wrong with the faces, edges and their tolerances."""
    from OCP.BRepCheck import BRepCheck_Analyzer

    return bool(BRepCheck_Analyzer(shape).IsValid())


def _silence() -> None:
    """Open CASCADE prints statistics on stdout, where results are."""
    from OCP.Message import Message

    Message.DefaultMessenger_s().ChangePrinters().Clear()


def write_step(path: Path, body: Body) -> float:
    """Writes a body as STEP AP214 in millimetres; its volume [m^3]. Raises RunError where it is no valid solid.

    The solid is called as the file is. The head bears no time of writing, so that the same body gives the same bytes.
    """
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    shape = body.shape()
    volume = shape_volume(shape)
    if not is_valid(shape) or not volume > 0.0:
        raise RunError(f"{path.name}: Open CASCADE made no valid solid (volume {1e6 * volume:.6g} cm^3)")
    _silence()
    writer = STEPControl_Writer()
    written = writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    _name(writer.Model(), path.stem)
    written = writer.Write(str(path)) if written == IFSelect_ReturnStatus.IFSelect_RetDone else written
    if written != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise RunError(f"{path}: Open CASCADE could not write the STEP file")
    return volume


def _name(model: "StepData_StepModel", name: str) -> None:
    """Calls the product of a STEP file by a name without number, and leaves the time of writing out."""
    from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
    from OCP.StepBasic import StepBasic_Product
    from OCP.TCollection import TCollection_HAsciiString

    APIHeaderSection_MakeHeader(model).SetTimeStamp(TCollection_HAsciiString(TIMELESS))
    for place in range(1, model.NbEntities() + 1):
        entity = model.Value(place)
        if isinstance(entity, StepBasic_Product):
            entity.SetId(TCollection_HAsciiString(name))
            entity.SetName(TCollection_HAsciiString(name))


def read_step(path: Path) -> Body:
    """The bodies of a STEP file. Raises ConfigError where it is none."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_Reader

    _silence()
    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone or not reader.TransferRoots():
        raise unusable(path, "is not a STEP file that can be read")
    return Body((reader.OneShape(),))
