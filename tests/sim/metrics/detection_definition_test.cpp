// SPDX-License-Identifier: BSD-3-Clause
// Detections and tracks judged by the definitions of docs/metrics.md in plain code: the whole history is kept, and the
// best of all assignments is found by enumeration.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/metrics/detection_score.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "tests/sim/metrics/metrics_run.hpp"

namespace swiftlet::sim {
namespace {

struct Mean {
  std::vector<double> values;
  void add(double value) {
    if (!std::isnan(value)) values.push_back(value);
  }
  double mean() const {
    double sum = 0.0;
    for (const double v : values) sum += v;
    return sum / static_cast<double>(values.size());
  }
  double deviation() const {
    double sum = 0.0;
    for (const double v : values) sum += (v - mean()) * (v - mean());
    return std::sqrt(sum / static_cast<double>(values.size()));
  }
};

struct Guess {
  TimeNs t;
  Vector3 p_m, v_mps;
  Matrix3 P;
  std::uint32_t id;
};

struct Look {
  TimeNs stamp, middle;
  std::vector<int> points;
};

/// Output of one observer's detector or tracker in all scans.
struct Stage {
  bool tracks = false;
  std::vector<DetectionScore> scores;  // per target
  Mean latency_s, ospa_m;
  int estimates = 0, right = 0, wrong = 0, switches = 0, crossings = 0;
  TimeNs first = -1, last = -1;
  std::map<std::uint32_t, VehicleId> follows;   // vehicle followed by each track of the last scan; kNoVehicle: none yet
  int ghosts = 0;                               // ended ghosts
  std::map<VehicleId, std::uint32_t> followed;  // last track that followed each vehicle
  std::map<VehicleId, TimeNs> seen, found;      // first time
};

class PlainJudge {
 public:
  explicit PlainJudge(const MetricsConfig& config) : config_(config) {}

  void keep(const MetricsRun& run, const std::vector<char>& flying) {
    times_.push_back(run.now);
    states_.push_back(run.states);
    flying_ = flying;
    std::vector<Pose> T;
    for (std::size_t i = 0; i < run.states.size(); ++i)
      T.push_back(run.actions[i].estimate.T_world_body() * run.states[i].T_world_body().inverse());
    T_estimate_truth_.push_back(T);
  }

  void judge(Stage& stage, VehicleId observer, const std::vector<Guess>& guesses, const Look* look, TimeNs middle) {
    const TimeNs now = times_.back();
    const auto count = static_cast<VehicleId>(states_.back().size());
    if (stage.first < 0) stage.first = now;
    stage.last = now;
    best_.clear();
    now_.assign(guesses.size(), kNoVehicle);
    saved_m_ = 0.0;
    pair(0, count, observer, guesses, 0.0);
    if (best_.empty()) best_ = now_;

    double sum_m = 0.0;
    int vehicles = 0, tracks = 0, paired = 0;
    for (VehicleId j = 0; j < count; ++j) {
      if (j == observer || !flying_[static_cast<std::size_t>(j)]) continue;
      DetectionScore score;
      score.target = j;
      score.t = middle;
      score.distance_m = (truth(j, middle).p_m - truth(observer, middle).p_m).norm();
      score.visible_points = look == nullptr ? -1 : look->points[static_cast<std::size_t>(j)];
      score.position_error_m = score.speed_error_mps = score.direction_error_rad = score.nees = score.latency_s = NAN;
      for (std::size_t e = 0; e < guesses.size(); ++e) {
        if (best_[e] == j) compare(guesses[e], believed(observer, j, guesses[e].t), now, score);
      }
      stage.scores.push_back(score);
      if (score.found && !stage.found.contains(j)) stage.found[j] = now;
      if (score.distance_m > config_.detection_range_m) continue;
      if (score.visible_points != 0 && !stage.seen.contains(j)) stage.seen[j] = score.t;
      ++vehicles;
      tracks += score.found;
      paired += score.found;
      if (score.found) sum_m += score.position_error_m;
    }
    for (std::size_t e = 0; e < guesses.size(); ++e) {
      stage.latency_s.add(to_seconds(now - guesses[e].t));
      if (best_[e] != kNoVehicle && !flying_[static_cast<std::size_t>(best_[e])]) continue;
      ++stage.estimates;
      (best_[e] == kNoVehicle ? stage.wrong : stage.right) += 1;
      tracks += best_[e] == kNoVehicle;
    }
    if (!stage.tracks) return;
    const int most = std::max(vehicles, tracks);
    stage.ospa_m.add(most == 0 ? 0.0 : (sum_m + config_.true_positive_m * (most - paired)) / most);
    std::map<std::uint32_t, VehicleId> told;
    for (std::size_t e = 0; e < guesses.size(); ++e) {
      const std::uint32_t id = guesses[e].id;
      const VehicleId before = stage.follows.contains(id) ? stage.follows[id] : kNoVehicle;
      told[id] = best_[e] == kNoVehicle ? before : best_[e];
      if (best_[e] == kNoVehicle) continue;
      stage.crossings += before != kNoVehicle && before != best_[e];
      stage.switches += stage.followed.contains(best_[e]) && stage.followed[best_[e]] != id;
      stage.followed[best_[e]] = id;
    }
    for (const auto& [id, vehicle] : stage.follows) stage.ghosts += !told.contains(id) && vehicle == kNoVehicle;
    stage.follows = told;
  }

