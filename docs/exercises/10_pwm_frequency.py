"""The frequency of a rotary valve.

The spool of the shipped system `prototype` has 3 helical sections, and each switches once per revolution. It
turns at 1477 rpm. At which frequency does the valve switch?
"""

from vvdp.api.exercise import ask

EXERCISE = ask(
    __name__,
    __doc__,
    circuit="prototype",
    key="pwm_frequency_Hz",
    hint="Each section switches once per revolution of the spool.",
    mistakes=(
        (
            lambda right: right / 3.0,
            "That is the frequency of the spool: each of its 3 sections switches once per revolution.",
        ),
    ),
)
