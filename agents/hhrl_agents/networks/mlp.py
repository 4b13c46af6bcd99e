"""Fully connected layers for stacked seeds, with their gradients written out.

Every layer holds E independent weight matrices, [E, in, out]. States, values and whatever lies between are columns,
[E, features, K], so that the matrix products of narrow layers are as wide as the batch. A gradient is a few lines a
layer, and costs half of what recording every operation for automatic differentiation does.
"""

from collections.abc import Mapping
from typing import NamedTuple

import torch
from torch import Tensor

Parameters = Mapping[str, Tensor]

_EPSILON = 1e-5  # what layer normalisation adds to the variance


def subset(parameters: Parameters, prefix: str) -> dict[str, Tensor]:
    """Return the parameters whose names start with `prefix`, the prefix taken off."""
    return {name.removeprefix(prefix): value for name, value in parameters.items() if name.startswith(prefix)}


class ForwardPass(NamedTuple):
    """What a forward pass leaves for `MLP.backward`.

    inputs: of every layer, [E, in, K]; norms: of every normalised layer its outputs [E, out, K] before the ReLU, and
    the factor [E, 1, K] that scaled them.
    """

    inputs: list[Tensor]
    norms: list[tuple[Tensor, Tensor]]

    def columns(self, part: slice) -> "ForwardPass":
        """Return what it leaves of these columns alone."""
        norms = [(outputs[..., part], factor[..., part]) for outputs, factor in self.norms]
        return ForwardPass([inputs[..., part] for inputs in self.inputs], norms)


class MLP:
    """Fully connected layers: ReLU inside, linear at the end.

    layer_norm: normalise what enters every ReLU to mean 0 and variance 1 over the units of the layer.
    """

    def __init__(self, parameters: Parameters, *, layer_norm: bool = False) -> None:
        depth = sum(name.endswith(".weight") for name in parameters)
        self.weights = [parameters[f"{layer}.weight"] for layer in range(depth)]
        self._biases = [parameters[f"{layer}.bias"].transpose(1, 2) for layer in range(depth)]
        self._layer_norm = layer_norm

    def __call__(self, inputs: Tensor) -> Tensor:
        """Return the last layer's outputs [E, out, K] for inputs [E, in, K]."""
        return self.forward(inputs)[0]

    def forward(self, inputs: Tensor) -> tuple[Tensor, ForwardPass]:
        """Return the outputs, and what `backward` needs."""
        kept = ForwardPass([inputs], [])
        for weight, bias in zip(self.weights[:-1], self._biases[:-1], strict=True):
            outputs = affine(weight, bias, kept.inputs[-1])
            if self._layer_norm:
                outputs, factor = _normalised(outputs)
                kept.norms.append((outputs.clone(), factor))
            kept.inputs.append(outputs.relu_())
        return affine(self.weights[-1], self._biases[-1], kept.inputs[-1]), kept

    def backward(self, kept: ForwardPass, outputs_grad: Tensor, gradients: Parameters) -> Tensor:
        """Return the loss's gradient by what the first layer's product gives, [E, out, K].

        outputs_grad: the gradient by the outputs, [E, out, K]; the parameters' gradients are written into `gradients`.
        """
        grad = outputs_grad
        for layer in reversed(range(len(self.weights))):
            inputs = kept.inputs[layer]
            affine_backward(inputs, grad, gradients[f"{layer}.weight"], gradients[f"{layer}.bias"])
            if layer > 0:
                grad = torch.bmm(self.weights[layer], grad).mul_(inputs.sign())
                if self._layer_norm:
                    grad = _normalised_backward(grad, *kept.norms[layer - 1])
        return grad


def affine(weight: Tensor, bias: Tensor, inputs: Tensor) -> Tensor:
    """Return W^T x + b, [E, out, K], for weight [E, in, out], bias [E, out, 1 or K] and inputs [E, in, K]."""
    return torch.baddbmm(bias, weight.transpose(1, 2), inputs)


def affine_backward(inputs: Tensor, grad: Tensor, weight_grad: Tensor, bias_grad: Tensor | None = None) -> None:
    """Write the gradients by weight [E, in, out] and bias [E, 1, out].

    inputs: [E, in, K]; grad: the gradient by the layer's product, [E, out, K].
    """
    if weight_grad.shape[2] < weight_grad.shape[1]:  # a product is quickest with its longer side last
        weight_grad.copy_(torch.bmm(grad, inputs.transpose(1, 2)).transpose(1, 2))
    else:
        torch.bmm(inputs, grad.transpose(1, 2), out=weight_grad)
    if bias_grad is not None:
        bias_grad.copy_(grad.sum(2).unsqueeze(1))


def _normalised(outputs: Tensor) -> tuple[Tensor, Tensor]:
    """Return the outputs less their mean, times the factor that makes their variance 1, and that factor."""
    centred = outputs - outputs.mean(1, keepdim=True)
    factor = centred.square().mean(1, keepdim=True).add_(_EPSILON).rsqrt_()
    return centred.mul_(factor), factor


def _normalised_backward(grad: Tensor, outputs: Tensor, factor: Tensor) -> Tensor:
    along = (grad * outputs).mean(1, keepdim=True)
    return (grad - grad.mean(1, keepdim=True)).addcmul_(outputs, along, value=-1.0).mul_(factor)
