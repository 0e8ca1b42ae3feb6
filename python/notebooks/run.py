"""Runs a notebook from its first cell to its last: python run.py NOTEBOOK. The file is not changed."""

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

notebook = Path(sys.argv[1]).resolve()
cells = nbformat.read(notebook, as_version=4)
NotebookClient(
    cells, timeout=900, kernel_name="python3", resources={"metadata": {"path": str(notebook.parent)}}
).execute()
print(f"{notebook.name}: {sum(cell.cell_type == 'code' for cell in cells.cells)} cells ran")
