# SPDX-License-Identifier: BSD-3-Clause
"""A small dataset and the training of a classifier in numpy: ground points against all others.

    python3 examples/python/train_classifier.py build/release/swiftlet [FOLDER]
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import swiftlet

GROUND = 40


DATASET = """name: small
splits: [{name: train, flights: 1, first_seed: 1}, {name: valid, flights: 1, first_seed: 2}]
families: [{name: trees, scenario: forest.yaml, flight: {speed_max_mps: 2}}]
content: {images: false}
pictures: {flights_per_split: 0}
"""
FOREST = """name: small_forest
duration_s: 1.2
world: {type: forest, size_m: [60, 60], surroundings_m: 0}
vehicles:
  - sensors: [{type: lidar, pattern: {type: ouster, columns: 512, rows: 64}}]
    agent: {localization: ground_truth}
"""


def generate(program, folder):
    with tempfile.TemporaryDirectory() as scratch:
        for name, text in (("small.yaml", DATASET), ("forest.yaml", FOREST)):
            (pathlib.Path(scratch) / name).write_text(text)
        subprocess.run([str(program), "dataset", f"{scratch}/small.yaml", "--out", str(folder)], check=True,
                       stdout=subprocess.DEVNULL)


def features(frame, every=7):
    """(n, features) of every seventh point: height in the world, elevation of its ray, and height range of its surroundings."""
    points = frame.points_lidar_m[::every].astype(float)
    world = points @ frame.T_world_lidar[:3, :3].T + frame.T_world_lidar[:3, 3]
    range_m = np.linalg.norm(points, axis=1)
    cells = np.floor(world[:, :2] / 0.5).astype(int)
    _, cell = np.unique(cells, axis=0, return_inverse=True)
    low = np.full(cell.max() + 1, np.inf)
    np.minimum.at(low, cell, world[:, 2])
    above = world[:, 2] - low[cell]
    slant = (world[:, 2] - frame.T_world_lidar[2, 3]) / range_m
    return np.stack([above, np.minimum(above, 0.3), slant, world[:, 2] * 0.1, np.ones(len(points))], axis=1)


def gather(dataset):
    frames = [dataset[i] for i in range(0, len(dataset), max(1, len(dataset) // 8))]
    x = np.concatenate([features(f) for f in frames])
    y = np.concatenate([f.label[::7] == GROUND for f in frames]).astype(float)
    return x, y


def train(x, y, steps=300, rate=1.0):
    """Logistic regression by gradient descent."""
    scale = np.where(x.std(axis=0) > 0, x.std(axis=0), 1.0)
    w = np.zeros(x.shape[1])
    for _ in range(steps):
        p = 1.0 / (1.0 + np.exp(-np.clip(x / scale @ w, -30, 30)))
        w -= rate * (x / scale).T @ (p - y) / len(y)
    return w / scale


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else pathlib.Path(scratch) / "data"
        if not folder.exists():
            generate(pathlib.Path(sys.argv[1]).resolve(), folder)
        train_set, valid_set = (swiftlet.datasets.Dataset(folder, split) for split in ("train", "valid"))
        print(f"{len(train_set)} frames to train, {len(valid_set)} to validate")
        w = train(*gather(train_set))
        x, y = gather(valid_set)
        right = ((x @ w > 0) == (y > 0.5)).mean()
        print(f"{right:.1%} of {len(y)} points right; always the same answer: {max(y.mean(), 1 - y.mean()):.1%}")
        assert right > max(y.mean(), 1 - y.mean())
