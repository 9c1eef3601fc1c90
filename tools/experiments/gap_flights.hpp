// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "experiment.hpp"
#include "guidance_flights.hpp"

/// A UAV guides a small one through a gap and back, in several configurations [Pritzl 2024, Fig. 6].
namespace swiftlet::tools {

/// The configurations of Fig. 6, in the order of its legend.
enum class GapTeam { kTruthOwnMap, kTruth, kFull, kFullToldOnce, kSingle };
const char* name_of(GapTeam team);

/// All flights of one configuration at one safe distance.
struct GapPoint {
  int flights = 0, successes = 0, crashes = 0;
  double share() const { return flights > 0 ? static_cast<double>(successes) / flights : 0.0; }
};
using GapCurve = std::map<double, GapPoint>;  // key: safe distance [m]

/// Sums of the error of the guide's estimate of the secondary's position, within 1 m of the gap.
struct GapErrors {
  double error_sum_m = 0.0, along_wall_sum_m = 0.0;
  int count = 0;
};

class GapFlights {
 public:
  explicit GapFlights(Experiment& experiment) : experiment_(experiment) {}

  void want(GapTeam team, double safe_distance_m, int first_seed, int last_seed);
  void fly_wanted();
  const GapCurve& curve(GapTeam team) const { return curves_.at(team); }
  const std::map<GapTeam, GapCurve>& curves() const { return curves_; }
  const GapErrors& errors(GapTeam team) { return errors_[team]; }
  const CsvTable& csv() const { return csv_; }

 private:
  struct Wanted {
    GapTeam team;
    double safe_distance_m;
    int seed;
  };
  void take(const Wanted& w, const GuidedFlight& flight);

  Experiment& experiment_;
  std::vector<Wanted> wanted_;
  std::map<GapTeam, GapCurve> curves_;
  std::map<GapTeam, GapErrors> errors_;
  CsvTable csv_{{"configuration", "safe_distance_m", "seed", "success", "contact", "passes", "time_s",
                 "least_clearance_m", "error_near_gap_m"}};
};

}  // namespace swiftlet::tools
