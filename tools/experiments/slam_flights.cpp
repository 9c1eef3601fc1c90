// SPDX-License-Identifier: BSD-3-Clause
#include "slam_flights.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <span>

#include "parallel.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/global_slam.hpp"
#include "swiftlet/core/slam/saved_map.hpp"
#include "swiftlet/core/slam/symmetric_eigen.hpp"
#include "swiftlet/sim/view/tick_view.hpp"

namespace swiftlet::tools {
namespace {

constexpr TimeNs kJudgedEvery = 100'000'000;  // scan period
constexpr TimeNs kShownEvery = 500'000'000;
constexpr double kLeftBehind_m = 30.0;  // least path length between two submaps to join, as in GlobalSlamConfig

constexpr double kLever_m = 5.0;   // lever that converts rotations to displacements
constexpr double kNothing = 1e-6;  // share of the largest eigenvalue below which a direction is unconstrained

/// Error of a closure against truth, without its component along the weakest direction if that is unconstrained.
Vector6 told_error(const RelativeFactor& closure, const Pose& T_from_to_true) {
  Vector6 error, scale;
  error << closure.T_from_to.translation() - T_from_to_true.translation(),
      rotation_vector_rad(
          Eigen::Quaterniond(Matrix3(T_from_to_true.linear().transpose() * closure.T_from_to.linear())));
  scale << Vector3::Ones(), Vector3::Constant(kLever_m);
  const Vector6 inverse = scale.cwiseInverse();
  const SymmetricEigen<6> eigen =
      symmetric_eigen<6>(Matrix6(inverse.asDiagonal() * closure.information * inverse.asDiagonal()));
  if (eigen.values(0) > kNothing * eigen.values(5)) return error;
  const Vector6 open = eigen.vectors.col(0), scaled = scale.cwiseProduct(error);
  return inverse.cwiseProduct(scaled - open.dot(scaled) * open);
}

Vector3 turn_of(const Matrix3& R) { return rotation_vector_rad(Eigen::Quaterniond(R)); }

/// Write and read numbers in the same order.
class FlightWriter {
 public:
  void operator()(double& x) { numbers.push_back(x); }
  void operator()(int& x) { numbers.push_back(x); }
  void operator()(bool& x) { numbers.push_back(x ? 1.0 : 0.0); }
  std::size_t size_of(std::size_t size) {
    numbers.push_back(static_cast<double>(size));
    return size;
  }
  std::vector<double> numbers;
};
class FlightReader {
 public:
  explicit FlightReader(std::span<const double> numbers) : numbers_(numbers) {}
  void operator()(double& x) { x = next(); }
  void operator()(int& x) { x = static_cast<int>(next()); }
  void operator()(bool& x) { x = next() > 0.0; }
  std::size_t size_of(std::size_t) { return static_cast<std::size_t>(next()); }

