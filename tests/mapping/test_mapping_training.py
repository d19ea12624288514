import numpy as np
import pytest
import torch
from mapping_data import BETA, rows, theta, with_tendons
from sklearn.linear_model import LinearRegression

from sstl_cli.core.errors import SstlError
from sstl_cli.mapping import networks, training
from sstl_cli.mapping.inference import forward
from sstl_cli.mapping.model import train
from sstl_cli.mapping.pairs import pairs_of
from sstl_cli.mapping.split import make_splits
from sstl_cli.mapping.variants import VARIANTS
from sstl_cli.mapping.weights import to_bytes
from sstl_cli.steps import train as step

FAST = training.Options(epochs=15)
LINEAR, PLAIN, PLAIN_INV, SKIP, SKIP_INV = VARIANTS


class Net(torch.nn.Module):
    """The network of Section IV-A as one would write it by hand."""

    def __init__(self, w, k, alpha):
        super().__init__()
        self.alpha = alpha
        self.embed, self.head = torch.nn.Linear(2, 128), torch.nn.Linear(128, 2)
        self.blocks = torch.nn.ModuleList(torch.nn.ModuleList([torch.nn.Linear(128, 128) for _ in "12"]) for _ in "12")
        self.double()
        with torch.no_grad():
            layers = [(self.embed, "e_w", "e_b"), (self.head, "h_w", "h_b")]
            for b, block in enumerate(self.blocks):
                layers += [(block[0], f"w1.{b}", f"b1.{b}"), (block[1], f"w2.{b}", f"b2.{b}")]
            for layer, weight, bias in layers:
                layer.weight.copy_(w[weight][k])
                layer.bias.copy_(w[bias][k])

    def forward(self, x):
        h = self.embed(x)
        for first, second in self.blocks:
            h = torch.tanh(second(torch.tanh(first(h))) + self.alpha * h)
        return self.head(h)


def prepared(per_place=12, seeds=(0, 1, 2), **options):
    pairs = pairs_of(theta(rows(per_place)))
    return pairs, make_splits(pairs.location_of(), seeds, 0, **options)


def test_pairs_hold_each_configuration_once_and_average_repeated_runs():
    made = rows(3)
    again = {**made[0], "run_id": "again", "gamma_p": made[0]["gamma_p"] + 0.02}
    pairs = pairs_of(theta([*reversed(made), again]))
    assert len(pairs) == 9 and pairs.configs == tuple(sorted({r["config_id"] for r in made}))
    first = pairs.config_id.index(made[0]["config_id"])
    assert pairs.sstl[first, 0] == pytest.approx(made[0]["gamma_p"] + 0.01)
    assert pairs.act[first, 1] == made[1]["gamma_r"]


def test_rows_that_cannot_be_paired_are_set_aside_with_their_reason():
    made = rows(3)
    made[0]["gamma_r"], made[0]["status"] = None, "no propagation reached"
    made[3]["config_id"] = None
    pairs = pairs_of(theta(made))
    assert len(pairs) == 7
    assert "no propagation" in pairs.aside[made[0]["run_id"]] and "config_id" in pairs.aside[made[3]["run_id"]]
    assert "no sensing-loop" in pairs.aside[made[1]["run_id"]] and "no actuation" in pairs.aside[made[2]["run_id"]]
    # the loop of the one was recorded, and its lines are not there
    assert pairs.aside[made[1]["run_id"]].endswith("no sensing-loop run that can be used")


@pytest.mark.parametrize("options", [{}, {"per_seed": True}, {"leave_out": "ND"}, {"test_share": 0.5}])
def test_no_configuration_is_in_two_parts(options):
    pairs, splits = prepared(**options)
    parts = [splits.mask(pairs.config_id, p) for p in "fvh"]
    assert (sum(p.astype(int) for p in parts) == 1).all() and all(p.any(axis=1).all() for p in parts)
    share = parts[2].mean(axis=1)
    if "leave_out" in options:
        np.testing.assert_array_equal(parts[2][0], [c.startswith("ND") for c in pairs.config_id])
    else:
        np.testing.assert_allclose(share, options.get("test_share", 0.25))
        for place in ("NP", "CP", "ND"):
            own = np.array([c.startswith(place) for c in pairs.config_id])
            assert abs(parts[2][0][own].mean() - share[0]) < 0.1
    assert len(set(splits.roles)) == 3, "seeds differ in validation"
    assert (len({m.tobytes() for m in parts[2]}) == 1) != options.get("per_seed", False)


