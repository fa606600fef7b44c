"""Other ways to run the layers of a transformer, each made from the trained one; on the CPU, for inference."""

import copy
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import torch
from torch import Tensor, nn

from ros_free_stack.errors import MissingDependency

BATCH, TOKENS = 2, 52  # of the example that tracing needs; every size runs afterwards


class Wrapped(nn.Module):
    """A function from hidden (B, N, W) and mask (B, N) to (B, N, W) in the place of a `Transformer`."""

    def __init__(self, run: Callable[[Tensor, Tensor], Tensor]) -> None:
        super().__init__()
        self.run = run

    def forward(self, hidden: Tensor, mask: Tensor) -> Tensor:
        return self.run(hidden, mask)


def eager(layers: nn.Module) -> nn.Module:
    """As the program runs it."""
    return layers


def compiled(layers: nn.Module) -> nn.Module:
    """`torch.compile` with dynamic shapes; needs a C++ compiler, and compiles when first run."""
    return Wrapped(torch.compile(copy.deepcopy(layers), dynamic=True))


def exported(layers: nn.Module) -> nn.Module:
    """The graph of `torch.export` with dynamic shapes, run by PyTorch."""
    batch, tokens = torch.export.Dim("batch", min=1), torch.export.Dim("tokens", min=2)
    sizes = {0: batch, 1: tokens}
    return Wrapped(torch.export.export(layers, _example(layers), dynamic_shapes=(sizes, sizes)).module())


def torchscript(layers: nn.Module) -> nn.Module:
    """A frozen TorchScript trace."""
    return Wrapped(torch.jit.freeze(torch.jit.trace(layers, _example(layers), check_trace=False)))


def onnx(layers: nn.Module) -> nn.Module:
    """ONNX Runtime; MissingDependency where it is not installed."""
    if find_spec("onnx") is None or find_spec("onnxruntime") is None:
        raise MissingDependency("ONNX Runtime", "pip install onnx onnxruntime")
    import onnxruntime  # pyright: ignore[reportMissingImports]

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = torch.get_num_threads()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layers.onnx"
        names, sizes = ("hidden", "mask", "out"), {0: "batch", 1: "tokens"}
        torch.onnx.export(
            layers,
            _example(layers),
            path,
            input_names=names[:2],
            output_names=names[2:],
            dynamic_axes=dict.fromkeys(names, sizes),
            dynamo=False,
        )
        session = onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])

    def run(hidden: Tensor, mask: Tensor) -> Tensor:
        return torch.from_numpy(session.run(None, {"hidden": hidden.numpy(), "mask": mask.numpy()})[0])

    return Wrapped(run)


def int8(layers: nn.Module) -> nn.Module:
    """Linear layers with 8-bit weights, their inputs quantized as they come."""
    return torch.ao.quantization.quantize_dynamic(copy.deepcopy(layers), {nn.Linear}, torch.qint8)


def bfloat16(layers: nn.Module) -> nn.Module:
    """All layers in bfloat16; slow on a processor without instructions for it (AVX-512 BF16, AMX)."""
    short = copy.deepcopy(layers).bfloat16()
    return Wrapped(lambda hidden, mask: short(hidden.bfloat16(), mask).float())


VARIANTS: dict[str, Callable[[nn.Module], nn.Module]] = {
    "eager": eager,
    "torch.compile": compiled,
    "torch.export": exported,
    "TorchScript": torchscript,
    "ONNX Runtime": onnx,
    "int8": int8,
    "bfloat16": bfloat16,
}


def _example(layers: nn.Module) -> tuple[Tensor, Tensor]:
    width = next(layers.parameters()).shape[-1]
    return torch.zeros(BATCH, TOKENS, width), torch.ones(BATCH, TOKENS, dtype=torch.bool)
