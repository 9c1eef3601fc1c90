// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/registry.hpp"

#include <stdexcept>
#include <vector>

#include "core/localization/ground_truth.hpp"
#include "core/localization/ins.hpp"
#include "core/localization/odometry.hpp"

namespace swiftlet {
namespace {

constexpr EstimatorType kTypes[] = {
    {{"ground_truth", "pose from outside: the simulator's truth, motion capture, RTK",
      make_module_config<GroundTruthConfig>},
     make_ground_truth_estimator},
    {{"odometry", "visual-inertial odometry in its drifting local frame, and the IMU",
      make_module_config<OdometryEstimatorConfig>},
     make_odometry_estimator},
    {{"ins", "inertial navigation aided by GNSS, altimeter, compass and odometry", make_module_config<InsConfig>},
     make_ins_estimator},
};

}  // namespace

std::span<const EstimatorType> estimator_types() { return kTypes; }

std::span<const ModuleType> estimator_module_types() {
  static const std::vector<ModuleType> modules = [] {
    std::vector<ModuleType> out;
    for (const EstimatorType& type : kTypes) out.push_back(type.module);
    return out;
  }();
  return modules;
}

std::unique_ptr<StateEstimator> make_estimator(const Module& config, const AgentSetup& setup) {
  for (const EstimatorType& type : kTypes) {
    if (config.type == type.module.name) return type.make(*config.config, setup);
  }
  throw std::invalid_argument("no localization type is named '" + config.type + "'");
}

}  // namespace swiftlet
