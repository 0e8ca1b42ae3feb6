"""Shared fixtures: the simulated ski run, simulated and replayed once."""

from pathlib import Path

import piste
import pytest

SOURCE = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def config() -> Path:
    """The ski run that comes with piste."""
    return SOURCE / "config/ski_run.yaml"


@pytest.fixture(scope="session")
def imu() -> piste.Table:
    """Its IMU."""
    return piste.read(SOURCE / "data/ski_run/mt9a_1.csv")


@pytest.fixture(scope="session")
def gnss() -> piste.Table:
    """Its receiver."""
    return piste.read(SOURCE / "data/ski_run/gnss.csv")


@pytest.fixture(scope="session")
def run(config: Path) -> piste.Run:
    return piste.replay(config)


@pytest.fixture(scope="session")
def scenario(tmp_path_factory) -> Path:
    """A scenario that takes a fraction of a second."""
    file = tmp_path_factory.mktemp("scenario") / "tiny.yaml"
    base = SOURCE / "config/scenarios/montecarlo/bicycle_l1l2.yaml"
    file.write_text(f"base: {base}\nmotion: {{rest_before: 2 s, run: 13 s, rest_after: 1 s}}\n")
    return file
