// SPDX-License-Identifier: BSD-3-Clause
// Local SLAM by both matching methods on the scans of vehicles that fly on true poses: each method gets the same scans.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "slam_flights.hpp"
#include "slam_rounds.hpp"
#include "stopwatch.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/grid_matcher.hpp"
#include "swiftlet/core/slam/local_slam.hpp"
#include "swiftlet/sim/view/tick_view.hpp"

namespace swiftlet::tools {
namespace {

/// A matching method and its settings.
struct MatchingWay {
  const char* label;
  bool grid;
  GridMatchingConfig config = {};
};

/// The group's simulation and its field flights with an Ouster (larics/uav_ros_cartographer).
GridMatchingConfig groups_simulation() {
  GridMatchingConfig config;
  config.submaps.high_resolution_m = 0.05;
  config.submaps.high_range_max_m = 40.0;
  config.submaps.scans = 50;
  config.high.range_max_m = 50.0;
  config.low.range_max_m = 70.0;
  config.cost.translation_weight_1_m = 10.0;
  config.cost.rotation_weight = 600.0;
  return config;
}
GridMatchingConfig groups_field() {
  GridMatchingConfig config;
  config.submaps.high_resolution_m = 0.2;
  config.submaps.high_range_max_m = 40.0;
  config.cost.translation_weight_1_m = 4.0;
  config.cost.rotation_weight = 150.0;
  return config;
}

std::vector<MatchingWay> matching_ways(bool quick) {
  std::vector<MatchingWay> ways = {{"surfaces", false}, {"grid", true}};
  if (quick) return ways;
  ways.push_back({"grid as in the group's simulation", true, groups_simulation()});
  ways.push_back({"grid as in the group's field flights", true, groups_field()});
  return ways;
}

/// Result of one method on one flight.
struct Matched {
  double rms_m = 0.0, worst_m = 0.0, ate_m = 0.0, drift_50m_percent = 0.0;
  double nees = 0.0;  ///< mean normalized estimation error squared, 6 degrees of freedom
  double scan_ms = 0.0, map_mb = 0.0;
  double open_percent = 0.0, unused_percent = 0.0;  ///< shares of scans: degenerate, unused
};

class Beside {
 public:
  explicit Beside(const std::vector<MatchingWay>& ways) : matching_ways_(ways) {}

  void take(const sim::Simulation& simulation) {
    const sim::TickView& view = simulation.view();
    const Pose T_true = view.states[0].T_world_body();
    if (!begun_) begin(simulation, T_true);
    const Observation& observation = view.observations[0];
    for (One& one : ways_) {
      for (const ImuSample& sample : observation.imu) one.slam->add(sample);
      for (const auto& scan : observation.scans) {
        ScanOutcome outcome;
        one.watch.time([&] { outcome = one.slam->add(scan); });
        one.num_open += outcome.fit.num_degenerate > 0;
        one.num_unused += !outcome.used;
        ++one.num_scans;
      }
      if (!observation.scans.empty()) one.judge(view.t, T_true);
    }
  }

  std::vector<Matched> results() const {
    std::vector<Matched> all;
    for (const One& one : ways_) all.push_back(one.result());
    return all;
  }

 private:
  struct One {
    std::unique_ptr<LocalSlam> slam;
    Stopwatch watch;
    int num_scans = 0, num_open = 0, num_unused = 0;
    double sum_sq = 0.0, worst_m = 0.0, nees = 0.0;
    std::vector<Pose> T_true, T_local;

    void judge(TimeNs t, const Pose& T_world_body) {
      const NavState& nav = slam->filter().state().nav;
      const double ahead_s = to_seconds(t - nav.t);
      const Pose T = make_pose(nav.p_m + ahead_s * nav.v_mps, nav.q * rotation_by(ahead_s * nav.omega_body_radps));
      Eigen::Matrix<double, 6, 1> off;
      off << T.translation() - T_world_body.translation(),
          rotation_vector_rad(Eigen::Quaterniond(T_world_body.linear().transpose() * T.linear()));
      sum_sq += off.head<3>().squaredNorm();
      worst_m = std::max(worst_m, off.head<3>().norm());
      nees += off.dot(Eigen::LDLT<Matrix6>(slam->pose_covariance(slam->filter())).solve(off));
      T_true.push_back(T_world_body);
      T_local.push_back(T);
    }

    Matched result() const {
      Matched m;
      const auto num = static_cast<double>(T_true.size());
      m.rms_m = std::sqrt(sum_sq / num);
      m.worst_m = worst_m;
      m.nees = nees / num;
      Eigen::Matrix3Xd from(3, T_true.size()), to(3, T_true.size());
      for (Eigen::Index i = 0; i < from.cols(); ++i) {
        from.col(i) = T_local[i].translation();
        to.col(i) = T_true[i].translation();
      }
      const Eigen::Matrix4d best = Eigen::umeyama(from, to, false);
      m.ate_m = std::sqrt(
          ((best.topLeftCorner<3, 3>() * from).colwise() + best.topRightCorner<3, 1>() - to).squaredNorm() / num);
      m.drift_50m_percent = median_of(drifts_percent(T_true, T_local, 50.0));
      m.scan_ms = watch.median_ms();
      m.map_mb = 1e-6 * static_cast<double>(slam->matcher().bytes());
      m.open_percent = 100.0 * num_open / num_scans;
      m.unused_percent = 100.0 * num_unused / num_scans;
      return m;
    }
  };

