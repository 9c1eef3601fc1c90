// SPDX-License-Identifier: BSD-3-Clause
// Relative localization against where the other vehicle is.
#include <gtest/gtest.h>

#include "swiftlet/sim/metrics/relative_score.hpp"
#include "tests/sim/metrics/metrics_run.hpp"

namespace swiftlet::sim {
namespace {

/// uav1 at (1, 2, 3) with heading 0.5 rad, uav2 at (5, 2, 4) with heading 2 rad; uav1 knows its own pose.
struct Pair : MetricsRun {
  Pair() : MetricsRun(2) {
    states[0].p_world_m = {1, 2, 3};
    states[0].q_world_body = Eigen::AngleAxisd(0.5, Vector3::UnitZ());
    states[1].p_world_m = {5, 2, 4};
    states[1].q_world_body = Eigen::AngleAxisd(2.0, Vector3::UnitZ());
    actions[0].estimate.valid = true;
    actions[0].estimate.T_local_body = states[0].T_world_body();
    RelativeEstimate& estimate = actions[0].relatives.emplace_back();
    estimate.other = 1;
    estimate.position_m = states[1].p_world_m;
    estimate.yaw_rad = 2.0;
    estimate.covariance = 0.01 * RelativeEstimate::Covariance::Identity();
  }
};

TEST(RelativeError, IsDistanceFromTruthToEstimate) {
  Pair run;
  run.actions[0].relatives[0].position_m += Vector3(0.3, 0.0, 0.4);
  run.actions[0].relatives[0].yaw_rad += 0.1 + 2.0 * 3.14159265358979323846;
  run.tick();
  EXPECT_NEAR(run.value("relative_position_mae_m"), 0.5, 1e-12);
  EXPECT_NEAR(run.value("relative_position_max_m"), 0.5, 1e-12);
  EXPECT_NEAR(run.value("relative_yaw_rmse_rad"), 0.1, 1e-12);
  EXPECT_NEAR(run.value("relative_nees"), 25.0, 1e-9);
}

TEST(RelativeError, ExcludesObserverSelfLocalizationError) {
  Pair run;
  // Its world is turned by 1 rad and shifted: so is everything that it believes.
  const Pose T_believed_world = make_pose({10, -20, 5}, Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Vector3::UnitZ())));
  run.actions[0].estimate.T_local_body = T_believed_world * run.actions[0].estimate.T_local_body;
  run.actions[0].relatives[0].position_m = T_believed_world * run.actions[0].relatives[0].position_m;
  run.actions[0].relatives[0].yaw_rad += 1.0;
  run.tick();
  EXPECT_NEAR(run.value("relative_position_mae_m"), 0.0, 1e-12);
  EXPECT_NEAR(run.value("relative_yaw_rmse_rad"), 0.0, 1e-12);
}

TEST(RelativeError, WritesRowForEveryTick) {
  Pair run;
  run.actions[0].relatives[0].t = run.now + kTick;
  run.tick();
  const auto series = run.metrics.series();
  const auto rows = rows_of<RelativeScore>(series);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].other, 1);
  EXPECT_NEAR(rows[0].distance_m, std::sqrt(17.0), 1e-12);
  EXPECT_NEAR(rows[0].sigma_m, 0.1 * std::sqrt(3.0), 1e-12);
  run.actions[0].relatives.clear();
  run.tick();
  EXPECT_TRUE(rows_of<RelativeScore>(run.metrics.series()).empty());
}

TEST(RelativeError, OverSeveralTicksTheyAreMeans) {
  Pair run;
  const Vector3 place_m = run.actions[0].relatives[0].position_m;
  for (const double error_m : {0.3, 0.5, 0.4}) {
    run.actions[0].relatives[0].position_m = place_m + Vector3(error_m, 0.0, 0.0);
    run.actions[0].relatives[0].yaw_rad = 2.0 - error_m;
    run.actions[0].relatives[0].covariance(6, 6) = 0.04;
    run.actions[0].relatives[0].t = run.now + kTick;
    run.actions[0].relatives[0].seen = run.now + kTick - 250'000'000;
    run.tick();
    const auto rows = rows_of<RelativeScore>(run.metrics.series());
    ASSERT_EQ(rows.size(), 1U);
    EXPECT_NEAR(rows[0].yaw_error_rad, -error_m, 1e-12);
    EXPECT_NEAR(rows[0].sigma_yaw_rad, 0.2, 1e-12);
    EXPECT_NEAR(rows[0].unseen_s, 0.25, 1e-12);
    EXPECT_LT((rows[0].error_world_m - Vector3(error_m, 0.0, 0.0)).norm(), 1e-12);
    EXPECT_EQ(rows[0].t, run.now);
  }
  const double square = (0.09 + 0.25 + 0.16) / 3.0;
  EXPECT_NEAR(run.value("relative_position_mae_m"), 0.4, 1e-12);
  EXPECT_NEAR(run.value("relative_position_rmse_m"), std::sqrt(square), 1e-12);
  EXPECT_NEAR(run.value("relative_position_max_m"), 0.5, 1e-12);
  EXPECT_NEAR(run.value("relative_yaw_rmse_rad"), std::sqrt(square), 1e-12);
  EXPECT_NEAR(run.value("relative_nees"), square / 0.01, 1e-9);
  EXPECT_NEAR(run.value("relative_known_s"), 0.03, 1e-12);
  run.states[1].crashed = true;
  run.tick();
  run.states[1].crashed = false;
  run.states[0].crashed = true;
  run.tick();
  EXPECT_NEAR(run.value("relative_known_s"), 0.03, 1e-12) << "wrecks are not localized, and do not localize others";
}

TEST(RelativeError, WithoutRelativeLocalizationHasNoRows) {
  MetricsRun run(2);
  run.tick();
  EXPECT_EQ(run.metrics.report().find("relative_position_mae_m", "uav1"), nullptr);
}

}  // namespace
}  // namespace swiftlet::sim
