// SPDX-License-Identifier: BSD-3-Clause
// Association of several observers' tracks to targets, and the reported tracks.
#include "core/shared_tracks/track_fusion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <set>

#include "tests/core/shared_tracks/sharing_support.hpp"

namespace swiftlet {
namespace {

/// Standard deviations of position and velocity of an observer's track, per axis.
constexpr double kSigma_m = 0.15, kSigma_mps = 0.4;

/// Tracks of several observers in one common frame, fused every 0.1 s.
class FusionScene {
 public:
  explicit FusionScene(std::uint64_t seed = 1, const TrackFusionConfig& config = {})
      : fusion(config), random_(seed, "test.fusion", "scene") {}

  /// Adds to the next fusion an observer's track of a target at p_m; `noisy` adds random errors to its estimate.
  void observe(VehicleId observer, std::uint32_t identity, const Vector3& p_m, const Vector3& v_mps = Vector3::Zero(),
               double existence = 0.95, double sigma_m = kSigma_m) {
    ObservedTrack track{observer, identity, {}, existence};
    track.estimate.covariance.setZero();
    track.estimate.covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
    track.estimate.covariance.diagonal().tail<3>().setConstant(kSigma_mps * kSigma_mps);
    track.estimate.mean << p_m, v_mps;
    const auto tick = static_cast<std::uint32_t>(k_);
    for (std::uint32_t i = 0; i < 3 && noisy; ++i) {
      const std::uint32_t index = 100 * static_cast<std::uint32_t>(observer) + 6 * identity + i;
      track.estimate.mean(i) += sigma_m * random_.normal(tick, index);
      track.estimate.mean(i + 3) += kSigma_mps * random_.normal(tick, index + 3);
    }
    observed_.push_back(track);
  }
  /// Fuses the added tracks.
  std::span<const FusedTrack> fuse() {
    std::stable_sort(observed_.begin(), observed_.end(),
                     [](const auto& a, const auto& b) { return a.observer < b.observer; });
    last = observed_;
    fusion.update(from_seconds(0.1 * k_++), observed_);
    observed_.clear();
    return fusion.reported();
  }

  TrackFusion fusion;
  bool noisy = true;
  std::vector<ObservedTrack> last;  // tracks of the latest fusion

 private:
  Random random_;
  int k_ = 0;
  std::vector<ObservedTrack> observed_;
};

TEST(TrackFusion, ReportsSoleObserversTracksUnchanged) {
  FusionScene scene;
  scene.noisy = false;
  scene.observe(0, 7, {1, 2, 3}, {1, 0, 0});
  scene.observe(0, 8, {1.2, 2, 3}, {1, 0, 0});  // near target 7, but the same observer reports two
  const auto reported = scene.fuse();
  ASSERT_EQ(reported.size(), 2U);
  EXPECT_EQ(reported[0].estimate.p_m(), Vector3(1, 2, 3));
  EXPECT_EQ(reported[0].estimate.covariance, scene.last[0].estimate.covariance);
  EXPECT_DOUBLE_EQ(reported[0].existence, 0.95);
}

TEST(TrackFusion, ReportsSharedTargetOnceFromStart) {
  FusionScene scene;
  for (int k = 0; k < 50; ++k) {
    scene.observe(0, 7, {0.1 * k, 2, 3}, {1, 0, 0});
    scene.observe(1, 9, {0.1 * k, 2, 3}, {1, 0, 0});
    const auto reported = scene.fuse();
    ASSERT_EQ(reported.size(), 1U) << k;
    EXPECT_EQ(reported[0].id, 1U);
    if (k >= 10) {
      EXPECT_EQ(reported[0].members.size(), 2U) << k;
    }
  }
  EXPECT_EQ(scene.fusion.num_joined(), 1U);
  EXPECT_EQ(scene.fusion.num_broken(), 0U);
}

TEST(TrackFusion, NeverJoinsBeforeConfirmation) {
  FusionScene scene;
  scene.noisy = false;
  for (int k = 0; k < 2; ++k) {  // two agreements; a join takes three (TrackFusionConfig::confirmations)
    scene.observe(0, 7, {0, 0, 0});
    scene.observe(1, 9, {0, 0, 0});
    scene.fuse();
  }
  EXPECT_EQ(scene.fusion.num_joined(), 0U);
}

TEST(TrackFusion, KeepsAdjacentTargetsApart) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    FusionScene scene(seed);
    for (int k = 0; k < 100; ++k) {
      const Vector3 v_mps(2, 0, 0), here_m(0.2 * k, 0, 5), beside_m(0.2 * k, 1.0, 5);
      scene.observe(0, 1, here_m, v_mps);
      scene.observe(0, 2, beside_m, v_mps);
      scene.observe(1, 1, here_m, v_mps);
      scene.observe(1, 2, beside_m, v_mps);
      scene.fuse();
    }
    // Both observers use the same identities, so that only tracks of equal identity may be joined.
    for (const FusedTrack& reported : scene.fusion.reported()) {
      std::set<std::uint32_t> identities;
      for (const std::size_t m : reported.members) identities.insert(scene.last[m].identity);
      EXPECT_EQ(identities.size(), 1U) << seed;
    }
    EXPECT_EQ(scene.fusion.reported().size(), 2U) << seed;
  }
}