 private:
  double next() {
    const double x = numbers_.front();
    numbers_ = numbers_.subspan(1);
    return x;
  }
  std::span<const double> numbers_;
};

void exchange(auto& stream, SlamFlight& f) {
  CorrectionCourse& c = f.correction;
  ClosureCount& k = f.closures;
  stream(f.crashed);
  stream(f.done);
  for (double* x : {&f.lost_s,
                    &f.time_s,
                    &f.way_m,
                    &f.least_clearance_m,
                    &f.corrected_s,
                    &f.rms_m,
                    &f.rms_local_after_m,
                    &f.rms_after_m,
                    &f.end_m,
                    &f.end_height_m,
                    &f.nees,
                    &f.drift_10m_percent,
                    &f.drift_50m_percent,
                    &f.speed_after_mps,
                    &f.acceleration_after_mps2,
                    &c.largest_m,
                    &c.step_m,
                    &c.speed_mps,
                    &c.acceleration_mps2,
                    &k.worst_m,
                    &f.graph.rms_m,
                    &f.graph.tilt_deg,
                    &f.graph.climb_m}) {
    stream(*x);
  }
  for (int* x : {&f.warnings, &c.count, &k.closed, &k.false_ones, &k.revisits, &k.revisits_closed}) stream(*x);
  f.moments.resize(stream.size_of(f.moments.size()));
  for (SlamMoment& moment : f.moments) {
    stream(moment.t_s);
    for (Vector3* p : {&moment.p_true_m, &moment.p_local_m, &moment.p_shown_m, &moment.p_gnss_m}) {
      for (double& x : *p) stream(x);
    }
  }
  f.slice_world_m.resize(stream.size_of(f.slice_world_m.size()));
  for (Eigen::Vector2d& p : f.slice_world_m) {
    for (double& x : p) stream(x);
  }
}

struct Mean {
  double sum = 0.0;
  int count = 0;
  void add(double x) {
    sum += x;
    ++count;
  }
  double value() const { return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN(); }
};

class SlamNotes {
 public:
  void take(const sim::Simulation& simulation) {
    const sim::TickView& view = simulation.view();
    const sim::VehicleState& state = view.states[0];
    const StateEstimate& e = view.actions[0]->estimate;
    const double dt_s = simulation.scenario().tick_s;
    const Pose T_true = state.T_world_body();
    truth_.emplace_back(view.t, T_true);
    for (const sim::Event& event : view.events) {
      flight_.crashed = flight_.crashed || event.kind == "crash";
      flight_.done = flight_.done || event.kind == "mission_done";
      flight_.warnings += event.kind == "mission" && event.note.starts_with("SLAM");
    }
    for (const GnssSample& fix : view.observations[0].gnss) p_gnss_m_ = fix.p_world_m;
    if (!view.clearance_m.empty()) {
      flight_.least_clearance_m =
          least_known_ ? std::min(flight_.least_clearance_m, view.clearance_m[0]) : view.clearance_m[0];
      least_known_ = true;
    }
    if (!e.valid) flight_.lost_s += dt_s;
    if (last_) flight_.way_m += (T_true.translation() - last_->p_true_m).norm();
    take_correction(e, view.t, dt_s);
    if (flight_.corrected_s >= 0.0) {
      flight_.speed_after_mps = std::max(flight_.speed_after_mps, state.v_world_mps.norm());
      if (last_) {
        flight_.acceleration_after_mps2 =
            std::max(flight_.acceleration_after_mps2, (state.v_world_mps - last_->v_true_mps).norm() / dt_s);
      }
    }
    if (view.t >= judged_ + kJudgedEvery) judge(e, T_true, view.t);
    if (view.t >= shown_ + kShownEvery) {
      shown_ = view.t;
      flight_.moments.push_back({to_seconds(view.t), T_true.translation(), e.T_local_body.translation(),
                                 e.T_world_body().translation(), p_gnss_m_});
    }
    const double off_m = (e.T_world_body().translation() - T_true.translation()).norm();
    flight_.end_m = off_m;
    flight_.end_height_m = e.T_world_body().translation().z() - T_true.translation().z();
    flight_.time_s = to_seconds(view.t);
    last_ = Last{T_true.translation(), state.v_world_mps, e.T_world_local, e.correction_revision};
    if (simulation.finished()) conclude(simulation);
  }

  SlamFlight& flight() { return flight_; }

 private:
  struct Last {
    Vector3 p_true_m, v_true_mps;
    Pose T_world_local;
    std::uint32_t revision;
  };

