"""The paper's networks and algorithms to read and to check against: plain torch modules, autograd, ONNX files."""
