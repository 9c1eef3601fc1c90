// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "crossing.hpp"
#include "experiments.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/orca.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/share_paths.hpp"
#include "swiftlet/core/stages/guidances.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kPeersHeight_m = 12.0;  // a sphere of 10 m lies above the ground
constexpr double kPeersSpeed_mps = 4.0;  // same for all methods

struct PeerMethod {
  const char* name;
  void (*choose)(sim::VehicleConfig& vehicle);
};

Module& peer_guidance(sim::VehicleConfig& vehicle) { return vehicle.agent.as<StackConfig>().guidance; }

void by_rbl(sim::VehicleConfig& vehicle) {
  RblConfig rbl;
  rbl.cells.step_m = 0.35;
  rbl.z_max_m = 2.0 * kPeersHeight_m;
  peer_guidance(vehicle).as<RblConfig>() = rbl;
}

// Zhou, Wang, Bandyopadhyay and Schwager, 2017: each vehicle flies to the point of its buffered cell nearest to the
// goal, and turns right when stuck. With so narrow a weight the centroid is that point.
void by_buffered_cells(sim::VehicleConfig& vehicle) {
  by_rbl(vehicle);
  RblConfig& rbl = peer_guidance(vehicle).as<RblConfig>();
  rbl.cells.cut = RblCellConfig::Cut::kBuffered;
  rbl.rules.beta_desired_m = rbl.rules.beta_min_m = 0.05;
  rbl.rules.elevation_rule = false;
  rbl.separation.enabled = false;
  rbl.neighbors = NeighborSourceConfig::forgetful();
}

void by_orca(sim::VehicleConfig& vehicle) {
  peer_guidance(vehicle) = Module(guidance_module_types(), "orca");
  OrcaConfig& orca = peer_guidance(vehicle).as<OrcaConfig>();
  orca.speed_mps = kPeersSpeed_mps;
  orca.z_max_m = 2.0 * kPeersHeight_m;
}

void by_shared_paths(sim::VehicleConfig& vehicle) {
  vehicle.sensors.clear();
  peer_guidance(vehicle) = Module(guidance_module_types(), "share_paths");
  SharePathsConfig& paths = peer_guidance(vehicle).as<SharePathsConfig>();
  paths.speed_mps = kPeersSpeed_mps;
  paths.z_max_m = 2.0 * kPeersHeight_m;
}

constexpr PeerMethod kPeerMethods[] = {
    {"RBL", by_rbl}, {"buffered cells", by_buffered_cells}, {"ORCA", by_orca}, {"shared paths", by_shared_paths}};

/// Quality of the knowledge of neighbors: their sensor and, for shared paths, the radio.
struct Knowledge {
  const char* name;
  void (*set)(sim::Scenario& pattern);
};

sim::NeighborsConfig& peer_sight(sim::Scenario& pattern) {
  return pattern.vehicles.front().sensors.front().as<sim::NeighborsConfig>();
}

void perfectly_known(sim::Scenario& pattern) {
  peer_sight(pattern).ideal = true;
  pattern.radio.loss_probability = 0.0;
}
void usually_known(sim::Scenario& pattern) {  // UVDAR; a radio with delay and loss
  pattern.radio.delay_s = 0.1;
  pattern.radio.loss_probability = 0.1;
}
void poorly_known(sim::Scenario& pattern) {
  peer_sight(pattern).rate_hz = 1.0;
  peer_sight(pattern).latency_s = 0.3;
  pattern.radio.delay_s = 0.3;
  pattern.radio.loss_probability = 0.5;
}
constexpr Knowledge kKnowledge[] = {{"perfect", perfectly_known}, {"usual", usually_known}, {"poor", poorly_known}};

sim::Scenario peer_scene(const PeerMethod& method, const Knowledge& knowledge, const Formation& formation,
                         std::uint64_t seed) {
  sim::Scenario pattern = scenario_with("reproduce/rbl_crossing.yaml", seed);
  pattern.metrics.stop_on_crash = true;
  pattern.duration_s = 60.0;
  knowledge.set(pattern);
  method.choose(pattern.vehicles.front());
  return make_crossing(pattern, formation, kPeersHeight_m);
}

}  // namespace

// Equal crossings by established methods, with three qualities of neighbor measurements.
void rbl_peers(Experiment& experiment) {
  const int seeds = experiment.repetitions(20, 1);
  CsvTable csv({"case", "knowledge", "vehicles", "success", "arrived", "contacts", "length_m", "time_s", "slowest_s",
                "least_m"});
  std::vector<Formation> formations = {{false, 10, 10.0}, {true, 30, 10.0}};
  if (!experiment.quick()) formations = {{false, 10, 10.0}, {false, 15, 10.0}, {true, 30, 10.0}, {true, 60, 10.0}};
  sim::plot::Figure figure("Crossings by four methods", 3);
  figure.set_panel_size(330, 260);
  for (int k = 0; k < 3; ++k) {
    const Knowledge& knowledge = kKnowledge[k];
    sim::plot::Panel& panel = figure.add_panel(std::string(knowledge.name) + " knowledge of the others");
    panel.x.label = "mean time [s]";
    panel.y.label = "least distance [m]";
    panel.y.min = 0.0;
    panel.legend = k == 2 ? sim::plot::Legend::kAuto : sim::plot::Legend::kNone;
    for (const PeerMethod& method : kPeerMethods) {
      std::vector<double> time_s, least_m;
      for (const Formation& formation : formations) {
        const int n = formation.num_vehicles;
        if (n > 15 && k == 2) continue;
        std::vector<sim::Scenario> scenarios;
        for (int seed = 1; seed <= (n > 15 ? std::max(1, seeds / 5) : seeds); ++seed) {
          scenarios.push_back(peer_scene(method, knowledge, formation, static_cast<std::uint64_t>(seed)));
        }
        const CrossingTable table = summarize(fly_crossings(experiment, scenarios), n);
        const std::string what =
            fmt::format("{} N={}, {}, {}", formation.sphere ? "sphere" : "circle", n, knowledge.name, method.name);
        csv.row(what, {static_cast<double>(k), static_cast<double>(n), table.success, table.arrived, table.crashed,
                       table.length_m.mean, table.time_s.mean, table.slowest_s.mean, table.min_separation_m});
        experiment.row(
            {what + ": success [-]; L [m], t [s]",
             table.success > 0.0
                 ? fmt::format("{:.2f}; {:.1f}, {:.1f}", table.success, table.length_m.mean, table.time_s.mean)
                 : fmt::format("{:.2f}", table.success),
             Verdict::kNotJudged,
             fmt::format("{:.0f} % of the vehicles arrive, contact in {:.0f} % of the flights, least distance "
                         "{:.2f} m",
                         100.0 * table.arrived, 100.0 * table.crashed, table.min_separation_m),
             table.success});
        if (table.success == 0.0) continue;
        time_s.push_back(table.time_s.mean);
        least_m.push_back(table.min_separation_m);
      }
      panel.scatter(method.name, time_s, least_m);
    }
    panel.horizontal("", 1.0, {.dash = sim::plot::Dash::kDotted});
  }
  experiment.write("peers.csv", csv);
  experiment.write("peers.svg", figure);
}

}  // namespace swiftlet::tools
