"""Convolutions over time."""

from torch import Tensor, nn
from torch.nn import functional


class ResidualBlock(nn.Module):
    """x + conv1(relu(dilated conv3(relu(x)))) on (B, C, T)."""

    def __init__(self, width: int, dilation: int) -> None:
        super().__init__()
        self.wide = nn.Conv1d(width, width, 3, padding=dilation, dilation=dilation)
        self.point = nn.Conv1d(width, width, 1)

    def forward(self, inputs: Tensor) -> Tensor:
        return inputs + self.point(functional.relu(self.wide(functional.relu(inputs))))
