// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/ground_truth.hpp"

#include <algorithm>

#include "swiftlet/core/math/latency.hpp"

namespace swiftlet {
namespace {

class GroundTruthDetector : public Detector {
 public:
  explicit GroundTruthDetector(const GroundTruthDetectorConfig& config) : config_(config), latency_(config.latency_s) {}

  void step(const DetectorInput& input, DetectorOutput& output, Outbox&) override {
    for (const NeighborSample& sample : input.observation.neighbors) {
      if (sample.p_body_m.norm() <= config_.range_max_m) waiting_.push_back(detection_of(sample, input.poses));
    }
    const auto due_end = std::stable_partition(waiting_.begin(), waiting_.end(),
                                               [&](const Detection& d) { return latency_.is_over(d.t, input.t); });
    if (due_end == waiting_.begin()) return;
    output.has_detections = true;
    output.stamp = (due_end - 1)->t;
    output.detections.insert(output.detections.end(), waiting_.begin(), due_end);
    waiting_.erase(waiting_.begin(), due_end);
  }

 private:
  Detection detection_of(const NeighborSample& sample, const LocalPoses& poses) const {
    const Pose T_local_body = poses.at(sample.t);
    const Matrix3 R = T_local_body.linear();
    Detection d;
    d.t = sample.t;
    d.position_m = T_local_body * sample.p_body_m;
    d.covariance = R * sample.covariance_body * R.transpose() + config_.sigma_m * config_.sigma_m * Matrix3::Identity();
    d.confidence = 1.0;
    return d;
  }

  GroundTruthDetectorConfig config_;
  Latency latency_;
  std::vector<Detection> waiting_;
};

}  // namespace

void GroundTruthDetectorConfig::visit(ConfigVisitor& v) {
  v.field("range_max_m", range_max_m, "[m] range beyond which objects are not detected", Range::positive());
  v.field("sigma_m", sigma_m, "[m] standard deviation reported in addition to the sensor's own", Range::non_negative());
  v.field("latency_s", latency_s, "[s] delay from the measurement to the detection", Range::non_negative());
}

std::unique_ptr<Detector> make_ground_truth_detector(const ModuleConfig& config, const AgentSetup&) {
  return std::make_unique<GroundTruthDetector>(dynamic_cast<const GroundTruthDetectorConfig&>(config));
}

}  // namespace swiftlet
