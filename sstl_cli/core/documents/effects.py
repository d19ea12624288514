"""What ``effects`` and ``schema`` list."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document, Part


class EffectParameter(Part):
    """A parameter of an effect; at ``neutral`` the effect is exactly absent."""

    name: str
    unit: str
    neutral: float
    low: float
    high: float
    meaning: str


class EffectPart(Part):
    """One effect of the catalogue."""

    id: str
    title: str
    stage: str
    equation: str
    source: str
    excitation: str = Field(description="what the recording must do for the effect to show")
    channel: str
    needs: list[str]
    systems: list[str]
    fitted: bool
    look_alikes: list[str]
    parameters: list[EffectParameter]


class EffectDocument(EffectPart, Document):
    """One effect: equation, source, parameters (``sstl effects show``)."""

    schema_id: Literal["sstl.effect/1"] = Field(alias="schema")


class EffectsDocument(Document):
    """The catalogue of effects (``sstl effects list``)."""

    schema_id: Literal["sstl.effects/1"] = Field(alias="schema")
    effects: list[EffectPart]


class SchemaEntry(Part):
    """One document of the toolchain."""

    name: str
    id: str
    what: str


class SchemasDocument(Document):
    """The documents of the toolchain (``sstl schema``)."""

    schema_id: Literal["sstl.schemas/1"] = Field(alias="schema")
    documents: list[SchemaEntry]
