"""The registered worlds, a file each: its scenario, and PettingZoo's constructors of it.

To add one, add a file: what lies in this folder is imported, and `register` makes it known everywhere.

The harder tiers (dense, erratic, wet, noisy) are worlds whose difficulty is not in the nominal values that a planner
knows. In stop-line-v0 a rule that knows the vehicle's lag, the speed limit and the stop zone never fails, because its
follower keeps more than the gap that physics asks for. Each tier takes away one thing that such a rule relies on
without measuring it: sight, prompt brakes, grip or exact sensors. Sensors are 0.6 to 0.9 s late, as attentive human
drivers are (Green 2000: 0.7 s and more). Infeasible draws stay and are counted (less than 1%). Numbers without a source
are design choices, made on validation worlds: the best rule succeeds in 76 to 87% of the episodes, and the same rule
driven more slowly, gently or further away in at least 8 points more.
"""

import pkgutil
from importlib import import_module
from types import ModuleType

WORLDS: dict[str, ModuleType] = {
    module.name: import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__)
}
"""The modules of this folder by their names: ``stop_line_v0`` for the scenario ``stop-line-v0``."""
