# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forms compiled in silence: the driver of the C compiler tells its commands to everyone's root
logger, and a first use looks like a failure."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import ufl
from dolfinx import fem


@contextmanager
def quiet_compiler() -> Iterator[None]:
    """Let nobody log but warnings and errors."""
    before = logging.root.manager.disable
    logging.disable(max(before, logging.INFO))
    try:
        yield
    finally:
        logging.disable(before)


@quiet_compiler()
def compiled(form: ufl.Form) -> Any:
    """The form, compiled or taken from the cache."""
    return fem.form(form)
