"""The exceptions of piste for wrong input. Each states where the fault is, what it is, and how to correct it."""

import re


class Error(Exception):
    """Base of all errors of piste. `where` is a file with its line, a table with its row, a keyword, or a time of the run."""

    def __init__(self, message: str, where: str = ""):
        super().__init__(message)
        self.where = where

    @property
    def file(self) -> str | None:
        """The wrong file, table, or keyword with its `=`."""
        return re.sub(r"(: (row|byte) |:)\d+$", "", self.where) or None

    @property
    def line(self) -> int | None:
        """The line of the fault, from 1; in a table its row, from 0."""
        place = re.search(r"(: row |:)(\d+)$", self.where)
        return int(place[2]) if place else None


class ConfigError(Error, ValueError):
    """A configuration, or a keyword, is wrong."""


class DataError(Error):
    """The data cannot be processed."""
