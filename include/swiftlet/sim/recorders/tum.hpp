// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct TumConfig : ModuleConfigOf<TumConfig>, OutputProvider {
  std::vector<std::string> vehicles;
  double rate_hz = 100.0;
  bool estimate = true;

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"type", "trajectories", false, "tum", vehicles, {}}; }
};

/// trajectories/VEHICLE.tum (truth) and VEHICLE.estimate.tum: "t_s x y z qx qy qz qw" of the body in the world.
std::unique_ptr<Recorder> make_tum_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
