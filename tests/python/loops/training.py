# SPDX-License-Identifier: MIT
"""The part of a trainer that does not depend on the rasterizer: rates, loss, density control."""
import json
import math
import sys

import numpy as np
import torch

DC = 0.28209479177387814  # of the spherical harmonics
RATES = {"dc": 2.5e-3, "rest": 1.25e-4, "opacities": 2.5e-2, "scales": 5e-3, "rotations": 1e-3}


class Data:
    """Photographs and cameras of an .npz file; every 8th one, from the first, is a test view."""

    def __init__(self, path):
        file = np.load(path)
        self.images = torch.from_numpy(file["images"]).float() / 255  # V x height x width x 3
        self.views = torch.from_numpy(file["views"]).float()  # V x 4 x 4, world to view
        self.focal = [float(value) for value in file["focal"]]
        self.points = torch.from_numpy(file["points"]).float()
        self.colors = torch.from_numpy(file["colors"]).float()
        everything = range(len(self.images))
        self.test = [view for view in everything if view % 8 == 0]
        self.training = [view for view in everything if view % 8 != 0]
        places = torch.stack([torch.inverse(self.views[view])[:3, 3] for view in self.training])
        self.extent = 1.1 * float((places - places.mean(0)).norm(dim=1).max())


class Trainer:
    """Trains by `draw(gaussians, view, degree)`, which returns the picture (height x width x 3), the visible
    Gaussians (N, bool), and a function that gives the gradients by their centres (N x 2, normalised
    device coordinates) after the backward pass."""

    def __init__(self, data, draw, nearest, ssim, most_degree):
        self.data, self.draw, self.ssim, self.most_degree = data, draw, ssim, most_degree
        count = len(data.points)
        size = nearest(data.points).clamp(min=1e-7).sqrt().log()
        start = {"means": data.points.clone(), "dc": ((data.colors - 0.5) / DC)[:, None],
                 "rest": torch.zeros(count, (most_degree + 1) ** 2 - 1, 3),
                 "opacities": torch.full((count, 1), math.log(0.1 / 0.9)), "scales": size[:, None].repeat(1, 3),
                 "rotations": torch.tensor([[1.0, 0, 0, 0]]).repeat(count, 1)}
        self.values = {name: torch.nn.Parameter(value) for name, value in start.items()}
        self.optimizer = torch.optim.Adam(
            [{"params": [value], "lr": RATES.get(name, 0.0), "name": name}
             for name, value in self.values.items()], eps=1e-15)
        self.forget()

    def forget(self):
        count = len(self.values["means"])
        self.moved, self.seen = torch.zeros(count), torch.zeros(count)

    def gaussians(self):
        """The values as a rasterizer takes them."""
        return {"means": self.values["means"], "opacities": torch.sigmoid(self.values["opacities"]),
                "scales": torch.exp(self.values["scales"]),
                "rotations": torch.nn.functional.normalize(self.values["rotations"]),
                "sh": torch.cat([self.values["dc"], self.values["rest"]], 1)}

    def run(self, ends, seed):
        """Yields the PSNR of the test views and the number of Gaussians at the ends of iterations."""
        order, shuffle = [], torch.Generator().manual_seed(seed)
        for iteration in range(1, ends[-1] + 1):
            share = min(iteration / 30000, 1)
            self.optimizer.param_groups[0]["lr"] = self.data.extent * math.exp(
                (1 - share) * math.log(1.6e-4) + share * math.log(1.6e-6))
            if not order:
                order = [self.data.training[place] for place in
                         torch.randperm(len(self.data.training), generator=shuffle).tolist()]
            adds = iteration >= 600 and iteration % 100 == 0
            self.differentiate(order.pop(), iteration)
            if not adds:
                self.optimizer.step()
            self.optimizer.zero_grad()
            if iteration in ends:
                yield {"psnr": self.psnr(), "gaussians": len(self.values["means"])}
            if adds:
                self.change_density(iteration)

    def differentiate(self, view, iteration):
        degree = min(iteration // 1000, self.most_degree)
        picture, visible, centres = self.draw(self.gaussians(), view, degree)
        wanted, shown = self.data.images[view], picture.clamp(0, 1)
        likeness = self.ssim(shown.permute(2, 0, 1)[None], wanted.permute(2, 0, 1)[None])
        loss = 0.8 * (shown - wanted).abs().mean() + 0.2 * (1 - likeness)
        loss.backward()
        with torch.no_grad():
            self.moved[visible] += centres()[visible].norm(dim=1)
            self.seen[visible] += 1

    @torch.no_grad()
    def change_density(self, iteration):
        average = self.moved / self.seen.clamp(min=1)
        largest = torch.exp(self.values["scales"]).max(1)[0]
        pulls, is_small = average > 2e-4, largest <= 0.01 * self.data.extent
        clones, splits = torch.where(pulls & is_small)[0], torch.where(pulls & ~is_small)[0]
        parents = splits.repeat(2)
        scales = torch.exp(self.values["scales"][parents])
        turned = torch.einsum("nij,nj->ni", matrices(self.values["rotations"][parents]),
                              torch.randn(len(parents), 3) * scales)
        source = torch.cat([torch.arange(len(pulls)), clones, parents])
        is_new = torch.arange(len(source)) >= len(pulls)
        fresh = {name: value[source].clone() for name, value in self.values.items()}
        if len(parents):
            fresh["means"][-len(parents):] += turned
            fresh["scales"][-len(parents):] = torch.log(scales / 1.6)
        keep = torch.sigmoid(fresh["opacities"][:, 0]) >= 0.005
        keep[splits] = False
        if iteration > 3000:
            keep &= torch.exp(fresh["scales"]).max(1)[0] <= 0.1 * self.data.extent
        for name in list(self.values):
            self.replace(name, fresh[name][keep], source[keep], is_new[keep])
        self.forget()
        if iteration % 3000 == 0:
            self.replace("opacities", self.values["opacities"].clamp(max=math.log(0.01 / 0.99)))

    def replace(self, name, value, source=None, is_new=None):
        """Gives a parameter other rows, with the moments of their sources; None: no moments."""
        group = next(group for group in self.optimizer.param_groups if group["name"] == name)
        state = self.optimizer.state.pop(self.values[name])
        for moment in ("exp_avg", "exp_avg_sq"):
            state[moment] = torch.zeros_like(value) if source is None else state[moment][source]
            if is_new is not None:
                state[moment][is_new] = 0
        self.values[name] = group["params"][0] = torch.nn.Parameter(value)
        self.optimizer.state[self.values[name]] = state

    @torch.no_grad()
    def psnr(self):
        """Mean PSNR of the test views."""
        errors = [(self.draw(self.gaussians(), view, self.most_degree)[0].clamp(0, 1)
                   - self.data.images[view]).square().mean() for view in self.data.test]
        return float(torch.stack([-10 * torch.log10(error) for error in errors]).mean())


def matrices(rotations):
    """N x 3 x 3 of N quaternions w x y z."""
    w, x, y, z = torch.nn.functional.normalize(rotations).unbind(1)
    rows = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
            2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
            2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    return torch.stack(rows, 1).reshape(-1, 3, 3)


def main(draw_of, nearest, ssim):
    """LOOP.py DATA.npz ITERATIONS[,ITERATIONS..] DEGREE SEED: prints the results as lines of JSON."""
    path, ends, degree, seed = sys.argv[1:5]
    torch.manual_seed(int(seed))
    data = Data(path)
    trainer = Trainer(data, draw_of(data), nearest, ssim, int(degree))
    for result in trainer.run([int(end) for end in ends.split(",")], int(seed)):
        print(json.dumps(result), flush=True)
