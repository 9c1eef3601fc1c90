// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/frames.hpp"

namespace swiftlet::sim {

/// Mean wind and Dryden turbulence (MIL-F-8785C, low altitude).
struct WindConfig {
  Eigen::Vector3d mean_mps = Eigen::Vector3d::Zero();
  bool gusts = false;
  double wind_at_6m_mps = 7.7;  ///< W20 of MIL-F-8785C: 7.7 light, 15.4 moderate, 23.2 severe

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
