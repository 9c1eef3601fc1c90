# SPDX-License-Identifier: BSD-3-Clause
"""Common parts of the experiments: tables and verdicts (experiment), parallel flights (flights), figures (figures)."""
