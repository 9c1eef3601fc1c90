// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mappers/sparse_mapper.hpp"

#include "core/mappers/vehicles_around.hpp"

namespace swiftlet {
namespace {

class SparseMapper : public Mapper {
 public:
  explicit SparseMapper(const SparseMapperConfig& config)
      : config_(config), map_(config.map), vehicles_(config.tracked_radius_m) {}

  void step(const MapperInput& input, Outbox&) override {
    vehicles_.update(input);
    for (const auto& cloud : input.clouds) {
      take_rays(*cloud);
      map_.insert(rays_, cloud->end());
      map_.keep_around(input.estimate.T_local_body.translation());
    }
    map_.set_time(input.observation.t);
  }

  const OccupancyView& map() const override { return map_; }

  void append_counters(std::vector<Counter>& counters) const override {
    counters.push_back({"returns farther than the map takes them", num_far_, num_returns_, "range_max_m"});
  }

 private:
  void take_rays(const LocalCloud& cloud) {
    const Scan& scan = *cloud.scan;
    rays_.clear();
    returned_.assign(static_cast<std::size_t>(scan.size()), false);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const int beam = static_cast<int>(cloud.beam[i]);
      returned_[beam] = true;
      if (vehicles_.contains(cloud.points_local_m[i], cloud.time_of(i))) continue;
      const Eigen::Vector3f origin = cloud.T_local_lidar_of_beam(beam).translation().cast<float>();
      const float range_m = (cloud.points_local_m[i] - origin).norm();
      if (range_m < config_.range_min_m) continue;
      ++num_returns_;
      if (range_m > config_.range_max_m) {
        ++num_far_;
        continue;
      }
      rays_.push_back({origin, cloud.points_local_m[i], true});
    }
    // Beams without return clear the air along them; the own body's beams have a return or a mask.
    const auto far_m = static_cast<float>(config_.map.clear_range_m);
    for (int beam = 0; beam < scan.size(); ++beam) {
      if (returned_[beam] || scan.hit(beam)) continue;
      if (!scan.beams->masked.empty() && scan.beams->masked[beam] != 0) continue;
      const Pose& T = cloud.T_local_lidar_of_beam(beam);
      const Vector3 direction = T.linear() * scan.beams->directions_lidar[beam].cast<double>();
      const Eigen::Vector3f origin = T.translation().cast<float>();
      rays_.push_back({origin, origin + far_m * direction.cast<float>(), false});
    }
  }

  SparseMapperConfig config_;
  SparseVoxelMap map_;
  VehiclesAround vehicles_;
  std::vector<SparseVoxelMap::Ray> rays_;
  std::vector<bool> returned_;  // per beam
  std::uint64_t num_returns_ = 0, num_far_ = 0;
};

}  // namespace

void SparseMapperConfig::visit(ConfigVisitor& v) {
  v.field("range_min_m", range_min_m, "[m] nearer returns are the own body (the thesis: 1 m)", Range::non_negative());
  v.field("range_max_m", range_max_m, "[m] farther returns are not used", Range{0.0, 1000.0, true});
  v.field("tracked_radius_m", tracked_radius_m,
          "[m] returns within this distance of another vehicle are left out, and farther ones with its uncertainty; 0: "
          "none",
          Range::non_negative());
  map.visit(v);
}

std::unique_ptr<Mapper> make_sparse_mapper(const ModuleConfig& config, const AgentSetup&) {
  return std::make_unique<SparseMapper>(dynamic_cast<const SparseMapperConfig&>(config));
}

}  // namespace swiftlet
