// SPDX-License-Identifier: BSD-3-Clause
#include "core/mappers/vehicles_around.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace swiftlet {
namespace {

constexpr double kRadius_m = 1.0;
constexpr TimeNs kTenth = kNsPerSecond / 10;

struct Around {
  explicit Around(double radius_m = kRadius_m) : vehicles(radius_m) {
    estimate.valid = true;
    estimate.T_local_body =
        make_pose({10.0, -3.0, 5.0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Vector3::UnitZ())));
    clouds = {std::make_shared<LocalCloud>()};
  }
  void tick(TimeNs t, bool scans = true) {
    observation.t = estimate.t = t;
    vehicles.update({observation,
                     estimate,
                     scans ? std::span(clouds) : std::span(clouds).first(0),
                     tracks,
                     {},
                     observation.neighbors});
    observation.neighbors.clear();
  }
  void sees(VehicleId id, TimeNs t, const Vector3& p_body_m, const Matrix3& covariance_body = Matrix3::Zero()) {
    NeighborSample sample;
    sample.t = t;
    sample.id = id;
    sample.p_body_m = p_body_m;
    sample.covariance_body = covariance_body;
    observation.neighbors.push_back(sample);
  }
  bool contains(const Vector3& p_local_m) const { return vehicles.contains(p_local_m.cast<float>(), observation.t); }

  VehiclesAround vehicles;
  Observation observation;
  StateEstimate estimate;
  std::vector<std::shared_ptr<const LocalCloud>> clouds;
  std::vector<Track> tracks;
};

TEST(VehiclesAround, ClaimReturnsNearNeighborSamples) {
  Around around;
  around.sees(3, 0, {8.0, 0.0, 1.0});  // ahead, which is +y
  around.tick(0);
  const Vector3 there_m(10.0, 5.0, 6.0);
  EXPECT_TRUE(around.contains(there_m));
  for (const Vector3& axis : {Vector3(1, 0, 0), Vector3(0, -1, 0), Vector3(0, 0, 1)}) {
    EXPECT_TRUE(around.contains(there_m + 0.99 * axis));
    EXPECT_FALSE(around.contains(there_m + 1.01 * axis));
  }
  EXPECT_FALSE(around.contains(there_m + Vector3(64.0 * 4.0, 0.0, 0.0))) << "its cells repeat, it does not";
}

TEST(VehiclesAround, ReachFartherAlongUncertainRange) {
  Around around;
  Matrix3 covariance = Matrix3::Zero();
  covariance(0, 0) = 0.64;  // 0.8 m of the range
  around.sees(3, 0, {8.0, 0.0, 0.0}, covariance);
  around.tick(0);
  const Vector3 there_m(10.0, 5.0, 5.0);
  const double reach_m = std::sqrt(1.0 + 4.0 * 0.64);
  EXPECT_TRUE(around.contains(there_m + Vector3(0.0, reach_m - 0.01, 0.0)));
  EXPECT_FALSE(around.contains(there_m + Vector3(0.0, reach_m + 0.01, 0.0)));
  EXPECT_FALSE(around.contains(there_m + Vector3(1.01, 0.0, 0.0)));
}

TEST(VehiclesAround, ExpireSamplesAfterHalfASecond) {
  Around around;
  around.sees(3, 0, {8.0, 0.0, 0.0});
  around.tick(0, false);
  const Vector3 there_m(10.0, 5.0, 5.0);
  around.tick(4 * kTenth);
  EXPECT_TRUE(around.contains(there_m + Vector3(1.79, 0.0, 0.0)));
  EXPECT_FALSE(around.contains(there_m + Vector3(1.81, 0.0, 0.0)));
  around.tick(6 * kTenth);
  EXPECT_FALSE(around.contains(there_m));
  // The next one takes the place of the last one, whatever order they come in.
  around.sees(3, 7 * kTenth, {4.0, 0.0, 0.0});
  around.sees(3, 6 * kTenth, {8.0, 0.0, 0.0});
  around.tick(7 * kTenth);
  EXPECT_TRUE(around.contains({10.0, 1.0, 5.0}));
  EXPECT_FALSE(around.contains(there_m));
}

TEST(VehiclesAround, NamelessOnesAreAllKept) {
  Around around;
  around.sees(kNoVehicle, 0, {8.0, 0.0, 0.0});
  around.sees(kNoVehicle, 0, {-8.0, 0.0, 0.0});
  around.tick(0);
  EXPECT_TRUE(around.contains({10.0, 5.0, 5.0}));
  EXPECT_TRUE(around.contains({10.0, -11.0, 5.0}));
}

TEST(VehiclesAround, PredictTracksToThePointTime) {
  Around around;
  Track track;
  track.t = -2 * kNsPerSecond;
  track.position_m = {0.0, 0.0, 5.0};
  track.velocity_mps = {4.0, 0.0, 0.0};
  around.tracks = {track};
  around.tick(0);
  EXPECT_TRUE(around.contains({8.9, 0.0, 5.0}));
  EXPECT_FALSE(around.contains({9.1, 0.0, 5.0}));
  EXPECT_TRUE(around.vehicles.contains({7.0F, 0.0F, 5.0F}, -kTenth * 2));
  EXPECT_FALSE(around.vehicles.contains({8.5F, 0.0F, 5.0F}, -kTenth * 2));
}

TEST(VehiclesAround, ClaimNothingAtZeroRadius) {
  Around around(0.0);
  around.sees(3, 0, {8.0, 0.0, 0.0}, Matrix3::Identity());
  around.tick(0);
  EXPECT_FALSE(around.contains({10.0, 5.0, 5.0}));
}

}  // namespace
}  // namespace swiftlet