def test_the_tendons_of_a_configuration_stay_together():
    pairs = pairs_of(theta(with_tendons(rows(8), 0.1)))
    held = make_splits(pairs.location_of(), [0], 0).mask(pairs.config_id, "h")[0]
    by_config = {}
    for config, h in zip(pairs.config_id, held, strict=True):
        by_config.setdefault(config, set()).add(h)
    assert len(pairs) == 48 and all(len(v) == 1 for v in by_config.values())


def test_linear_regression_is_that_of_scikit_learn_on_the_training_part():
    pairs, splits = prepared(leave_out=None)
    fitted = training.fit(pairs.sstl, pairs.act, pairs.config_id, splits, [LINEAR])
    own = forward(pairs.sstl, fitted.group.scaling, fitted.group.variants["linear"], None)
    for k, mask in enumerate(splits.mask(pairs.config_id, "fv")):
        known = LinearRegression().fit(pairs.sstl[mask], pairs.act[mask])
        np.testing.assert_allclose(own[k], known.predict(pairs.sstl), rtol=1e-10)


@pytest.mark.parametrize("alpha", [0.0, 1.0])
def test_stacked_networks_and_loss_agree_with_plain_modules(alpha):
    p = networks.initial([3, 4], 2, torch.float64)
    rng = np.random.default_rng(0)
    x, y = (torch.from_numpy(rng.normal(1, 0.4, (2, 9, 2))) for _ in "xy")
    for value in p.values():
        value.requires_grad_(True)
    out = networks.forward(p, x, torch.full((2, 1, 1), alpha, dtype=torch.float64))
    weight, lam = torch.full((2, 9), 1 / 9, dtype=torch.float64), torch.tensor([0.0, 0.3], dtype=torch.float64)
    losses = networks.loss(out, y, weight, lam)
    losses.sum().backward()
    for k in range(2):
        net = Net(p, k, alpha)
        guess = net(x[k])
        mse = ((guess - y[k]) ** 2).sum(1).mean()
        loss = mse + lam[k] * ((guess[:, 0] * guess[:, 1] - 1) ** 2).mean()
        loss.backward()
        torch.testing.assert_close(out[k], guess)
        torch.testing.assert_close(losses[k], loss)
        torch.testing.assert_close(p["w1.0"].grad[k], net.blocks[0][0].weight.grad)
        torch.testing.assert_close(p["w2.1"].grad[k], net.blocks[1][1].weight.grad)
        torch.testing.assert_close(p["e_w"].grad[k], net.embed.weight.grad)


def test_a_member_trains_as_if_it_were_alone():
    pairs, splits = prepared(per_seed=True)
    options = training.Options(epochs=60, patience=10, double=True)
    data = (pairs.sstl, pairs.act, pairs.config_id)
    together = training.fit(*data, splits, VARIANTS, options)
    assert len({c.epoch[-1] for c in together.curves}) > 1, "members stop at different epochs"
    alone = make_splits(pairs.location_of(), [1], 0, per_seed=True)
    for variant in (PLAIN, SKIP_INV):
        single = training.fit(*data, alone, [variant], options)
        for name, value in single.group.variants[variant.name].items():
            np.testing.assert_allclose(together.group.variants[variant.name][name][1], value[0], atol=1e-9)


def test_a_member_follows_adamw_on_a_plain_module():
    pairs, splits = prepared(seeds=(5,))
    options = training.Options(epochs=5, double=True)
    fitted = training.fit(pairs.sstl, pairs.act, pairs.config_id, splits, [SKIP_INV], options)
    mask, whole = splits.mask(pairs.config_id, "f")[0], splits.mask(pairs.config_id, "fv")[0]
    mean, std = pairs.act[whole].mean(0), pairs.act[whole].std(0)
    x = torch.from_numpy(((pairs.sstl - pairs.sstl[whole].mean(0)) / pairs.sstl[whole].std(0))[mask])
    y, mean, std = torch.from_numpy(pairs.act[mask]), torch.from_numpy(mean), torch.from_numpy(std)
    net = Net(networks.initial([5], 2, torch.float64), 0, 1.0)
    optimiser = torch.optim.AdamW(net.parameters(), lr=options.learning_rate, weight_decay=options.weight_decay)
    for _ in range(5):
        optimiser.zero_grad()
        out = mean + std * net(x)
        (((out - y) ** 2).sum(1).mean() + 2e-3 * ((out.prod(1) - 1) ** 2).mean()).backward()
        optimiser.step()
    np.testing.assert_allclose(fitted.group.variants["skip-inv"]["h_w"][0], net.head.weight.detach().numpy(), atol=1e-9)


def test_held_out_values_change_nothing_that_is_learnt():
    pairs, splits = prepared()
    changed = pairs.act + splits.mask(pairs.config_id, "h")[0][:, None] * 0.5
    found = [training.fit(pairs.sstl, y, pairs.config_id, splits, VARIANTS, FAST) for y in (pairs.act, changed)]
    for name in ("linear", "skip"):
        for key, value in found[0].group.variants[name].items():
            np.testing.assert_array_equal(value, found[1].group.variants[name][key])


