"""Mapping: predicted against true, residuals, variants with seed spread, training curves, the model."""

from __future__ import annotations

from sstl_cli.core.tables import EVALUATION
from sstl_cli.reporting import drawing
from sstl_cli.reporting.figures import predicted, residuals, training, variants
from sstl_cli.reporting.inputs import Inputs
from sstl_cli.reporting.rows import apart
from sstl_cli.reporting.sections.summary import flat
from sstl_cli.reporting.table import table

TITLE, ORDER, NEEDS = "Mapping", 40, ("predictions", "evaluation", "evaluate", "history", "model")


def context(inputs: Inputs) -> dict[str, object]:
    """Return the pictures and tables that the given inputs allow."""
    pictures = [
        (heading, drawing.picture(module, found, name))
        for heading, module, name in (
            ("Predicted against true", predicted, "predicted"),
            ("Residuals", residuals, "residuals"),
            ("Variants and their spread over seeds", variants, "variants"),
            ("Training curves", training, "training"),
        )
        if (found := module.default(inputs, None)) is not None
    ]
    tables = []
    if inputs.evaluation:
        tables.append(
            table(
                "Evaluation",
                [(c.name, c.unit) for c in EVALUATION.columns],
                ([getattr(row, c.name) for c in EVALUATION.columns] for row in apart(inputs.evaluation)),
            )
        )
    for name, document in inputs.evaluate:
        tables.append(table(f"Evaluation: {name}", ["field", "value"], flat(document)))
    for model in inputs.model:
        tables.append(
            table(
                f"Model {model.name} ({model.parameters} parameters)",
                ["tensor", "type", "shape"],
                ([n, t, " × ".join(map(str, s)) or "scalar"] for n, t, s in model.tensors),
            )
        )
        if model.metadata:
            tables.append(table(f"Model {model.name}: notes", ["field", "value"], model.metadata.items()))
    return {"pictures": pictures, "tables": tables}
