"""What a number of a document goes with when tensions are brought to another unit: said once, beside the field."""

from __future__ import annotations

from enum import Enum


class Quantity(Enum):
    """What a field is: in its annotation, for whoever brings a document to the units of a recording.

    A field without one is in no unit of tension, or in one that its name or ``unit`` says and that stays.
    """

    INPUT = "a tension of the input, or its rate"
    OUTPUT = "how large a difference of the output is, in its unit"
    DIFFERENCE = "a difference of the output with its sign, in its unit"
    READING = "what the output reads, in its unit and from its origin"
    OWN = "in the field ``unit`` beside it"
