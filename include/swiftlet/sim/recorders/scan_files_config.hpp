// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Settings common to the recorders of scans as single files (PCD, PLY).
struct ScanFilesConfig {
  std::vector<std::string> vehicles;
  std::vector<std::string> sensors;
  int every = 1;
  enum class Frame { kLidar, kWorld, kWorldEstimate };
  static constexpr const char* kFrames[] = {"lidar", "world", "world_estimate"};
  Frame frame = Frame::kLidar;
  std::string folder = "scans";

  void visit_common(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
