// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/lidar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/sensors/lidar_external_pose.hpp"
#include "sim/sensors/lidar_tiles.hpp"
#include "sim/sensors/noise.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/parallel/crew.hpp"
#include "swiftlet/sim/parallel/first_exception.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

void LidarConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "sensors", "preset: os1_128, os0_128, mid360, puck_lite, os1_128_uniform, os0_128_uniform");
  visit_name(v);
  v.field("rate_hz", rate_hz, "[Hz] sweeps per second", Range::between(0.1, 1000));
  v.field("rolling", rolling, "[-] every beam at its own time; false: the whole sweep in one instant");
  v.field("ideal", ideal, "[-] no noise, no lost returns, thin beams, true poses");
  v.field("self_mask", self_mask, "[-] remove returns of beams that can intersect the own vehicle");
  v.field("range_min_m", range_min_m, "[m] least measured range", Range::non_negative());
  v.field("range_max_m", range_max_m, "[m] greatest measured range", Range::positive());
  v.object("mount", mount, "mounting on the vehicle");
  v.module("pattern", pattern, lidar_pattern_types(), "where and when it fires");
  v.object("noise", noise, "noise of the range");
  v.object("detection", detection, "detection of returns by the receiver");
  v.object("beam", beam, "width of the beam");
  v.object("external_pose", external_pose, "pose of an external localization, delivered with each scan");
  v.check(range_max_m > range_min_m, "range_max_m", "more than range_min_m");
}

namespace {

constexpr float kIntensityRange_m = 10.0F;  // Scan::intensity is 1 for a white wall at this range
constexpr int kMaxSubRays = 9;
constexpr int kTilesAtATime = 32;  // per thread

/// Properties of a surface for the measurement, besides its truth labels.
struct SurfaceLookUp {
  float reflectivity = 0.0F;
  bool retroreflective = false;
  std::uint8_t part = 0;
  std::uint16_t surface_class = 0;
  std::uint16_t instance = 0;
};

/// One echo per beam of a packet. The brightness is reflectivity * cos(incidence), summed over the beam's
/// cross-section.
struct alignas(64) Echoes {
  std::array<float, kPacketSize> range_m;  // 0: none
  std::array<float, kPacketSize> cos_incidence;
  std::array<float, kPacketSize> brightness;
  std::array<std::uint32_t, kPacketSize> surface;
};

/// A sample of the beam's cross-section, in standard deviations of its Gaussian profile.
struct SubRay {
  float across, up, weight;
};

// Cubature of a plane Gaussian: 5 points exact to degree 3 (and 4 on the axes), 9 points of the Gauss-Hermite product.
std::vector<SubRay> sub_rays(int count) {
  const float a = std::sqrt(3.0F);
  std::vector<SubRay> rays = {{0, 0, 1}};
  if (count == 5) rays = {{0, 0, 1.0F / 3}, {a, 0, 1.0F / 6}, {-a, 0, 1.0F / 6}, {0, a, 1.0F / 6}, {0, -a, 1.0F / 6}};
  if (count == 9) {
    rays.clear();
    for (const int i : {0, 1, -1}) {
      for (const int j : {0, 1, -1}) {
        rays.push_back({i * a, j * a, (i == 0 ? 2.0F / 3 : 1.0F / 6) * (j == 0 ? 2.0F / 3 : 1.0F / 6)});
      }
    }
  }
  return rays;
}

// Beams rotated by small angles: `across` to the left, `up` upwards.
BeamPacket turned(const BeamPacket& beams, float across_rad, float up_rad) {
  BeamPacket out = beams;
  for (int i = 0; i < kPacketSize; ++i) {
    const float x = beams.direction_x[i], y = beams.direction_y[i], z = beams.direction_z[i];
    const float level = std::sqrt(x * x + y * y);
    // Left is horizontal; for vertical beams any horizontal direction serves.
    const float left_x = level > 1e-6F ? -y / level : 0.0F;
    const float left_y = level > 1e-6F ? x / level : 1.0F;
    const float up_x = -z * left_y, up_y = z * left_x, up_z = x * left_y - y * left_x;
    const float dx = x + across_rad * left_x + up_rad * up_x;
    const float dy = y + across_rad * left_y + up_rad * up_y;
    const float dz = z + up_rad * up_z;
    const float scale = 1.0F / std::sqrt(dx * dx + dy * dy + dz * dz);
    out.direction_x[i] = scale * dx;
    out.direction_y[i] = scale * dy;
    out.direction_z[i] = scale * dz;
  }
  return out;
}

// Arc cosine of 0..1, error below 2e-7 in single precision: Abramowitz and Stegun 4.4.46.
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

/// A pooled scan; patterns that do not repeat need a beam table per scan.
struct PooledScan : LabeledScan {
  std::shared_ptr<BeamTable> own_beams;
};

class Lidar final : public Sensor {
 public:
  Lidar(const LidarConfig& config, SensorSetup setup);

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override;
  std::span<const std::shared_ptr<const LabeledScan>> scans() const override { return completed_; }
  bool makes_scan_by(TimeNs now) const override { return schedule_.is_due(now); }
  int begin_sweep(TimeNs now, const StateHistory& truth) override;
  void trace_part(int part) override;
  int heading_of_part(int part) const override;
  double look_back_s() const override { return 1.0 / config_.rate_hz; }

