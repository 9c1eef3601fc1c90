// SPDX-License-Identifier: BSD-3-Clause
// The tracker with any of its options, against the same written out plainly: every pair of points, every pairing.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "swiftlet/core/tracking/cloud_tracker.hpp"
#include "tests/support/config_checks.hpp"
#include "tests/support/target_clouds.hpp"

namespace swiftlet {
namespace {

using testing::CloudMaker;
using testing::detection_at;
using testing::ListedBackground;

constexpr TimeNs kSweep = 100'000'000;
using Config = CloudTrackerConfig;

class PlainTracker {
 public:
  PlainTracker(const Config& config, std::unique_ptr<MotionFilter> filter)
      : config_(config), filter_(std::move(filter)) {}

  struct Target {
    std::uint32_t id = 0;
    TimeNs t = 0;
    MotionState state;
    int num_detections = 1;
    bool corrected = true;
    Vector3 measured_m = Vector3::Zero();
    Matrix3 measured_covariance = Matrix3::Identity();
    double reflectivity = 0.0;

    Matrix3 P() const { return state.belief.position_covariance(); }
    Vector3 at(TimeNs time) const { return state.belief.position() + to_seconds(time - t) * state.belief.velocity(); }
  };

  void new_cloud(const LocalCloud& cloud, const BackgroundQuery& background) {
    if (!clouds_.empty() && cloud.stamp() <= clouds_.back().stamp()) return;
    clouds_.push_back(cloud);
    if (clouds_.size() > static_cast<std::size_t>(config_.buffer_size)) clouds_.erase(clouds_.begin());
    std::vector<Target*> all;
    for (Target& target : targets) all.push_back(&target);
    update(all, cloud, background);
    for (std::size_t i = 0; i < targets.size(); ++i) {
      for (std::size_t j = i + 1; j < targets.size();) {
        const double most_m = config_.merge_radius_max_m;
        const double distance_m = (targets[i].at(targets[j].t) - targets[j].state.belief.position()).norm();
        if (distance_m >= std::min(radius_m(targets[i]), most_m) + std::min(radius_m(targets[j]), most_m)) {
          ++j;
          continue;
        }
        const int most = std::max(targets[i].num_detections, targets[j].num_detections);
        if (radius_m(targets[j]) < radius_m(targets[i])) std::swap(targets[i], targets[j]);
        targets[i].num_detections = most;
        targets.erase(targets.begin() + static_cast<std::ptrdiff_t>(j));
      }
    }
    std::erase_if(targets, [&](const Target& target) { return radius_m(target) > config_.radius_max_m; });
  }

  void new_detections(const std::vector<Detection>& detections, const BackgroundQuery& background) {
    for (const Detection& detection : detections) {
      Target target;
      target.t = detection.t;
      target.measured_m = detection.position_m;
      target.measured_covariance = covariance(detection.position_m, config_.measurement.sigma_initial_m);
      if (clouds_.empty())
        target.measured_covariance = std::pow(config_.measurement.sigma_initial_m, 2) * Matrix3::Identity();
      target.reflectivity = detection.reflectivity;
      target.state = filter_->start(detection.position_m, target.measured_covariance);
      bool lost = false;
      for (const LocalCloud& cloud : clouds_) {
        if (cloud.stamp() <= detection.t || lost) continue;
        update({&target}, cloud, background);
        lost = radius_m(target) > config_.radius_max_m;
      }
      if (lost) continue;
      Target* nearest = nullptr;
      const auto distance_m = [&](const Target& other) {
        return (other.at(target.t) - target.state.belief.position()).norm();
      };
      const auto reach_m = [&](const Target& of) { return std::max(config_.association_radius_min_m, radius_m(of)); };
      for (Target& other : targets) {
        if (distance_m(other) > reach_m(other) + reach_m(target)) continue;
        if (nearest == nullptr || distance_m(other) < distance_m(*nearest)) nearest = &other;
      }
      if (nearest != nullptr) {
        ++nearest->num_detections;
        continue;
      }
      target.id = next_id_++;
      targets.push_back(target);
    }
  }

  std::vector<Target> targets;

 private:
  struct Cluster {
    std::vector<Vector3> points_m;
    Vector3 position_m;
    Matrix3 Z;
    TimeNs t;
    double reflectivity;
  };

  double radius_m(const Target& target) const {
    const double cubic = std::cbrt(target.P().determinant());
    return config_.radius_scale * (config_.radius_law == Config::RadiusLaw::kPrinted ? cubic : std::sqrt(cubic));
  }
  double search_m(const Target& target) const { return std::max(config_.search_radius_min_m, radius_m(target)); }

