#!/usr/bin/env python3
"""Holds exported units against FMPy and against native runs of the same cases.

    cargo build --release && pip install fmpy && python3 docs/examples/fmpy_check.py

Exit code 0: no finding, and all numbers agree.
"""

import csv
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

ROOT = Path(__file__).resolve().parents[2]
MENISCUS = ROOT / "target" / "release" / "meniscus"


def meniscus(*arguments):
    subprocess.run([MENISCUS, *map(str, arguments)], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def native(case, out, *settings):
    """Columns of probes.csv of a native run, and the ends of its windows."""
    meniscus("run", case, "--quiet", "--no-report", "--out", out, *settings)
    with open(out / "probes.csv") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def close(what, found, expected, tolerance):
    error = float(np.max(np.abs(np.asarray(found) - expected)) / np.max(np.abs(expected)))
    print(f"{what}: largest difference {error:.1e} of the largest value (allowed {tolerance:.0e})")
    if not error <= tolerance:
        sys.exit(f"{what} differs")


def validated(unit):
    findings = validate_fmu(str(unit))
    if findings:
        sys.exit(f"{unit.name}: {findings}")
    print(f"{unit.name}: no finding")
    return unit


def oscillating_plate(folder):
    """FMI 3.0: the plate swings as in the native run, whose windows are the steps."""
    settings = ["--set", "case.particle_spacing=5e-3", "--end-time", "0.05"]
    expected = native("cases/oscillating_plate", folder / "plate", *settings)
    unit = folder / "plate.fmu"
    meniscus("export-fmu", "cases/oscillating_plate", "-o", unit, *settings)
    validated(unit)
    times = expected["t"]
    step = times[1] - times[0]
    assert np.allclose(np.diff(times), step), "windows of one size"
    result = simulate_fmu(str(unit), stop_time=times[-1], step_size=step, output_interval=step, output=["tip.ux", "tip.uy"])
    # Times are sums in one and products in the other: no other difference.
    for name in ["tip.ux", "tip.uy"]:
        close(f"oscillating plate, {name}, FMI 3.0", result[name], expected[name], 1e-9)
    return unit


def state(unit):
    """FMI 3.0: kept, restored and serialised in the middle of a run, to the bit."""
    description = read_model_description(str(unit))
    unpacked = extract(str(unit))
    references = {v.name: v.valueReference for v in description.modelVariables}
    slave = FMU3Slave(
        guid=description.guid, unzipDirectory=unpacked,
        modelIdentifier=description.coSimulation.modelIdentifier, instanceName="state",
    )
    slave.instantiate()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    count = slave.getUInt64([references["interface_points"]])[0]

    def steps(first, last):
        seen = []
        for n in range(first, last):
            load = [1e3 * np.sin(n + k) for k in range(2 * count)]
            slave.setFloat64([references["pressure_gradient"]], load)
            slave.doStep(n * 1e-4, 1e-4)
            seen.append(slave.getFloat64([references["position"]], nValues=2 * count))
        return seen

    steps(0, 3)
    kept = slave.getFMUState()
    first = steps(3, 6)
    slave.setFMUState(kept)
    assert steps(3, 6) == first, "restored, the run is another"
    serialised = slave.serializeFMUState(kept)
    slave.freeFMUState(kept)
    slave.setFMUState(slave.deserializeFMUState(serialised))
    assert steps(3, 6) == first, "deserialised, the run is another"
    slave.terminate()
    slave.freeInstance()
    shutil.rmtree(unpacked)
    print(f"state: kept, restored and serialised ({len(serialised)} bytes) to the bit")


def cantilever(folder):
    """FMI 2.0: a ramped force at one point of the free end, against the same force in the case."""
    settings = ["--set", "case.particle_spacing=2.5e-3", "--set", "structure.load=[]", "--end-time", "3e-3"]
    unit = folder / "cantilever.fmu"
    meniscus("export-fmu", "cases/static_cantilever", "-o", unit, "--fmi", "2", "--points", "4", *settings)
    validated(unit)
    start = simulate_fmu(str(unit), stop_time=1e-6, step_size=1e-6, output=[f"point[{k}].position.{a}" for k in range(1, 5) for a in "xy"])[0]
    points = {k: (float(start[f"point[{k}].position.x"]), float(start[f"point[{k}].position.y"])) for k in range(1, 5)}
    end = max(points, key=lambda k: points[k])
    at, ramp = points[end], "[[0.0, 0.0], [1.5e-3, 1.0]]"
    load = f"structure.load=[{{ name = 'end', body = 'beam', at = [{at[0]!r}, {at[1]!r}], force = [0.0, 1.75e6], ramp = {ramp} }}]"
    expected = native("cases/static_cantilever", folder / "cantilever", *settings[:2], "--set", load, *settings[4:])
    times = expected["t"]
    step = (times[1] - times[0]) / 8
    names = [f"point[{k}].force.{a}" for k in range(1, 5) for a in "xy"]
    force = np.zeros(3, dtype=[(name, float) for name in ["time", *names]])
    force["time"], force[f"point[{end}].force.y"] = [0.0, 1.5e-3, 3e-3], [0.0, 1.75e6, 1.75e6]
    result = simulate_fmu(str(unit), stop_time=times[-1], step_size=step, output_interval=step, input=force, output=["tip.uy"])
    # The unit holds the force over a step where the native run follows the ramp: half a step behind.
    close("cantilever, tip.uy, FMI 2.0", np.interp(times, result["time"], result["tip.uy"]), expected["tip.uy"], 2e-3)
    return unit


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plate = oscillating_plate(folder)
        state(plate)
        cantilever(folder)


if __name__ == "__main__":
    main()
