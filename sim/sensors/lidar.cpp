// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/lidar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "sim/sensors/lidar_echoes.hpp"
#include "sim/sensors/lidar_external_pose.hpp"
#include "sim/sensors/lidar_faults.hpp"
#include "sim/sensors/lidar_tiles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/parallel/crew.hpp"
#include "swiftlet/sim/parallel/first_exception.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

void LidarConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "sensors",
          "preset: os1_128, os0_128, mid360, puck_lite, each also as NAME_sheet: noise of the data sheet, no faults; "
          "os1_128_uniform and os0_128_uniform as in the simulator of the papers");
  visit_common(v);
  v.field("rate_hz", rate_hz, "[Hz] sweeps per second", Range::between(0.1, 1000));
  v.field("rolling", rolling, "[-] whether each beam fires at its own time; false: the whole sweep at one instant");
  v.field("ideal", ideal, "[-] ideal sensor: no noise, no lost returns, thin beams, true poses");
  v.field("self_mask", self_mask, "[-] whether returns of beams that can intersect the own vehicle are removed");
  v.field("range_min_m", range_min_m, "[m] minimum range; returns that are measured closer are lost",
          Range::non_negative());
  v.field("range_max_m", range_max_m, "[m] largest range; surfaces farther away return nothing", Range::positive());
  v.object("mount", mount, "mounting on the vehicle");
  v.object("mount_error", mount_error, "error of the mounting: true pose relative to that known to the agent");
  v.module("pattern", pattern, lidar_pattern_types(), "directions and times of the beams");
  v.object("noise", noise, "noise of the measured range");
  v.object("detection", detection, "detection of returns by the receiver");
  v.object("beam", beam, "width of the beam");
  v.object("faults", faults, "lost shots, outliers, resolution, near returns");
  v.object("external_pose", external_pose, "pose of an external localization, delivered with each scan");
  v.check(range_max_m > range_min_m, "range_max_m", "more than range_min_m");
}

namespace {

/// [tiles] Number of tiles that a thread traces at a time. Smaller values synchronize more often, larger ones
/// distribute the work less evenly.
constexpr int kTilesAtATime = 32;
/// [beams] Number of beams whose random numbers a thread draws at a time.
constexpr int kBeamsAtATime = 4096;

/// Arc cosine [rad] for arguments from 0 to 1, with an error below 2e-7: Abramowitz and Stegun 4.4.46.
float arc_cosine(float x) {
  float p = -0.0012624911F;
  p = p * x + 0.0066700901F;
  p = p * x - 0.0170881256F;
  p = p * x + 0.0308918810F;
  p = p * x - 0.0501743046F;
  p = p * x + 0.0889789874F;
  p = p * x - 0.2145988016F;
  p = p * x + 1.5707963050F;
  return std::sqrt(std::max(1.0F - x, 0.0F)) * p;
}

/// Scan whose memory is reused. Patterns that do not repeat need a beam table for each scan.
struct PooledScan : LabeledScan {
  std::shared_ptr<BeamTable> own_beams;
};

class Lidar final : public Sensor {
 public:
  Lidar(const LidarConfig& config, SensorSetup setup);

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override;
  std::span<const std::shared_ptr<LabeledScan>> scans() const override { return completed_; }
  bool makes_scan_by(TimeNs now) const override { return schedule_.is_due(now); }
  int begin_sweep(TimeNs now, const StateHistory& truth) override;
  void trace_part(int part) override;
  int heading_of_part(int part) const override;
  double look_back_s() const override { return 1.0 / config_.rate_hz; }

 private:
  std::shared_ptr<PooledScan> take_from_pool();
  void resize(LabeledScan& scan) const;
  std::vector<Firing> firings_of(const BeamTable& beams) const;
  void make_tiles(BeamTable& beams);
  void make_tile(BeamTable& beams, LidarTile& tile) const;
  std::shared_ptr<PooledScan> sweep(TimeNs stamp, std::uint32_t index, const StateHistory& truth);
  void prepare(TimeNs stamp, std::uint32_t index, const StateHistory& truth, PooledScan& out);

  void measure_tile(const LidarTile& tile, std::uint32_t index, LabeledScan& out) const;

