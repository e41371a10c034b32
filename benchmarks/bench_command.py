"""The command as a user types it, start-up included; what Python takes to load its drawing and spline libraries stands beside it as a yardstick."""

import os
import subprocess
import sys

COMMANDS = {
    "energy-mgr plan commute --corridor road": ["-m", "energy_mgr.cli.main", "plan", "commute", "--corridor", "road", "--out", "out/bench/plan"],
    "energy-mgr --help": ["-m", "energy_mgr.cli.main", "--help"],
    "yardstick: import matplotlib.figure, scipy.interpolate": ["-c", "import matplotlib.figure, scipy.interpolate"],
}


#: What a user has: modules compiled once and kept, whatever the shell of whoever measures says.
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE" and not key.endswith("_NUM_THREADS")}


def pytest_generate_tests(metafunc):
    metafunc.parametrize("label", COMMANDS)


def bench_command(benchmark, label):
    benchmark.group = "command, start-up included"

    def run():
        subprocess.run([sys.executable, *COMMANDS[label]], check=True, capture_output=True, env=ENVIRONMENT)

    benchmark.pedantic(run, rounds=7, warmup_rounds=1)
    benchmark.extra_info.update(method=label, ours="plan commute" in label)
