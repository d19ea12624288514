"""What ``--json`` prints where a command fails (exit codes 1 and 2)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from sstl_cli.core.documents.base import Document
from sstl_cli.core.errors import SstlError, shown


class ErrorDocument(Document):
    """A failure: a stable code, what went wrong and where, and what to do."""

    schema_id: Literal["sstl.error/1"] = Field(alias="schema")
    code: str = Field(pattern=r"^E\d{3}$", description="stable code, explained in docs/errors.md")
    message: str = Field(description="what went wrong, and where, in one line")
    fix: str = Field(description="what to do about it; empty where there is nothing to say")
    where: str = Field(default="", description="file, run, column or option concerned")
    exit_code: int = Field(default=1, description="exit code of the program")


def of(error: SstlError) -> ErrorDocument:
    """Return the document of an error."""
    message = f"{error.where}: {error.what}" if error.where else error.what
    return ErrorDocument(
        schema="sstl.error/1",
        code=error.code,
        message=shown(message),
        fix=shown(error.fix),
        where=shown(error.where),
        exit_code=error.exit_code,
    )
