// SPDX-License-Identifier: BSD-3-Clause
#include "core/stages/estimators.hpp"

#include "core/localization/ground_truth.hpp"
#include "core/localization/ins.hpp"
#include "core/localization/odometry.hpp"
#include "swiftlet/core/registry.hpp"

namespace swiftlet {
namespace {

void need_pose(const ModuleConfig&, AgentNeeds& needs) { needs.true_pose = true; }

constexpr EstimatorType kEstimatorTypes[] = {
    {{"ground_truth", "pose from outside: the simulator's truth, motion capture, RTK",
      make_module_config<GroundTruthConfig>},
     make_ground_truth_estimator,
     need_pose},
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

void add_estimator_needs(const Module& config, AgentNeeds& needs) {
  const EstimatorType& row = row_named(kEstimatorTypes, config.type, "localization");
  if (row.add_needs != nullptr) row.add_needs(*config.config, needs);
}

}  // namespace swiftlet
