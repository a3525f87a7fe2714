#!/usr/bin/env python3
"""Drives an exported unit with libcosim, from export to plot, and holds the result against FMPy.

    cargo build --release && pip install libcosimpy fmpy matplotlib && python3 docs/examples/libcosim_plot.py

Writes plate.png. Exit code 0: both importers got the same numbers.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from fmpy import simulate_fmu
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

ROOT = Path(__file__).resolve().parents[2]
STEP, STEPS = 2e-3, 150
FORCE = "point[1].force.y"


def with_libcosim(unit):
    """Tip over time of the swinging plate, with a force of 20 N at one of its points."""
    execution = CosimExecution.from_step_size(step_size=round(STEP * 1e9))
    plate = execution.add_local_slave(CosimLocalSlave(fmu_path=str(unit), instance_name="plate"))
    references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(plate)}
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)
    manipulator.slave_real_values(plate, [references[FORCE]], [20.0])
    tip = []
    for step in range(STEPS):
        if not execution.step():
            sys.exit(f"step {step} failed")
        tip.append(observer.last_real_values(plate, [references["tip.uy"]])[0])
    return np.array(tip)


def with_fmpy(unit):
    times = {"stop_time": STEPS * STEP, "step_size": STEP, "output_interval": STEP}
    result = simulate_fmu(str(unit), **times, start_values={FORCE: 20.0}, output=["tip.uy"])
    return result["tip.uy"][1:]


def main():
    with tempfile.TemporaryDirectory() as folder:
        unit = Path(folder) / "plate.fmu"
        export = ["export-fmu", "cases/oscillating_plate", "--fmi", "2", "--points", "4", "-o", unit]
        subprocess.run([ROOT / "target" / "release" / "meniscus", *export], cwd=ROOT, check=True)
        ours, other = with_libcosim(unit), with_fmpy(unit)
    difference = np.max(np.abs(ours - other)) / np.max(np.abs(other))
    print(f"libcosim and FMPy differ by {difference:.1e} of the largest deflection")
    times = STEP * np.arange(1, STEPS + 1)
    plt.plot(times, 1e3 * ours, label="libcosim")
    plt.plot(times, 1e3 * other, "--", label="FMPy")
    plt.xlabel("time (s)"), plt.ylabel("deflection of the tip (mm)"), plt.legend()
    plt.savefig("plate.png", dpi=120)
    # Times are sums of nanoseconds in one and of seconds in the other.
    if difference > 1e-9:
        sys.exit("they differ")


if __name__ == "__main__":
    main()
