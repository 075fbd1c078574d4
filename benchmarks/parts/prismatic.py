"""Milled parts: planes, bores, pockets, fillets."""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepGProp import BRepGProp
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.GProp import GProp_GProps
from OCP.TopoDS import TopoDS_Compound

from crispline import occt
from parts.modelling import (
    X,
    Y,
    box,
    chamfer,
    cut,
    cylinder,
    disc,
    fillet,
    fuse,
    polygon,
    prism,
    unified,
)


def pocket_block() -> Any:
    """Planes only: a block (80 x 60 x 30) with two pockets, a step and an open slot."""
    return cut(
        box((80, 60, 30)),
        box((26, 20, 14), (8, 8, 16)),
        box((18, 34, 9), (46, 16, 21)),
        box((12, 60, 10), (68, 0, 20)),
        box((80, 8, 8), (0, 40, 0)),
    )


def filleted_bracket() -> Any:
    """An angle (60 x 40 x 50, 10 thick): inner fillet 8, rounded corners, three bores."""
    angle = fuse(box((60, 40, 10)), box((10, 40, 50)))
    angle = fillet(angle, 8.0, lambda m: bool(abs(m[0] - 10) < 1e-6 and abs(m[2] - 10) < 1e-6))
    angle = fillet(angle, 10.0, lambda m: bool(m[0] > 59.9 and 0.1 < m[2] < 9.9))
    return cut(
        angle,
        cylinder(4.5, 30, (42, 11, -5)),
        cylinder(4.5, 30, (42, 29, -5)),
        cylinder(7.0, 30, (-5, 20, 34), X),
    )


def low_pads() -> Any:
    """A plate (90 x 60 x 12) with low pads and shallow pockets whose outlines turn corners."""
    plate = fuse(
        box((90, 60, 12)),
        box((26, 20, 1.2), (8, 8, 12)),
        fillet(box((26, 18, 2.2), (8, 34, 12)), 5.0, lambda m: bool(abs(m[2] - 13.1) < 1e-6)),
    )
    ell = prism(disc(polygon([(44, 8, 10.9), (82, 8, 10.9), (82, 26, 10.9), (60, 26, 10.9),
                              (60, 36, 10.9), (44, 36, 10.9)])), (0, 0, 5))  # fmt: skip
    return cut(plate, ell, cylinder(6.0, 5.0, (72, 44, 11.0)))


def chamfered_link() -> Any:
    """A link with round ends (96 x 36 x 14), 1.2 off all along both outlines, and two bores."""
    link = fuse(
        box((60, 36, 14), (-30, -18, 0)),
        cylinder(18.0, 14.0, (-30, 0, 0)),
        cylinder(18.0, 14.0, (30, 0, 0)),
    )
    link = chamfer(link, 1.2, lambda m: bool(m[2] < 1e-6 or m[2] > 14 - 1e-6))
    return cut(link, cylinder(9.0, 20.0, (-30, 0, -2)), cylinder(6.0, 20.0, (30, 0, -2)))


def draft_pocket() -> Any:
    """A block (70 x 50 x 26) with a rounded pocket whose walls lean by 8 degrees."""
    sections = BRepOffsetAPI_ThruSections(True, True)
    for depth in (0.0, 18.0):
        inset = float(np.tan(np.radians(8.0)) * depth)
        width, length = 46 - 2 * inset, 28 - 2 * inset
        plug = prism(disc(_rectangle(width, length, 26 - depth)), (0, 0, 30))
        plug = fillet(plug, 9 - inset, lambda m: bool(m[2] > 26.1 - 18 and _is_post(m)))
        floor = min(occt.subshapes(plug, occt.FACE), key=_height)
        sections.AddWire(occt.subshapes(floor, occt.WIRE)[0])
    sections.Build()
    return cut(box((70, 50, 26), (-35, -25, 0)), sections.Shape())


def shallow_roof() -> Any:
    """A prism (80 x 50) whose roof has edges of 11, 13, 16 and 20 degrees."""
    outline = [(0.0, 0.0, 0.0), (80.0, 0.0, 0.0), (80.0, 0.0, 20.0)]
    slope = np.radians(30.0)
    for turn in (11.0, 13.0, 16.0, 20.0):
        x, _, z = outline[-1]
        outline.append((x - 16.0, 0.0, z + 16.0 * float(np.tan(slope))))
        slope -= np.radians(turn)
    x, _, z = outline[-1]
    outline.append((0.0, 0.0, z + x * float(np.tan(slope))))
    return prism(disc(polygon(outline)), (0, 50, 0))


def thin_box() -> Any:
    """A tray (60 x 45 x 25) with walls of 2: 3.6 spacings at 50,000 points."""
    return cut(box((60, 45, 25)), box((56, 41, 25), (2, 2, 2)))


def crossing_bores() -> Any:
    """A block (50 x 50 x 40) with two crossing bores of one radius, and a third smaller one."""
    return cut(
        box((50, 50, 40)),
        cylinder(10, 60, (-5, 25, 20), X),
        cylinder(10, 60, (25, -5, 20), Y),
        cylinder(5, 50, (25, 25, -5)),
    )


