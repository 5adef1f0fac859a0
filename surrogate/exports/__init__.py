"""A fitted model as C, JavaScript, NumPy, ONNX, sympy, text."""
