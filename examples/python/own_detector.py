# SPDX-License-Identifier: BSD-3-Clause
"""A detector written in Python against `vofod`: the same flight, scored by the simulator.

    python3 examples/python/own_detector.py
"""
import numpy as np

import swiftlet

TEAM = {
    "name": "pair", "duration_s": 4.0, "world": {"type": "empty", "ground": True},
    "vehicles": [
        {"name": "eye", "start": {"position_m": [0, 0, 5]}, "sensors": [{"type": "lidar", "model": "os1_128"}],
         "agent": {"localization": {"type": "ground_truth"}, "detector": {"type": "vofod"}, "guidance": {"type": "hover"}}},
        {"name": "other", "start": {"position_m": [7, 2, 5]},
         "agent": {"localization": {"type": "ground_truth"}, "guidance": {"type": "hover"}}}]}


@swiftlet.detector("hanging", doc="small clusters of points in the air")
class Hanging:
    least_height_m = swiftlet.key(2.0, "[m] above the local origin's ground: what is lower is no vehicle", min=0.0)
    cell_m = swiftlet.key(1.0, "[m] points in neighboring cells belong together", min=0.1)
    greatest_extent_m = swiftlet.key(1.6, "[m] what is larger is no vehicle", min=0.1)

    def step(self, now):
        if not now.clouds:
            return None
        points = now.clouds[-1].points_local_m
        points = points[points[:, 2] > self.least_height_m]
        found = []
        cells = np.floor(points / self.cell_m).astype(int)
        while len(points):
            # Region growing from the first point over adjacent cells.
            group = np.zeros(len(points), bool)
            group[0] = True
            for _ in range(4):
                group = (np.abs(cells[:, None] - np.unique(cells[group], axis=0)[None]).max(axis=2) <= 1).any(axis=1)
            low, high = points[group].min(axis=0), points[group].max(axis=0)
            if group.sum() >= 3 and (high - low).max() <= self.greatest_extent_m:
                found.append(swiftlet.Detection((low + high) / 2, extent_m=high - low, num_points=int(group.sum())))
            points, cells = points[~group], cells[~group]
        return found


def score(detector):
    metrics = swiftlet.fly(TEAM, {"vehicles[eye].agent.detector": detector})["metrics"]["vehicles"]["eye"]
    return metrics["detection_recall"], metrics["false_detections_per_min"], metrics["detection_error_mean_m"]


if __name__ == "__main__":
    for name in ("hanging", "vofod"):
        recall, false_per_min, error_m = score({"type": name})
        print(f"{name:8s} recall {recall:.2f}, {false_per_min:.1f} false detections a minute, {error_m:.2f} m off")
        assert recall > 0.5