  /// Evaluates the displacement of the vehicle's current position by corrections.
  void take_correction(const StateEstimate& e, TimeNs t, double dt_s) {
    CorrectionCourse& course = flight_.correction;
    if (!last_) T_before_ = e.T_world_local;
    if (!last_) return;
    const Vector3 p_local_m = e.T_local_body.translation();
    const Vector3 moved_m = e.T_world_local * p_local_m - last_->T_world_local * p_local_m;
    const Vector3 v_mps = moved_m / dt_s;
    if (e.correction_revision != last_->revision) {
      if (!moving_) {
        moving_ = true;
        ++course.count;
        T_before_ = last_->T_world_local;
        if (flight_.corrected_s < 0.0) flight_.corrected_s = to_seconds(t);
      }
      course.step_m = std::max(course.step_m, dt_s * (v_mps - v_mps_).norm());  // without the continuing motion
      v_known_ = false;
    } else {
      course.speed_mps = std::max(course.speed_mps, v_mps.norm());
      if (v_known_) course.acceleration_mps2 = std::max(course.acceleration_mps2, (v_mps - v_mps_).norm() / dt_s);
      v_known_ = true;
    }
    v_mps_ = v_mps;
    course.largest_m = std::max(course.largest_m, (e.T_world_local * p_local_m - T_before_ * p_local_m).norm());
    if (moving_ && moved_m.isZero() && e.correction_revision == last_->revision) moving_ = false;
  }

  void judge(const StateEstimate& e, const Pose& T_true, TimeNs t) {
    judged_ = t;
    const Vector3 off_local_m = e.T_local_body.translation() - T_true.translation();
    const double off_sq = (e.T_world_body().translation() - T_true.translation()).squaredNorm();
    all_sq_.add(off_sq);
    if (flight_.corrected_s >= 0.0) {
      after_sq_.add(off_sq);
      local_after_sq_.add(off_local_m.squaredNorm());
    } else {
      local_before_sq_.add(off_local_m.squaredNorm());
    }
    Vector6 error;
    error.head<3>() = off_local_m;
    error.tail<3>() = turn_of(T_true.linear().transpose() * e.T_local_body.linear());
    const Eigen::LDLT<Matrix6> covariance(e.covariance);
    if (covariance.isPositive() && covariance.info() == Eigen::Success) nees_.add(error.dot(covariance.solve(error)));
    T_true_.push_back(T_true);
    T_local_.push_back(e.T_local_body);
  }

  void conclude(const sim::Simulation& simulation) {
    flight_.rms_m = std::sqrt(all_sq_.value());
    const bool corrected = after_sq_.count > 0;
    flight_.rms_after_m = std::sqrt((corrected ? after_sq_ : all_sq_).value());
    flight_.rms_local_after_m = std::sqrt((corrected ? local_after_sq_ : local_before_sq_).value());
    flight_.nees = nees_.value();
    flight_.drift_10m_percent = median_of(drifts_percent(T_true_, T_local_, 10.0));
    flight_.drift_50m_percent = median_of(drifts_percent(T_true_, T_local_, 50.0));
    if (const auto* provider = dynamic_cast<const SavedMapProvider*>(simulation.view().agents[0].get());
        provider != nullptr) {
      if (const auto map = provider->saved_map()) {
        count_closures(*map);
        measure_graph(*map);
      }
    }
    std::vector<MapVoxels> maps;
    simulation.view().agents[0]->append_maps(maps);
    const Pose& T_world_local = simulation.view().actions[0]->estimate.T_world_local;
    for (const MapVoxels& map : maps) {
      if (map.name != "mapping") continue;
      for (std::size_t i = 0; i < map.size(); ++i) {
        const Vector3 p_world_m = T_world_local * map.centers_local_m[i].cast<double>();
        if (map.state[i] < map.occupied_from || std::abs(p_world_m.z() - SlamFlight::kSlice_m) > 0.5 * map.edge_m) {
          continue;
        }
        flight_.slice_world_m.emplace_back(p_world_m.head<2>());
      }
    }
  }

