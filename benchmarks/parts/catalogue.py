"""The parts by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from parts import freeform, prismatic, turned

PARTS: dict[str, Callable[[], Any]] = {
    maker.__name__.replace("_", "-"): maker
    for maker in (
        prismatic.pocket_block,
        prismatic.filleted_bracket,
        prismatic.draft_pocket,
        prismatic.shallow_roof,
        prismatic.thin_box,
        prismatic.crossing_bores,
        prismatic.tangent_chain,
        prismatic.chamfered_nest,
        prismatic.two_bodies,
        prismatic.slotted_plate,
        prismatic.housing,
        prismatic.rounded_box,
        prismatic.sheet_channel,
        prismatic.low_pads,
        prismatic.chamfered_link,
        turned.flange,
        turned.cone_hub,
        turned.ball_rod,
        turned.ring_groove,
        turned.filleted_boss,
        turned.hex_bolt,
        turned.stepped_shaft,
        turned.keyed_shaft,
        turned.spline_vase,
        turned.elbow,
        freeform.lofted_body,
        freeform.wavy_block,
        freeform.variable_fillet,
        freeform.fading_crease,
        freeform.bent_sheet,
    )
}
"""Name to the function that models the part; its docstring says what is in it."""
