// SPDX-License-Identifier: BSD-3-Clause
#include "guidance_flights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "parallel.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/sim/metrics/relative_score.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kNearPassage_m = 1.0;
constexpr double kThrough_m = 0.6;  // least distance from the passage's middle: jitter at the middle is no pass
constexpr TimeNs kSeenLately = 300'000'000;

class Notes {
 public:
  explicit Notes(const Passage& passage) : passage_(passage) {}

  void take(const sim::Simulation& simulation) {
    const sim::TickView& view = simulation.view();
    const std::size_t last = view.states.size() - 1;
    const Vector3& p_world_m = view.states[last].p_world_m;
    const Eigen::Vector2d at_m = passage_.of(p_world_m);
    if (std::abs(at_m.x()) > kThrough_m) {
      const int side = at_m.x() > 0.0 ? 1 : -1;
      flight_.passes += side_ != 0 && side != side_;
      side_ = side;
    }
    for (const sim::Event& event : view.events) {
      flight_.crashed = flight_.crashed || event.kind == "crash";
      flight_.done = flight_.done || (event.kind == "mission_done" && event.vehicle == 0);
      guides_ = event.vehicle == 0 ? event.note == "secondary moving" : guides_;
    }
    if (!view.clearance_m.empty()) {
      const double least_m = *std::min_element(view.clearance_m.begin(), view.clearance_m.end());
      flight_.least_clearance_m = noted_ ? std::min(flight_.least_clearance_m, least_m) : least_m;
      noted_ = true;
    }
    if (last > 0) take_guidance(simulation, p_world_m, at_m);
    flight_.time_s = to_seconds(view.t);
  }
  const GuidedFlight& flight() const { return flight_; }

  std::vector<double> numbers() const {
    const GuidedFlight& f = flight_;
    return {
        f.done ? 1.0 : 0.0,  f.crashed ? 1.0 : 0.0, f.time_s,           static_cast<double>(f.passes),     f.farthest_m,
        f.least_clearance_m, f.error_sum_m,         f.along_wall_sum_m, static_cast<double>(f.num_errors), f.seen_s,
        f.guided_s};
  }
  void read(std::span<const double> n) {
    flight_ = {n[0] > 0.0, n[1] > 0.0, n[2], static_cast<int>(n[3]), n[4], n[5], n[6], n[7], static_cast<int>(n[8]),
               n[9],       n[10]};
  }

 private:
  void take_guidance(const sim::Simulation& simulation, const Vector3& p_world_m, const Eigen::Vector2d& at_m) {
    if (guides_) {
      if (!began_world_m_) began_world_m_ = p_world_m;
      flight_.farthest_m = std::max(flight_.farthest_m, (p_world_m - *began_world_m_).head<2>().norm());
      const auto& relatives = simulation.view().actions[0]->relatives;
      const double dt_s = simulation.scenario().tick_s;
      flight_.guided_s += dt_s;
      if (!relatives.empty() && simulation.view().t - relatives.front().seen < kSeenLately) flight_.seen_s += dt_s;
    }
    if (at_m.norm() > kNearPassage_m) return;
    const Eigen::Vector2d wall(-std::sin(passage_.yaw_rad), std::cos(passage_.yaw_rad));
    for (const sim::RelativeScore& score : sim::rows_of<sim::RelativeScore>(simulation.info().series)) {
      flight_.error_sum_m += score.error_world_m.norm();
      flight_.along_wall_sum_m += std::abs(score.error_world_m.head<2>().dot(wall));
      ++flight_.num_errors;
    }
  }

  Passage passage_;
  GuidedFlight flight_;
  int side_ = 0;
  bool guides_ = false, noted_ = false;
  std::optional<Vector3> began_world_m_;
};

}  // namespace

Eigen::Vector2d Passage::of(const Vector3& p_world_m) const {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  const double x = p_world_m.x() - x_world_m, y = p_world_m.y() - y_world_m;
  return {c * x + s * y, c * y - s * x};
}

std::vector<GuidedFlight> fly_guided(const Experiment& experiment, std::vector<sim::Scenario> scenarios,
                                     const std::vector<Passage>& passages) {
  std::vector<Notes> notes;
  notes.reserve(scenarios.size());
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    scenarios[i].recorders.clear();
    scenarios[i].snapshots.clear();
    scenarios[i].metrics.stop_on_crash = true;
    notes.emplace_back(passages[i]);
  }
  fly(experiment, scenarios,
      {.after_tick = [&](std::size_t i, const sim::Simulation& simulation) { notes[i].take(simulation); },
       .write = [&](std::size_t i) { return notes[i].numbers(); },
       .read = [&](std::size_t i, std::span<const double> numbers) { notes[i].read(numbers); }});
  std::vector<GuidedFlight> flights;
  flights.reserve(notes.size());
  for (const Notes& note : notes) flights.push_back(note.flight());
  return flights;
}

GuideConfig& guide_of(sim::Scenario& scenario) {
  return scenario.vehicles.front().agent.as<StackConfig>().guidance.as<GuideConfig>();
}

Vector3 in_world(const Passage& passage, double along_m, double across_m, double height_m) {
  const double c = std::cos(passage.yaw_rad), s = std::sin(passage.yaw_rad);
  return {passage.x_world_m + c * along_m - s * across_m, passage.y_world_m + s * along_m + c * across_m, height_m};
}

std::string text_of(const Vector3& p_world_m) {
  return fmt::format("[{}, {}, {}]", p_world_m.x(), p_world_m.y(), p_world_m.z());
}

ShareInterval wilson(int successes, int attempts) {
  if (attempts == 0) return {};
  constexpr double kZ = 1.959963984540054;
  const double n = attempts, p = successes / n, denominator = 1.0 + kZ * kZ / n;
  const double middle = (p + kZ * kZ / (2.0 * n)) / denominator;
  const double half = kZ / denominator * std::sqrt(p * (1.0 - p) / n + kZ * kZ / (4.0 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

}  // namespace swiftlet::tools
