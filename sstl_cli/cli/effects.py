"""``sstl effects``: the catalogue of effects that a simulator may leave out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from sstl_cli.cli.options import Config, Json, usage
from sstl_cli.cli.render import Screen

if TYPE_CHECKING:
    from sstl_cli.core.documents.effects import EffectPart
    from sstl_cli.physics.effect import Effect

effects_app = typer.Typer(
    help="List and explain the effects of the catalogue.",
    no_args_is_help=True,
    rich_markup_mode=None,
    epilog="Example: sstl effects show pulley_friction",
)


def register(app: typer.Typer) -> None:
    """Add the subcommand group."""
    app.add_typer(effects_app, name="effects")


def _part(effect: Effect) -> EffectPart:
    from sstl_cli.core.documents.effects import EffectParameter, EffectPart

    return EffectPart(
        id=effect.id,
        title=effect.title,
        stage=effect.stage,
        equation=effect.equation,
        source=effect.source,
        excitation=effect.excitation,
        channel=effect.channel,
        needs=list(effect.needs),
        systems=list(effect.systems),
        fitted=effect.fitted,
        look_alikes=list(effect.look_alikes),
        parameters=[
            EffectParameter(name=p.name, unit=p.unit, neutral=p.neutral, low=p.low, high=p.high, meaning=p.meaning)
            for p in effect.parameters
        ],
    )


@effects_app.command("list", epilog="Example: sstl effects list --json")
def list_effects(as_json: Json = False, config: Config = None) -> None:
    """List all effects."""
    from sstl_cli.core.documents.effects import EffectsDocument
    from sstl_cli.physics.effects import catalogue

    screen = Screen(as_json)
    rows = [(e.id, e.stage, e.title) for e in catalogue().values()]
    screen.say(f"{len(rows)} effects that a simulator may leave out; 'sstl effects show ID' explains one.")
    screen.table("", ("id", "stage", "title"), rows)
    screen.finish(EffectsDocument(schema="sstl.effects/1", effects=[_part(e) for e in catalogue().values()]))


@effects_app.command("show", epilog="Example: sstl effects show pulley_friction")
def show_effect(
    effect_id: Annotated[str, typer.Argument(metavar="ID", help="Id of the effect.")], as_json: Json = False, config: Config = None
) -> None:
    """Show one effect: equation, source, parameters, and what it takes to see it."""
    from sstl_cli.core.documents.effects import EffectDocument
    from sstl_cli.physics.effects import get

    screen = Screen(as_json)
    with usage("ID"):
        effect = get(effect_id)
    screen.say(f"{effect.id}: {effect.title} ({effect.stage})")
    screen.say(f"  {effect.equation}")
    screen.say(f"  source: {effect.source}")
    screen.say(f"  shows with: {effect.excitation}")
    if effect.needs:
        screen.say(f"  needs the channel: {', '.join(effect.needs)}")
    if effect.look_alikes:
        screen.say(f"  may be mistaken for: {', '.join(effect.look_alikes)}")
    rows = [(p.name, "" if p.unit == "1" else p.unit, p.neutral, p.low, p.high, p.meaning) for p in effect.parameters]
    screen.table("", ("parameter", "unit", "neutral", "low", "high", "meaning"), rows)
    screen.finish(EffectDocument.joined(_part(effect), schema="sstl.effect/1"))
