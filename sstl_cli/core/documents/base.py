"""What every JSON document of the toolchain has: a schema id; fields may be added, never renamed."""

from __future__ import annotations

from typing import Any, Self, get_args

from pydantic import BaseModel, ConfigDict, Field

DIALECT = "https://json-schema.org/draft/2020-12/schema"


class Part(BaseModel):
    """A part of a document: frozen, and open to fields that a later version adds."""

    model_config = ConfigDict(frozen=True, extra="allow")

    def plain(self) -> dict[str, Any]:
        """Return what JSON is written from, in the order of the fields; one that was not given stays away."""
        return self.model_dump(by_alias=True, exclude_unset=True)


class DataSetAside(Part):
    """Samples of a run that no recorder can have measured."""

    run_id: str
    samples: int = Field(description="that are not used; 0 where the run was only split")
    of: int = Field(description="samples of the run")
    why: str


class Document(Part):
    """A document with a schema id in its field ``schema``."""

    data_set_aside: list[DataSetAside] | None = Field(
        default=None, description="what the reading of logs set aside, where it did, the first 1000 entries; the exit code is 3 then"
    )
    data_set_aside_more: int | None = Field(default=None, description="entries beyond those, where there are any")

    @classmethod
    def joined(cls, *parts: Part, **fields: object) -> Self:
        """Return a document from parts that it inherits from and fields of its own, all of it checked.

        A field that no part was given stays away.
        """
        return cls.model_validate({name: value for part in parts for name, value in part.plain().items()} | fields)

    def plain(self) -> dict[str, Any]:
        """Return what JSON is written from: the schema id, the fields that were given, inherited ones too, and what was set aside."""
        found = super().plain()
        aside: dict[str, Any] = {name: found.pop(name) for name in ("data_set_aside", "data_set_aside_more") if name in found}
        return {"schema": found.pop("schema"), **found, **aside}

    @classmethod
    def schema_name(cls) -> str:
        """Return the schema id, such as ``sstl.diagnosis/1``."""
        return str(get_args(cls.model_fields["schema_id"].annotation)[0])

    @classmethod
    def json_schema(cls) -> dict[str, Any]:
        """Return the JSON Schema (draft 2020-12) that every such document validates against."""
        found = cls.model_json_schema(by_alias=True)
        return {"$schema": DIALECT, "$id": f"urn:sstl:{cls.schema_name().replace('/', ':')}", **found, "title": cls.schema_name()}
