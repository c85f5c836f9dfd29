"""LightGlue's network beside torch."""

import numpy as np
import pytest

from fsel.captures.colmap import lightglue
from fsel.captures.colmap.lightglue import LightGlue


def published(rng):
    """Random tensors under the names of the authors' file."""
    state = {"posenc.Wr.weight": rng.normal(size=(32, 2))}

    def add(name, out, inner, size=1.0):
        state[f"{name}.weight"] = rng.normal(0, size, (out, inner)) / np.sqrt(inner)
        state[f"{name}.bias"] = rng.normal(0, 0.1, out)

    add("input_proj", 256, 128, 4)
    for at in range(lightglue.LAYERS):
        inside, across = (f"transformers.{at}.{part}_attn" for part in ("self", "cross"))
        add(f"{inside}.Wqkv", 768, 256)
        for name in (f"{inside}.out_proj", *(f"{across}.to_{v}" for v in ("qk", "v", "out"))):
            add(name, 256, 256)
        for name in (inside, across):
            add(f"{name}.ffn.0", 512, 512)
            add(f"{name}.ffn.3", 256, 512, 0.3)
            state[f"{name}.ffn.1.weight"] = rng.uniform(0.5, 1, 512)
            state[f"{name}.ffn.1.bias"] = rng.normal(0, 0.1, 512)
        add(f"log_assignment.{at}.final_proj", 256, 256, 3)
        add(f"log_assignment.{at}.matchability", 1, 256)
        state[f"log_assignment.{at}.matchability.bias"] += 5
        add(f"token_confidence.{at}.token.0", 1, 256)
    return {name: np.float32(value) for name, value in state.items()}


def by_torch(state, sides, layers):
    """Matches after some layers, as the paper has them."""
    torch = pytest.importorskip("torch")
    tools = torch.nn.functional
    state = {name: torch.from_numpy(value) for name, value in state.items()}

    def linear(x, name):
        return tools.linear(x, state[f"{name}.weight"], state[f"{name}.bias"])

    def told(x, heads, name, last):
        message = linear(heads.transpose(0, 1).flatten(1), f"{name}.{last}")
        hidden = linear(torch.cat([x, message], 1), f"{name}.ffn.0")
        gain, shift = (state[f"{name}.ffn.1.{part}"] for part in ("weight", "bias"))
        hidden = tools.gelu(tools.layer_norm(hidden, (512,), gain, shift))
        return x + linear(hidden, f"{name}.ffn.3")

    def turned(part, angle):
        even, odd = part[..., ::2], part[..., 1::2]
        cosine, sine = angle.cos(), angle.sin()
        pairs = [even * cosine - odd * sine, odd * cosine + even * sine]
        return torch.stack(pairs, -1).flatten(-2)

    def heads(x, name):
        return linear(x, name).unflatten(1, (4, 64)).transpose(0, 1)

    xs, angles = [], []
    for points, descriptors, (width, height) in sides:
        places = torch.from_numpy(points) - torch.tensor([width / 2, height / 2])
        angles.append(places / (max(width, height) / 2) @ state["posenc.Wr.weight"].T)
        xs.append(linear(torch.from_numpy(descriptors), "input_proj"))
    for at in range(layers):
        name = f"transformers.{at}.self_attn"
        for side, angle in enumerate(angles):
            q, k, v = linear(xs[side], f"{name}.Wqkv").unflatten(1, (4, 64, 3)).permute(3, 1, 0, 2)
            q, k = turned(q, angle), turned(k, angle)
            seen = tools.scaled_dot_product_attention(q, k, v)
            xs[side] = told(xs[side], seen, name, "out_proj")
        name = f"transformers.{at}.cross_attn"
        keys, values = ([heads(x, f"{name}.{part}") for x in xs] for part in ("to_qk", "to_v"))
        pairs = ((keys[0], keys[1], values[1]), (keys[1], keys[0], values[0]))
        seen = [tools.scaled_dot_product_attention(*pair) for pair in pairs]
        xs = [told(x, one, name, "to_out") for x, one in zip(xs, seen, strict=True)]
    name = f"log_assignment.{layers - 1}"
    a, b = (linear(x, f"{name}.final_proj") / 256**0.25 for x in xs)
    worth = [tools.logsigmoid(linear(x, f"{name}.matchability")) for x in xs]
    likeness = a @ b.T
    score = likeness.log_softmax(1) + likeness.log_softmax(0) + worth[0] + worth[1].T
    there, back = score.argmax(1), score.argmax(0)
    rows = torch.arange(len(a))
    kept = (back[there] == rows) & (score[rows, there].exp() > lightglue.LEAST)
    return torch.stack([rows[kept], there[kept]], 1).numpy()


@pytest.mark.parametrize("layers", [1, 4, lightglue.LAYERS])
def test_matches_are_those_of_torch(layers):
    rng = np.random.default_rng(layers)
    state = published(rng)
    for at in range(lightglue.LAYERS):  # all features are sure after some layers, none before
        state[f"token_confidence.{at}.token.0.bias"] += 100 if at == layers - 1 else -100
    described = rng.normal(size=(70, 128)).astype(np.float32)
    points = rng.uniform(0, 200, (70, 2)).astype(np.float32)
    sides = (points, described, (200, 220)), (points[10:] + 3, described[10:], (240, 200))
    found = LightGlue(state)(*sides)
    expected = by_torch(state, sides, layers)
    assert len(expected) > 5
    np.testing.assert_array_equal(found, expected)


def test_images_without_features_have_no_matches():
    nothing = np.zeros((0, 2), np.float32), np.zeros((0, 128), np.float32), (20, 20)
    assert LightGlue({})(nothing, nothing).shape == (0, 2)
