"""Policies of other libraries as agents: callables, torch modules, ONNX files and models of Stable-Baselines3."""
