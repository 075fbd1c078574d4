"""What finds borders and corners: by search on the surfaces, or drawn between them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from crispline.region.topology import Chain
from crispline.sharp.corner import Corner
from crispline.sharp.crease import Border, Crease, Ends
from crispline.sharp.trace import Guide
from crispline.surface.base import Array


class Finder(Protocol):
    """Where borders run and corners are; :class:`crispline.sharp.draw.Drawing` tells what the
    parameters mean.
    """

    def borders(self, chains: Sequence[Chain], guides: Sequence[Guide]) -> list[Border]: ...

    def corners(
        self,
        places: Array,
        around: Sequence[Sequence[int]],
        chains: Sequence[Chain],
        borders: Sequence[Border],
    ) -> list[Corner]: ...

    def creases(
        self, chains: Sequence[Chain], borders: Sequence[Border], ends: Sequence[Ends]
    ) -> list[Crease]: ...
