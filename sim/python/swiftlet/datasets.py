# SPDX-License-Identifier: BSD-3-Clause
"""Datasets of `swiftlet dataset` as an iterator of frames with labels and boxes (docs/datasets.md)."""
import csv as _csv
import dataclasses as _dataclasses
import json as _json
import pathlib as _pathlib
import typing as _typing

import numpy as np

from .results import Rows

__all__ = ["Dataset", "Frame"]

_TRUTH = np.dtype([("t_ns", "<u4"), ("ring", "<u2"), ("column", "<u2"), ("range_m", "<f4"), ("incidence_rad", "<f4")])


@_dataclasses.dataclass(repr=False)
class Frame:
    """One scan with its truth; n returns."""
    sequence: str
    index: int
    t_s: float                              # start of the sweep
    points_lidar_m: np.ndarray              # (n, 3) float32, as measured, each at the instant of its beam
    remission: np.ndarray                   # (n,) float32
    label: np.ndarray                       # (n,) uint16, class
    instance: np.ndarray                    # (n,) uint16
    T_world_lidar: np.ndarray               # (4, 4), true pose of the LiDAR at t_s
    truth: _typing.Optional[np.ndarray]     # (n,) of t_ns, ring, column, range_m, incidence_rad; None: not written
    boxes: Rows                             # other vehicles: name, number of points, center (LiDAR and world), size ...

    def __repr__(self):
        return (f"Frame {self.index} of sequence {self.sequence} at {self.t_s:.3f} s: {len(self.label)} returns, "
                f"{len(self.boxes)} boxes")


class Dataset:
    """A dataset on the disk. `for frame in dataset`, `dataset[5]`, len(dataset); split: train, valid ...; None: all."""

    def __init__(self, folder, split=None):
        self.folder = _pathlib.Path(folder)
        if not (self.folder / "sequences").is_dir():
            raise FileNotFoundError(f"{self.folder}: there is no dataset")
        self.sequences, self._frames, self._known = [], [], {}
        for path in sorted((self.folder / "sequences").iterdir()):
            if path.name.startswith(".") or not (path / "sequence.json").is_file():
                continue
            info = _json.loads((path / "sequence.json").read_text())
            if split is not None and info.get("split") != split:
                continue
            self.sequences.append(path.name)
            self._frames += [(path, i) for i in range(len(list((path / "velodyne").glob("*.bin"))))]

    def __len__(self):
        return len(self._frames)

    def __iter__(self):
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index):
        path, i = self._frames[index]
        times, poses, boxes = self._of_sequence(path)
        scan = np.fromfile(path / f"velodyne/{i:06d}.bin", "<f4").reshape(-1, 4)
        label = np.fromfile(path / f"labels/{i:06d}.label", "<u4")
        truth = path / f"point_truth/{i:06d}.bin"
        return Frame(path.name, i, times[i], scan[:, :3], scan[:, 3], (label & 0xFFFF).astype(np.uint16),
                     (label >> 16).astype(np.uint16), poses[i], np.fromfile(truth, _TRUTH) if truth.is_file() else None,
                     boxes.get(i, Rows()))

    def _of_sequence(self, path):
        if path not in self._known:
            poses = np.loadtxt(path / "poses.txt", ndmin=2).reshape(-1, 3, 4)
            poses = np.concatenate([poses, np.tile([[[0.0, 0.0, 0.0, 1.0]]], (len(poses), 1, 1))], axis=1)
            boxes = {}
            if (path / "boxes.csv").is_file():
                with open(path / "boxes.csv", newline="") as file:
                    for row in _csv.DictReader(file):
                        box = {key: value if key == "vehicle" else _number(value) for key, value in row.items()}
                        boxes.setdefault(int(row["frame"]), Rows()).append(box)
            self._known[path] = np.loadtxt(path / "times.txt", ndmin=1), poses, boxes
        return self._known[path]


def _number(text):
    value = float(text) if text else float("nan")
    return int(value) if value.is_integer() and "." not in text else value
