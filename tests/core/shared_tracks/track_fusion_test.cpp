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

constexpr double kSigma_m = 0.15, kSigma_mps = 0.4;

/// All observers see the same world, a scan every 0.1 s.
class FusionScene {
 public:
  explicit FusionScene(std::uint64_t seed = 1, const TrackFusionConfig& config = {})
      : fusion(config), random_(seed, "test.fusion", "scene") {}

  /// A track of a target that is at a place.
  void see(VehicleId observer, std::uint32_t identity, const Vector3& p_m, const Vector3& v_mps = Vector3::Zero(),
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
  std::span<const FusedTrack> scan() {
    std::stable_sort(observed_.begin(), observed_.end(),
                     [](const auto& a, const auto& b) { return a.observer < b.observer; });
    last = observed_;
    fusion.update(from_seconds(0.1 * k_++), observed_);
    observed_.clear();
    return fusion.reported();
  }

  TrackFusion fusion;
  bool noisy = true;
  std::vector<ObservedTrack> last;

 private:
  Random random_;
  int k_ = 0;
  std::vector<ObservedTrack> observed_;
};

TEST(TrackFusion, ReportsSoleObserversTracksUnchanged) {
  FusionScene scene;
  scene.noisy = false;
  scene.see(0, 7, {1, 2, 3}, {1, 0, 0});
  scene.see(0, 8, {1.2, 2, 3}, {1, 0, 0});  // near it, but reported by the same observer as a second target
  const auto reported = scene.scan();
  ASSERT_EQ(reported.size(), 2U);
  EXPECT_EQ(reported[0].estimate.p_m(), Vector3(1, 2, 3));
  EXPECT_EQ(reported[0].estimate.covariance, scene.last[0].estimate.covariance);
  EXPECT_DOUBLE_EQ(reported[0].existence, 0.95);
}

TEST(TrackFusion, ReportsSharedTargetOnceFromStart) {
  FusionScene scene;
  for (int k = 0; k < 50; ++k) {
    scene.see(0, 7, {0.1 * k, 2, 3}, {1, 0, 0});
    scene.see(1, 9, {0.1 * k, 2, 3}, {1, 0, 0});
    const auto reported = scene.scan();
    ASSERT_EQ(reported.size(), 1U) << k;
    EXPECT_EQ(reported[0].id, 1U);
    if (k >= 10) {
      EXPECT_EQ(reported[0].members.size(), 2U) << k;
    }
  }
  EXPECT_EQ(scene.fusion.num_joined(), 1U);
  EXPECT_EQ(scene.fusion.num_broken(), 0U);
}

TEST(TrackFusion, NeverJoinsOnSingleAgreement) {
  FusionScene scene;
  scene.noisy = false;
  for (int k = 0; k < 2; ++k) {  // two cross at the same place
    scene.see(0, 7, {0, 0, 0});
    scene.see(1, 9, {0, 0, 0});
    scene.scan();
  }
  EXPECT_EQ(scene.fusion.num_joined(), 0U);
}

TEST(TrackFusion, KeepsAdjacentTargetsApart) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    FusionScene scene(seed);
    for (int k = 0; k < 100; ++k) {
      const Vector3 v_mps(2, 0, 0), here_m(0.2 * k, 0, 5), beside_m(0.2 * k, 1.0, 5);
      scene.see(0, 1, here_m, v_mps);
      scene.see(0, 2, beside_m, v_mps);
      scene.see(1, 1, here_m, v_mps);
      scene.see(1, 2, beside_m, v_mps);
      scene.scan();
    }
    // Joined are, if anything, tracks of the same identity.
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
      scene.see(0, 1, {0.2 * k, 0, 5}, v_mps);
      scene.see(1, 2, {0.2 * k, 1.5, 5}, v_mps);
      scene.scan();
    }
    EXPECT_EQ(scene.fusion.num_joined(), 0U) << seed;
    EXPECT_EQ(scene.fusion.reported().size(), 2U) << seed;
  }
}

