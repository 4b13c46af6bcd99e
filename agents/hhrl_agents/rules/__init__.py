"""The rule agents: analytic controllers, one for each sub-goal, and the rules that select which of them acts.

To add a rule, add a file with a mapping ``RULES``, id -> constructor; what lies in this folder is found.
"""
