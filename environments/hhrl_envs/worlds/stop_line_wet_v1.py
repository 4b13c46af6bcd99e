"""A harder tier: a wet road that is iced over in a third of the worlds, and looks the same in all of them.

There the friction is 0.05 to 0.12, that of wet ice (Wallman and Astrom 2001: 0.05 to 0.1; dry ice 0.15);
in the others it is 1. Hidden is the friction. No observation shows it, but the answer to the brakes does: who remembers
what it asked for, and sees how little came of it, knows. One set of parameters does not serve both: who always drives
as on ice is late in most worlds. Revealed, one set for each, the same rule comes close to the oracle. Of the
worlds that are drawn, 35% are icy; those in which nobody could stop in time are drawn anew: one in 35, all of them icy.
"""

from hhrl_envs.scenario.scenario import Road, Scenario, Slippery, Traffic
from hhrl_envs.views.triad import register
from hhrl_envs.worlds.driver_families import TRAIN_FAMILIES

SCENARIO = Scenario(
    id="stop-line-wet-v1",
    traffic=Traffic(families=TRAIN_FAMILIES, gap=(18.0, 32.0), speed=(7.0, 11.0)),
    road=Road(
        start_distance=(90.0, 130.0), start_speed=(9.0, 12.0), slippery=Slippery(share=0.35, friction=(0.05, 0.12))
    ),
)

env, raw_env, parallel_env = register(SCENARIO, place=6, summary="ice in a third of the worlds, which nothing shows")