  /// Of a place as the sensor in the origin measures it.
  Matrix3 covariance(const Vector3& p_m, double constant_m) const {
    if (config_.measurement.noise == TrackMeasurementConfig::Noise::kConstant)
      return constant_m * constant_m * Matrix3::Identity();
    return std::pow(config_.measurement.sigma_sampling_m, 2) * Matrix3::Identity() +
           point_covariance(p_m.normalized(), p_m.norm(), Matrix3::Identity(), config_.measurement.sensor.Sigma_w());
  }

  std::vector<Cluster> clusters(const std::vector<Target>& predicted, const LocalCloud& cloud,
                                const BackgroundQuery& background) const {
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Vector3 p_m = cloud.points_local_m[i].cast<double>();
      if (std::any_of(predicted.begin(), predicted.end(), [&](const Target& target) {
            return (p_m - target.state.belief.position()).norm() <= search_m(target);
          })) {
        near.push_back(i);
      }
    }
    std::vector<Cluster> found;
    std::vector<char> done(cloud.size(), 0);
    for (const std::size_t seed : near) {
      if (done[seed]) continue;
      std::vector<std::size_t> own = {seed};
      done[seed] = 1;
      for (std::size_t k = 0; k < own.size(); ++k) {
        for (const std::size_t i : near) {
          const float distance_m = (cloud.points_local_m[i] - cloud.points_local_m[own[k]]).norm();
          if (done[i] || distance_m > static_cast<float>(config_.cluster_distance_m)) continue;
          done[i] = 1;
          own.push_back(i);
        }
      }
      Cluster cluster{};
      Vector3 mean_m = Vector3::Zero(), low_m = Vector3::Constant(1e9), high_m = -low_m;
      std::int64_t sum = 0;
      for (const std::size_t i : own) {
        cluster.points_m.push_back(cloud.points_local_m[i].cast<double>());
        mean_m += cluster.points_m.back() / static_cast<double>(own.size());
        low_m = low_m.cwiseMin(cluster.points_m.back());
        high_m = high_m.cwiseMax(cluster.points_m.back());
        sum += cloud.time_of(i) - cloud.stamp();
        cluster.reflectivity = std::max(cluster.reflectivity, static_cast<double>(cloud.reflectivity_of(i)));
      }
      const double size_m = (high_m - low_m).norm();
      cluster.position_m = config_.position == Config::Position::kCentroid ? mean_m : Vector3(0.5 * (low_m + high_m));
      cluster.t = cloud.stamp() + sum / static_cast<std::int64_t>(own.size());
      cluster.Z = covariance(cluster.position_m, config_.measurement.sigma_m);
      if (config_.max_size_m > 0.0 && size_m > config_.max_size_m) continue;
      if (config_.background == Config::Background::kMap &&
          background.occupied_within(cluster.position_m, config_.background_distance_m))
        continue;
      if (config_.background == Config::Background::kCloud) {
        std::size_t around = 0;
        for (const Eigen::Vector3f& p : cloud.points_local_m)
          around += (p.cast<double>() - cluster.position_m).norm() <= 0.5 * size_m + config_.background_distance_m;
        if (around > own.size()) continue;
      }
      found.push_back(cluster);
    }
    return found;
  }

  void update(const std::vector<Target*>& of, const LocalCloud& cloud, const BackgroundQuery& background) {
    const TimeNs middle = cloud.stamp() + cloud.scan->duration / 2;
    std::vector<Target> predicted;
    for (const Target* target : of) {
      predicted.push_back(*target);
      predicted.back().t = std::max(target->t, middle);
      filter_->predict(predicted.back().state, to_seconds(predicted.back().t - target->t));
    }
    const std::vector<Cluster> found = clusters(predicted, cloud, background);
    const std::vector<int> chosen = choose(predicted, found);
    for (std::size_t i = 0; i < of.size(); ++i) {
      Target& target = *of[i];
      target.corrected = chosen[i] >= 0;
      if (!target.corrected) {
        target.state = predicted[i].state;
        target.t = predicted[i].t;
        continue;
      }
      const Cluster& cluster = found[static_cast<std::size_t>(chosen[i])];
      const TimeNs t = std::max(target.t, cluster.t);
      filter_->predict(target.state, to_seconds(t - target.t));
      target.t = t;
      filter_->correct(target.state, cluster.position_m, cluster.Z);
      target.measured_m = cluster.position_m;
      target.measured_covariance = cluster.Z;
      target.reflectivity = cluster.reflectivity;
    }
  }

