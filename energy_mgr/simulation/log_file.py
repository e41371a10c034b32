"""The log of a drive as a Parquet file."""

from __future__ import annotations

import importlib
import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import PlanningError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike

    from numpy.typing import NDArray


def write(columns: Mapping[str, NDArray[Any]], about: Mapping[str, Any], path: str | PathLike[str]) -> Path:
    """Write columns (n,) and, as metadata, what they are about; whole or not at all.

    Raises:
        PlanningError: the place cannot be written to.
    """
    path = Path(path)
    arrow: Any = importlib.import_module("pyarrow")
    parquet: Any = importlib.import_module("pyarrow.parquet")
    table = arrow.table(dict(columns)).replace_schema_metadata({b"energy_mgr.drive": json.dumps(about, default=str).encode()})
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".drive-") as folder:
            staged = Path(folder, "log.parquet")
            parquet.write_table(table, staged, compression="zstd", use_dictionary=False, use_byte_stream_split=True)
            staged.replace(path)
    except OSError as error:
        raise PlanningError(f"{path}: cannot be written: {error.strerror or error}") from None
    return path
