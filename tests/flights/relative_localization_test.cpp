// SPDX-License-Identifier: BSD-3-Clause
// Relative localization in the full simulation: OS0-128, detector, tracker, radio, drifting odometry; and a guide that
// sends a vehicle around by what it finds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "swiftlet/core/guidance/hover.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/sim/metrics/relative_score.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {
namespace {

struct Figures {
  std::vector<double> errors_m, yaw_errors_rad, nees, distances_m;
  double first_s = -1.0;

  static double mean(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value / static_cast<double>(values.size());
    return sum;
  }
};

/// Hovers, and sends the vehicle that it localizes from corner to corner, in that vehicle's body frame.
class SquareGuide : public Guidance {
 public:
  static constexpr double kSilentFrom_s = 12.0, kSilentTo_s = 18.0;
  static std::vector<Vector3> corners_world_m() { return {{6, 2, 4}, {6, -1, 4.5}, {3, -1, 4.5}, {4, 2, 4}}; }

  explicit SquareGuide(const GuidanceSetup& setup) : start_m_(setup.agent.T_local_body_start.translation()) {}

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    output.goal.position_m = start_m_;
    output.mission = MissionStatus::kEndless;
    const double t_s = to_seconds(input.observation.t);
    if (input.observation.t < next_ || (t_s > kSilentFrom_s && t_s < kSilentTo_s)) return;
    if (number_ == 0 && input.relatives.empty()) return;  // the other moves to and fro until it is spoken to
    next_ = input.observation.t + kNsPerSecond / 5;
    GuidingPath path;
    path.path = ++number_;
    for (const RelativeEstimate& other : input.relatives) {
      if (!left_m_.empty() && (left_m_.front() - other.position_m).norm() < 0.3) left_m_.erase(left_m_.begin());
      path.has_instant = true;
      path.t = other.report_stamp;
      const Eigen::AngleAxisd turn(-other.report_yaw_rad, Vector3::UnitZ());
      for (const Vector3& corner_m : left_m_) {
        const Vector3 p_body_m = turn * (corner_m - other.report_position_m);
        path.waypoints.push_back({p_body_m.cast<float>(), static_cast<float>(-other.report_yaw_rad)});
      }
    }
    write_message(path, outbox.add(1));
  }

 private:
  Vector3 start_m_;
  std::vector<Vector3> left_m_ = corners_world_m();
  TimeNs next_ = 0;
  std::uint32_t number_ = 0;
};

void add_square_guide() {
  static const bool added = [] {
    guidance_registry().add({{"square_guide", "of this test", make_module_config<HoverConfig>},
                             [](const ModuleConfig&, const GuidanceSetup& setup) -> std::unique_ptr<Guidance> {
                               return std::make_unique<SquareGuide>(setup);
                             },
                             nullptr,
                             ""});
    return true;
  }();
  (void)added;
}

template <class EachTick>
Figures fly(const Scenario& scenario, EachTick&& each_tick) {
  Simulation simulation(scenario);
  Figures figures;
  while (!simulation.finished()) {
    simulation.tick();
    for (const RelativeScore& score : rows_of<RelativeScore>(simulation.info().series)) {
      if (figures.first_s < 0.0) figures.first_s = to_seconds(score.t);
      figures.errors_m.push_back(score.error_world_m.norm());
      figures.yaw_errors_rad.push_back(std::abs(score.yaw_error_rad));
      figures.nees.push_back(score.nees);
      figures.distances_m.push_back(score.distance_m);
    }
    each_tick(simulation);
  }
  return figures;
}

Scenario scenario_of(std::vector<std::pair<std::string, std::string>> changes) {
  changes.emplace_back("recorders", "[]");
  changes.emplace_back("snapshots", "[]");
  return load_scenario("relative_localization", changes);
}

// [Pritzl 2024, sec. III-A]: 0.10 m in the mean at about 5 m.
TEST(RelativeLocalizationInFull, FindsAVehicleToFiveCentimeters) {
  const Figures figures = fly(scenario_of({}), [](const Simulation&) {});
  ASSERT_FALSE(figures.errors_m.empty());
  EXPECT_LT(figures.first_s, 15.0);
  EXPECT_LT(Figures::mean(figures.errors_m), 0.05);
  EXPECT_LT(Figures::mean(figures.yaw_errors_rad), 0.05);
  EXPECT_LT(Figures::mean(figures.nees), 6.0);
}

// The guided vehicle has only its odometry, and its guide is silent for six seconds.
TEST(RelativeLocalizationInFull, GuidedVehicleReachesItsPlaces) {
  add_square_guide();
  const Scenario scenario = scenario_of({{"vehicles[0].agent.guidance", "{type: square_guide}"},
                                         {"duration_s", "60"},
                                         {"vehicles[1].agent.guidance.speed_mps", "0.5"}});
  const auto corners_m = SquareGuide::corners_world_m();
  std::vector<double> nearest_m(corners_m.size(), 1e9);
  std::vector<std::string> notes;
  double flown_in_silence_m = 0.0;
  Vector3 last_m = Vector3::Zero();
  const Figures figures = fly(scenario, [&](const Simulation& simulation) {
    const TickView& view = simulation.view();
    const Vector3 p_m = view.states[1].p_world_m;
    for (std::size_t i = 0; i < corners_m.size(); ++i)
      nearest_m[i] = std::min(nearest_m[i], (p_m - corners_m[i]).norm());
    for (const Event& event : view.events) {
      if (event.vehicle == 1) notes.push_back(event.note);
    }
    const double t_s = to_seconds(view.t);
    if (t_s > SquareGuide::kSilentFrom_s + 3.5 && t_s < SquareGuide::kSilentTo_s) {
      flown_in_silence_m += (p_m - last_m).norm();
    }
    last_m = p_m;
  });
  for (const double nearest : nearest_m) {
    EXPECT_LT(nearest, 0.45) << "0.3 m count as visited, the rest is error";
  }
  EXPECT_LT(flown_in_silence_m, 0.15) << "distance flown without the link to the guide";
  const auto count_of = [&](const char* note) { return std::count(notes.begin(), notes.end(), note); };
  EXPECT_EQ(count_of("hovering: link to the guide lost"), 1);
  EXPECT_EQ(count_of("following the guide"), 2) << "before and after";
}

}  // namespace
}  // namespace swiftlet::sim