TEST(TrackFusion, NeitherJoinsNorDuplicatesWhenAmbiguous) {
  FusionScene scene;
  scene.noisy = false;
  for (int k = 0; k < 30; ++k) {  // the one that the first sees may be either of those of the second
    scene.see(0, 1, {0, 0, 5});
    scene.see(1, 1, {0, 0.2, 5});
    scene.see(1, 2, {0, -0.2, 5});
    const auto reported = scene.scan();
    ASSERT_EQ(reported.size(), 2U) << k;  // at least two, as the second observer reports
    for (const FusedTrack& track : reported) EXPECT_EQ(scene.last[track.members.front()].observer, 1);
  }
  EXPECT_EQ(scene.fusion.num_joined(), 0U);
}

TEST(TrackFusion, IgnoresPoorlyKnownPositions) {
  FusionScene scene;
  for (int k = 0; k < 100; ++k) {
    scene.see(0, 1, {0, 0, 5}, Vector3::Zero(), 0.95, 1.5);
    scene.see(1, 1, {0, 0, 5}, Vector3::Zero(), 0.95, 0.1);
    scene.scan();
  }
  EXPECT_EQ(scene.fusion.num_joined(), 0U);
}

TEST(TrackFusion, SplitsTracksThatDiverge) {
  FusionScene scene;
  for (int k = 0; k < 60; ++k) {
    const double apart_m = k < 20 ? 0.0 : 0.2 * (k - 20);
    scene.see(0, 1, {0, 0, 5});
    scene.see(1, 1, {apart_m, 0, 5}, {k < 20 ? 0.0 : 2.0, 0, 0});
    scene.scan();
  }
  EXPECT_EQ(scene.fusion.num_joined(), 1U);
  EXPECT_EQ(scene.fusion.num_broken(), 1U);
  EXPECT_EQ(scene.fusion.reported().size(), 2U);
  EXPECT_EQ(scene.fusion.reported()[0].id, 1U);  // the own one goes on
}

TEST(TrackFusion, KeepsIdentityWhenAnObserverReacquires) {
  FusionScene scene;
  for (int k = 0; k < 120; ++k) {
    const Vector3 p_m(0.1 * k, 0, 5), v_mps(1, 0, 0);
    if (k < 40) scene.see(0, 1, p_m, v_mps);
    if (k >= 80) scene.see(0, 2, p_m, v_mps);  // another identity
    scene.see(1, 5, p_m, v_mps);
    const auto reported = scene.scan();
    ASSERT_EQ(reported.size(), 1U) << k;
    EXPECT_EQ(reported[0].id, 1U) << k;
  }
}

TEST(TrackFusion, DropsTargetsWithoutReports) {
  FusionScene scene;
  scene.see(1, 5, {0, 0, 5});
  EXPECT_EQ(scene.scan().size(), 1U);
  EXPECT_EQ(scene.scan().size(), 0U);
  scene.see(1, 5, {0, 0, 5});
  ASSERT_EQ(scene.scan().size(), 1U);
  EXPECT_EQ(scene.fusion.reported()[0].id, 1U);  // remembered
}

TEST(TrackFusion, ReportsWeakTracksThatAgree) {
  FusionScene scene;
  std::size_t reported = 0;
  for (int k = 0; k < 20; ++k) {
    scene.see(0, 1, {0, 0, 5}, Vector3::Zero(), 0.2);
    scene.see(1, 1, {0, 0, 5}, Vector3::Zero(), 0.2);
    reported = scene.scan().size();
  }
  ASSERT_EQ(reported, 1U);
  EXPECT_NEAR(scene.fusion.reported()[0].existence, 0.714, 0.01);  // odds of a quarter, nearly tenfold
}

TEST(TrackFusion, ThreeObserversSeeOneTarget) {
  FusionScene scene;
  for (int k = 0; k < 40; ++k) {
    for (VehicleId observer = 0; observer < 3; ++observer) scene.see(observer, 1, {0, 0.1 * k, 5}, {0, 1, 0});
    ASSERT_EQ(scene.scan().size(), 1U) << k;
  }
  EXPECT_EQ(scene.fusion.reported()[0].members.size(), 3U);
}

/// With any common errors, the fused error does not exceed its covariance: six degrees of freedom.
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
