import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.hydraulics.spool_drive import SpoolDrive, coupling_loss, drive_power, drive_torque

DRIVEN, FREE = SpoolDrive(coupling=0.01), SpoolDrive(coupling=0.0)
SPEEDS = st.floats(-1e3, 1e3)


def test_by_hand():
    assert drive_torque(150.0, 140.0, DRIVEN) == pytest.approx(0.1, rel=1e-14)  # 0.01 * 10
    assert drive_power(150.0, 140.0, DRIVEN) == pytest.approx(15.0, rel=1e-14)
    assert coupling_loss(150.0, 140.0, DRIVEN) == pytest.approx(1.0, rel=1e-14)


@given(motor=SPEEDS, spool=SPEEDS)
def test_power_given_arrives_or_is_lost(motor, spool):
    arrived = drive_torque(motor, spool, DRIVEN) * spool
    loss = coupling_loss(motor, spool, DRIVEN)
    assert loss >= 0.0
    assert drive_power(motor, spool, DRIVEN) == pytest.approx(arrived + loss, rel=1e-12, abs=1e-9)
    assert drive_torque(motor, spool, FREE) == 0.0