 private:
  struct Motion {
    Vector3 p_m, v_mps;
  };

  Motion truth(VehicleId j, TimeNs t) const {
    const auto at = static_cast<std::size_t>(j);
    std::size_t k = 0;
    while (k + 1 < times_.size() && times_[k + 1] <= t) ++k;
    const VehicleState& a = states_[k][at];
    if (t <= times_[k] || k + 1 == times_.size()) return {a.p_world_m, a.v_world_mps};
    const VehicleState& b = states_[k + 1][at];
    const double f = static_cast<double>(t - times_[k]) / static_cast<double>(times_[k + 1] - times_[k]);
    return {(1.0 - f) * a.p_world_m + f * b.p_world_m, (1.0 - f) * a.v_world_mps + f * b.v_world_mps};
  }
  Motion believed(VehicleId observer, VehicleId j, TimeNs t) const {
    std::size_t k = 0;
    while (k + 1 < times_.size() && times_[k + 1] <= t) ++k;
    const Pose& T = T_estimate_truth_[k][static_cast<std::size_t>(observer)];
    const Motion motion = truth(j, t);
    return {T * motion.p_m, T.linear() * motion.v_mps};
  }

  /// Enumerates assignments; keeps the one that saves the largest sum of distances below the limit.
  void pair(VehicleId j, VehicleId count, VehicleId observer, const std::vector<Guess>& guesses, double saved_m) {
    if (j == count) {
      if (saved_m <= saved_m_) return;
      saved_m_ = saved_m;
      best_ = now_;
      return;
    }
    pair(j + 1, count, observer, guesses, saved_m);
    if (j == observer) return;
    for (std::size_t e = 0; e < guesses.size(); ++e) {
      const double distance_m = (guesses[e].p_m - believed(observer, j, guesses[e].t).p_m).norm();
      if (now_[e] != kNoVehicle || distance_m >= config_.true_positive_m) continue;
      now_[e] = j;
      pair(j + 1, count, observer, guesses, saved_m + config_.true_positive_m - distance_m);
      now_[e] = kNoVehicle;
    }
  }

  static void compare(const Guess& guess, const Motion& motion, TimeNs now, DetectionScore& score) {
    const Vector3 off_m = guess.p_m - motion.p_m;
    score.found = true;
    score.t = guess.t;
    score.track_id = guess.id;
    score.latency_s = to_seconds(now - guess.t);
    score.position_error_m = off_m.norm();
    score.nees = off_m.dot(guess.P.inverse() * off_m);
    if (std::isnan(guess.v_mps.x())) return;
    score.speed_error_mps = std::abs(guess.v_mps.norm() - motion.v_mps.norm());
    if (motion.v_mps.norm() < 0.5 || guess.v_mps.norm() == 0.0) return;
    score.direction_error_rad = std::acos(guess.v_mps.normalized().dot(motion.v_mps.normalized()));
  }

