# SPDX-License-Identifier: LGPL-3.0-or-later
"""The README's snippets run verbatim, each by itself, beside the meshes."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from processes import HANGS

TOP = Path(__file__).resolve().parent.parent
SNIPPETS = re.findall(r"```python\n(.*?)```", (TOP / "README.md").read_text(), re.DOTALL)


def test_there_are_snippets():
    assert len(SNIPPETS) >= 5


@pytest.mark.parametrize("snippet", SNIPPETS, ids=range(len(SNIPPETS)))
def test_snippet(snippet, tmp_path):
    (tmp_path / "meshes").symlink_to(TOP / "meshes")
    (tmp_path / "snippet.py").write_text(snippet)
    run = subprocess.run(
        [sys.executable, "snippet.py"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(TOP)},
        capture_output=True,
        text=True,
        timeout=HANGS,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert "print(" not in snippet or run.stdout.strip()
    assert "stopped" not in run.stdout
