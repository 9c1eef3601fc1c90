// SPDX-License-Identifier: BSD-3-Clause
// Present pose of another vehicle: late data, missing data, and consistency of the covariance.
#include "core/localization/relative_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/localization/relative_support.hpp"

namespace swiftlet {
namespace {

/// A path driven by white acceleration, as the filter assumes.
Path random_flight(double acceleration_mps2_psqrthz, std::uint64_t seed) {
  constexpr double kStep_s = 0.01;
  const Random random(seed, "test.path", "other");
  auto places = std::make_shared<std::vector<Vector3>>();
  Vector3 p(5.0, 1.0, 0.5), v(0.4, 0.1, 0.0);
  for (int k = 0; k < 6000; ++k) {
    places->push_back(p);
    const Vector3 a(random.normal(k, 0), random.normal(k, 1), random.normal(k, 2));
    p += kStep_s * v;
    v += acceleration_mps2_psqrthz * std::sqrt(kStep_s) * a;
  }
  return [places](double t) {
    const double k = std::clamp((t + 1.0) / kStep_s, 0.0, 5998.0);
    const auto i = static_cast<std::size_t>(k);
    return Vector3((*places)[i] + (k - static_cast<double>(i)) * ((*places)[i + 1] - (*places)[i]));
  };
}

struct Measurement {
  double at_s;  // when it comes
  bool is_odometry;
  double t_s;
};

struct FilterTrial {
  RelativeFilterConfig config;
  OdometryDriftConfig drift;
  double start_s = 1.0;
  double end_s = 21.0;
  double sightings_end_s = 1e9, odometry_end_s = 1e9;
  double sighting_latency_s = 0.15, odometry_latency_s = 0.1;
  double true_drift_factor = 1.0;  // relative to the assumed drift

  OdometryDriftConfig true_drift() const {
    OdometryDriftConfig d = drift;
    for (double* rate : {&d.position_m_psqrtm, &d.position_m_psqrtturn, &d.position_m_psqrts, &d.yaw_deg_psqrtm,
                         &d.yaw_deg_psqrtturn, &d.yaw_deg_psqrts}) {
      *rate *= true_drift_factor;
    }
    return d;
  }
  std::vector<Measurement> measurements() const {
    std::vector<Measurement> all;
    for (int k = 0; start_s + 0.1 * k + 0.05 < end_s; ++k) {
      const double t_s = start_s + 0.1 * k + 0.05;
      if (t_s < sightings_end_s) all.push_back({t_s + sighting_latency_s, false, t_s});
    }
    for (int k = 1; start_s + 0.5 * k < end_s; ++k) {
      const double t_s = start_s + 0.5 * k;
      if (t_s < odometry_end_s) all.push_back({t_s + odometry_latency_s, true, t_s});
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Measurement& a, const Measurement& b) { return a.at_s < b.at_s; });
    return all;
  }
};

class FilterRun {
 public:
  FilterRun(const FilterTrial& trial, const Path& path, std::uint64_t seed)
      : trial_(trial),
        flight_(path, trial.end_s + 2.0, trial.true_drift(), seed),
        random_(seed, "test.filter", "noise"),
        filter_(trial.config, trial.drift) {
    // Started by an alignment with an error drawn from its covariance.
    FrameAlignment start;
    start.covariance.setZero();
    start.covariance.diagonal() << 0.0025, 0.0025, 0.0025, 0.0009;
    const OtherMotion anchor = odometry(trial.start_s);
    const OtherFlight::Sample& truth = flight_.at(trial.start_s);
    start.anchor_other_m = anchor.p_other_local_m;
    start.anchor_local_m =
        truth.p_local_m + 0.05 * Vector3(random_.normal(0, 30), random_.normal(0, 31), random_.normal(0, 32));
    start.yaw_rad = truth.yaw_local_other_rad + 0.03 * random_.normal(0, 33);
    filter_.start(start, anchor);
  }

  void take(const std::vector<Measurement>& measurements) {
    for (const Measurement& m : measurements) {
      if (m.at_s > trial_.end_s) continue;
      m.is_odometry ? filter_.push(odometry(m.t_s)) : filter_.push(sighting(m.t_s));
    }
  }