  MetricsConfig config_;
  std::vector<TimeNs> times_;
  std::vector<std::vector<VehicleState>> states_;
  std::vector<std::vector<Pose>> T_estimate_truth_;
  std::vector<char> flying_;
  std::vector<VehicleId> now_, best_;  // index per guess
  double saved_m_ = 0.0;
};

class DetectionDefinition : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Worlds, DetectionDefinition, ::testing::Range(0, 6));

TEST_P(DetectionDefinition, OfARandomRunIsReported) {
  const Random random(static_cast<std::uint64_t>(GetParam()), "scores");
  constexpr int kVehicles = 4;
  MetricsConfig config;
  config.true_positive_m = 2.0 + GetParam() % 3;
  config.detection_range_m = 12.0 + 3.0 * GetParam();
  config.detection_bin_m = GetParam() % 2 == 0 ? 4.0 : 1.5;
  std::vector<Perception> perception(kVehicles);
  perception[0] = {true, true, {}};
  perception[2] = {GetParam() % 2 == 0, true, {}};
  MetricsRun run(kVehicles, config, perception);
  PlainJudge judge(config);
  std::map<std::pair<VehicleId, bool>, Stage> stages;  // key: observer, and whether it tracks
  std::map<VehicleId, std::vector<Look>> looks;
  std::vector<DetectionScore> told;
  for (std::uint32_t k = 0; k < 500; ++k) {
    const double t_s = run.next_s();
    std::vector<char> flying(kVehicles, 1);
    for (std::uint32_t i = 0; i < kVehicles; ++i) {
      VehicleState& state = run.states[i];
      const double rate = 0.3 + 0.2 * i, reach_m = 4.0 + 5.0 * i * random.uniform(0, i);
      state.p_world_m = {reach_m * std::cos(rate * t_s + i),
                         reach_m * std::sin(rate * t_s * (i % 2 == 0 ? 1.0 : -1.0) + i), 5.0 + std::sin(t_s + i)};
      state.v_world_mps = {std::sin(0.8 * t_s + i), 0.7 * std::cos(t_s), i == 3 ? 0.9 : 0.1};
      state.q_world_body = Eigen::AngleAxisd(0.5 * t_s + i, Vector3::UnitZ());
      state.crashed = i == 3 && k > 420;
      const bool down = i == 1 && k > 100 && k < 160;
      run.clearances[i].surface_m = down ? -0.1 : 1.0;
      if (down) state.v_world_mps *= 0.05;
      flying[i] = !state.crashed && (!down || state.v_world_mps.norm() > 0.1);
      run.actions[i].estimate.valid = true;
      run.actions[i].estimate.t = run.now + kTick;
      // The observer's own world moves against the true one.
      const Pose T = make_pose({3.0 * i, 0.2 * t_s, -1.0},
                               Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * i + 0.05 * t_s, Vector3::UnitZ())));
      run.actions[i].estimate.T_local_body = T * state.T_world_body();
    }
    std::map<std::pair<VehicleId, bool>, std::vector<Guess>> guesses;
    std::map<VehicleId, TimeNs> stamps;
    for (const VehicleId i : {0, 2}) {
      const auto at = static_cast<std::uint32_t>(i);
      run.scans[at].clear();
      if (k % 10 == 4 + at) {
        auto labeled = std::make_shared<LabeledScan>();
        labeled->scan.stamp = run.now + kTick - (k % 20 == 4 + at ? 0 : 30'000'000);
        labeled->scan.duration = k % 20 == 4 + at ? 0 : 30'000'000;
        Look look{labeled->scan.stamp, labeled->scan.stamp + labeled->scan.duration / 2,
                  std::vector<int>(kVehicles, 0)};
        for (std::uint32_t b = 0; b < 40; ++b) {
          const auto u = [&](std::uint32_t m) { return random.uniform(k, 1000 * at + 10 * b + m); };
          const bool is_vehicle = u(0) < 0.3, is_returned = u(1) < 0.8;
          const auto instance = static_cast<std::uint16_t>(1.0 + 5.0 * u(2));  // one more than there are
          labeled->scan.range_m.push_back(is_returned ? 5.0F : 0.0F);
          labeled->truth.instance.push_back(instance);
          labeled->truth.surface_class.push_back(
              static_cast<std::uint16_t>(is_vehicle ? SurfaceClass::kVehicle : SurfaceClass::kWall));
          if (is_vehicle && is_returned && instance <= kVehicles) ++look.points[instance - 1U];
        }
        run.scans[at] = {labeled};
        looks[i].push_back(look);
      }
      const bool tells = k > 20 && k % 10 == 6 + at / 2, tracks = k % 5 == (4 + at) % 5;
      Action& action = run.actions[at];
      action.clear_outputs();
      action.tracks.clear();
      action.has_detections = perception[at].detects && tells;
      action.has_tracks = tracks;
      stamps[i] = looks[i].empty() || k % 70 == 6 ? 12'345 : looks[i].back().stamp;  // an unknown scan
      action.detections_stamp = stamps[i];
      for (std::uint32_t e = 0; e < 5; ++e) {
        const auto u = [&](std::uint32_t m) { return random.uniform(k, 100'000 + 1000 * at + 10 * e + m); };
        const auto n = random.normal3(k, 200'000 + 1000 * at + e);
        if (u(0) < 0.2) continue;
        const auto j = static_cast<std::size_t>(u(1) < 0.15 ? 3.0 * u(2) : e % kVehicles);
        const TimeNs t = std::max<TimeNs>(run.now + kTick - static_cast<TimeNs>(55e6 * u(3)), 0);
        const Pose T = action.estimate.T_world_body() * run.states[at].T_world_body().inverse();
        const Vector3 p_m =
            T * run.states[j].p_world_m + 1.1 * Vector3(n[0], n[1], n[2]) + (e == 4 ? 60.0 : 0.0) * Vector3::UnitZ();
        const Vector3 v_mps = u(4) < 0.1
                                  ? Vector3(Vector3::Zero())
                                  : Vector3(T.linear() * run.states[j].v_world_mps + 0.3 * Vector3(n[1], n[2], n[0]));
        Matrix3 P = (0.5 + u(5)) * Matrix3::Identity();
        P(0, 1) = P(1, 0) = 0.2;
        const auto id = static_cast<std::uint32_t>(1 + 20 * e + (u(6) < 0.1 ? 7 : 0) + k / 100);
        if (e % 2 == 0 && action.has_detections) {
          Detection& d = action.detections.emplace_back();
          d.t = t;
          d.position_m = p_m;
          d.covariance = P;
          guesses[{i, false}].push_back({t, p_m, Vector3::Constant(NAN), P, 0});
        }
        if (tracks && std::none_of(action.tracks.begin(), action.tracks.end(),
                                   [&](const Track& track) { return track.id == id; })) {
          Track& track = action.tracks.emplace_back();
          track.id = id;
          track.t = t;
          track.position_m = p_m;
          track.velocity_mps = v_mps;
          track.covariance.topLeftCorner<3, 3>() = P;
          guesses[{i, true}].push_back({t, p_m, v_mps, P, id});
        }
      }
    }
    run.tick();
    judge.keep(run, flying);
    const auto rows = rows_of<DetectionScore>(run.metrics.series());
    told.insert(told.end(), rows.begin(), rows.end());
    for (const VehicleId i : {0, 2}) {
      const auto at = static_cast<std::size_t>(i);
      const Look* last = looks[i].empty() ? nullptr : &looks[i].back();
      if (run.actions[at].has_detections) {
        const Look* look = nullptr;
        for (const Look& other : looks[i]) look = other.stamp == stamps[i] ? &other : look;
        judge.judge(stages[{i, false}], i, guesses[{i, false}], look, look == nullptr ? stamps[i] : look->middle);
      }
      if (run.actions[at].has_tracks && (last == nullptr || !run.scans[at].empty())) {
        stages[{i, true}].tracks = true;
        judge.judge(stages[{i, true}], i, guesses[{i, true}], last, last == nullptr ? run.now : last->middle);
      }
    }
  }

  const MetricTable table = run.metrics.report();
  std::size_t bins = 0;
  for (const auto& [key, stage] : stages) {
    const std::string vehicle = key.first == 0 ? "uav1" : "uav3", what = stage.tracks ? "track" : "detection";
    const auto expect = [&](const std::string& name, double expected) {
      const MetricRow* row = table.find(name, vehicle);
      ASSERT_NE(row, nullptr) << name;
      if (std::isnan(expected)) {
        EXPECT_TRUE(std::isnan(row->value)) << vehicle << " " << name << " " << row->value;
      } else {
        EXPECT_NEAR(row->value, expected, 1e-9 * (1.0 + std::abs(expected))) << vehicle << " " << name;
      }
    };
    struct Sums {
      double targets = 0, found = 0, visible = 0, visible_found = 0;
      Mean position, speed, direction;
    };
    const auto sums_within = [&, &stage = stage](double from_m, double to_m) {
      Sums sums;
      for (const DetectionScore& s : stage.scores) {
        if (s.distance_m < from_m || s.distance_m > to_m) continue;
        sums.targets += 1;
        sums.found += s.found;
        sums.visible += s.visible_points != 0;
        sums.visible_found += s.found && s.visible_points != 0;
        sums.position.add(s.position_error_m);
        sums.speed.add(s.speed_error_mps);
        sums.direction.add(s.direction_error_rad);
      }
      return sums;
    };
    const Sums all = sums_within(0.0, config.detection_range_m);
    expect(what + "_recall", all.found / all.targets);
    expect(what + "_recall_visible", all.visible_found / all.visible);
    expect(what + "_precision", static_cast<double>(stage.right) / stage.estimates);
    expect(what + "_error_mean_m", all.position.mean());
    expect(what + "_error_std_m", all.position.deviation());
    expect(what + "_latency_s", stage.latency_s.mean());
    const double minutes = to_seconds(stage.last - stage.first) / 60.0;
    Mean first_s;
    for (const auto& [target, t] : stage.found) {
      if (stage.seen.contains(target)) first_s.add(std::max(to_seconds(t - stage.seen.at(target)), 0.0));
    }
    expect("time_to_first_" + what + "_s", first_s.mean());
    EXPECT_GT(stage.wrong, 10) << what;
    EXPECT_GT(all.found, 0) << what;
    if (!stage.tracks) {
      expect("false_detections_per_min", stage.wrong / minutes);
    } else {
      Mean nees;
      double within = 0.0;
      for (const DetectionScore& s : stage.scores) {
        nees.add(s.nees);
        within += s.nees <= 7.815;
      }
      int ghosts = stage.ghosts;
      for (const auto& [id, target] : stage.follows) ghosts += target == kNoVehicle;
      expect("track_speed_error_mean_mps", all.speed.mean());
      expect("track_direction_error_mean_rad", all.direction.mean());
      expect("false_tracks_per_min", ghosts / minutes);
      expect("track_identity_switches", stage.switches);
      expect("track_cross_associations", stage.crossings);
      expect("track_ospa_m", stage.ospa_m.mean());
      expect("track_nees", nees.mean());
      expect("track_nees_within_95", within / static_cast<double>(nees.values.size()));
      EXPECT_GT(stage.switches + stage.crossings, 0);
      EXPECT_GT(ghosts, 0);
    }
    for (const DistanceBin& bin : table.bins()) {
      if (bin.vehicle != vehicle || bin.stage != (stage.tracks ? "tracker" : "detector")) continue;
      ++bins;
      EXPECT_NEAR(std::remainder(bin.from_m, config.detection_bin_m), 0.0, 1e-9);
      EXPECT_NEAR(bin.to_m - bin.from_m, config.detection_bin_m, 1e-9);
      const Sums sums = sums_within(bin.from_m, bin.to_m);
      EXPECT_EQ(bin.targets, sums.targets);
      EXPECT_GT(bin.targets, 0);
      EXPECT_NEAR(bin.recall, sums.found / sums.targets, 1e-9);
      const auto same = [](double a, double b) { return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) < 1e-7; };
      EXPECT_TRUE(same(bin.recall_visible, sums.visible_found / sums.visible));
      EXPECT_TRUE(same(bin.error_mean_m, sums.position.mean()));
      EXPECT_TRUE(same(bin.error_std_m, sums.position.deviation()));
      EXPECT_TRUE(same(bin.speed_error_mean_mps, sums.speed.mean()));
      EXPECT_TRUE(same(bin.direction_error_mean_rad, sums.direction.mean()));
    }
  }
  EXPECT_EQ(bins, table.bins().size());
  std::size_t expected_bins = 0;
  for (const auto& [key, stage] : stages) {
    std::set<int> of_stage;
    for (const DetectionScore& s : stage.scores)
      of_stage.insert(static_cast<int>(s.distance_m / config.detection_bin_m));
    expected_bins +=
        static_cast<std::size_t>(std::count_if(of_stage.begin(), of_stage.end(), [](int b) { return b < 20; }));
  }
  EXPECT_EQ(bins, expected_bins);
  for (const DistanceBin& bin : table.bins()) EXPECT_LE(bin.to_m, 20.0 * config.detection_bin_m + 1e-9);

  // Rows for recorders: those of targets are the scores themselves.
  std::size_t of_targets = 0, of_nobody = 0, expected_wrong = 0, expected_right = 0;
  for (const DetectionScore& s : told) {
    (s.target == kNoVehicle ? of_nobody : of_targets) += 1;
    if (s.target != kNoVehicle) continue;
    EXPECT_FALSE(s.found);
    EXPECT_GE(s.latency_s, 0.0);
    EXPECT_LT(s.latency_s, 0.06);
    EXPECT_TRUE(std::isnan(s.position_error_m));
    EXPECT_GT(s.distance_m, 0.0);
  }
  for (const auto& [key, stage] : stages) {
    expected_wrong += static_cast<std::size_t>(stage.wrong);
    expected_right += stage.scores.size();
  }
  EXPECT_EQ(of_targets, expected_right);
  EXPECT_EQ(of_nobody, expected_wrong);
}

}  // namespace
}  // namespace swiftlet::sim