  std::vector<int> choose(const std::vector<Target>& predicted, const std::vector<Cluster>& found) const {
    const bool exclusive = config_.assignment == Config::Assignment::kExclusive;
    std::vector<std::vector<double>> costs;
    for (const Target& target : predicted) {
      costs.emplace_back();
      for (const Cluster& cluster : found) {
        const Vector3 d_m = cluster.position_m - target.at(cluster.t);
        const Matrix3 S = target.P() + cluster.Z;
        const bool reached = std::any_of(cluster.points_m.begin(), cluster.points_m.end(), [&](const Vector3& p_m) {
          return (p_m - target.state.belief.position()).norm() <= search_m(target);
        });
        costs.back().push_back(!reached    ? INFINITY
                               : exclusive ? d_m.dot(S.inverse() * d_m) + std::log(S.determinant())
                                           : d_m.norm());
      }
    }
    std::vector<int> best(predicted.size(), -1), now = best;
    if (!exclusive) {
      for (std::size_t i = 0; i < costs.size(); ++i) {
        for (std::size_t c = 0; c < found.size(); ++c) {
          if (std::isfinite(costs[i][c]) && (best[i] < 0 || costs[i][c] < costs[i][static_cast<std::size_t>(best[i])]))
            best[i] = static_cast<int>(c);
        }
      }
      return best;
    }
    int most = 0;
    double least = INFINITY;
    pair(0, costs, now, 0, 0.0, best, most, least);
    return best;
  }

  /// As many pairs as possible, and of these pairings the cheapest.
  static void pair(std::size_t i, const std::vector<std::vector<double>>& costs, std::vector<int>& now, int pairs,
                   double sum, std::vector<int>& best, int& most, double& least) {
    if (i == costs.size()) {
      if (pairs < most || (pairs == most && sum >= least)) return;
      most = pairs, least = sum, best = now;
      return;
    }
    pair(i + 1, costs, now, pairs, sum, best, most, least);
    for (std::size_t c = 0; c < costs[i].size(); ++c) {
      if (!std::isfinite(costs[i][c]) || std::find(now.begin(), now.end(), static_cast<int>(c)) != now.end()) continue;
      now[i] = static_cast<int>(c);
      pair(i + 1, costs, now, pairs + 1, sum + costs[i][c], best, most, least);
      now[i] = -1;
    }
  }

  Config config_;
  std::unique_ptr<MotionFilter> filter_;
  std::vector<LocalCloud> clouds_;
  std::uint32_t next_id_ = 1;
};

class TrackerOptions : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Variants, TrackerOptions, ::testing::Range(0, 12));