  OtherMotion odometry(double t_s) const {
    OtherMotion motion = flight_.at(t_s).motion;
    const auto k = static_cast<std::uint32_t>(std::lround(t_s * 1000));
    motion.p_other_local_m +=
        trial_.config.odometry_sigma_m * Vector3(random_.normal(k, 1), random_.normal(k, 2), random_.normal(k, 3));
    motion.v_other_local_mps += trial_.config.odometry_velocity_sigma_mps *
                                Vector3(random_.normal(k, 4), random_.normal(k, 5), random_.normal(k, 6));
    motion.yaw_rad += trial_.config.odometry_yaw_sigma_deg * kRadPerDeg * random_.normal(k, 7);
    return motion;
  }
  Sighting sighting(double t_s) const {
    const Matrix3 C = sighting_covariance();
    return {from_seconds(t_s), sighting_of(flight_, t_s, C, random_), C};
  }

  Vector3 error_m(double t_s) const { return filter_.at(from_seconds(t_s)).position_m - flight_.at(t_s).p_local_m; }
  double nees(double t_s) const {
    const Matrix3 C = filter_.at(from_seconds(t_s)).covariance.topLeftCorner<3, 3>();
    return error_m(t_s).dot(C.ldlt().solve(error_m(t_s)));
  }
  double yaw_nees(double t_s) const {
    const RelativeEstimate e = filter_.at(from_seconds(t_s));
    const double error = std::remainder(e.yaw_rad - OtherFlight::kHeading_rad, 2 * kPi);
    return error * error / e.covariance(6, 6);
  }
  double velocity_nees(double t_s) const {
    const RelativeEstimate e = filter_.at(from_seconds(t_s));
    const Vector3 error = e.velocity_mps - flight_.at(t_s).v_local_mps;
    const Matrix3 C = e.covariance.block<3, 3>(3, 3);
    return error.dot(C.ldlt().solve(error));
  }
  RelativeFilter& filter() { return filter_; }

