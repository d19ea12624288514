"""Mapping of the sensing loop's slopes to the actuation tendon's (Section IV): data, networks, weights, export.

Loading and prediction need numpy alone; torch is imported by ``training`` only.
"""

from __future__ import annotations

from sstl_cli.mapping.inference import MappingModel
from sstl_cli.mapping.onnx_export import export_onnx
from sstl_cli.mapping.weights import load_model, save_model

__all__ = ["MappingModel", "export_onnx", "load_model", "save_model"]
