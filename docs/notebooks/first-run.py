# %% [markdown]
# # First run in Python
#
# A first simulation of the published prototype, from a script. You need vvdp in an environment of your own
# (`pip install '.[notebook]'` in its folder); Jupyter is optional, the cells are one program.

# %%
import matplotlib.pyplot as plt

import vvdp

system = vvdp.load("prototype", operation={"duty_ratio": 0.4})
run = system.run(until="0.5 s")
run

# %% [markdown]
# `load` takes the name of a shipped system or the path of a file, and values by table and key. A number is in SI units; a
# text has its unit, such as `"1200 rpm"`. The first run of a circuit compiles it, which takes some seconds. After that a
# second of the machine takes less than a tenth of a second.
#
# `summary` holds means over whole PWM periods. Every key ends in its SI unit.

# %%
for key in ("pwm_frequency_Hz", "mean_load_flow_m3_s", "load_power_W", "efficiency"):
    print(f"{key:22}{run.summary[key]:.4g}")

# %% [markdown]
# ## Pictures
#
# `run.plot()` draws the course of the run; `run.result.charts` names all charts, and the name of any series is one as
# well.

# %%
run.plot("load_pressure", "load_flow")

# %% [markdown]
# `run.to_xarray()` has every recorded series with its unit, along the dimension `time`; pressures are absolute. Here are
# the last PWM periods:

# %%
data = run.to_xarray().sel(time=slice(0.46, 0.5))
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
for name in ("inlet", "load_line"):
    axes.plot(1e3 * data.time, data[f"states.{name}"] / 1e5, label=name)
axes.set(xlabel="time [ms]", ylabel="pressure [bar absolute]")
axes.legend()
plt.show()

# %% [markdown]
# The inlet is a square wave: it follows the load while the load port is open and falls to a few bar while the tank port
# is open. In between, both ports are nearly closed, and the relief valve opens.
#
# ## Several duty ratios
#
# The duty ratio sets how much of the pump's flow reaches the load.

# %%
for ratio in (0.3, 0.4, 0.5, 0.6, 0.7):
    found = system.with_values(operation={"duty_ratio": ratio}).run(until="2 s").summary
    flow, efficiency = 6e4 * found["mean_load_flow_m3_s"], 100 * found["efficiency"]
    print(f"duty ratio {ratio}: {flow:5.2f} lpm to the load, efficiency {efficiency:4.1f} %")

# %% [markdown]
# More flow through the same orifice means more pressure, until from 0.6 on the relief valve takes the rest. For a load of
# constant pressure, `vvdp map prototype` holds the pressure and gives the whole map.
#
# ## Keep it
#
# `save` writes what `vvdp run` writes, the report included; `vvdp.open` reads it again.

# %%
run.save("results/first-run")
vvdp.open("results/first-run").summary["efficiency"] == run.summary["efficiency"]

# %% [markdown]
# From here: [many cases at once](../studies.md), [a circuit of your own](../own-circuit.md), [all of
# `vvdp`](../reference/python.md).
