# SPDX-License-Identifier: BSD-3-Clause
"""Common parts of the experiments: verdicts and parallel flights (experiment), tables, statistics, rotations, pages, flights by subject."""
