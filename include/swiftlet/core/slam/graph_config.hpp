// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

/// Weighting of a GNSS fix by its standard deviations.
enum class GnssWeighting {
  kIsotropic,  ///< all axes by the largest [Orsulic 2021, eq. 6]
  kPerAxis,    ///< each axis by its own [eq. 5]
  kReleased,   ///< each axis by the square of its own, as in the authors' released program
};

struct GnssFactorConfig {
  GnssWeighting weighting = GnssWeighting::kIsotropic;
  double a = 1.0;
  double b_1_m = 0.0;
  double huber = 1.0;

  void visit(ConfigVisitor& v);
};

struct GraphSolverConfig {
  int iterations = 20;     ///< [-] largest number of iterations of one optimization; larger values cost time
  double step_min = 1e-6;  ///< [m, rad] step size below which the optimization ends
};

}  // namespace swiftlet