TEST(TrackFusion, KeepsSeparatelyObservedTargetsApart) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    FusionScene scene(seed);
    for (int k = 0; k < 100; ++k) {
      const Vector3 v_mps(2, 0, 0);
      scene.observe(0, 1, {0.2 * k, 0, 5}, v_mps);
      scene.observe(1, 2, {0.2 * k, 1.5, 5}, v_mps);
      scene.fuse();
    }
    EXPECT_EQ(scene.fusion.num_joined(), 0U) << seed;
    EXPECT_EQ(scene.fusion.reported().size(), 2U) << seed;
  }
}

TEST(TrackFusion, NeitherJoinsNorDuplicatesWhenAmbiguous) {
  FusionScene scene;
  scene.noisy = false;
  for (int k = 0; k < 30; ++k) {  // observer 0's target may be either of observer 1's two
    scene.observe(0, 1, {0, 0, 5});
    scene.observe(1, 1, {0, 0.2, 5});
    scene.observe(1, 2, {0, -0.2, 5});
    const auto reported = scene.fuse();
    ASSERT_EQ(reported.size(), 2U) << k;  // observer 1 distinguishes two targets
    for (const FusedTrack& track : reported) EXPECT_EQ(scene.last[track.members.front()].observer, 1);
  }
  EXPECT_EQ(scene.fusion.num_joined(), 0U);
}

TEST(TrackFusion, NeverJoinsTracksOfUncertainPosition) {
  FusionScene scene;
  for (int k = 0; k < 100; ++k) {
    scene.observe(0, 1, {0, 0, 5}, Vector3::Zero(), 0.95, 1.5);
    scene.observe(1, 1, {0, 0, 5}, Vector3::Zero(), 0.95, 0.1);
    scene.fuse();
  }
  EXPECT_EQ(scene.fusion.num_joined(), 0U);
}

TEST(TrackFusion, SplitsTracksThatDiverge) {
  FusionScene scene;
  for (int k = 0; k < 60; ++k) {
    const double apart_m = k < 20 ? 0.0 : 0.2 * (k - 20);
    scene.observe(0, 1, {0, 0, 5});
    scene.observe(1, 1, {apart_m, 0, 5}, {k < 20 ? 0.0 : 2.0, 0, 0});
    scene.fuse();
  }
  EXPECT_EQ(scene.fusion.num_joined(), 1U);
  EXPECT_EQ(scene.fusion.num_broken(), 1U);
  EXPECT_EQ(scene.fusion.reported().size(), 2U);
  EXPECT_EQ(scene.fusion.reported()[0].id, 1U);  // observer 0's track keeps the id
}