 private:
  FilterTrial trial_;
  OtherFlight flight_;
  Random random_;
  RelativeFilter filter_;
};

struct MeanNees {
  double position = 0.0, velocity = 0.0, yaw = 0.0, sigma_m = 0.0, error_m = 0.0, factor = 0.0;
};

MeanNees mean_nees(FilterTrial trial, int num, double at_s) {
  trial.config.bias_sigma_m = 0.0;
  trial.config.gate_sigma = 6.0;
  trial.config.yaw_rate_sigma_degps = 0.0;
  MeanNees mean;
  for (int seed = 1; seed <= num; ++seed) {
    FilterRun run(trial, random_flight(trial.config.acceleration_mps2_psqrthz, seed), seed);
    run.take(trial.measurements());
    mean.position += run.nees(at_s) / num;
    mean.velocity += run.velocity_nees(at_s) / num;
    mean.yaw += run.yaw_nees(at_s) / num;
    mean.sigma_m += std::sqrt(run.filter().at(from_seconds(at_s)).covariance.topLeftCorner<3, 3>().trace()) / num;
    mean.error_m += run.error_m(at_s).norm() / num;
    mean.factor += std::sqrt(run.filter().drift_variance_factor()) / num;
  }
  return mean;
}

// Bound for k degrees of freedom and n runs, exceeded in one of 1000 cases.
double mean_bound(int degrees, int num) { return 3.3 * std::sqrt(2.0 * degrees / num); }

TEST(RelativeFilter, IsConsistentUnderDelaysAndDrift) {
  const MeanNees mean = mean_nees({}, 300, 21.0);
  EXPECT_NEAR(mean.position, 3.0, mean_bound(3, 300));
  EXPECT_NEAR(mean.velocity, 3.0, mean_bound(3, 300));
  EXPECT_NEAR(mean.yaw, 1.0, mean_bound(1, 300));
}

// An odometry with three or six times the assumed drift, and no other data for six seconds.
TEST(RelativeFilter, EstimatesExcessOdometryDrift) {
  constexpr int kRuns = 100;
  for (const double factor : {3.0, 6.0}) {
    FilterTrial trial;
    trial.true_drift_factor = factor;
    trial.sightings_end_s = 15.0;
    const MeanNees mean = mean_nees(trial, kRuns, 21.0);
    EXPECT_LT(mean.position, 3.0 + mean_bound(3, kRuns)) << factor;
    EXPECT_GT(mean.factor, 0.7 * factor);
    EXPECT_LT(mean.factor, 1.4 * factor);
    trial.config.drift_factor_max = 1.0;
    const MeanNees trusting = mean_nees(trial, kRuns, 21.0);
    EXPECT_GT(trusting.position, 2.0 * mean.position) << "without that, it is surer than it may be";
    EXPECT_GT(trusting.error_m, 1.1 * mean.error_m) << "the error grows without an estimated drift factor";
  }
  EXPECT_LT(mean_nees({}, kRuns, 21.0).factor, 1.3) << "one that drifts as it is said to is believed";
}

TEST(RelativeFilter, KeepsLearnedDriftAfterALoss) {
  FilterTrial trial;
  trial.true_drift_factor = 6.0;
  FilterRun run(trial, random_flight(0.5, 3), 3);
  run.take(trial.measurements());
  const double learned = run.filter().drift_variance_factor();
  EXPECT_GT(learned, 4.0);
  run.filter().stop();
  EXPECT_EQ(run.filter().drift_variance_factor(), learned);
  run.filter().start({}, run.odometry(21.0));
  EXPECT_EQ(run.filter().drift_variance_factor(), learned);
}

TEST(RelativeFilter, IsConsistentWhileCoastingOnOdometry) {
  FilterTrial trial;
  trial.sightings_end_s = 6.0;
  trial.drift.position_m_psqrtm = 0.1;
  trial.drift.yaw_deg_psqrtm = 0.3;
  const MeanNees mean = mean_nees(trial, 300, 21.0);
  EXPECT_NEAR(mean.position, 3.0, mean_bound(3, 300));
  trial.sightings_end_s = 1e9;
  EXPECT_GT(mean.sigma_m, 1.5 * mean_nees(trial, 20, 21.0).sigma_m) << "not being seen makes it less sure";
}

TEST(RelativeFilter, IsConsistentWithoutAnyMeasurements) {
  FilterTrial trial;
  trial.sightings_end_s = trial.odometry_end_s = 18.0;
  const MeanNees mean = mean_nees(trial, 300, 21.0);
  EXPECT_NEAR(mean.position, 3.0, mean_bound(3, 300));
  EXPECT_NEAR(mean.velocity, 3.0, mean_bound(3, 300));
}

TEST(RelativeFilter, SightingsAloneKeepThePlace) {
  FilterTrial trial;
  trial.odometry_end_s = 6.0;
  const MeanNees mean = mean_nees(trial, 300, 21.0);
  EXPECT_NEAR(mean.position, 3.0, mean_bound(3, 300));
  EXPECT_LT(mean.sigma_m, 0.5);
}

TEST(RelativeFilter, IsIndependentOfArrivalOrder) {
  FilterTrial trial;
  trial.config.gate_sigma = 100.0;
  const Path path = random_flight(0.5, 3);
  FilterRun in_order(trial, path, 3), late(trial, path, 3);
  std::vector<Measurement> measurements = trial.measurements();
  std::stable_sort(measurements.begin(), measurements.end(),
                   [](const Measurement& a, const Measurement& b) { return a.t_s < b.t_s; });
  in_order.take(measurements);
  // Every sighting up to 1.5 s late.
  const Random random(7, "test.jitter", "late");
  std::stable_sort(measurements.begin(), measurements.end(), [&](const Measurement& a, const Measurement& b) {
    const auto when = [&](const Measurement& m) {
      return m.is_odometry ? m.t_s
                           : m.t_s + random.uniform(0.0, 1.5, static_cast<std::uint32_t>(std::lround(m.t_s * 100)), 0);
    };
    return when(a) < when(b);
  });
  late.take(measurements);
  const RelativeEstimate a = in_order.filter().at(from_seconds(21.0)), b = late.filter().at(from_seconds(21.0));
  EXPECT_LT((a.position_m - b.position_m).norm(), 1e-9);
  EXPECT_LT((a.velocity_mps - b.velocity_mps).norm(), 1e-9);
  EXPECT_LT((a.covariance - b.covariance).norm(), 1e-9);
}

TEST(RelativeFilter, RefusesMeasurementsOlderThanItsHistory) {
  const FilterTrial trial;
  FilterRun run(trial, random_flight(0.5, 3), 3);
  run.take(trial.measurements());
  EXPECT_FALSE(run.filter().push(run.sighting(15.05)));
  EXPECT_FALSE(run.filter().push(run.odometry(15.5)));
}

TEST(RelativeFilter, RejectsFalseSightings) {
  const FilterTrial trial;
  FilterRun run(trial, random_flight(0.5, 3), 3);
  run.take(trial.measurements());
  const RelativeEstimate before = run.filter().at(from_seconds(21.0));
  Sighting other = run.sighting(20.95);
  other.p_local_m += Vector3(2.0, 0.0, 0.0);
  EXPECT_GT(run.filter().squared_sigmas(other), 16.0);
  EXPECT_FALSE(run.filter().push(other));
  EXPECT_EQ(run.filter().at(from_seconds(21.0)).position_m, before.position_m);
}

TEST(RelativeFilter, AnswersWithinItsPastHistory) {
  const FilterTrial trial;
  FilterRun run(trial, random_flight(0.5, 3), 3);
  run.take(trial.measurements());
  EXPECT_LT(run.error_m(19.0).norm(), 0.3);
}

TEST(RelativeFilter, KeepsCommonSightingBiasInCovariance) {
  FilterTrial trial;
  trial.config.bias_sigma_m = 0.1;
  FilterRun run(trial, random_flight(0.5, 3), 3);
  run.take(trial.measurements());
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GT(run.filter().at(from_seconds(21.0)).covariance(axis, axis), 0.01);
  }
}

