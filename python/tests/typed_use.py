"""What a user with a type checker writes: mypy --strict reads this, nothing runs it (scripts/python)."""

from typing import assert_type

import numpy as np
import pandas
import piste
import piste.distributed

run = piste.replay("run.yaml", judged=False, progress=lambda stage, part: print(stage, part))
assert_type(run, piste.Run)
assert_type(run.smoothed, piste.Solution)
assert_type(run.smoothed.to_pandas(), pandas.DataFrame)
assert_type(run.solution.to_pandas(), pandas.DataFrame)
run.plot(["height_m"], sigmas=3).savefig("run.png")
piste.replay(3)  # type: ignore[arg-type]
run.smothed  # type: ignore[attr-defined]  # noqa: B018

navigation = piste.filter_of(run)
navigation.add_gnss(0.0, [46.0, 7.0, 2500.0], [1.0, 1.0, 2.0])
navigation.state()["height_m"]
live = piste.Live("run.yaml")
live.add(0.01, [0.0, 0.0, 0.0], (0.0, 0.0, -9.81))
live.add(np.array([0.02, 0.03]), np.zeros((2, 3)), np.zeros((2, 3)))
live.add("now", 3)  # type: ignore[call-arg]
if (state := live.now()) is not None:
    print(state["sigma_euler_deg"])
assert_type(piste.inspect("imu.csv", pandas.DataFrame()).suspicions, list[str])
piste.distributed.montecarlo("scenario.yaml", 10_000, "out", until=0.05)["consistent"]
