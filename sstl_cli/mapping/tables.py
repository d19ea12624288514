"""Tables that training and evaluation write beside those of the contract."""

from __future__ import annotations

import pyarrow as pa

from sstl_cli.core.tables import Column, Schema

HISTORY = Schema(
    "sstl.history",
    1,
    (
        Column("variant", pa.string()),
        Column("seed", pa.int64()),
        Column("tendon", pa.string(), nullable=True, meaning="tendon of the mapping; null where one serves all"),
        Column("epoch", pa.int64()),
        Column("train_loss", pa.float64(), "1", meaning="Eq. (loss) on the fit part"),
        Column("val_loss", pa.float64(), "1", meaning="squared error on the validation part"),
    ),
)

PREDICTIONS = Schema(
    "sstl.predictions",
    1,
    (
        Column("config_id", pa.string()),
        Column("location", pa.string(), nullable=True),
        Column("tendon", pa.string(), nullable=True),
        Column("variant", pa.string()),
        Column("gamma_p_true", pa.float64(), "1"),
        Column("gamma_p_pred", pa.float64(), "1", meaning="mean over seeds"),
        Column("gamma_r_true", pa.float64(), "1"),
        Column("gamma_r_pred", pa.float64(), "1", meaning="mean over seeds"),
        Column("outside", pa.bool_(), meaning="input outside the trained range"),
    ),
)
