"""What the surfaces of a model leave open, in words that name the place."""

from __future__ import annotations

from dataclasses import dataclass

from crispline.surface.base import Array, Similarity


@dataclass(frozen=True)
class Doubt:
    """Something that the surfaces leave open.

    Attributes
    ----------
    text : what, with ``{place}`` where its place is to be named.
    position : the place, in the frame of the model, shape ``(3,)``.
    """

    text: str
    position: Array

    def sentence(self, to_user: Similarity) -> str:
        """The sentence with the place in the user's unit."""
        place = "({:.4g}, {:.4g}, {:.4g})".format(*to_user.points(self.position))
        return self.text.format(place=place)