TEST_P(TrackerOptions, TracksAreThoseOfThePlainTracker) {
  const int variant = GetParam();
  const Random random(static_cast<std::uint64_t>(variant), "test.options");
  Config config;
  config.buffer_size = 3 + variant;
  config.radius_law = variant % 2 == 0 ? Config::RadiusLaw::kPrinted : Config::RadiusLaw::kSphere;
  config.search_radius_min_m = variant % 3 == 0 ? 1.0 : 2.0;
  config.radius_max_m = variant % 2 == 0 ? 0.8 : 1.6;
  config.background = static_cast<Config::Background>(variant % 3);
  config.background_distance_m = 0.5;
  config.max_size_m = variant % 4 == 3 ? 0.0 : 1.5;
  config.position = variant % 2 == 0 ? Config::Position::kBoxCenter : Config::Position::kCentroid;
  config.assignment = variant % 3 == 1 ? Config::Assignment::kNearest : Config::Assignment::kExclusive;
  config.association_radius_min_m = 0.3 + 0.1 * (variant % 4);
  config.merge_radius_max_m = variant % 5 == 0 ? 0.0 : 0.4;
  config.min_detections = 1 + variant % 3;
  config.measurement.noise =
      variant % 4 < 2 ? TrackMeasurementConfig::Noise::kSigmaW : TrackMeasurementConfig::Noise::kConstant;
  config.measurement.sigma_m = 0.25;
  config.measurement.sensor.sigma_attitude_rad.setConstant(0.02);
  const auto filter = [&] { return variant % 2 == 0 ? make_imm_filter({}) : make_kalman_filter({}); };
  CloudTracker tracker(config, filter());
  PlainTracker plain(config, filter());
  ListedBackground background;
  background.centers_m = {{9, 1, 4}, {12, -3, 5}};

  const auto place = [&](int i, double t) {
    const Vector3 start(6.0 + 2.0 * i, 1.5 * i - 3.0, 4.0 + 0.3 * i);
    return Vector3(start + Vector3(0.8 * std::sin(0.9 * t + i), 1.2 * std::cos(0.7 * t + 2 * i), 0.2 * t));
  };
  int told = 0, corrected = 0;
  for (int k = 1; k <= 60; ++k) {
    const TimeNs t = k * kSweep;
    CloudMaker maker(t, variant % 2 == 0 ? kSweep : 0);
    for (int i = 0; i < 4; ++i) {
      if ((k + 7 * i) % 25 < 8) continue;  // hidden now and then
      const double offset_s = 0.02 * i;
      for (std::uint32_t j = 0; j < 9; ++j) {
        const auto n = random.normal3(k, 100 * i + j);
        maker.add(place(i, to_seconds(t) + offset_s) + (i == 3 && k > 40 ? 0.6 : 0.12) * Vector3(n[0], n[1], n[2]),
                  offset_s + 1e-3 * j, random.uniform(k, 1000 + 100 * i + j));
      }
    }
    for (std::uint32_t j = 0; j < 15; ++j) {
      const auto n = random.normal3(k, 5000 + j);
      maker.add({9.0 + 4.0 * n[0], 4.0 * n[1], 5.0 + 2.0 * n[2]}, 0.01 * j);
    }
    const LocalCloud cloud = maker.make();
    tracker.new_cloud(cloud, &background);
    plain.new_cloud(cloud, background);
    std::vector<Detection> detections;
    for (int i = 0; i < 4; ++i) {
      if ((k + 2 * i) % 5 != 0) continue;
      const TimeNs seen = t - kSweep * ((k + i) % 6) - 20'000'000;
      detections.push_back(detection_at(place(i, to_seconds(seen)) + Vector3(0.1, -0.1, 0.05), seen));
      detections.back().reflectivity = 0.5 * i;
    }
    tracker.new_detections(detections, &background);
    plain.new_detections(detections, background);

    std::vector<Track> tracks;
    tracker.publish(tracks);
    EXPECT_EQ(tracker.num_tracks(), static_cast<int>(plain.targets.size())) << k;
    std::vector<PlainTracker::Target> expected;
    for (const auto& target : plain.targets) {
      if (target.num_detections >= config.min_detections) expected.push_back(target);
    }
    std::sort(expected.begin(), expected.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    ASSERT_EQ(tracks.size(), expected.size()) << k;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      ASSERT_EQ(tracks[i].id, expected[i].id) << k;
      ASSERT_EQ(tracks[i].t, expected[i].t) << k;
      ASSERT_EQ(tracks[i].corrected, expected[i].corrected) << k;
      ASSERT_EQ(tracks[i].num_detections, expected[i].num_detections) << k;
      ASSERT_LT((tracks[i].position_m - expected[i].state.belief.position()).norm(), 1e-5) << k;
      ASSERT_LT((tracks[i].velocity_mps - expected[i].state.belief.velocity()).norm(), 1e-4) << k;
      ASSERT_LT((tracks[i].acceleration_mps2 - expected[i].state.belief.mean.tail<3>()).norm(), 1e-3) << k;
      ASSERT_LT((tracks[i].covariance - expected[i].state.belief.covariance).norm(), 1e-4) << k;
      ASSERT_LT((tracks[i].measured_m - expected[i].measured_m).norm(), 1e-5) << k;
      ASSERT_LT((tracks[i].measured_covariance - expected[i].measured_covariance).norm(), 1e-5) << k;
      ASSERT_NEAR(tracks[i].reflectivity, expected[i].reflectivity, 1e-6) << k;
      corrected += tracks[i].corrected;
    }
    told += static_cast<int>(tracks.size());
  }
  EXPECT_GT(corrected, 20);
  EXPECT_GT(told, corrected);
}

TEST(CloudTrackerConfig, AnEquivalentSphereMayNotBeLostWhereItIsLookedFor) {
  Config config;
  EXPECT_TRUE(testing::ConfigChecks(config).refuses_nothing());
  config.search_radius_min_m = 6.0;
  EXPECT_TRUE(testing::ConfigChecks(config).refuses_nothing()) << "the printed radius is no length";
  config.radius_law = Config::RadiusLaw::kSphere;
  EXPECT_TRUE(testing::ConfigChecks(config).refuses("radius_max_m"));
  config.search_radius_min_m = config.radius_max_m;
  EXPECT_TRUE(testing::ConfigChecks(config).refuses_nothing());
}

}  // namespace
}  // namespace swiftlet
