# SPDX-License-Identifier: BSD-3-Clause
"""rbl-forest with the settings of its authors' experiment files [Kamler 2025, sec. 3.4]"""
from rbl_forest import compare_forest


def run(experiment):
    agent = "vehicles[0].agent."
    compare_forest(experiment, {agent + "guidance.model": "rbl_thesis_files", agent + "guidance.cells.step_m": 0.5,
                              agent + "mapping.edge_m": 0.3})
