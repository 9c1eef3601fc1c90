// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "detection_flights.hpp"
#include "detection_histories.hpp"
#include "experiments.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::uint64_t kFirstSmall = 451;  // nothing is tuned on seeds from here on
constexpr double kFarthestSmall_m = 25.0;
constexpr double kTold = 0.5;  // existence probability below which nothing is reported

struct SmallCase {
  const char* name;
  const char* scenario;
  bool drawn;  // the seed draws the observer's flight
  Overrides overrides;
};

/// The small quadrotor f330 at four tenths of its size: 0.2 m across, 90 g.
Overrides bird_of_0_2_m() {
  const std::string airframe = "vehicles[1].airframe.";
  return {{"vehicles[1].model", "f330"},
          {airframe + "mass_kg", "0.09"},
          {airframe + "inertia_diagonal_kgm2", "[1.0e-4, 1.0e-4, 1.9e-4]"},
          {airframe + "arm_length_m", "0.066"},
          {airframe + "body_height_m", "0.028"},
          {airframe + "body_radius_m", "0.032"},
          {airframe + "leg_height_m", "0.048"},
          {airframe + "propeller_radius_m", "0.036"},
          {airframe + "thrust_constant_N_per_radps2", "5.5e-7"},
          {airframe + "torque_to_thrust_m", "0.0064"},
          {airframe + "rotor_inertia_kgm2", "1.7e-7"},
          {airframe + "body_drag_area_m2", "[0.0067, 0.0067, 0.0067]"},
          {airframe + "rotors",
           "[{position_m: [0.0467, -0.0467, 0.014], spin: ccw}, {position_m: [-0.0467, 0.0467, 0.014], spin: ccw}, "
           "{position_m: [0.0467, 0.0467, 0.014], spin: cw}, {position_m: [-0.0467, -0.0467, 0.014], spin: cw}]"}};
}

/// The target flies along a wall, with 0.5 m between its hull and the wall.
Overrides along_a_wall() {
  return {{"world", "{type: walls, walls: [{points_m: [[-30, 9.5, 0], [30, 9.5, 0]], height_m: 12}]}"},
          {"vehicles[1].model", "f330"},
          {"vehicles[1].start.position_m", "[-12, 8.6, 8]"},
          {"vehicles[1].agent.guidance",
           "{type: waypoints, loop: true, waypoints_m: [[12, 4, 8], [12, 8.6, 8], [-12, 8.6, 8], [-12, 4, 8], "
           "[12, 4, 8], [12, 8.6, 8], [-12, 8.6, 8]]}"},
          {"vehicles[0].agent.guidance.area_max_m", "[24, 7, 5.5]"}};
}

/// A target of 0.2 m that flies as birds do.
Overrides bird_in_flight() {
  return {
      {"vehicles[1].model", "bird"},
      {"vehicles[1].agent.guidance",
       "{type: bird, area_min_m: [-24, -13, 7.5], area_max_m: [24, 13, 10.0], perches_m: [[-15, 8, 8], [15, -8, 9]]}"}};
}

/// The target flies around a clearing in a forest, with 0.5 m between its hull and the closest possible crowns, and
/// once a round through the middle.
Overrides along_crowns() {
  constexpr double kClearing_m = 12.0, kHull_m = 0.25, kHeight_m = 8.0;
  constexpr int kCorners = 24;
  std::string waypoints_m;
  for (int k = 0; k <= kCorners; ++k) {
    const double azimuth_rad = 2.0 * kPi * k / kCorners, radius_m = kClearing_m - kHull_m - 0.5;
    waypoints_m += fmt::format("[{:.2f}, {:.2f}, {}], ", radius_m * std::cos(azimuth_rad),
                               radius_m * std::sin(azimuth_rad), kHeight_m);
  }
  return {
      {"world", fmt::format("{{type: forest, size_m: [70, 70], stems_per_ha: 700, keep_clear: {{clear_height_m: 30, "
                            "clearings: [{{center_m: [0, 0], radius_m: {}}}]}}}}",
                            kClearing_m)},
      {"vehicles[0].start.position_m", "[-4, 0, 5]"},
      {"vehicles[0].agent.guidance.area_min_m", "[-6, -6, 4.5]"},
      {"vehicles[0].agent.guidance.area_max_m", "[6, 6, 5.5]"},
      {"vehicles[1].model", "f330"},
      {"vehicles[1].start.position_m", fmt::format("[0, 3, {}]", kHeight_m)},
      {"vehicles[1].agent.guidance",
       fmt::format("{{type: waypoints, loop: true, waypoints_m: [{}[0, 3, {}]]}}", waypoints_m, kHeight_m)}};
}