  LidarConfig config_;
  Pose T_body_lidar_;       // as calibrated
  Pose true_T_body_lidar_;  // with the mounting error
  Schedule schedule_;
  TimeNs duration_;  // duration of a sweep; 0: all beams fire at the same time
  std::unique_ptr<LidarPattern> pattern_;
  LidarMeasurement measurement_;
  SweepScene scene_;
  EchoTracer tracer_;
  ExternalPoses external_poses_;
  Random range_random_, detection_random_;
  std::shared_ptr<BeamTable> beams_;  // beams of a repeating pattern, otherwise of the first sweep
  LidarFaults faults_;
  LidarTiler tiler_;
  std::vector<LidarTile> tiles_;
  std::vector<float> range_normals_;  // (beams), standard normal range errors in the current sweep
  std::vector<std::shared_ptr<PooledScan>> pool_;
  std::vector<std::shared_ptr<LabeledScan>> completed_;
  std::shared_ptr<PooledScan> begun_;  // started by begin_sweep(), delivered by measure()
  int tiles_of_part_ = 1;              // number of tiles that one trace_part() traces
};

std::shared_ptr<const StaticScene> world_or_empty(const SensorSetup& setup) {
  return setup.world ? setup.world : std::make_shared<const StaticScene>(Scene{});
}

std::vector<SurfaceLookUp> surfaces_of(const SweepScene& scene, const SensorSetup& setup) {
  std::vector<SurfaceLookUp> surfaces;
  for (const SweepSurface& surface : scene.surfaces()) {
    const bool is_static = surface.vehicle == kNoVehicle;
    static const std::vector<Material> kNone;
    const std::vector<Material>& materials = !is_static    ? setup.vehicle_shapes[surface.vehicle]->materials
                                             : setup.scene ? setup.scene->materials
                                                           : kNone;
    const Material material = surface.material < materials.size() ? materials[surface.material] : Material{};
    surfaces.push_back({material.reflectivity, material.retroreflective, static_cast<std::uint8_t>(surface.part),
                        static_cast<std::uint16_t>(surface.surface_class), surface.instance});
  }
  if (surfaces.empty()) surfaces.emplace_back();  // beams that hit nothing refer to surface 0
  return surfaces;
}

std::shared_ptr<BeamTable> first_sweep_of(const LidarPattern& pattern) {
  auto beams = std::make_shared<BeamTable>();
  pattern.fill(0, *beams);
  return beams;
}

Lidar::Lidar(const LidarConfig& config, SensorSetup setup)
    : Sensor(std::move(setup)),
      config_(config),
      T_body_lidar_(config.mount.place_on(*setup_.vehicle_shapes.at(setup_.vehicle), config.pattern)),
      true_T_body_lidar_(config.mount_error.applied_to(T_body_lidar_)),
      schedule_(config.rate_hz, from_seconds(1.0 / config.rate_hz)),
      duration_(config.rolling ? schedule_.period() : 0),
      pattern_(make_lidar_pattern(config.pattern, 1.0 / config.rate_hz)),
      measurement_(config.noise, config.detection, config.range_max_m, config.ideal),
      scene_(world_or_empty(setup_), setup_.vehicle_shapes, setup_.vehicle, true_T_body_lidar_, config.range_max_m),
      tracer_(config, scene_, surfaces_of(scene_, setup_)),
      external_poses_(config.external_pose, config.ideal, setup_.seed, setup_.entity),
      range_random_(stream("lidar.range")),
      detection_random_(stream("lidar.detection")),
      beams_(first_sweep_of(*pattern_)),
      faults_(config.faults, config.ideal, setup_.seed, setup_.entity, beams_->size()) {
  const std::vector<Firing> firings = firings_of(*beams_);
  scene_.set_firings(firings, pattern_->is_image());
  tiler_ = LidarTiler(*pattern_, *beams_, firings.size() == static_cast<std::size_t>(beams_->cols));
  make_tiles(*beams_);
  // In a scattered pattern, beams are about a degree apart, so consecutive tiles have little cached data in common. In
  // parts of one tile each, they can be traced in order of direction together with the tiles of other sensors.
  tiles_of_part_ = pattern_->is_image() ? kTilesAtATime : 1;
  range_normals_.resize(beams_->size());
}

// One firing per column if all beams of a column have the same origin and time, otherwise one per beam.
std::vector<Firing> Lidar::firings_of(const BeamTable& beams) const {
  bool by_column = beams.row_offset_s.empty();
  for (int i = 0; i < beams.size() && by_column; ++i) {
    by_column = beams.origins_lidar[i] == beams.origins_lidar[i % beams.cols];
  }
  std::vector<Firing> firings;
  for (int i = 0; i < (by_column ? beams.cols : beams.size()); ++i) {
    firings.push_back({static_cast<float>(beams.offset_s(i)), beams.origins_lidar[i]});
  }
  return firings;
}

// Groups neighboring beams into packets and marks beams that can intersect the own vehicle.
void Lidar::make_tiles(BeamTable& beams) {
  tiler_.arrange(beams, tiles_);
  beams.masked.resize(beams.size());
  parallel_for(static_cast<int>(tiles_.size()), kTilesAtATime, [&](int t) { make_tile(beams, tiles_[t]); });
}

void Lidar::make_tile(BeamTable& beams, LidarTile& tile) const {
  tiler_.load(beams, tile);
  const std::uint32_t reaches_self = tracer_.reaches_self(tile.beams);
  tile.meets_self = reaches_self != 0;
  for (int i = 0; i < kPacketSize; ++i) {
    if (tile.beam[i] >= 0) beams.masked[tile.beam[i]] = (reaches_self >> i) & 1U;
  }
}

void Lidar::measure(TimeNs now, const StateHistory& truth, Observation& out) {
  completed_.clear();
  TimeNs due = 0;
  std::uint32_t index = 0;
  while (schedule_.next(now, due, index)) {
    std::shared_ptr<PooledScan> scan = begun_ ? std::move(begun_) : sweep(due - duration_, index, truth);
    begun_.reset();
    faults_.add_near_returns(index, setup_.vehicle, static_cast<float>(config_.range_min_m), *scan);
    out.scans.push_back(std::shared_ptr<const Scan>(scan, &scan->scan));
    completed_.push_back(std::move(scan));
  }
}

int Lidar::begin_sweep(TimeNs now, const StateHistory& truth) {
  if (begun_ || !schedule_.is_due(now)) return 0;
  begun_ = take_from_pool();
  prepare(schedule_.due() - duration_, schedule_.index(), truth, *begun_);
  return (static_cast<int>(tiles_.size()) + tiles_of_part_ - 1) / tiles_of_part_;
}

void Lidar::trace_part(int part) {
  const int end = std::min((part + 1) * tiles_of_part_, static_cast<int>(tiles_.size()));
  for (int t = part * tiles_of_part_; t < end; ++t) measure_tile(tiles_[t], schedule_.index(), *begun_);
}

int Lidar::heading_of_part(int part) const {
  const BeamPacket& beams = tiles_[static_cast<std::size_t>(part) * tiles_of_part_].beams;
  const Vector3 direction_lidar(beams.direction_x[0], beams.direction_y[0], beams.direction_z[0]);
  return direction_cell((scene_.T_world_lidar(beams.firing[0]).linear() * direction_lidar).cast<float>());
}

// A scan of the pool that no consumer holds any more, or a new one.
std::shared_ptr<PooledScan> Lidar::take_from_pool() {
  for (const auto& scan : pool_) {
    if (scan.use_count() == 1) return scan;
  }
  auto scan = std::make_shared<PooledScan>();
  resize(*scan);
  scan->scan.beams = beams_;
  pool_.push_back(scan);
  return scan;
}

void Lidar::resize(LabeledScan& labeled) const {
  const std::size_t size = beams_->size();
  Scan& scan = labeled.scan;
  scan.sensor = setup_.name;
  scan.duration = duration_;
  scan.T_body_lidar = T_body_lidar_;
  labeled.truth.T_body_lidar = true_T_body_lidar_;
  scan.range_max_m = config_.range_max_m;
  scan.sigma_range_m = config_.ideal ? 0.0 : config_.noise.sigma_range_m;
  scan.range_m.resize(size);
  scan.intensity.resize(size);
  scan.reflectivity.resize(size);
  labeled.truth.range_m.resize(size);
  labeled.truth.incidence_rad.resize(size);
  labeled.truth.surface_class.resize(size);
  labeled.truth.instance.resize(size);
  labeled.truth.part.resize(size);
  labeled.truth.T_world_lidar.resize(duration_ == 0 ? 1 : beams_->cols);
}

std::shared_ptr<PooledScan> Lidar::sweep(TimeNs stamp, std::uint32_t index, const StateHistory& truth) {
  std::shared_ptr<PooledScan> scan = take_from_pool();
  prepare(stamp, index, truth, *scan);
  parallel_for(static_cast<int>(tiles_.size()), kTilesAtATime, [&](int t) { measure_tile(tiles_[t], index, *scan); });
  return scan;
}

// Prepares a sweep for tracing: beams, poses of the sensor, external poses and random numbers.
void Lidar::prepare(TimeNs stamp, std::uint32_t index, const StateHistory& truth, PooledScan& out) {
  out.scan.stamp = stamp;
  if (!pattern_->repeats()) {
    // A consumer may hold the beam table after it has released the scan.
    out.scan.beams.reset();
    if (!out.own_beams || out.own_beams.use_count() > 1) out.own_beams = std::make_shared<BeamTable>();
    pattern_->fill(index, *out.own_beams);
    make_tiles(*out.own_beams);
    out.scan.beams = out.own_beams;
  }
  scene_.begin(truth, stamp, duration_);
  external_poses_.append_poses(truth, setup_.vehicle, true_T_body_lidar_, stamp, duration_, index,
                               out.scan.external_poses);

  // Each random number is a function of sweep and beam, so it does not depend on the distribution over threads.
  const int size = static_cast<int>(range_normals_.size());
  parallel_for((size + kBeamsAtATime - 1) / kBeamsAtATime, 1, [&](int chunk) {
    const int first = chunk * kBeamsAtATime;
    const std::size_t count = std::min(kBeamsAtATime, size - first);
    const std::span normals = std::span(range_normals_).subspan(first, count);
    range_random_.fill_normal(index, first, normals);
    faults_.draw(index, first, normals);
  });
  for (std::size_t c = 0; c < out.truth.T_world_lidar.size(); ++c) {
    out.truth.T_world_lidar[c] = scene_.T_world_lidar(static_cast<int>(c));
  }
}

// ---- one tile ----

void Lidar::measure_tile(const LidarTile& tile, std::uint32_t index, LabeledScan& out) const {
  // Prefetches the range errors for use after the tracing: those of a tile are a row of the scan apart in memory.
  for (const int beam : tile.beam) __builtin_prefetch(&range_normals_[std::max(beam, 0)]);
  Echoes echoes;
  tracer_.trace(tile, echoes);
  if (const auto factors = faults_.reflectivity_factors(); !factors.empty()) {
    for (int i = 0; i < kPacketSize; ++i) echoes.brightness[i] *= factors[std::max(tile.beam[i], 0)];
  }
  std::array<float, kPacketSize> incidence_rad;
  for (int i = 0; i < kPacketSize; ++i) incidence_rad[i] = arc_cosine(echoes.cos_incidence[i]);

  const auto range_min = static_cast<float>(config_.range_min_m);
  const auto range_max = static_cast<float>(config_.range_max_m);
  for (int i = 0; i < kPacketSize; ++i) {
    const int beam = tile.beam[i];
    if (beam < 0) continue;
    const float range = echoes.range_m[i];
    const bool hit = range > 0.0F;
    const SurfaceLookUp& surface = tracer_.surface(echoes.surface[i]);
    out.truth.range_m[beam] = range;
    out.truth.incidence_rad[beam] = hit ? incidence_rad[i] : 0.0F;
    out.truth.surface_class[beam] = hit ? surface.surface_class : 0;
    out.truth.instance[beam] = hit ? surface.instance : 0;
    out.truth.part[beam] = hit ? surface.part : 0;

    const float brightness = echoes.brightness[i];
    float sigma = 0.0F, gain = 0.0F;
    measurement_.look_up(range, echoes.cos_incidence[i], brightness, sigma, gain);
    const float measured = std::min(range + sigma * range_normals_[beam], range_max);
    // Range limits apply to the measured range, not to the true one.
    const bool detected =
        hit && measured >= range_min && measured > 0.0F &&
        measurement_.detected(brightness * gain, [&] { return detection_random_.normal(index, beam); });
    // The intensity falls with the square of the range. The sensor corrects this in the reflectivity by its measured
    // range.
    const float true_ratio = kIntensityRange_m / (hit ? range : 1.0F);
    const float intensity = brightness * true_ratio * true_ratio;
    const float measured_ratio = measured / kIntensityRange_m;
    out.scan.range_m[beam] = detected ? measured : 0.0F;
    out.scan.intensity[beam] = detected ? intensity : 0.0F;
    out.scan.reflectivity[beam] = detected ? intensity * measured_ratio * measured_ratio : 0.0F;
  }
  if (faults_.has_range_step()) {
    for (const int beam : tile.beam) {
      if (beam >= 0) out.scan.range_m[beam] = faults_.rounded_m(out.scan.range_m[beam]);
    }
  }
  if (config_.self_mask && tile.meets_self) {
    const BeamTable& beams = *out.scan.beams;
    for (const int beam : tile.beam) {
      if (beam < 0 || beams.masked[beam] == 0) continue;
      out.scan.range_m[beam] = out.scan.intensity[beam] = out.scan.reflectivity[beam] = 0.0F;
    }
  }
}

}  // namespace

std::unique_ptr<Sensor> make_lidar(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<Lidar>(dynamic_cast<const LidarConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