  Pose true_pose(TimeNs t) const {
    const auto after = std::lower_bound(truth_.begin(), truth_.end(), t,
                                        [](const auto& known, TimeNs at) { return known.first < at; });
    if (after == truth_.begin()) return truth_.front().second;
    if (after == truth_.end()) return truth_.back().second;
    const auto before = std::prev(after);
    const double share = to_seconds(t - before->first) / to_seconds(after->first - before->first);
    Pose T = Pose::Identity();
    T.linear() = Eigen::Quaterniond(before->second.linear())
                     .slerp(share, Eigen::Quaterniond(after->second.linear()))
                     .toRotationMatrix();
    T.translation() = (1.0 - share) * before->second.translation() + share * after->second.translation();
    return T;
  }

  void count_closures(const SavedMap& map) {
    struct Submap {
      Pose T_true = Pose::Identity();
      double begin_m = 0.0, end_m = 0.0;
      bool closed = false;
    };
    std::map<int, std::pair<Pose, double>> nodes;  // key: pose of the graph; value: true pose and path length
    double way_m = 0.0;
    std::optional<Vector3> last_m;
    for (const SavedMap::Node& node : map.nodes) {
      const Pose T = true_pose(node.t);
      if (last_m) way_m += (T.translation() - *last_m).norm();
      last_m = T.translation();
      nodes[node.pose] = {T, way_m};
    }
    std::map<int, std::size_t> index;
    std::vector<Submap> submaps(map.submaps.size());
    std::vector<bool> known(submaps.size(), false);
    for (std::size_t i = 0; i < submaps.size(); ++i) index[map.submaps[i].pose] = i;
    for (const RelativeFactor& factor : map.graph.relative_factors()) {
      const auto submap = index.find(factor.from);
      const auto node = nodes.find(factor.to);
      if (submap == index.end() || node == nodes.end()) continue;
      Submap& its = submaps[submap->second];
      if (!known[submap->second]) {  // from the true pose of its first node
        known[submap->second] = true;
        its.T_true = node->second.first * factor.T_from_to.inverse();
        its.begin_m = node->second.second;
      }
      its.end_m = node->second.second;
    }
    ClosureCount& count = flight_.closures;
    for (const RelativeFactor& factor : map.graph.relative_factors()) {
      const auto from = index.find(factor.from), to = index.find(factor.to);
      if (factor.huber == kNoHuber || from == index.end() || to == index.end()) continue;
      const Pose T_truth = submaps[from->second].T_true.inverse() * submaps[to->second].T_true;
      const Vector6 off = told_error(factor, T_truth);
      const double off_m = off.head<3>().norm(), off_deg = off.tail<3>().norm() * 180.0 / std::numbers::pi;
      ++count.closed;
      submaps[to->second].closed = true;
      if (off_m > ClosureCount::kFalse_m || off_deg > ClosureCount::kFalse_deg)
        ++count.false_ones;
      else
        count.worst_m = std::max(count.worst_m, off_m);
    }
    for (std::size_t newer = 0; newer + 1 < submaps.size(); ++newer) {  // the last one is not finished
      const bool revisit =
          std::any_of(submaps.begin(), submaps.begin() + static_cast<std::ptrdiff_t>(newer), [&](const Submap& older) {
            const Submap& its = submaps[newer];
            return its.begin_m - older.end_m >= kLeftBehind_m &&
                   (its.T_true.translation() - older.T_true.translation()).norm() <= ClosureCount::kRevisit_m;
          });
      count.revisits += revisit;
      count.revisits_closed += revisit && submaps[newer].closed;
    }
  }