std::vector<SmallCase> small_cases() {
  return {{"0.65 m, as in detection-sparse", "detection_real", true, {}},
          {"a bird of 0.2 m", "detection_real", true, bird_of_0_2_m()},
          {"a bird of 0.2 m that flies like one", "detection_real", true, bird_in_flight()},
          {"a target of 2 m", "detection_real", true, {{"vehicles[1].airframe.body_radius_m", "1"}}},
          {"a target 0.5 m from a wall", "detection_real", true, along_a_wall()},
          {"a target 0.5 m from crowns", "detection_real", true, along_crowns()},
          {"two targets 0.5 m apart", "detection_pair", true, {}},
          {"three in a forest", "detection_forest", false, {}},
          {"three in a forest, leaves in wind",
           "detection_forest",
           false,
           {{"world.foliage", "{sway_m: 0.4, flutter_m: 0.1}"}}}};
}

/// Share of the scans with both targets in view in which two different tracks follow them.
double share_told_apart(const Flights& flights) {
  int both = 0, apart = 0;
  for (const auto& log : flights.logs) {
    std::map<TimeNs, std::array<const Sighting*, 2>> scans;
    for (const Sighting& s : log->tracks()) {
      if (s.target < 2) scans[s.t][static_cast<std::size_t>(s.target)] = &s;
    }
    for (const auto& [t, pair] : scans) {
      if (pair[0] == nullptr || pair[1] == nullptr || !pair[0]->visible || !pair[1]->visible) continue;
      if (pair[0]->range_m > kFarthestSmall_m) continue;
      ++both;
      apart += pair[0]->found && pair[1]->found && pair[0]->track != pair[1]->track;
    }
  }
  return both > 0 ? static_cast<double>(apart) / both : std::nan("");
}

void tell_small(Experiment& experiment, const std::string& what, const Flights& flights, bool is_pair, CsvTable& csv) {
  int seen = 0, found = 0, returned = 0, told = 0, false_told = 0, switches = 0;
  double error_m = 0.0;
  const double apart = is_pair ? share_told_apart(flights) : std::nan("");
  for (const auto& log : flights.logs) {
    for (const Judged& j : judged_sightings(log->detections(), kFarthestSmall_m)) {
      ++seen;
      returned += j.returned.front();
      found += j.found;
      if (j.found) error_m += j.error_m;
    }
    told += log->num_told_detections();
    false_told += log->num_false_detections();
    switches += histories_of(log->tracks()).switches;
  }
  const double recall = seen > 0 ? static_cast<double>(found) / seen : std::nan("");
  const double with_return = seen > 0 ? static_cast<double>(returned) / seen : std::nan("");
  const double precision = told > 0 ? 1.0 - static_cast<double>(false_told) / told : std::nan("");
  error_m /= std::max(found, 1);
  plain_row(experiment, what + ": recall up to 25 m", recall, 3,
            fmt::format("{} sightings, {:.3f} with a return; error {:.3f} m; precision {:.3f}; {} false tracks in "
                        "{:.0f} s; {} switches{}",
                        seen, with_return, error_m, precision, flights.false_tracks, flights.observed_s, switches,
                        std::isnan(apart) ? "" : fmt::format("; told apart in {:.3f} of the scans", apart)));
  csv.row(what, {static_cast<double>(seen), with_return, recall, error_m, precision,
                 static_cast<double>(flights.false_tracks), flights.observed_s, static_cast<double>(switches), apart});
}

}  // namespace

/// Targets that are smaller, larger or nearer to obstacles than in the other experiments.
void detection_small(Experiment& experiment) {
  CsvTable csv({"case", "sightings", "with_return", "recall", "error_m", "precision", "false_tracks", "observed_s",
                "switches", "told_apart"});
  for (const bool mid360 : {true, false}) {
    for (const SmallCase& small : small_cases()) {
      std::vector<sim::Scenario> scenarios;
      const int flights = experiment.repetitions(2, 1);
      for (int k = 0; k < flights; ++k) {
        Overrides overrides = small.overrides;
        const Overrides more = {
            {"vehicles[0].agent.detector", fmt::format("{{type: track_before_detect, told_existence: {}}}", kTold)},
            {"vehicles[0].agent.tracker", "{type: detector}"}};
        overrides.insert(overrides.end(), more.begin(), more.end());
        if (mid360) overrides.emplace_back("vehicles[0].sensors[0]", kMid360WithPose);
        if (small.drawn) overrides.emplace_back("vehicles[0].agent.guidance.seed", std::to_string(kFirstSmall + k));
        overrides.emplace_back("duration_s", experiment.quick() ? "20" : "40");
        scenarios.push_back(
            scenario_with(fmt::format("reproduce/{}.yaml", small.scenario), kFirstSmall + k, overrides));
      }
      const double bottom_deg = mid360 ? kMid360Bottom_deg : -kOs1Fov_deg,
                   top_deg = mid360 ? kMid360Top_deg : kOs1Fov_deg;
      tell_small(experiment, fmt::format("{}, {}", mid360 ? "Mid-360" : "OS1-128", small.name),
                 fly_and_log(experiment, scenarios, bottom_deg, top_deg, kIgnored_s, kTold),
                 small.scenario == std::string("detection_pair"), csv);
    }
  }
  experiment.write("detection-small.csv", csv);
}

}  // namespace swiftlet::tools
