"""Splitting a motion demand over motors, brakes and steering."""

from .effectiveness import Effectiveness, Model
from .efficient import EfficientAllocator
from .layout import NO_FAULTS, Faults, Layout
from .preview import PreviewAllocator
from .programme import Weights
from .published import TwoStepAllocator, WeightedAllocator
from .simple import EqualSplitAllocator, MinimumNormAllocator
from .situation import Ahead, Allocation, Allocator, Situation

#: Allocators by name.
ALLOCATORS: dict[str, type] = {
    "efficient": EfficientAllocator,
    "preview": PreviewAllocator,
    "two-step": TwoStepAllocator,
    "weighted": WeightedAllocator,
    "minimum-norm": MinimumNormAllocator,
    "equal-split": EqualSplitAllocator,
}

__all__ = [
    "ALLOCATORS",
    "NO_FAULTS",
    "Ahead",
    "Allocation",
    "Allocator",
    "Effectiveness",
    "EfficientAllocator",
    "EqualSplitAllocator",
    "Faults",
    "Layout",
    "MinimumNormAllocator",
    "Model",
    "PreviewAllocator",
    "Situation",
    "TwoStepAllocator",
    "WeightedAllocator",
    "Weights",
]