TEST(RelativeFilter, AcceptsSightingsFromItsStartOnward) {
  RelativeFilter filter({}, no_drift());
  OtherMotion anchor;
  anchor.t = anchor.stamp = kNsPerSecond;
  FrameAlignment start;
  start.covariance = FrameAlignment::Covariance(0.01 * FrameAlignment::Covariance::Identity());
  filter.start(start, anchor);
  Sighting sighting;
  sighting.covariance = 0.01 * Matrix3::Identity();
  sighting.t = anchor.t;
  EXPECT_TRUE(filter.push(sighting));
  sighting.t = anchor.t - 1;
  EXPECT_FALSE(filter.push(sighting));
}

TEST(RelativeFilter, GrowsHeadingUncertaintyByTurnRate) {
  const auto variance = [](double yaw_rate_sigma_degps, double since_s) {
    FilterTrial trial;
    trial.config.yaw_rate_sigma_degps = yaw_rate_sigma_degps;
    FilterRun run(trial, random_flight(0.5, 3), 3);
    run.take(trial.measurements());
    const RelativeEstimate last = run.filter().at(from_seconds(trial.end_s));
    return run.filter().at(last.report_t + from_seconds(since_s)).covariance(6, 6);
  };
  for (const double since_s : {0.5, 2.0}) {
    const double turned_rad = 3.0 * kRadPerDeg * since_s;
    EXPECT_NEAR(variance(3.0, since_s) - variance(0.0, since_s), turned_rad * turned_rad, 1e-12);
  }
}

// The difference of two filters with different acceleration of the other vehicle is white noise, integrated once and
// twice.
TEST(RelativeFilter, GrowsUncertaintyByIntegratedAcceleration) {
  const auto covariance = [](double acceleration_mps2_psqrthz, double since_s) {
    RelativeFilterConfig config;
    config.acceleration_mps2_psqrthz = acceleration_mps2_psqrthz;
    RelativeFilter filter(config, no_drift());
    OtherMotion anchor;
    anchor.t = anchor.stamp = kNsPerSecond;
    FrameAlignment start;
    start.covariance = FrameAlignment::Covariance(0.01 * FrameAlignment::Covariance::Identity());
    filter.start(start, anchor);
    return filter.at(anchor.t + from_seconds(since_s)).covariance;
  };
  for (const double t_s : {0.5, 2.0}) {
    const double q = 0.7 * 0.7;
    const auto added = (covariance(0.7, t_s) - covariance(0.0, t_s)).eval();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(added(axis, axis), q * t_s * t_s * t_s / 3.0, 1e-12);
      EXPECT_NEAR(added(axis, 3 + axis), q * t_s * t_s / 2.0, 1e-12);
      EXPECT_NEAR(added(3 + axis, axis), q * t_s * t_s / 2.0, 1e-12);
      EXPECT_NEAR(added(3 + axis, 3 + axis), q * t_s, 1e-12);
    }
  }
}

}  // namespace
}  // namespace swiftlet
