// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/target_prediction.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace swiftlet {
namespace {

TrackModes certain_of(TrackModes::Model model, const Vector3& p_m, const Vector3& v_mps, const Vector3& a_mps2) {
  TrackModes modes;
  modes.probability[model] = 1.0;
  for (auto& mean : modes.mean_local_m) mean << p_m, v_mps, a_mps2;
  return modes;
}

TEST(TargetPrediction, StartsFromTrackTime) {
  Track track;
  track.t = 1'000'000'000;
  const TrackModes modes = certain_of(TrackModes::kConstantVelocity, {1, 2, 3}, {4, 0, -1}, {9, 9, 9});
  const TargetPrediction prediction({}, track, &modes, 1'500'000'000);
  EXPECT_LT((prediction.at(0.0).p_m - Vector3(3, 2, 2.5)).norm(), 1e-6);
  EXPECT_LT((prediction.at(1.0).p_m - Vector3(7, 2, 1.5)).norm(), 1e-6);
}

// A target on a circle of 5 m at 1 rad/s is on that circle for ever.
TEST(TargetPrediction, ContinuesTurnsAlongTheirCircle) {
  const TrackModes modes = certain_of(TrackModes::kCoordinatedTurn, {5, 0, 8}, {0, 5, 0}, {-5, 0, 0});
  const TargetPrediction prediction({}, Track{}, &modes, 0);
  for (int tenth = 0; tenth < 40; ++tenth) {
    const double t_s = 0.1 * tenth;
    EXPECT_LT((prediction.at(t_s).p_m - Vector3(5 * std::cos(t_s), 5 * std::sin(t_s), 8)).norm(), 1e-6) << t_s;
  }
}

TEST(TargetPrediction, AnAccelerationDiesAway) {
  TargetPredictionConfig config;
  config.acceleration_time_s = 0.5;
  Track track;
  track.acceleration_mps2 = {2, 0, 0};
  const TargetPrediction prediction(config, track, nullptr, 0);
  EXPECT_NEAR(prediction.at(0.01).p_m.x(), 0.5 * 2 * 1e-4, 1e-6) << "at first it is constant";
  EXPECT_NEAR(prediction.at(10.0).v_mps.x(), 2 * 0.5, 1e-6) << "in all it gives a T of velocity";
}

TEST(TargetPrediction, MixesItsModelsByTheirProbabilities) {
  TrackModes modes = certain_of(TrackModes::kConstantVelocity, {0, 0, 0}, {4, 0, 0}, {0, 0, 0});
  modes.probability = {0.75, 0.25, 0.0};
  modes.mean_local_m[TrackModes::kConstantAcceleration].segment<3>(3) = Vector3(0, 4, 0);
  const TargetPrediction prediction({}, Track{}, &modes, 0);
  EXPECT_LT((prediction.at(2.0).p_m - Vector3(6, 2, 0)).norm(), 1e-6);
}

TEST(TargetPrediction, LosesCertaintyWithLookahead) {
  Track track;
  track.covariance.setIdentity();
  const TargetPrediction prediction({}, track, nullptr, 0);
  EXPECT_DOUBLE_EQ(prediction.sigma_m(0.0), 1.0);
  EXPECT_DOUBLE_EQ(prediction.sigma_m(2.0), std::sqrt(5.0));
}

}  // namespace
}  // namespace swiftlet
