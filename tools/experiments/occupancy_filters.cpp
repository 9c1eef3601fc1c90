// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "experiments.hpp"
#include "swiftlet/core/map/log_odds_map.hpp"
#include "swiftlet/core/map/ray_lengths.hpp"
#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet::tools {
namespace {

// The situation of Fig. 3: a flying object fills an otherwise empty voxel for a while.
constexpr double kEnters_s = 2.0, kLeaves_s = 4.5, kEnd_s = 8.0;
constexpr double kScan_s = 0.1;
constexpr double kRaycast_s = 0.3195;  // Table VI: the ray casting is slower than the classification
constexpr double kObject_m = 0.15;
const Vector3 kVoxel_m(10.125, 0.125, 0.125);           // its center, 10 m before the sensor
constexpr double kRayWeight = 0.003, kRayMax_m = 20.0;  // Table II

// The beams of an OS1-128 (1024 x 128 over 360 x 45 degrees) that pass near the voxel.
std::vector<Vector3> beams_near_the_voxel() {
  std::vector<Vector3> beams;
  const double azimuth_step = 2.0 * std::numbers::pi / 1024.0, elevation_step = std::numbers::pi / 4.0 / 127.0;
  for (int i = -8; i <= 8; ++i) {
    for (int j = -8; j < 8; ++j) {
      const double azimuth = i * azimuth_step, elevation = (j + 0.5) * elevation_step;
      beams.emplace_back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation));
    }
  }
  return beams;
}

// Range to the object's surface.
std::optional<double> hit_m(const Vector3& direction) {
  const double along = kVoxel_m.dot(direction);
  const double off_sq = kVoxel_m.squaredNorm() - along * along;
  if (off_sq >= kObject_m * kObject_m) return std::nullopt;
  return along - std::sqrt(kObject_m * kObject_m - off_sq);
}

struct Sample {
  double t_s = 0.0, G = 0.0, L = 0.0;
  VoxelState G_state = VoxelState::kUncertain, L_state = VoxelState::kUncertain;
};

class Filters {
 public:
  Filters()
      : map_(map_config()), log_odds_(log_odds_config()), index_(map_.grid().index(map_.grid().cell_of(kVoxel_m))) {}

  void scan(double t_s) {
    const bool present = t_s >= kEnters_s && t_s < kLeaves_s;
    std::vector<Vector3> ends;
    std::vector<std::uint8_t> is_point;
    for (const Vector3& beam : beams_) {
      const std::optional<double> range_m = present ? hit_m(beam) : std::nullopt;
      ends.push_back(range_m.value_or(kRayMax_m) * beam);
      is_point.push_back(range_m ? 1 : 0);
    }
    log_odds_.insert(Vector3::Zero(), ends, is_point);
    // Classification: its points are a flying object (rule B), so their voxels become unknown, eqs. (9) and (17).
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (is_point[i] != 0)
        map_.update(map_.grid().index(map_.grid().cell_of(ends[i])), std::numeric_limits<double>::infinity(),
                    map_.config().g_unknown);
    }
    ++updates_;
    if (t_s + 1e-9 < next_raycast_s_) return;
    next_raycast_s_ = t_s + kRaycast_s;
    raycast(ends);
  }

  Sample sample(double t_s) const {
    const std::ptrdiff_t log_index = log_odds_.grid().index(log_odds_.grid().cell_of(kVoxel_m));
    return {t_s, map_.value(index_), log_odds_.value(log_index), map_.state(index_), log_odds_.state(log_index)};
  }

 private:
  static VoxelMapConfig map_config() {
    VoxelMapConfig config;
    config.extent = VoxelMapConfig::Extent::kBounded;
    config.center_m = {10.0, 0.0, 0.0};
    config.size_m = {30.0, 12.0, 12.0};
    return config;
  }
  static LogOddsConfig log_odds_config() {
    LogOddsConfig config;
    config.center_m = {10.0, 0.0, 0.0};
    config.size_m = {30.0, 12.0, 12.0};
    return config;
  }

  // Eqs. (20) to (22), for all classifications since the last one.
  void raycast(const std::vector<Vector3>& ends) {
    rays_.begin({Vector3::Constant(-0.1), Vector3::Constant(0.1)}, kRayMax_m, map_.grid().edge_m);
    for (const Vector3& end : ends) rays_.add(Vector3::Zero(), end.normalized(), end.norm());
    rays_.apply(updates_ * kRayWeight / std::numbers::sqrt3, map_);
    updates_ = 0;
  }

  VoxelMap map_;
  LogOddsMap log_odds_;
  RayLengths rays_;
  std::ptrdiff_t index_;
  std::vector<Vector3> beams_ = beams_near_the_voxel();
  int updates_ = 0;  // N_cls
  double next_raycast_s_ = 0.0;
};

