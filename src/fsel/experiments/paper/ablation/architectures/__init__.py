"""Scorers that the paper compared its own with (Appendix D.1), one class each.

The paper names them; their details are ours, kept to torch's own layers and the scorer's width.
`config/scorers.yaml` says which class and settings make which row.
"""

from fsel.experiments.paper.ablation.architectures.attention import (
    CrossAttention,
    SelfAttention,
    ViewAttention,
)
from fsel.experiments.paper.ablation.architectures.pointwise import (
    Perceptron,
    Pooled,
    Rescoring,
    Residual,
)
from fsel.experiments.paper.ablation.architectures.recurrent import (
    Bidirectional,
    Convolution,
    Decoder,
    Sequential,
)

MODULES = {
    "perceptron": Perceptron,
    "residual": Residual,
    "pooled": Pooled,
    "rescoring": Rescoring,
    "cross_attention": CrossAttention,
    "self_attention": SelfAttention,
    "view_attention": ViewAttention,
    "decoder": Decoder,
    "sequential": Sequential,
    "bilstm": Bidirectional,
    "convolution": Convolution,
}
