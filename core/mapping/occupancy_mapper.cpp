// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mapping/occupancy_mapper.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

constexpr double kShown_m = 15.0;  // cells of an overlay

class OccupancyMapper : public Mapper {
 public:
  explicit OccupancyMapper(const OccupancyMapperConfig& config) : config_(config), map_(config.map) {}

  void step(const MapperInput& input, Outbox&) override {
    for (const auto& cloud : input.clouds) {
      take_rays(*cloud, input.tracks);
      p_local_m_ = input.estimate.T_local_body.translation();
      map_.keep_around(p_local_m_);
      map_.insert(rays_, cloud->end());
    }
  }

  const OccupancyView& map() const override { return map_; }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    Overlay cells;
    cells.name = "mapping.cells";
    cells.kind = Overlay::Kind::kCubes;
    cells.size_m = static_cast<float>(config_.map.edge_m);
    cells.colors = {{0.45F, 0.32F, 0.2F, 1.0F}};
    std::vector<Vector3> centers_local_m;
    map_.occupied_within(p_local_m_, kShown_m, kEver, centers_local_m);
    cells.positions.reserve(centers_local_m.size());
    for (const Vector3& center_local_m : centers_local_m) cells.positions.push_back(center_local_m.cast<float>());
    overlays.push_back(std::move(cells));
  }

 private:
  bool chosen(int beam, int cols) const {
    return beam % cols % config_.every_column == 0 && beam / cols % config_.every_row == 0;
  }

  void take_rays(const LocalCloud& cloud, std::span<const Track> tracks) {
    const Scan& scan = *cloud.scan;
    rays_.clear();
    returned_.assign(static_cast<std::size_t>(scan.size()), false);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const int beam = static_cast<int>(cloud.beam[i]);
      returned_[beam] = true;
      if (!chosen(beam, scan.cols()) || is_tracked(cloud, i, tracks)) continue;
      const Eigen::Vector3f origin_local_m = cloud.T_local_lidar_of_beam(beam).translation().cast<float>();
      if ((cloud.points_local_m[i] - origin_local_m).norm() < config_.range_min_m) continue;
      rays_.push_back({origin_local_m, cloud.points_local_m[i], true});
    }
    if (config_.clear_range_m > 0.0) take_rays_without_return(cloud);
  }

  // Beams without return tell that nothing is near; the own body's beams have a return or a mask.
  void take_rays_without_return(const LocalCloud& cloud) {
    const Scan& scan = *cloud.scan;
    const auto far_m = static_cast<float>(config_.clear_range_m);
    for (int beam = 0; beam < scan.size(); ++beam) {
      if (!chosen(beam, scan.cols()) || returned_[beam] || scan.hit(beam)) continue;
      if (!scan.beams->masked.empty() && scan.beams->masked[beam] != 0) continue;
      const Pose& T = cloud.T_local_lidar_of_beam(beam);
      const Vector3 direction = T.linear() * scan.beams->directions_lidar[beam].cast<double>();
      const Eigen::Vector3f origin_local_m = T.translation().cast<float>();
      rays_.push_back({origin_local_m, origin_local_m + far_m * direction.cast<float>(), false});
    }
  }

  /// Does the point lie near where a tracked vehicle was when it was measured?
  bool is_tracked(const LocalCloud& cloud, std::size_t point, std::span<const Track> tracks) const {
    if (tracks.empty()) return false;
    const TimeNs t = cloud.time_of(point);
    const Vector3 p_local_m = cloud.points_local_m[point].cast<double>();
    return std::any_of(tracks.begin(), tracks.end(), [&](const Track& track) {
      const Vector3 then_local_m = track.position_m + to_seconds(t - track.t) * track.velocity_mps;
      return (p_local_m - then_local_m).squaredNorm() < config_.tracked_radius_m * config_.tracked_radius_m;
    });
  }

  OccupancyMapperConfig config_;
  OccupancyMap map_;
  Vector3 p_local_m_ = Vector3::Zero();
  std::vector<OccupancyMap::Ray> rays_;
  std::vector<bool> returned_;  // by beam
};

}  // namespace

void OccupancyMapperConfig::visit(ConfigVisitor& v) {
  v.field("every_column", every_column, "[-] of the columns of a scan one in so many is used (the paper: 4)",
          Range::between(1, 10000));
  v.field("every_row", every_row, "[-] of its rows one in so many", Range::between(1, 10000));
  v.field("range_min_m", range_min_m, "[m] nearer returns are the own body", Range::non_negative());
  v.field("clear_range_m", clear_range_m, "[m] beams without return clear up to here; 0: they tell nothing",
          Range::between(0.0, 1000.0));
  v.field("tracked_radius_m", tracked_radius_m, "[m] returns nearer than this to a tracked vehicle are left out",
          Range::non_negative());
  map.visit(v);
  v.check(clear_range_m <= map.range_max_m, "clear_range_m", "at most range_max_m");
}

std::unique_ptr<Mapper> make_occupancy_mapper(const ModuleConfig& config, const AgentSetup&) {
  return std::make_unique<OccupancyMapper>(dynamic_cast<const OccupancyMapperConfig&>(config));
}

}  // namespace swiftlet
