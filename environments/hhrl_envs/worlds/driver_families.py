"""Families of drivers that several worlds draw their front vehicles from; a family of one world stands in its file."""

from hhrl_envs.scenario.profiles import ProfileFamily

TRAIN_FAMILIES = (
    ProfileFamily(
        "calm",
        0.30,
        desired_speed=(7.0, 10.0),
        headway=(1.4, 2.0),
        max_accel=(0.8, 1.6),
        comfort_decel=(1.5, 2.5),
        min_gap=(2.0, 3.5),
        line_decel=(1.5, 2.5),
        dwell=(1.0, 4.0),
    ),
    ProfileFamily(
        "brisk",
        0.25,
        desired_speed=(9.0, 12.0),
        headway=(0.8, 1.4),
        max_accel=(1.5, 2.6),
        comfort_decel=(2.5, 4.5),
        min_gap=(1.0, 2.5),
        line_decel=(2.5, 3.4),
        dwell=(0.5, 2.0),
        start_delay=(0.3, 0.8),
        styles=(0.6, 0.4, 0.0),
    ),
    ProfileFamily(
        "late-braking",
        0.20,
        desired_speed=(9.0, 12.0),
        headway=(0.8, 1.6),
        max_accel=(1.2, 2.6),
        line_decel=(3.4, 6.0),
        comfort_decel=(3.0, 4.5),
        dwell=(0.5, 3.0),
    ),
    ProfileFamily(
        "hesitant",
        0.15,
        desired_speed=(6.0, 10.0),
        headway=(1.2, 2.0),
        line_decel=(1.5, 3.0),
        dwell=(2.0, 6.0),
        start_delay=(1.0, 2.5),
        slow_chance=0.6,
    ),
    ProfileFamily(
        "heedless",
        0.10,
        desired_speed=(9.0, 12.0),
        headway=(0.8, 1.2),
        max_accel=(1.5, 2.6),
        styles=(0.0, 0.3, 0.7),
    ),
)
"""The families that the main task draws from."""

HELD_OUT_FAMILIES = (
    ProfileFamily(
        "creeping", 0.3, desired_speed=(4.0, 7.0), headway=(1.5, 2.5), max_accel=(0.6, 1.2), comfort_decel=(1.0, 2.0),
        min_gap=(2.5, 4.5), line_decel=(1.0, 1.6), dwell=(3.0, 6.0), start_delay=(1.0, 3.0),
    ),
    ProfileFamily(
        "pushing", 0.3, desired_speed=(10.0, 12.0), headway=(0.5, 0.8), max_accel=(2.4, 3.2), comfort_decel=(4.0, 5.0),
        min_gap=(0.8, 1.5), line_decel=(3.4, 7.0), dwell=(0.2, 1.0), start_delay=(0.1, 0.4), stop_position=(-2.0, 0.5),
    ),
    ProfileFamily(
        "stuttering", 0.4, desired_speed=(7.0, 11.0), line_decel=(2.0, 4.0), dwell=(1.0, 3.0), slow_at=(20.0, 60.0),
        slow_decel=(3.0, 6.0), slow_time=(0.3, 1.0), slow_every=(8.0, 25.0), slow_chance=0.8, styles=(0.8, 0.2, 0.0),
    ),
)  # fmt: skip
"""Families that no training scenario draws from: slower, closer and more fitful drivers than ``TRAIN_FAMILIES``."""


STOP_AND_GO_FAMILIES = (
    ProfileFamily(
        "stop-and-go",
        1.0,
        desired_speed=(5.0, 9.0),
        headway=(1.0, 1.6),
        max_accel=(1.0, 2.0),
        comfort_decel=(2.0, 3.5),
        line_decel=(2.0, 3.4),
        dwell=(0.5, 2.0),
        slow_at=(40.0, 70.0),
        slow_decel=(2.5, 4.0),
        slow_time=(2.0, 3.5),
        slow_every=(12.0, 20.0),
        slow_chance=1.0,
    ),
)
"""Drivers of a traffic jam: each slows down and drives on again every few metres."""
