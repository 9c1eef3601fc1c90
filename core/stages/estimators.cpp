// SPDX-License-Identifier: BSD-3-Clause
#include "core/stages/estimators.hpp"

#include "core/localization/ground_truth.hpp"
#include "core/localization/ins.hpp"
#include "core/localization/odometry.hpp"
#include "swiftlet/core/registry.hpp"

namespace swiftlet {
namespace {

constexpr EstimatorType kEstimatorTypes[] = {
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

std::span<const EstimatorType> estimator_types() { return kEstimatorTypes; }

std::span<const ModuleType> estimator_module_types() { return module_types_of<kEstimatorTypes>(); }

std::unique_ptr<StateEstimator> make_estimator(const Module& config, const AgentSetup& setup) {
  return row_named(kEstimatorTypes, config.type, "localization").make(*config.config, setup);
}

}  // namespace swiftlet
