"""The mapping from the sensing loop's slopes to the actuation tendon's: train, predict, keep."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
from numpy.typing import ArrayLike, NDArray

from sstl_cli.core.files import atomic
from sstl_cli.core.parquet import conform
from sstl_cli.core.tables import THETA
from sstl_cli.mapping import MappingModel, export_onnx, load_model, save_model
from sstl_cli.mapping.variants import LAMBDA, chosen
from sstl_cli.steps import evaluate as evaluating
from sstl_cli.steps import train as training


@dataclass(frozen=True)
class Mapping:
    """A trained mapping.

    Attributes
    ----------
    model : MappingModel
        Weights and header; ``model.header`` says what it was trained on and how.
    history : DataFrame or None
        Learning curves by variant, seed and epoch; None for a mapping that was loaded.
    """

    model: MappingModel
    history: pd.DataFrame | None = None

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Mapping:
        """Return a mapping from a file of ``sstl train`` or ``save``.

        Raises
        ------
        SstlError
            If the file is missing, damaged, or no mapping.
        """
        return cls(load_model(Path(path)))

    @property
    def variants(self) -> pd.DataFrame:
        """Name, title and validation RMSE of every variant."""
        return pd.DataFrame([v.model_dump() for v in self.model.header.variants])

    def predict(self, gamma_sstl: ArrayLike, tendon: str | None = None, variant: str | None = None) -> NDArray[np.float64]:
        """Return the slopes Gamma_p, Gamma_r of the actuation tendon, shape (n, 2), dimensionless.

        Parameters
        ----------
        gamma_sstl : array-like, shape (n, 2)
            Slopes Gamma_p, Gamma_r of the sensing loop, such as ``theta[["gamma_p", "gamma_r"]]``.
        tendon, variant : str, optional
            Needed where the mapping knows several tendons; another variant than the default.

        Raises
        ------
        SstlError
            For another shape, or an unknown tendon or variant.
        """
        return self.model.predict(np.asarray(gamma_sstl, np.float64), tendon, variant)

    def evaluate(self, theta: pd.DataFrame, everything: bool = False) -> pd.DataFrame:
        """Return the RMSE of every variant and seed on held-out configurations (on all with ``everything``)."""
        found = evaluating.run(self.model, table_of(theta), everything, "DataFrame")
        frame: pd.DataFrame = evaluating.evaluation_table(found, self.model.header.seeds).to_pandas()
        return frame

    def predictions(self, theta: pd.DataFrame, everything: bool = False) -> pd.DataFrame:
        """Return true and predicted slopes of every judged pair and variant, as ``sstl evaluate --predictions`` writes them."""
        frame: pd.DataFrame = evaluating.predictions_table(evaluating.run(self.model, table_of(theta), everything, "DataFrame")).to_pandas()
        return frame

    def save(self, path: str | PathLike[str], force: bool = False) -> None:
        """Write the mapping as safetensors, whole or not at all."""
        save_model(Path(path), self.model, force)

    def export(self, path: str | PathLike[str], force: bool = False) -> None:
        """Write the default prediction as an ONNX graph, whole or not at all.

        Raises
        ------
        SstlError
            Without the extra ``onnx``, or if the file exists and ``force`` is not given.
        """
        with atomic(Path(path), force) as temporary:
            export_onnx(self.model, temporary)

    def __repr__(self) -> str:
        header = self.model.header
        return f"Mapping({header.default} of {len(header.variants)} variants, {len(header.seeds)} seeds)"


def train(
    theta: pd.DataFrame,
    *,
    variants: str = "all",
    seeds: int = 20,
    seed: int = 0,
    epochs: int | None = None,
    weight_inv: float = LAMBDA,
    test_share: float = 0.25,
    per_seed_split: bool = False,
    leave_out: str | None = None,
    tendons: str = "auto",
) -> Mapping:
    """Return a mapping trained on a Theta table; parameters as the options of ``sstl train``.

    Parameters
    ----------
    theta : DataFrame
        Theta table with ``act`` and ``sstl`` rows of at least 8 configurations, as ``log.segment()`` returns it.
    variants : str
        ``all``, or some of linear, plain, plain-inv, skip, skip-inv with commas.
    seeds, seed : int
        Number of training seeds, from ``seed`` upwards.
    epochs : int, optional
        Most epochs (600 by default).
    weight_inv : float
        Weight of the inverse-consistency term.
    test_share : float
        Share of configurations held out.
    per_seed_split : bool
        Hold out other configurations for every seed.
    leave_out : str, optional
        Hold out this location instead of a share.
    tendons : str
        With several tendons: one-hot (one mapping with tendon inputs), separate (one each), or auto (the better of both).

    Raises
    ------
    SstlError
        With too few pairs, or an unknown variant or location.

    Examples
    --------
    >>> from sstl_cli.api.log import simulate
    >>> theta = simulate("sample-40", seed=1).segment()
    >>> train(theta, variants="linear", seeds=2)
    Mapping(linear of 1 variants, 2 seeds)
    """
    config = training.Config(chosen(variants, weight_inv), seeds, seed, epochs, test_share, per_seed_split, leave_out, tendons)
    found = training.run(table_of(theta), config, where="DataFrame")
    return Mapping(found.model, found.history.to_pandas())


def relate(theta: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return how the slopes of both systems relate (Tables I and II), as ``sstl evaluate --tables`` tells it.

    Parameters
    ----------
    theta : DataFrame
        Theta table with ``act`` and ``sstl`` rows, as ``log.segment()`` returns it.

    Returns
    -------
    correlation : DataFrame
        A row a direction: Gamma_sstl against the square of Gamma_act, dimensionless.
    slopes : DataFrame
        A row a system and quantity: mean, standard deviation and range.

    Raises
    ------
    SstlError
        If no configuration has both systems.

    Examples
    --------
    >>> from sstl_cli.api.log import simulate
    >>> correlation, slopes = relate(simulate("sample", seed=1).segment())
    >>> correlation["direction"].tolist(), slopes["system"].unique().tolist()
    (['pull', 'release'], ['act', 'sstl'])
    """
    found = evaluating.run_tables(table_of(theta), "DataFrame").relations
    correlation = [{"direction": name, **asdict(row)} for name, row in found.correlation.items()]
    slopes = [{"system": system, "quantity": name, **asdict(row)} for system, rows in found.slopes.items() for name, row in rows.items()]
    return pd.DataFrame(correlation), pd.DataFrame(slopes)


def table_of(theta: pd.DataFrame) -> pa.Table:
    """Return a Theta table as Arrow, its columns checked; NaN is null there."""
    return conform(pa.Table.from_pandas(theta, preserve_index=False), THETA, "DataFrame").replace_schema_metadata(None)
