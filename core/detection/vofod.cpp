// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/vofod.hpp"

#include <algorithm>

#include "core/detection/vofod_overlays.hpp"
#include "core/detection/vofod_stages.hpp"
#include "swiftlet/core/math/latency.hpp"

namespace swiftlet {
namespace {

using Cloud = std::shared_ptr<const LocalCloud>;

class VofodDetector : public Detector {
 public:
  VofodDetector(const VofodConfig& config, const AgentSetup& setup)
      : config_(config),
        stages_(config),
        classification_(config.timing.classification_latency_s),
        raycasting_(config.timing.raycasting_latency_s),
        separation_(config.timing.separation_latency_s),
        separation_period_(from_seconds(config.timing.separation_period_s)) {
    if (setup.prior_map == nullptr) return;
    stages_.map().set_prior(*setup.prior_map);
    prior_counters_ = setup.prior_map->counters;
  }

  void step(const DetectorInput& input, DetectorOutput& output, Outbox&) override {
    stages_.map().follow(input.estimate.T_local_body.translation());
    seed(input);
    for (const Cloud& cloud : input.clouds) {
      if (!config_.sensor.empty() && cloud->scan->sensor != config_.sensor) continue;
      ++num_sweeps_;
      if (waiting_ != nullptr) ++num_sweeps_passed_over_;
      waiting_ = cloud;
    }
    // A step that is due ends before the next one begins. A step without latency ends in the same tick.
    end_classification(input.t, output);
    begin_classification(input.t);
    end_classification(input.t, output);
    end_raycasting(input.t);
    end_separation(input.t);
    begin_separation(input.t);
    end_separation(input.t);
  }

  const VoxelMap* map() const override { return &stages_.map(); }
  void append_overlays(std::vector<Overlay>& overlays) const override {
    append_vofod_overlays(stages_, config_.search_distance_m, newest_, overlays);
  }
  void append_counters(std::vector<Counter>& counters) const override {
    counters.push_back({"sweeps skipped because the previous one was still being classified", num_sweeps_passed_over_,
                        num_sweeps_, "timing.classification_latency_s"});
    counters.push_back(
        {"returns outside the detector's map", stages_.num_points_outside(), stages_.num_points(), "map.size_m"});
    counters.push_back({"voxels of the prior outside the map", stages_.map().num_prior_outside(),
                        stages_.map().num_prior(), "map.size_m"});
    counters.insert(counters.end(), prior_counters_.begin(), prior_counters_.end());
  }

 private:
  void seed(const DetectorInput& input) {
    if (config_.seed != VofodSeed::kAltimeter && config_.seed != VofodSeed::kLargeAndAltimeter) return;
    for (const AltimeterSample& sample : input.observation.altimeter) {
      stages_.seed_ground(input.estimate.T_local_body.translation() - sample.height_m * Vector3::UnitZ());
    }
  }

  void begin_classification(TimeNs t) {
    if (!classification_.idle() || waiting_ == nullptr) return;
    classified_ = std::move(waiting_);
    waiting_ = nullptr;
    classification_.start(t);
    if (raycasting_.idle()) {
      stages_.cast_rays(*classified_);
      raycasting_.start(t);
      classifications_in_raycasting_ = 0;
    }
  }

  void end_classification(TimeNs t, DetectorOutput& output) {
    if (!classification_.due(t)) return;
    classification_.stop();
    stages_.classify(*classified_, output.detections);
    output.has_detections = true;
    output.stamp = classified_->stamp();
    newest_ = output.detections;
    classified_ = nullptr;
    ++classifications_in_raycasting_;
    ++classifications_in_separation_;
  }

  // Ray casting takes effect only after at least one classification, so that rays do not outweigh its points.
  void end_raycasting(TimeNs t) {
    if (!raycasting_.due(t) || classifications_in_raycasting_ == 0) return;
    raycasting_.stop();
    stages_.apply_rays(classifications_in_raycasting_);
  }

  void begin_separation(TimeNs t) {
    if (!separation_.idle() || t < next_separation_) return;
    separation_.start(t);
    next_separation_ = t + separation_period_;
    stages_.find_separate();
  }

  void end_separation(TimeNs t) {
    if (!separation_.due(t)) return;
    separation_.stop();
    stages_.remove_separate(std::max(classifications_in_separation_, 1));
    classifications_in_separation_ = 0;
  }

  VofodConfig config_;
  VofodStages stages_;
  Worker classification_, raycasting_, separation_;
  TimeNs separation_period_;
  TimeNs next_separation_ = 0;
  Cloud waiting_, classified_;
  int classifications_in_raycasting_ = 0, classifications_in_separation_ = 0;
  std::vector<Detection> newest_;  // shown in overlays
  std::uint64_t num_sweeps_ = 0, num_sweeps_passed_over_ = 0;
  std::vector<Counter> prior_counters_;
};

}  // namespace

std::unique_ptr<Detector> make_vofod_detector(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<VofodDetector>(dynamic_cast<const VofodConfig&>(config), setup);
}

}  // namespace swiftlet
