// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/track_before_detect.hpp"

#include "core/detection/detection_spheres.hpp"
#include "core/detection/hypotheses.hpp"
#include "swiftlet/core/math/latency.hpp"

namespace swiftlet {
namespace {

class TrackBeforeDetect : public Detector {
 public:
  explicit TrackBeforeDetect(const TrackBeforeDetectConfig& config)
      : sensor_(config.sensor), hypotheses_(config), worker_(config.latency_s) {}

  void step(const DetectorInput& input, DetectorOutput& output, Outbox&) override {
    for (const auto& cloud : input.clouds) {
      if (!sensor_.empty() && cloud->scan->sensor != sensor_) continue;
      ++num_sweeps_;
      if (waiting_ != nullptr) ++num_sweeps_passed_over_;
      waiting_ = cloud;
    }
    // A step that is due ends before the next one begins. A step without latency ends in the same tick.
    end(input.t, output);
    begin(input.t);
    end(input.t, output);
  }

  std::span<const Track> tracks() const override { return tracks_; }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    Overlay tracked = detection_spheres();
    for (const Track& track : tracks_) tracked.positions.push_back(track.position_m.cast<float>());
    overlays.push_back(std::move(tracked));
  }

  void append_counters(std::vector<Counter>& counters) const override {
    const Counter passed_over = {"sweeps skipped because the previous one was still being processed",
                                 num_sweeps_passed_over_, num_sweeps_, "latency_s"};
    counters.push_back(passed_over);
    hypotheses_.append_counters(counters);
  }

 private:
  void begin(TimeNs t) {
    if (!worker_.idle() || waiting_ == nullptr) return;
    taken_ = std::move(waiting_);
    waiting_ = nullptr;
    worker_.start(t);
  }

  void end(TimeNs t, DetectorOutput& output) {
    if (!worker_.due(t)) return;
    worker_.stop();
    hypotheses_.take(*taken_);
    hypotheses_.append_reported(output.detections);
    tracks_.clear();
    hypotheses_.append_reported(tracks_);
    output.has_detections = true;
    output.stamp = taken_->stamp();
    taken_ = nullptr;
  }

  std::string sensor_;
  Hypotheses hypotheses_;
  Worker worker_;
  std::shared_ptr<const LocalCloud> waiting_, taken_;
  std::vector<Track> tracks_;
  std::uint64_t num_sweeps_ = 0, num_sweeps_passed_over_ = 0;
};

}  // namespace

std::unique_ptr<Detector> make_track_before_detect(const ModuleConfig& config, const AgentSetup&) {
  return std::make_unique<TrackBeforeDetect>(dynamic_cast<const TrackBeforeDetectConfig&>(config));
}

}  // namespace swiftlet
