"""Write a scenario back as TOML, so that an accepted model can be used by the next command."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from sstl_cli.physics.scenario import Scenario


def dump(scenario: Scenario, movements: str = "") -> str:
    """Return a scenario as TOML text that ``load`` reads back unchanged, with a remark above its movements where one is given."""
    document = scenario.model_dump(mode="json", by_alias=True, exclude_none=True)
    lines = [f"{k} = {_value(v)}" for k, v in document.items() if not isinstance(v, (dict, list))]
    for key in ("rig", "noise"):
        lines += ["", *_table(key, document[key])]
    for effect_id, values in document.get("effects", {}).items():
        lines += ["", *_table(f"effects.{effect_id}", values)]
    if document.get("laws"):
        lines += ["", *_table("laws", document["laws"])]
    if document.get("dispersion"):
        lines += ["", "[dispersion]", *(f"{_value(k)} = {_value(v)}" for k, v in document["dispersion"].items())]
    if document.get("faults"):
        lines += ["", *_table("faults", document["faults"])]
    if document.get("wander"):
        lines += ["", *_table("wander", document["wander"])]
    if document.get("output"):
        lines += ["", *_table("output", document["output"])]
    for key in ("configurations", "trajectories", "tendons", "misfits"):
        for place, item in enumerate(document.get(key, [])):
            remark = [f"# {movements}"] if key == "trajectories" and movements and not place else []
            lines += ["", *remark, f"[[{key}]]", *(f"{k} = {_value(v)}" for k, v in item.items())]
    return "\n".join(lines) + "\n"


def _table(name: str, values: Mapping[str, object]) -> list[str]:
    return [f"[{name}]", *(f"{k} = {_value(v)}" for k, v in values.items())]


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    # JSON strings and numbers are TOML strings and numbers
    return json.dumps(value)
