"""``sstl schema``: the JSON Schemas of the documents that commands print."""

from __future__ import annotations

from typing import Annotated

import typer

from sstl_cli.cli.options import Config, Json
from sstl_cli.cli.render import Screen

EPILOG = "Example: sstl schema diagnosis > diagnosis.schema.json"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("schema", epilog=EPILOG)(schema)


def schema(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Document, such as diagnosis; without a name: list them.")] = None,
    as_json: Json = False,
    config: Config = None,
) -> None:
    """Print the JSON Schema of a document (draft 2020-12); every document of --json validates against its own."""
    from sstl_cli.core.documents import catalogue, get
    from sstl_cli.core.documents.effects import SchemaEntry, SchemasDocument

    screen = Screen(as_json)
    if name is not None:
        model = get(name)
        # a schema is JSON in any case
        screen.as_json = True
        screen.finish(model)
    rows = [(known, model.schema_name(), (model.__doc__ or "").splitlines()[0].replace("``", "'")) for known, model in catalogue().items()]
    screen.say(f"{len(rows)} documents; 'sstl schema NAME' prints what is in one.")
    screen.table("", ("name", "schema", "what"), rows)
    screen.finish(SchemasDocument(schema="sstl.schemas/1", documents=[SchemaEntry(name=n, id=i, what=w) for n, i, w in rows]))