def test_networks_learn_a_curve_that_a_line_cannot():
    pairs, splits = prepared(50, (0, 1))
    z = (pairs.sstl[:, 0] - pairs.sstl[:, 0].mean()) / pairs.sstl[:, 0].std()
    y = pairs.act + np.outer(z**2 - 1, [0.02, -0.05])
    fitted = training.fit(pairs.sstl, y, pairs.config_id, splits, VARIANTS)
    held = splits.mask(pairs.config_id, "h")[0]
    error = {}
    for v in VARIANTS:
        out = forward(pairs.sstl, fitted.group.scaling, fitted.group.variants[v.name], v.alpha)
        error[v.name] = np.sqrt(((out - y)[:, held] ** 2).mean())
    assert max(error["plain"], error["plain-inv"], error["skip"], error["skip-inv"]) < 0.75 * error["linear"]
    assert all(fitted.rmse_validation[n].mean() < fitted.rmse_validation["linear"].mean() for n in ("plain", "skip"))


def test_a_heavy_inverse_consistency_term_pulls_the_product_to_one():
    from dataclasses import replace

    pairs, splits = prepared(20, (0,))
    product = {}
    for weight in (0.0, 100.0):
        v = replace(PLAIN_INV, weight_inv=weight)
        fitted = training.fit(pairs.sstl, pairs.act, pairs.config_id, splits, [v], training.Options(300, patience=300))
        out = forward(pairs.sstl, fitted.group.scaling, fitted.group.variants[v.name], 0.0)[0]
        product[weight] = np.abs(out.prod(1) - 1).mean()
    assert product[100.0] < 0.6 * product[0.0]


def test_same_seed_same_bytes_other_seed_other_bytes():
    found = [to_bytes(step.run(theta(rows(8)), step.Config(seeds=2, seed=s, epochs=15)).model) for s in (1, 1, 2)]
    assert found[0] == found[1] != found[2]


def test_the_order_of_rows_does_not_matter():
    made = rows(8)
    found = [to_bytes(step.run(theta(m), step.Config(seeds=2, epochs=10)).model) for m in (made, made[::-1])]
    assert found[0] == found[1]


def test_constant_inputs_train_and_predict_the_mean():
    made = rows(12, places=("CP",))
    for row in made:
        if row["system"] == "sstl":
            row["gamma_p"], row["gamma_r"] = 0.27, 3.2
    result = step.run(theta(made), step.Config(seeds=2, epochs=50))
    whole = np.array([r != "h" for r in result.model.header.roles[0]])
    expected = result.pairs.act[whole].mean(axis=0)
    for name in ("linear", "skip"):
        np.testing.assert_allclose(result.model.predict(np.array([[0.27, 3.2]]), variant=name)[0], expected, atol=0.05)


def test_too_few_pairs_and_unknown_location_are_clear_errors():
    with pytest.raises(SstlError, match=r"E502.*6 paired"):
        step.run(theta(rows(2)))
    with pytest.raises(SstlError, match=r"E503.*'XX'"):
        step.run(theta(rows(4)), step.Config(leave_out="XX"))
    with pytest.raises(SstlError, match="E503"):
        step.run(theta(rows(10, places=("CP",))), step.Config(leave_out="CP"))


def test_tendons_train_by_both_strategies_and_the_better_one_is_kept():
    pairs = pairs_of(theta(with_tendons(rows(20, scatter=1.0), 0.1)))
    splits = make_splits(pairs.location_of(), [0, 1], 0)
    found = train(pairs, splits, (LINEAR, SKIP), training.Options(epochs=200)).model
    header = found.header
    assert header.tendons == ("A", "B") and set(header.strategy_rmse) == {"one-hot", "separate"}
    assert header.strategy == min(header.strategy_rmse, key=header.strategy_rmse.get)
    for strategy in ("one-hot", "separate"):
        model = train(pairs, splits, (LINEAR, SKIP), training.Options(epochs=200), strategy).model
        for k, tendon in enumerate("AB"):
            mask = np.array(pairs.tendon) == tendon
            error = model.predict(pairs.sstl[mask], tendon) - pairs.act[mask]
            # the tendons lie 0.06 and 0.17 apart: an error this small means they were told apart
            assert np.sqrt((error**2).mean()) < 0.02, (strategy, tendon, k)
        with pytest.raises(SstlError, match="E505"):
            model.predict(pairs.sstl)
        assert model.beta_act_of("B") == pytest.approx(BETA)