def tangent_chain() -> Any:
    """A rounded slab (80 x 50 x 16) with an oblong pocket; the top rim is rounded all round."""
    slab = fillet(box((80, 50, 16)), 12.0, lambda m: bool(0.1 < m[2] < 15.9))
    slab = fillet(slab, 4.0, lambda m: bool(m[2] > 15.9))
    oblong = fuse(
        box((30, 20, 10), (25, 15, 8)), cylinder(10, 10, (25, 25, 8)), cylinder(10, 10, (55, 25, 8))
    )
    return cut(slab, oblong)


def chamfered_nest() -> Any:
    """A block (60 x 60 x 24) on a wider base, every vertical edge chamfered, and a hexagon bore."""
    block = chamfer(box((60, 60, 24), (-30, -30, 10)), 6.0, lambda m: bool(12 < m[2] < 32))
    turns = np.arange(6) * np.pi / 3
    hexagon = polygon([(16 * float(np.cos(t)), 16 * float(np.sin(t)), -5.0) for t in turns])
    block = fuse(block, box((84, 60, 10), (-42, -30, 0)))
    return unified(cut(block, prism(disc(hexagon), (0, 0, 60))))


def two_bodies() -> Any:
    """Two parts that do not touch: a stepped block and a bored disc."""
    both, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(both)
    builder.Add(both, cut(box((40, 40, 25)), box((20, 40, 12), (20, 0, 13))))
    builder.Add(both, cut(cylinder(18, 20, (80, 20, 0)), cylinder(8, 30, (80, 20, -5))))
    return both


def slotted_plate() -> Any:
    """A rounded plate (100 x 60 x 14) with two slots, four counterbores and a rim rounded by 2."""
    plate = fillet(box((100, 60, 14)), 10.0, lambda m: bool(0.1 < m[2] < 13.9))
    bores = [_obround(18.0), _obround(42.0)]
    for x in (11.0, 89.0):
        for y in (11.0, 49.0):
            bores += [cylinder(3.5, 30, (x, y, -5)), cylinder(6.5, 30, (x, y, 8))]
    return fillet(cut(plate, *bores), 2.0, lambda m: bool(m[2] > 13.99 and _is_outer(m)))


def housing() -> Any:
    """An open housing (90 x 60 x 35, walls of 4) with blind screw bosses, a rib and two windows."""
    shell = fillet(box((90, 60, 35)), 10.0, lambda m: bool(0.1 < m[2] < 34.9))
    inside = fillet(box((82, 52, 40), (4, 4, 4)), 6.0, lambda m: bool(4.1 < m[2] < 43.9))
    shell = cut(shell, inside)
    for x in (13.0, 77.0):
        for y in (13.0, 47.0):
            boss = fuse(shell, cylinder(6, 26, (x, y, 3)))
            shell = cut(boss, cylinder(3, 20, (x, y, 14)))
    shell = fuse(shell, box((4, 52, 18), (43, 4, 3)))
    return cut(shell, box((24, 10, 12), (33, -3, 15)), cylinder(8, 10, (-3, 30, 20), X))


def rounded_box() -> Any:
    """A box (60 x 45 x 30) with all edges rounded by 5: an eighth of a ball in every corner."""
    return fillet(box((60, 45, 30)), 5.0, lambda m: True)


def sheet_channel() -> Any:
    """A channel (90 x 50 x 35) of sheet metal, 3 thick, bent on radius 2, with slots and holes."""
    sheet = cut(box((90, 50, 35)), box((100, 44, 40), (-5, 3, 3)))
    sheet = fillet(sheet, 5.0, lambda m: bool(m[2] < 1e-6 and min(m[1], 50 - m[1]) < 1e-6))
    sheet = fillet(sheet, 2.0, lambda m: bool(abs(m[2] - 3) < 1e-6 and 1.0 < m[0] < 89.0))
    for x in (20.0, 70.0):
        ends = [cylinder(4, 20, (x + s, 25, -5)) for s in (-6.0, 6.0)]
        slot = fuse(box((12, 8, 20), (x - 6, 21, -5)), *ends)
        sheet = cut(sheet, slot, cylinder(4, 70, (x, -5, 20), Y))
    return sheet


def _obround(y: float) -> Any:
    """What cuts a slot with round ends, 50 x 10."""
    ends = [cylinder(5, 30, (x, y, -5)) for x in (30.0, 70.0)]
    return fuse(box((40, 10, 30), (30, y - 5, -5)), *ends)


def _is_outer(middle: Any) -> bool:
    """Whether the middle of an edge is on the rim of the slotted plate."""
    return bool(min(middle[0], 100 - middle[0], middle[1], 60 - middle[1]) < 3.0)


def _rectangle(width: float, length: float, z: float) -> Any:
    x, y = width / 2, length / 2
    return polygon([(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)])


def _is_post(middle: Any) -> bool:
    """Whether the middle of an edge is that of an upright edge: at a corner, not on a side."""
    return bool(min(abs(middle[0]), abs(middle[1])) > 1.0)


def _height(face: Any) -> float:
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    return float(properties.CentreOfMass().Z())
