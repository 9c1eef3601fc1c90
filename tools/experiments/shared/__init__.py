# SPDX-License-Identifier: BSD-3-Clause
"""What the experiments share: tables and verdicts (experiment), parallel flights (flights), figures (figures)."""
