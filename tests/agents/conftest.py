import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # of torch, where something imports it