  void measure_graph(const SavedMap& map) {
    const auto count = static_cast<Eigen::Index>(map.nodes.size());
    if (count < 10) return;
    Eigen::Matrix3Xd truth_m(3, count), graph_m(3, count);
    std::vector<MatchedPosition> matched;
    for (Eigen::Index i = 0; i < count; ++i) {
      const SavedMap::Node& node = map.nodes[static_cast<std::size_t>(i)];
      truth_m.col(i) = true_pose(node.t).translation();
      graph_m.col(i) = map.graph.pose(node.pose).translation();
      matched.push_back({graph_m.col(i), truth_m.col(i), 1.0});
    }
    const Pose T = fit_to_world(matched, 0.0, 0.1);
    double sum_sq = 0.0;
    for (const MatchedPosition& m : matched) sum_sq += (T * m.p_local_m - m.p_world_m).squaredNorm();
    flight_.graph.rms_m = std::sqrt(sum_sq / static_cast<double>(count));
    const Eigen::Matrix4d best = Eigen::umeyama(graph_m, truth_m, false);
    flight_.graph.tilt_deg = std::acos(std::clamp(best(2, 2), -1.0, 1.0)) * 180.0 / std::numbers::pi;
    flight_.graph.climb_m = (graph_m(2, count - 1) - graph_m(2, 0)) - (truth_m(2, count - 1) - truth_m(2, 0));
  }

  SlamFlight flight_;
  Vector3 p_gnss_m_ = Vector3::Zero();
  bool least_known_ = false;
  std::optional<Last> last_;
  std::vector<std::pair<TimeNs, Pose>> truth_;  // one each tick
  std::vector<Pose> T_true_, T_local_;          // one for each evaluation
  TimeNs judged_ = 0, shown_ = -kShownEvery;
  Mean all_sq_, after_sq_, local_before_sq_, local_after_sq_, nees_;
  bool moving_ = false, v_known_ = false;
  Vector3 v_mps_ = Vector3::Zero();
  Pose T_before_ = Pose::Identity();
};

}  // namespace

std::vector<SlamFlight> fly_on_slam(const Experiment& experiment, std::vector<sim::Scenario> scenarios) {
  for (sim::Scenario& scenario : scenarios) {
    scenario.recorders.clear();
    scenario.snapshots.clear();
    scenario.metrics.stop_on_crash = true;
  }
  std::vector<SlamNotes> notes(scenarios.size());
  fly(experiment, scenarios,
      {.after_tick = [&](std::size_t i, const sim::Simulation& simulation) { notes[i].take(simulation); },
       .write =
           [&](std::size_t i) {
             FlightWriter writer;
             exchange(writer, notes[i].flight());
             return writer.numbers;
           },
       .read =
           [&](std::size_t i, std::span<const double> numbers) {
             FlightReader reader(numbers);
             exchange(reader, notes[i].flight());
           }});
  std::vector<SlamFlight> flights;
  flights.reserve(notes.size());
  for (SlamNotes& note : notes) flights.push_back(std::move(note.flight()));
  return flights;
}

std::vector<double> drifts_percent(const std::vector<Pose>& T_world_true, const std::vector<Pose>& T_local_estimate,
                                   double length_m) {
  std::vector<double> way_m(T_world_true.size(), 0.0);
  for (std::size_t i = 1; i < way_m.size(); ++i) {
    way_m[i] = way_m[i - 1] + (T_world_true[i].translation() - T_world_true[i - 1].translation()).norm();
  }
  std::vector<double> drifts;
  double next_m = 0.0;
  for (std::size_t i = 0; i < way_m.size(); ++i) {
    if (way_m[i] < next_m) continue;
    const auto end = std::lower_bound(way_m.begin(), way_m.end(), way_m[i] + length_m);
    if (end == way_m.end()) break;
    const auto j = static_cast<std::size_t>(end - way_m.begin());
    const Pose moved_true = T_world_true[i].inverse() * T_world_true[j];
    const Pose moved_estimate = T_local_estimate[i].inverse() * T_local_estimate[j];
    drifts.push_back(100.0 * (moved_true.inverse() * moved_estimate).translation().norm() / (way_m[j] - way_m[i]));
    next_m = way_m[i] + 0.1 * length_m;
  }
  return drifts;
}

double median_of(std::vector<double> values) {
  std::erase_if(values, [](double x) { return std::isnan(x); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

}  // namespace swiftlet::tools
