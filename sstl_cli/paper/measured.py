"""The sampling spread of the tables over data sets, measured seed by seed into a folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from sstl_cli.core.documents.outputs import ReproduceDocument
from sstl_cli.core.files import write_text
from sstl_cli.paper import data_seeds
from sstl_cli.paper.spread import FILES, Draw, of_draws, parse
from sstl_cli.paper.written import require


def run(
    table: str, out: Path, seed: int, seeds: int, force: bool = False, advance: Callable[[float], None] = lambda _: None
) -> ReproduceDocument:
    """Measure a sampling spread and write it to the folder: of block R, Table III, or Tables I, II and IV.

    What a stopped run has left in ``seeds`` inside the folder is taken up.
    """
    experiment = table if table in FILES else "generator"
    name = FILES[experiment]
    require(out, (name,), force)

    def place(one: int) -> Path:
        return out / "seeds" / f"{experiment}-{one:05d}.csv"

    def at_hand(one: int) -> Draw | None:
        if not place(one).is_file():
            return None
        kept = parse(place(one).read_text(encoding="utf-8"))
        return {block: {key: mean for key, (mean, _) in moments.items()} for block, moments in kept.blocks.items()}

    def keep(one: int, draw: Draw) -> None:
        write_text(place(one), of_draws([draw]).csv(), True)

    (out / "seeds").mkdir(exist_ok=True)
    draws = []
    for draw in data_seeds.run(experiment, range(seed + 1, seed + 1 + seeds), at_hand, keep):
        draws.append(draw)
        advance(1)
    write_text(out / name, of_draws(draws).csv(), force)
    return ReproduceDocument(schema="sstl.reproduce/1", spread=str(out / name), seed=seed, seeds=seeds)
