// SPDX-License-Identifier: BSD-3-Clause
// A custom detector, scored by the simulator: small isolated clusters above the ground are flying objects.
#include <cstdio>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/detection/euclidean_clusters.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/world/empty.hpp"

namespace {

using namespace swiftlet;

struct HoveringConfig : ModuleConfigOf<HoveringConfig> {
  double least_height_m = 1.0;
  double greatest_extent_m = 1.5;
  double tolerance_m = 0.6;
  int least_points = 3;

  void visit(ConfigVisitor& v) override {
    v.field("least_height_m", least_height_m, "[m] points below this height are attributed to the ground");
    v.field("greatest_extent_m", greatest_extent_m, "[m] larger clusters are rejected", Range::positive());
    v.field("tolerance_m", tolerance_m, "[m] largest distance between neighboring points of a cluster",
            Range::positive());
    v.field("least_points", least_points, "[-] smaller clusters are rejected as noise", Range::between(1, 1000));
  }
};

class HoveringDetector : public Detector {
 public:
  explicit HoveringDetector(const HoveringConfig& config) : config_(config) {}

  /// A cloud is a scan transformed to the local frame, each beam at its own instant.
  void step(const DetectorInput& input, DetectorOutput& output, Outbox&) override {
    for (const auto& cloud : input.clouds) {
      const FrameChange to_world = FrameChange::to_world(input.estimate);
      points_.clear();
      for (const Eigen::Vector3f& p_local_m : cloud->points_local_m) {
        if (to_world.point(p_local_m.cast<double>()).z() > config_.least_height_m) points_.push_back(p_local_m);
      }
      clusters_.compute(points_, config_.tolerance_m);
      for (int i = 0; i < clusters_.size(); ++i) add_if_small(clusters_.members(i), *cloud, output);
      output.has_detections = true;  // also when the list is empty
      output.stamp = cloud->stamp();
    }
  }

 private:
  void add_if_small(std::span<const std::uint32_t> members, const LocalCloud& cloud, DetectorOutput& output) const {
    Eigen::AlignedBox3f box;
    for (const std::uint32_t member : members) box.extend(points_[member]);
    const int count = static_cast<int>(members.size());
    if (count < config_.least_points || box.sizes().maxCoeff() > config_.greatest_extent_m) return;
    Detection& found = output.detections.emplace_back();
    found.t = (cloud.stamp() + cloud.end()) / 2;
    found.position_m = box.center().cast<double>();
    found.covariance = 0.04 * Matrix3::Identity();
    found.extent_m = box.sizes().cast<double>();
    found.num_points = count;
    found.confidence = 1.0;
  }

  HoveringConfig config_;
  EuclideanClusters clusters_;
  std::vector<Eigen::Vector3f> points_;
};

std::unique_ptr<Detector> make_hovering(const ModuleConfig& config, const AgentSetup&) {
  return std::make_unique<HoveringDetector>(dynamic_cast<const HoveringConfig&>(config));
}

/// Requests scores of its detections against the truth.
void request_detection_scores(const ModuleConfig&, AgentNeeds& needs) { needs.detects = true; }

}  // namespace

int main() {
  detector_registry().add({{"hovering", "small clusters of points in the air", make_module_config<HoveringConfig>},
                           make_hovering,
                           request_detection_scores});

  sim::Scenario scenario;
  scenario.duration_s = 3.0;
  scenario.world = Module(sim::world_module_types(), "empty");
  scenario.world.as<sim::EmptyConfig>().ground = true;
  scenario.vehicles.resize(2);
  scenario.vehicles[0].start.position_m = {0.0, 0.0, 4.0};
  scenario.vehicles[0].sensors.emplace_back(sim::sensor_module_types(), "lidar");
  scenario.vehicles[0].agent.as<StackConfig>().detector = Module(detector_module_types(), "hovering");
  scenario.vehicles[1].start.position_m = {7.0, 3.0, 4.5};

  sim::Simulation simulation(sim::validated(scenario));
  while (!simulation.finished()) simulation.tick();
  const sim::MetricTable metrics = simulation.summary().metrics;
  const double recall = metrics.find("detection_recall", "uav1")->value;
  const double false_per_min = metrics.find("false_detections_per_min", "uav1")->value;
  const double error_m = metrics.find("detection_error_mean_m", "uav1")->value;
  std::printf("hovering: recall %.2f, %.1f false detections a minute, %.2f m off\n", recall, false_per_min, error_m);
  return recall > 0.9 && false_per_min == 0.0 && error_m < 0.3 ? 0 : 1;
}
