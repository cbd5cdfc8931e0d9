# %% [markdown]
# # Speed from a log
#
# A photodiode observes a wheel with eight stripes, and its voltage has been logged a thousand times a second. This
# notebook estimates the speed from such a log. The tutorial on how the estimator works is [speed from a bad
# encoder](../tutorials/speed-from-a-bad-encoder.md).
#
# ## A log to try it on
#
# The wheel turns at 24.7 turns a second and slows down to 20 within a second. The stripes have blurred edges, and the
# voltage has some noise. Any CSV file with a time and a voltage will do in its place.

# %%
import numpy as np

random = np.random.default_rng(7)
time = np.arange(4000) / 1000.0
speed = 2 * np.pi * np.interp(time, [1.5, 2.5], [24.7, 20.0])
angle = np.cumsum(speed) / 1000.0
edges = np.pi / 4 * np.arange(angle[-1] // (np.pi / 4) + 2)
seen = np.sort(edges + random.triangular(-0.1, 0.0, 0.1, edges.size))
voltage = 0.2 + 4.1 * (np.searchsorted(seen, angle) % 2) + 0.02 * random.standard_normal(time.size)
table = np.column_stack([time, voltage])
np.savetxt("wheel.csv", table, fmt="%.6f", delimiter=",", header="time [s],photodiode [V]", comments="")

# %% [markdown]
# ## The estimate
#
# `load_estimation` takes the options of `vvdp estimate` by their key, option and value; `estimate` goes through the log
# in portions, however long it is, and writes what it finds into a folder.

# %%
from pathlib import Path

from vvdp.offline.config import Option, load_estimation
from vvdp.offline.estimate import estimate, open_for_estimate

wanted = load_estimation(
    None, [Option("sensor.wave", "--wave", "photodiode"), Option("sensor.sectors", "--sectors", 8)]
)
Path("wheel").mkdir()
with open_for_estimate(Path("wheel.csv"), wanted) as log:
    found = estimate(log, wanted, Path("wheel")).numbers
for key in ("edges", "missed_edges", "spool_speed_mean_rad_s", "speed_deviation_mean_rad_s", "nis_mean"):
    print(f"{key:28}{found[key].value:.4g}")

# %% [markdown]
# `nis_mean` is the mean squared innovation over what the filter expects. Near 1, the stated standard deviation agrees with the errors.
#
# ## Against the truth
#
# `result.h5` holds time, angle and speed with their standard deviations. Here the truth is known:

# %%
import h5py
import matplotlib.pyplot as plt

with h5py.File("wheel/result.h5") as file:
    moments, estimated, deviation = (file[name][:] for name in ("time", "speed", "speed_deviation"))
error = estimated - np.interp(moments, time, speed)
settled = moments > 0.5
print(f"root mean square error {np.sqrt(np.mean(error[settled] ** 2)):.2f} rad/s of {speed[0]:.0f} rad/s")

figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
axes.plot(time, speed, color="black", label="true")
axes.plot(moments, estimated, label="estimated")
axes.fill_between(moments, estimated - 2 * deviation, estimated + 2 * deviation, alpha=0.3, label="±2σ")
axes.set(xlabel="time [s]", ylabel="speed [rad/s]", ylim=(115, 165))
axes.legend()
plt.show()

# %% [markdown]
# The filter expects a constant speed. While the speed falls it drifts off, detects this, and corrects in jumps; the
# stated standard deviation is larger there. `vvdp estimate wheel.csv --wave photodiode --sectors 8 --fit` finds a setting that follows
# this log evenly; `--smooth` also uses the edges to come. What the warnings mean is in [measured logs](../logs.md).
