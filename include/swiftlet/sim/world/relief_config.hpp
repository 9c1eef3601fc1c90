// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Smooth hills of the ground. Each octave has half the wavelength and half the height of the previous one.
struct ReliefConfig {
  double amplitude_m = 0.0;
  double wavelength_m = 30.0;
  int octaves = 4;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
