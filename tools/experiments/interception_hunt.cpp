// SPDX-License-Identifier: BSD-3-Clause
#include "interception_hunt.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet::tools {
namespace {

constexpr int kFirstHunt = 500;                    // the planner is tuned on other flights
constexpr double kAccelerationTime_s = 1.0 / 0.6;  // intruder: largest speed over largest acceleration
constexpr double kNearest_m = 10.0;                // least distance between any two starts
constexpr std::uint32_t kOtherStarts = 1000;       // first draw for the second start
constexpr double kField_m = 16.0, kLowest_m = 6.5, kHighest_m = 10.5;  // box of starts, within the intruder's

}  // namespace

HuntEye os1_eye() { return {"OS1-128", {}}; }

HuntEye mid360_eye() {
  return {"Mid-360",
          {{"vehicles[0].sensors[0].model", "mid360"},
           {"vehicles[0].sensors[0].mount", "{position_m: [0, 0, -0.12], rpy_deg: [180, 0, 0]}"},
           {"vehicles[0].agent.detector", "{type: track_before_detect}"},
           {"vehicles[0].agent.tracker", "{type: detector}"},
           {"vehicles[0].agent.guidance.search", "{timeout_s: 60, fov_bottom_deg: -52, fov_top_deg: 7, range_m: 25}"}}};
}

sim::Scenario hunt(int number, const char* method, double speed_mps, const Overrides& changes, int start) {
  const auto n = static_cast<std::uint32_t>(kFirstHunt + number);
  const Random random(1, "interception.lidar");
  const auto place = [&](std::uint32_t index) {
    return Vector3(random.uniform(-kField_m, kField_m, n, index), random.uniform(-kField_m, kField_m, n, index + 1),
                   random.uniform(kLowest_m, kHighest_m, n, index + 2));
  };
  const auto text = [](const Vector3& p_m) {
    return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", p_m.x(), p_m.y(), p_m.z());
  };
  Vector3 hunter_m = place(0), intruder_m = place(4);
  for (std::uint32_t draw = 2; (intruder_m - hunter_m).norm() < kNearest_m; ++draw) intruder_m = place(4 * draw);
  if (start > 0) {
    const Vector3 first_m = hunter_m;
    for (std::uint32_t draw = kOtherStarts; draw == kOtherStarts || (hunter_m - first_m).norm() < kNearest_m ||
                                            (hunter_m - intruder_m).norm() < kNearest_m;
         ++draw) {
      hunter_m = place(4 * draw);
    }
  }
  Overrides overrides = {
      {"vehicles[0].agent.guidance.method", method},
      {"vehicles[0].start.position_m", text(hunter_m)},
      {"vehicles[1].start.position_m", text(intruder_m)},
      {"vehicles[1].agent.guidance.seed", std::to_string(n)},
      {"vehicles[1].agent.guidance.speed_mps", fmt::format("{:g}", speed_mps)},
      {"vehicles[1].agent.guidance.acceleration_mps2", fmt::format("{:.3f}", speed_mps / kAccelerationTime_s)}};
  overrides.insert(overrides.end(), changes.begin(), changes.end());
  return scenario_with("reproduce/interception_lidar.yaml", n, overrides);
}

bool hunt_is_over(const sim::Simulation& simulation) {
  const auto& events = simulation.view().events;
  return std::any_of(events.begin(), events.end(), [](const auto& event) {
    return event.kind == "mission_done" || event.kind == "mission_failed" || event.kind == "crash";
  });
}

}  // namespace swiftlet::tools