  void begin(const sim::Simulation& simulation, const Pose& T_true) {
    begun_ = true;
    for (const MatchingWay& way : matching_ways_) {
      std::unique_ptr<ScanMatcher> matcher;
      if (way.grid) matcher = std::make_unique<GridMatcher>(way.config);
      ways_.emplace_back();
      ways_.back().slam = std::make_unique<LocalSlam>(
          LocalSlamConfig{}, T_true, simulation.info().airframes[0]->circumscribed_radius_m(), std::move(matcher));
    }
  }

  const std::vector<MatchingWay>& matching_ways_;
  bool begun_ = false;
  std::vector<One> ways_;
};

struct MatchingCase {
  const DriftWorld* world;
  const DriftLidar* lidar;
  bool agile;
};

}  // namespace

void slam_matching(Experiment& experiment) {
  const int seeds = experiment.repetitions(3, 1);
  std::vector<MatchingCase> cases;
  std::vector<sim::Scenario> scenarios;
  for (const DriftWorld& world : kDriftWorlds) {
    if (experiment.quick() && world.costly) continue;
    for (const DriftLidar& lidar : kDriftLidars) {
      for (const bool agile : {false, true}) {
        for (int seed = 1; seed <= seeds; ++seed) {
          cases.push_back({&world, &lidar, agile});
          scenarios.push_back(round_flight(world, lidar, agile, experiment.quick() ? 60.0 : 150.0,
                                           static_cast<std::uint64_t>(seed), "{type: ground_truth}"));
        }
      }
    }
  }
  const std::vector<MatchingWay> ways = matching_ways(experiment.quick());
  std::vector<std::unique_ptr<Beside>> beside(scenarios.size());
  std::vector<std::vector<Matched>> matched(scenarios.size());
  fly(experiment, scenarios, [&](std::size_t i, const sim::Simulation& simulation) {
    if (!beside[i]) beside[i] = std::make_unique<Beside>(ways);
    beside[i]->take(simulation);
    if (!simulation.finished()) return;
    matched[i] = beside[i]->results();
    beside[i].reset();
  });

  CsvTable csv({"world", "lidar", "agile", "way", "rms_m", "worst_m", "ate_m", "drift_50m_percent", "nees", "scan_ms",
                "map_mb", "open_percent", "unused_percent"});
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (std::size_t w = 0; w < matched[i].size(); ++w) {
      const Matched& m = matched[i][w];
      csv.row(cases[i].world->scenario, {static_cast<double>(cases[i].lidar - kDriftLidars), cases[i].agile ? 1.0 : 0.0,
                                         static_cast<double>(w), m.rms_m, m.worst_m, m.ate_m, m.drift_50m_percent,
                                         m.nees, m.scan_ms, m.map_mb, m.open_percent, m.unused_percent});
    }
  }
  experiment.write("flights.csv", csv);

  const auto median = [&](std::size_t way, const DriftLidar* lidar, const DriftWorld* world, double Matched::*value) {
    std::vector<double> values;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if ((lidar == nullptr || cases[i].lidar == lidar) && (world == nullptr || cases[i].world == world))
        values.push_back(matched[i][way].*value);
    }
    return median_of(values);
  };
  for (const DriftLidar& lidar : kDriftLidars) {
    for (std::size_t way = 0; way < ways.size(); ++way) {
      std::string by_world;
      for (const DriftWorld& world : kDriftWorlds) {
        const double rms_m = median(way, &lidar, &world, &Matched::rms_m);
        if (std::isfinite(rms_m))
          by_world += fmt::format("{}{} {}", by_world.empty() ? "" : ", ", world.scenario, short_number(rms_m, 2));
      }
      const auto of = [&](double Matched::*value, int digits) {
        return short_number(median(way, &lidar, nullptr, value), digits);
      };
      experiment.row(
          {fmt::format("{}, {}: error of the position [m]", lidar.label, ways[way].label), of(&Matched::rms_m, 2),
           Verdict::kNotJudged,
           fmt::format("median of root mean squares; {}; after alignment {}; drift over 50 m {} %; normalized "
                       "squared error {}; {} ms a scan; {} MB; {} % of the scans leave a direction open",
                       by_world, of(&Matched::ate_m, 2), of(&Matched::drift_50m_percent, 2), of(&Matched::nees, 2),
                       of(&Matched::scan_ms, 2), of(&Matched::map_mb, 2), of(&Matched::open_percent, 2)),
           median(way, &lidar, nullptr, &Matched::rms_m)});
    }
  }
  for (std::size_t way = 1; way < ways.size(); ++way) {
    int better = 0;
    for (const std::vector<Matched>& flight : matched) better += flight[0].rms_m < flight[way].rms_m;
    experiment.claim(fmt::format("surfaces are nearer to the truth than {}", ways[way].label),
                     fmt::format("on {} of {} flights", better, matched.size()),
                     2 * better > static_cast<int>(matched.size()));
  }
}

}  // namespace swiftlet::tools