TEST(TrackFusion, KeepsIdentityWhenAnObserverReacquires) {
  FusionScene scene;
  for (int k = 0; k < 120; ++k) {
    const Vector3 p_m(0.1 * k, 0, 5), v_mps(1, 0, 0);
    if (k < 40) scene.observe(0, 1, p_m, v_mps);
    if (k >= 80) scene.observe(0, 2, p_m, v_mps);  // reacquired under another identity
    scene.observe(1, 5, p_m, v_mps);
    const auto reported = scene.fuse();
    ASSERT_EQ(reported.size(), 1U) << k;
    EXPECT_EQ(reported[0].id, 1U) << k;
  }
}

TEST(TrackFusion, DropsTargetsWithoutReports) {
  FusionScene scene;
  scene.observe(1, 5, {0, 0, 5});
  EXPECT_EQ(scene.fuse().size(), 1U);
  EXPECT_EQ(scene.fuse().size(), 0U);
  scene.observe(1, 5, {0, 0, 5});
  ASSERT_EQ(scene.fuse().size(), 1U);
  EXPECT_EQ(scene.fusion.reported()[0].id, 1U);  // the id is kept over the fusion without reports
}

TEST(TrackFusion, ReportsWeakTracksThatAgree) {
  FusionScene scene;
  std::size_t reported = 0;
  for (int k = 0; k < 20; ++k) {
    scene.observe(0, 1, {0, 0, 5}, Vector3::Zero(), 0.2);
    scene.observe(1, 1, {0, 0, 5}, Vector3::Zero(), 0.2);
    reported = scene.fuse().size();
  }
  ASSERT_EQ(reported, 1U);
  EXPECT_NEAR(scene.fusion.reported()[0].existence, 0.714, 0.01);  // odds 0.25, times 1 / kCommonClutter = 10 at most
}

TEST(TrackFusion, ThreeObserversSeeOneTarget) {
  FusionScene scene;
  for (int k = 0; k < 40; ++k) {
    for (VehicleId observer = 0; observer < 3; ++observer) scene.observe(observer, 1, {0, 0.1 * k, 5}, {0, 1, 0});
    ASSERT_EQ(scene.fuse().size(), 1U) << k;
  }
  EXPECT_EQ(scene.fusion.reported()[0].members.size(), 3U);
}

/// With independent and with equal errors of the observers, the mean NEES is at most the degrees of freedom, six.
TEST(TrackFusion, KeepsErrorWithinReportedCovariance) {
  for (const bool common : {false, true}) {
    double nees = 0.0;
    int count = 0;
    const Random random(9, "test.fusion", common ? "common" : "own");
    TrackFusion fusion((TrackFusionConfig()));
    for (int k = 0; k < 2000; ++k) {
      std::vector<ObservedTrack> observed;
      for (VehicleId observer = 0; observer < 2; ++observer) {
        ObservedTrack track{observer, 1, {}, 0.9};
        track.estimate.covariance.setZero();
        track.estimate.covariance.diagonal() << 0.01, observer == 0 ? 0.09 : 0.01, 0.04, 0.1, 0.1, 0.1;
        for (std::uint32_t i = 0; i < 6; ++i) {
          const double z =
              random.normal(static_cast<std::uint32_t>(k), common ? i : 6U * static_cast<std::uint32_t>(observer) + i);
          track.estimate.mean(i) = std::sqrt(track.estimate.covariance(i, i)) * z;
        }
        observed.push_back(track);
      }
      fusion.update(from_seconds(0.1 * k), observed);
      for (const FusedTrack& reported : fusion.reported()) {
        if (reported.members.size() < 2) continue;
        nees += reported.estimate.mean.dot(reported.estimate.covariance.ldlt().solve(reported.estimate.mean));
        ++count;
      }
    }
    ASSERT_GT(count, 1500) << common;
    EXPECT_LT(nees / count, 6.3) << common;
    EXPECT_GT(nees / count, common ? 5.0 : 2.5) << common;
  }
}

}  // namespace
}  // namespace swiftlet
