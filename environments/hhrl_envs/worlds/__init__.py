"""The registered worlds, a file each: its scenario, and PettingZoo's constructors of it.

To add one, add a file: what lies in this folder is imported, and `register` makes it known everywhere.

In stop-line-v0 a rule whose numbers were searched for there comes close to the oracle. The harder tiers (dense-v1,
erratic-v1, wet-v1, noisy-v1) hide a quantity that a driver has to know and no single observation shows: who is in
front, whether what stands ahead is real, the friction, or where the line is. So a rule without memory has to guess,
however well it is tuned: it scores at most 0.75 of what the oracle does, and at least 0.9 where the quantity is
revealed. An agent with memory can find it out. Infeasible draws of dense-v1, erratic-v1 and noisy-v1 stay and are
counted (less than 0.1%). Numbers without a source are design choices, made on validation worlds.

Dense-v0, erratic-v0, wet-v0 and noisy-v0 are their first versions. A tuned rule that crawls hardly ever fails in them.
They stay for whoever has results there.
"""

import pkgutil
from importlib import import_module
from types import ModuleType

WORLDS: dict[str, ModuleType] = {
    module.name: import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__)
}
"""The modules of this folder by their names: ``stop_line_v0`` for the scenario ``stop-line-v0``."""
