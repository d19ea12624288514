"""``sstl doctor``: what is installed, and whether it works."""

from __future__ import annotations

import typer

from sstl_cli.cli.options import Config, Json
from sstl_cli.cli.render import Screen

EPILOG = "Example: sstl doctor --json > doctor.json"


def register(app: typer.Typer) -> None:
    """Add the subcommand."""
    app.command("doctor", epilog=EPILOG)(doctor)


def doctor(as_json: Json = False, config: Config = None) -> None:
    """Print versions, cores, caches and extras, and run a self-test of a few seconds (exit 1 if it fails)."""
    from sstl_cli.core.errors import EXIT_DONE, EXIT_FAILED
    from sstl_cli.steps import doctor as step

    screen = Screen(as_json)
    found = step.run()
    bad = ", ".join(p.name for p in found.probes if not p.ok)
    screen.say("This installation works." if found.ok else f"This installation does not work as it should: {bad}.")
    screen.say(f"sstl {found.sstl}, Python {found.python}, {found.system}")
    screen.say(f"{found.cores_usable} of {found.cores} cores usable")
    screen.say(", ".join(f"{name} {version or 'missing'}" for name, version in found.packages.items()))
    for name, present in found.extras.items():
        screen.say(f"extra {name}: {'present' if present else f'absent (pip install sstl-cli[{name}])'}")
    for probe in found.probes:
        screen.say(f"{'good' if probe.ok else 'BAD '} {probe.name}: {probe.detail}")
        if not probe.ok:
            screen.note(f"{probe.name}: {probe.fix}")
    screen.finish(found, EXIT_DONE if found.ok else EXIT_FAILED)