// Seconds after the object left until the state is confident free; infinity: never.
template <class StateOf>
double freed_after_s(const std::vector<Sample>& samples, const StateOf& state_of) {
  for (const Sample& sample : samples) {
    if (sample.t_s >= kLeaves_s && state_of(sample) == VoxelState::kFree) return sample.t_s - kLeaves_s;
  }
  return std::numeric_limits<double>::infinity();
}

template <class StateOf>
int num_confident_occupied(const std::vector<Sample>& samples, const StateOf& state_of) {
  int count = 0;
  for (const Sample& sample : samples) count += state_of(sample) == VoxelState::kConfident ? 1 : 0;
  return count;
}

void draw(Experiment& experiment, const std::vector<Sample>& samples) {
  CsvTable csv({"t_s", "G", "L", "G_state", "L_state"});
  std::vector<double> t, G, L, G_state, L_state;
  for (const Sample& sample : samples) {
    t.push_back(sample.t_s);
    G.push_back(sample.G);
    L.push_back(sample.L);
    G_state.push_back(static_cast<double>(sample.G_state));
    L_state.push_back(static_cast<double>(sample.L_state));
    csv.row({sample.t_s, sample.G, sample.L, G_state.back(), L_state.back()});
  }
  experiment.write("occupancy-filters.csv", csv);

  const VoxelMapConfig g;
  const LogOddsConfig l;
  sim::plot::Figure figure("A flying object in an empty voxel from 2 s to 4.5 s (Fig. 3)");
  figure.set_panel_size(820, 250);
  const sim::plot::Style limit{.color = 6, .width_px = 1.0, .dash = sim::plot::Dash::kDotted};
  sim::plot::Panel& log_odds = figure.add_panel("log-odds L(v)");
  log_odds.y.label = "L [-]";
  log_odds.step("L(v)", t, L, {.color = 1})
      .horizontal("occupied", l.L_occupied, limit)
      .horizontal("free", l.L_free, limit);
  sim::plot::Panel& multi = figure.add_panel("multi-state G(v)");
  multi.y.label = "G [-]";
  multi.step("G(v)", t, G, {.color = 0}).horizontal("uncertain", g.G_uncertain, limit);
  sim::plot::Panel& states = figure.add_panel("state");
  states.x.label = "time [s]";
  states.y.categories = {"free", "uncertain", "tentative", "confident"};
  states.step("L(v)", t, L_state, {.color = 1, .dash = sim::plot::Dash::kDashed})
      .step("G(v)", t, G_state, {.color = 0});
  for (sim::plot::Panel* panel : {&log_odds, &multi, &states}) {
    panel->vertical("", kEnters_s, {.color = 2, .width_px = 1.0})
        .vertical("", kLeaves_s, {.color = 2, .width_px = 1.0});
    panel->legend = sim::plot::Legend::kOutside;
  }
  experiment.write("occupancy-filters.svg", figure);
}

}  // namespace

void occupancy_filters(Experiment& experiment) {
  Filters filters;
  std::vector<Sample> samples;
  for (int k = 0; k * kScan_s < kEnd_s; ++k) {
    const double t_s = k * kScan_s;
    filters.scan(t_s);
    samples.push_back(filters.sample(t_s));
  }
  draw(experiment, samples);

  const auto of_G = [](const Sample& sample) { return sample.G_state; };
  const auto of_L = [](const Sample& sample) { return sample.L_state; };
  const int confident_G = num_confident_occupied(samples, of_G), confident_L = num_confident_occupied(samples, of_L);
  experiment.claim("scans in which G(v) is confident occupied", std::to_string(confident_G), confident_G == 0);
  experiment.claim("scans in which L(v) is confident occupied", std::to_string(confident_L), confident_L > 0);
  const double free_G_s = freed_after_s(samples, of_G), free_L_s = freed_after_s(samples, of_L);
  experiment.claim("confident free again after it left: G(v) sooner than L(v)",
                   fmt::format("{:.1f} s against {:.1f} s", free_G_s, free_L_s), free_G_s < free_L_s);
}

}  // namespace swiftlet::tools