 private:
  std::shared_ptr<PooledScan> take_from_pool();
  void resize(LabeledScan& scan) const;
  void look_up_surfaces();
  std::vector<Firing> firings_of(const BeamTable& beams) const;
  void make_tiles(BeamTable& beams);
  void make_tile(BeamTable& beams, LidarTile& tile) const;
  std::shared_ptr<PooledScan> sweep(TimeNs stamp, std::uint32_t index, const StateHistory& truth);
  void prepare(TimeNs stamp, std::uint32_t index, const StateHistory& truth, PooledScan& out);

  void measure_tile(const LidarTile& tile, std::uint32_t index, LabeledScan& out) const;
  void trace_thin(const LidarTile& tile, Echoes& echoes) const;
  void trace_wide(const LidarTile& tile, Echoes& echoes) const;
  float brightness(std::uint32_t surface, float cos_incidence) const;

  LidarConfig config_;
  Pose T_body_lidar_;
  Schedule schedule_;
  TimeNs duration_;  // duration of a sweep; 0: frozen
  std::unique_ptr<LidarPattern> pattern_;
  LidarMeasurement measurement_;
  std::vector<SubRay> sub_rays_;
  float sub_ray_sigma_rad_ = 0.0F;
  SweepScene scene_;
  ExternalPoses external_poses_;
  Random range_random_, detection_random_;
  std::vector<SurfaceLookUp> surfaces_;  // indexed by surface number of SweepScene
  std::shared_ptr<BeamTable> beams_;     // beams of a repeating pattern, otherwise of the first sweep
  LidarTiler tiler_;
  std::vector<LidarTile> tiles_;
  std::vector<float> range_normals_;  // (beams), of the current sweep
  std::vector<std::shared_ptr<PooledScan>> pool_;
  std::vector<std::shared_ptr<const LabeledScan>> completed_;
  std::shared_ptr<PooledScan> begun_;  // started by begin_sweep(), delivered by measure()
  int tiles_of_part_ = 1;
};

std::shared_ptr<const StaticScene> world_or_nothing(const SensorSetup& setup) {
  return setup.world ? setup.world : std::make_shared<const StaticScene>(Scene{});
}

Lidar::Lidar(const LidarConfig& config, SensorSetup setup)
    : Sensor(std::move(setup)),
      config_(config),
      T_body_lidar_(config.mount.place_on(*setup_.vehicle_shapes.at(setup_.vehicle), config.pattern)),
      schedule_(config.rate_hz, from_seconds(1.0 / config.rate_hz)),
      duration_(config.rolling ? schedule_.period() : 0),
      pattern_(make_lidar_pattern(config.pattern, 1.0 / config.rate_hz)),
      measurement_(config.noise, config.detection, config.range_max_m, config.ideal),
      sub_rays_(sub_rays(config.ideal ? 1 : config.beam.sub_rays)),
      // FWHM of a Gaussian = 2 sqrt(2 ln 2) sigma.
      sub_ray_sigma_rad_(static_cast<float>(config.beam.divergence_deg * kRadPerDeg / 2.354820045)),
      scene_(world_or_nothing(setup_), setup_.vehicle_shapes, setup_.vehicle, T_body_lidar_, config.range_max_m),
      external_poses_(config.external_pose, config.ideal, setup_.seed, setup_.entity),
      range_random_(stream("lidar.range")),
      detection_random_(stream("lidar.detection")),
      beams_(std::make_shared<BeamTable>()) {
  look_up_surfaces();
  pattern_->fill(0, *beams_);
  const std::vector<Firing> firings = firings_of(*beams_);
  scene_.set_firings(firings, pattern_->is_image());
  tiler_ = LidarTiler(*pattern_, *beams_, firings.size() == static_cast<std::size_t>(beams_->cols));
  make_tiles(*beams_);
  // Scattered shots about a degree apart share little data in the caches with their neighbors, so small parts allow a
  // better order.
  tiles_of_part_ = pattern_->is_image() ? kTilesAtATime : 1;
  range_normals_.resize(beams_->size());
}

void Lidar::look_up_surfaces() {
  for (const SweepSurface& surface : scene_.surfaces()) {
    const bool is_static = surface.vehicle == kNoVehicle;
    static const std::vector<Material> kNone;
    const std::vector<Material>& materials = !is_static     ? setup_.vehicle_shapes[surface.vehicle]->materials
                                             : setup_.scene ? setup_.scene->materials
                                                            : kNone;
    const Material material = surface.material < materials.size() ? materials[surface.material] : Material{};
    surfaces_.push_back({material.reflectivity, material.retroreflective, static_cast<std::uint8_t>(surface.part),
                         static_cast<std::uint16_t>(surface.surface_class), surface.instance});
  }
  if (surfaces_.empty()) surfaces_.emplace_back();  // lanes without a hit refer to number 0
}

// One firing per column where all its beams share origin and time, otherwise one per beam.
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
  std::uint32_t reaches_self = 0;
  for (const SubRay& ray : sub_rays_) {
    const bool is_axis = ray.across == 0.0F && ray.up == 0.0F;
    reaches_self |= scene_.reaches_self(
        is_axis ? tile.beams : turned(tile.beams, ray.across * sub_ray_sigma_rad_, ray.up * sub_ray_sigma_rad_));
  }
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

// A pooled scan without other references, or a new one.
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

// All steps of a sweep except the tracing.
void Lidar::prepare(TimeNs stamp, std::uint32_t index, const StateHistory& truth, PooledScan& out) {
  out.scan.stamp = stamp;
  if (!pattern_->repeats()) {
    // The table may still be referenced without the scan.
    out.scan.beams.reset();
    if (!out.own_beams || out.own_beams.use_count() > 1) out.own_beams = std::make_shared<BeamTable>();
    pattern_->fill(index, *out.own_beams);
    make_tiles(*out.own_beams);
    out.scan.beams = out.own_beams;
  }
  scene_.begin(truth, stamp, duration_);
  external_poses_.append_poses(truth, setup_.vehicle, T_body_lidar_, stamp, duration_, index, out.scan.external_poses);

  // Each number is a function of (sweep, beam), so it does not depend on the distribution over threads.
  constexpr int kChunk = 4096;
  const int size = static_cast<int>(range_normals_.size());
  parallel_for((size + kChunk - 1) / kChunk, 1, [&](int chunk) {
    const int first = chunk * kChunk;
    const std::size_t count = std::min(kChunk, size - first);
    range_random_.fill_normal(index, first, std::span(range_normals_).subspan(first, count));
  });
  for (std::size_t c = 0; c < out.truth.T_world_lidar.size(); ++c) {
    out.truth.T_world_lidar[c] = scene_.T_world_lidar(static_cast<int>(c));
  }
}

// ---- one tile ----

void Lidar::measure_tile(const LidarTile& tile, std::uint32_t index, LabeledScan& out) const {
  // Prefetches the noise values, which lie a row apart, for use after the tracing.
  for (const int beam : tile.beam) __builtin_prefetch(&range_normals_[std::max(beam, 0)]);
  Echoes echoes;
  sub_rays_.size() == 1 ? trace_thin(tile, echoes) : trace_wide(tile, echoes);
  std::array<float, kPacketSize> incidence_rad;
  for (int i = 0; i < kPacketSize; ++i) incidence_rad[i] = arc_cosine(echoes.cos_incidence[i]);

  const auto range_min = static_cast<float>(config_.range_min_m);
  const auto range_max = static_cast<float>(config_.range_max_m);
  for (int i = 0; i < kPacketSize; ++i) {
    const int beam = tile.beam[i];
    if (beam < 0) continue;
    const float range = echoes.range_m[i];
    const bool met = range > 0.0F;
    const SurfaceLookUp& surface = surfaces_[echoes.surface[i]];
    out.truth.range_m[beam] = range;
    out.truth.incidence_rad[beam] = met ? incidence_rad[i] : 0.0F;
    out.truth.surface_class[beam] = met ? surface.surface_class : 0;
    out.truth.instance[beam] = met ? surface.instance : 0;
    out.truth.part[beam] = met ? surface.part : 0;

    const float brightness = echoes.brightness[i];
    float sigma = 0.0F, gain = 0.0F;
    measurement_.look_up(range, echoes.cos_incidence[i], brightness, sigma, gain);
    const float measured = std::min(range + sigma * range_normals_[beam], range_max);
    // Range limits apply to the measured range, not to the true one.
    const bool detected =
        met && measured >= range_min && measured > 0.0F &&
        measurement_.detected(brightness * gain, [&] { return detection_random_.normal(index, beam); });
    const float toward_10_m = kIntensityRange_m / (met ? range : 1.0F);
    const float intensity = brightness * toward_10_m * toward_10_m;
    const float corrected = measured / kIntensityRange_m;
    out.scan.range_m[beam] = detected ? measured : 0.0F;
    out.scan.intensity[beam] = detected ? intensity : 0.0F;
    out.scan.reflectivity[beam] = detected ? intensity * corrected * corrected : 0.0F;
  }
  if (config_.self_mask && tile.meets_self) {
    const BeamTable& beams = *out.scan.beams;
    for (const int beam : tile.beam) {
      if (beam < 0 || beams.masked[beam] == 0) continue;
      out.scan.range_m[beam] = out.scan.intensity[beam] = out.scan.reflectivity[beam] = 0.0F;
    }
  }
}

float Lidar::brightness(std::uint32_t surface, float cos_incidence) const {
  const SurfaceLookUp& s = surfaces_[surface];
  return s.retroreflective ? s.reflectivity * static_cast<float>(config_.detection.retro_gain)
                           : s.reflectivity * cos_incidence;
}

void Lidar::trace_thin(const LidarTile& tile, Echoes& echoes) const {
  PacketHits hits;
  scene_.trace(tile.beams, tile.meets_self, hits);
  echoes.range_m = hits.range_m;
  echoes.cos_incidence = hits.cos_incidence;
  echoes.surface = hits.surface;
  for (int i = 0; i < kPacketSize; ++i) echoes.brightness[i] = brightness(hits.surface[i], hits.cos_incidence[i]);
}

// Echoes of sub-rays within one pulse length merge into one; the strongest merged echo is returned.
void Lidar::trace_wide(const LidarTile& tile, Echoes& echoes) const {
  const int count = static_cast<int>(sub_rays_.size());
  std::array<PacketHits, kMaxSubRays> hits;
  for (int k = 0; k < count; ++k) {
    const SubRay& ray = sub_rays_[k];
    scene_.trace(turned(tile.beams, ray.across * sub_ray_sigma_rad_, ray.up * sub_ray_sigma_rad_), tile.meets_self,
                 hits[k]);
  }
  const auto pulse_m = static_cast<float>(config_.beam.pulse_length_m);
  for (int i = 0; i < kPacketSize; ++i) {
    std::array<float, kMaxSubRays> bright{}, power{};
    for (int k = 0; k < count; ++k) {
      const float range = hits[k].range_m[i];
      if (range <= 0.0F) continue;
      bright[k] = sub_rays_[k].weight * brightness(hits[k].surface[i], hits[k].cos_incidence[i]);
      power[k] = bright[k] / (range * range) + std::numeric_limits<float>::min();  // > 0: the sub-ray meets a surface
    }
    echoes.range_m[i] = echoes.cos_incidence[i] = echoes.brightness[i] = 0.0F;
    echoes.surface[i] = 0;
    float strongest = 0.0F;
    for (int first = 0; first < count; ++first) {
      if (power[first] == 0.0F) continue;
      float sum_power = 0.0F, sum_range = 0.0F, sum_bright = 0.0F;
      int brightest = first;
      for (int k = 0; k < count; ++k) {
        const float behind = hits[k].range_m[i] - hits[first].range_m[i];
        if (power[k] == 0.0F || behind < 0.0F || behind > pulse_m) continue;
        sum_power += power[k];
        sum_range += power[k] * behind;
        sum_bright += bright[k];
        if (power[k] > power[brightest]) brightest = k;
      }
      if (sum_power <= strongest) continue;
      strongest = sum_power;
      echoes.range_m[i] = hits[first].range_m[i] + sum_range / sum_power;
      echoes.brightness[i] = sum_bright;
      echoes.cos_incidence[i] = hits[brightest].cos_incidence[i];
      echoes.surface[i] = hits[brightest].surface[i];
    }
  }
}

}  // namespace

std::unique_ptr<Sensor> make_lidar(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<Lidar>(dynamic_cast<const LidarConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
