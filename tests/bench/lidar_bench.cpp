// SPDX-License-Identifier: BSD-3-Clause
// One LiDAR scan of a forest of about a million triangles with four moving vehicles, compared with the bare cost of the
// same rays in two ray tracers: Embree (packets of 16 in the tiles of the sensor, coherent where possible, in the
// two-level scene that its manual suggests) and Bullet's rayTest. One thread, processor time.
#include <benchmark/benchmark.h>
#include <btBulletCollisionCommon.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "sim/raycast/exact_hits_internal.hpp"
#include "sim/sensors/lidar_tiles.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/bench/processor_time.hpp"
#include "tests/support/sensor_driver.hpp"

namespace swiftlet::sim {
namespace {

constexpr int kVehicles = 5;  // the sensor's and four others
constexpr TimeNs kSweep = 100'000'000;
constexpr TimeNs kStep = 1'000'000;
constexpr double kHeight_m = 4.0;

// The sensor flies a curve at 5 m/s; the others circle around it at 4 to 10 m.
VehicleState state_of(int vehicle, TimeNs t) {
  const double s = to_seconds(t);
  VehicleState state;
  state.t = t;
  const double radius = vehicle == 0 ? 3.0 : 2.0 + 2.0 * vehicle;
  const double phase = 5.0 / radius * s + 1.7 * vehicle;
  state.p_world_m = Vector3(radius * std::cos(phase), radius * std::sin(phase), kHeight_m + 0.3 * vehicle);
  state.v_world_mps = Vector3(-5.0 * std::sin(phase), 5.0 * std::cos(phase), 0.0);
  state.q_world_body = Eigen::AngleAxisd(phase, Vector3::UnitZ()) * Eigen::AngleAxisd(0.1, Vector3::UnitY());
  state.rotor_speed_radps.fill(500.0);
  for (int r = 0; r < 4; ++r) state.rotor_angle_rad[r] = (r % 2 == 0 ? 500.0 : -500.0) * s;
  return state;
}

/// The world of all benchmarks, built once.
struct Stage {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const StaticScene> world;
  std::shared_ptr<const VehicleShape> shape = quadrotor_shape();

  Stage() {
    ForestConfig forest;
    forest.size_m = {70.0, 70.0};
    forest.surroundings_m = 0.0;
    forest.detail = 0.5;
    scene = std::make_shared<const Scene>(make_forest(forest, 1));
    world = std::make_shared<const StaticScene>(*scene);
  }

  SensorSetup setup() const {
    SensorSetup setup = sensor_setup("lidar", 1, kVehicles, world);
    setup.scene = scene;
    setup.vehicle_shapes.assign(kVehicles, shape);
    return setup;
  }
};

const Stage& stage() {
  static const Stage stage;
  return stage;
}

LidarConfig os1_config() { return {}; }  // the defaults are an OS1-128 with 1024 columns

LidarConfig mid360_config() {
  LidarConfig config;
  config.pattern = Module(lidar_pattern_types(), "livox_mid360");
  config.range_min_m = 0.1;
  config.range_max_m = 70.0;
  config.detection.range_80_percent_m = 70.0;
  return config;
}

// ---- the complete scan
// ------------------------------------------------------------------------------------------------

/// Endless sequence of sweeps.
class CompleteScan {
 public:
  explicit CompleteScan(const LidarConfig& config) : lidar_(make_lidar(config, stage().setup())) {
    for (int warm_up = 0; warm_up < 3; ++warm_up) {
      fly();
      scan();
    }
  }

  /// The vehicles' motion during the next sweep; not timed.
  void fly() {
    for (const TimeNs end = now_ + kSweep; now_ < end;) {
      now_ += kStep;
      for (int v = 0; v < kVehicles; ++v) history_.push(v, state_of(v, now_));
    }
  }
  void scan() {
    observation_.clear();
    lidar_->measure(now_, history_, observation_);
  }

 private:
  std::unique_ptr<Sensor> lidar_;
  Observation observation_;
  StateHistory history_{kVehicles, 200};
  TimeNs now_ = -kStep;
};

// ---- the same rays, bare
// ----------------------------------------------------------------------------------------------

/// The rays of the sweep [0, 100 ms] in tiles of 16, as the sensor traces them.
std::vector<Rays> rays_of(const LidarConfig& config) {
  const auto pattern = make_lidar_pattern(config.pattern, 0.1);
  BeamTable beams;
  pattern->fill(0, beams);
  LidarTiler tiler(*pattern, beams, true);
  std::vector<LidarTile> tiles;
  tiler.arrange(beams, tiles);
  std::vector<Rays> rays(tiles.size());
  const Pose T_body_lidar = config.mount.T_body_lidar();
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    tiler.load(beams, tiles[t]);
    for (int i = 0; i < kPacketSize; ++i) {
      const int beam = std::max(tiles[t].beam[i], 0);
      const Pose T_world_lidar = state_of(0, from_seconds(beams.offset_s(beam))).T_world_body() * T_body_lidar;
      const Vector3 origin = T_world_lidar * beams.origins_lidar[beam].cast<double>();
      const Vector3 direction = T_world_lidar.linear() * beams.directions_lidar[beam].cast<double>();
      rays[t].set(i, origin.cast<float>(), direction.cast<float>());
    }
  }
  return rays;
}

/// Nearest hits of a packet in Embree alone.
RTCRayHit16 hits_of(const Rays& rays, RTCScene scene, float range_max_m, bool coherent) {
  alignas(64) static constexpr std::array<int, kPacketSize> kAll = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                                    -1, -1, -1, -1, -1, -1, -1, -1};
  EmbreeQuery options;
  options.coherent = coherent;
  RTCRayHit16 query;
  std::copy_n(rays.origin_x.data(), kPacketSize, query.ray.org_x);
  std::copy_n(rays.origin_y.data(), kPacketSize, query.ray.org_y);
  std::copy_n(rays.origin_z.data(), kPacketSize, query.ray.org_z);
  std::copy_n(rays.direction_x.data(), kPacketSize, query.ray.dir_x);
  std::copy_n(rays.direction_y.data(), kPacketSize, query.ray.dir_y);
  std::copy_n(rays.direction_z.data(), kPacketSize, query.ray.dir_z);
  for (int i = 0; i < kPacketSize; ++i) {
    query.ray.tnear[i] = query.ray.time[i] = 0.0F;
    query.ray.tfar[i] = range_max_m;
    query.ray.mask[i] = ~0U;
    query.ray.id[i] = query.ray.flags[i] = 0;
    query.hit.geomID[i] = query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  intersect(kAll.data(), scene, options, query);
  return query;
}

/// Lower bound with Embree: prepared packets of rays, no processing of hits, vehicles as frozen instances.
class BareEmbree {
 public:
  explicit BareEmbree(const LidarConfig& config) {
    const auto& impl = stage().world->impl();
    RTCDevice device = impl.device.get();
    scene_.reset(rtcNewScene(device));
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    add_instance(device, impl.world.scene.get(), Pose::Identity());
    // Without the own vehicle, whose plates would stop the beams near the sensor and make them cheaper.
    for (int v = 1; v < kVehicles; ++v) {
      bodies_.push_back(impl.body_of(stage().shape, true));
      add_instance(device, bodies_.back()->triangles.scene.get(), state_of(v, kSweep / 2).T_world_body());
    }
    rtcCommitScene(scene_.get());
    rays_ = rays_of(config);
    range_max_m_ = static_cast<float>(config.range_max_m);
    coherent_ = make_lidar_pattern(config.pattern, 0.1)->is_image();
  }

  float scan() const {
    float sum = 0.0F;
    for (const Rays& rays : rays_) {
      const RTCRayHit16 query = hits_of(rays, scene_.get(), range_max_m_, coherent_);
      for (int i = 0; i < kPacketSize; ++i) sum += query.ray.tfar[i];
    }
    return sum;
  }

 private:
  void add_instance(RTCDevice device, RTCScene of, const Pose& pose) {
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, of);
    const Eigen::Matrix4f matrix = pose.matrix().cast<float>();
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, matrix.data());
    rtcCommitGeometry(instance);
    rtcAttachGeometry(scene_.get(), instance);
    rtcReleaseGeometry(instance);
  }

  std::vector<std::shared_ptr<const VehicleBody>> bodies_;
  EmbreeScene scene_;
  std::vector<Rays> rays_;
  float range_max_m_ = 0.0F;
  bool coherent_ = true;
};

/// Cost of equal bits: the static world by exact hits and by Embree alone, with unmodified triangles. Both return
/// range, incidence and surface.
class EqualBits {
 public:
  explicit EqualBits(const LidarConfig& config) : range_max_m_(static_cast<float>(config.range_max_m)) {
    const auto& impl = stage().world->impl();
    world_ = &impl.world;
    RTCDevice device = impl.device.get();
    plain_.reset(rtcNewScene(device));
    rtcSetSceneFlags(plain_.get(), RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const std::size_t num_corners = 3 * world_->size();
    auto* corners = static_cast<Eigen::Vector3f*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Eigen::Vector3f), num_corners));
    for (std::size_t i = 0; i < num_corners; ++i) corners[i] = world_->corners_m[i / 3][i % 3];
    auto* numbers = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), world_->size()));
    std::iota(numbers, numbers + num_corners, 0U);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(plain_.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(plain_.get());
    surfaces_.reserve(world_->size());
    for (const Facet& facet : world_->facets) surfaces_.push_back(facet.surface);
    rays_ = rays_of(config);
  }

  float by_rule() const {
    std::array<float, kPacketSize> range_max_m;
    range_max_m.fill(range_max_m_);
    float sum = 0.0F;
    for (const Rays& rays : rays_) {
      ExactQuery query(*world_);
      query.set_rays(rays, range_max_m);
      query.trace_together();
      for (int i = 0; i < kPacketSize; ++i) {
        if (query.met(i)) sum += query.range_m(i) + query.cos_incidence(i) + static_cast<float>(query.surface(i));
      }
    }
    return sum;
  }

  float plain() const {
    float sum = 0.0F;
    for (const Rays& rays : rays_) {
      const RTCRayHit16 query = hits_of(rays, plain_.get(), range_max_m_, true);
      for (int i = 0; i < kPacketSize; ++i) {
        if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        const Eigen::Vector3f normal(query.hit.Ng_x[i], query.hit.Ng_y[i], query.hit.Ng_z[i]);
        const Eigen::Vector3f direction(query.ray.dir_x[i], query.ray.dir_y[i], query.ray.dir_z[i]);
        sum += query.ray.tfar[i] + std::abs(normal.dot(direction)) / normal.norm() +
               static_cast<float>(surfaces_[query.hit.primID[i]]);
      }
    }
    return sum;
  }

 private:
  const TriangleScene* world_;
  EmbreeScene plain_;
  std::vector<std::uint32_t> surfaces_;
  std::vector<Rays> rays_;
  float range_max_m_;
};

/// The static world in Bullet: a BVH of the same triangles, quantized as Bullet does by default.
class BareBullet {
 public:
  explicit BareBullet(const LidarConfig& config) : range_max_m_(config.range_max_m), rays_(rays_of(config)) {
    const auto& triangles = stage().world->impl().world.corners_m;
    for (const auto& of_triangle : triangles)
      corners_m_.insert(corners_m_.end(), of_triangle.begin(), of_triangle.end());
    corner_numbers_.resize(corners_m_.size());
    std::iota(corner_numbers_.begin(), corner_numbers_.end(), 0);
    btIndexedMesh mesh;
    mesh.m_numTriangles = static_cast<int>(triangles.size());
    mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(corner_numbers_.data());
    mesh.m_triangleIndexStride = 3 * sizeof(int);
    mesh.m_numVertices = static_cast<int>(corners_m_.size());
    mesh.m_vertexBase = reinterpret_cast<const unsigned char*>(corners_m_.data());
    mesh.m_vertexStride = sizeof(corners_m_[0]);
    mesh.m_vertexType = PHY_FLOAT;
    mesh_.addIndexedMesh(mesh);
    shape_ = std::make_unique<btBvhTriangleMeshShape>(&mesh_, true);
    object_.setCollisionShape(shape_.get());
    world_.addCollisionObject(&object_);
  }

  double scan() const {
    double sum = 0.0;
    for (const Rays& rays : rays_) {
      for (int i = 0; i < kPacketSize; ++i) {
        const btVector3 from(rays.origin_x[i], rays.origin_y[i], rays.origin_z[i]);
        const btVector3 to =
            from + range_max_m_ * btVector3(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]);
        btCollisionWorld::ClosestRayResultCallback result(from, to);
        world_.rayTest(from, to, result);
        sum += result.m_closestHitFraction * range_max_m_;
      }
    }
    return sum;
  }

 private:
  double range_max_m_;
  std::vector<Rays> rays_;
  std::vector<Eigen::Vector3f> corners_m_;
  std::vector<int> corner_numbers_;
  btTriangleIndexVertexArray mesh_;
  std::unique_ptr<btBvhTriangleMeshShape> shape_;
  btCollisionObject object_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  mutable btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
};

// ---- rows of the table
// ------------------------------------------------------------------------------------------------

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// Runs alternate, so that other load on the machine affects all alike.
void ratios(benchmark::State& state, const LidarConfig& config, bool with_bullet) {
  CompleteScan complete(config);
  const BareEmbree embree(config);
  const auto bullet = with_bullet ? std::make_unique<BareBullet>(config) : nullptr;
  std::vector<double> complete_s, embree_s, bullet_s;
  for (auto _ : state) {
    for (int i = 0; i < 25; ++i) {
      embree_s.push_back(time_of_s([&] { benchmark::DoNotOptimize(embree.scan()); }));
      complete.fly();
      complete_s.push_back(time_of_s([&] { complete.scan(); }));
      if (bullet && i % 8 == 0) bullet_s.push_back(time_of_s([&] { benchmark::DoNotOptimize(bullet->scan()); }));
    }
  }
  state.counters["complete_ms"] = 1e3 * median(complete_s);
  state.counters["embree_ms"] = 1e3 * median(embree_s);
  state.counters["complete/embree"] = median(complete_s) / median(embree_s);
  if (!bullet) return;
  state.counters["bullet_ms"] = 1e3 * median(bullet_s);
  state.counters["bullet/complete"] = median(bullet_s) / median(complete_s);
}

// One core: the ratios compare work, not parallelism.
const bool kOneThread = (omp_set_num_threads(1), true);

// Share of a scan's time spent on equal bits, compared with the same scan by Embree alone.
void equal_bits_os1(benchmark::State& state) {
  CompleteScan complete(os1_config());
  const EqualBits world(os1_config());
  std::vector<double> complete_s, by_rule_s, plain_s;
  for (auto _ : state) {
    for (int i = 0; i < 25; ++i) {
      plain_s.push_back(time_of_s([&] { benchmark::DoNotOptimize(world.plain()); }));
      by_rule_s.push_back(time_of_s([&] { benchmark::DoNotOptimize(world.by_rule()); }));
      complete.fly();
      complete_s.push_back(time_of_s([&] { complete.scan(); }));
    }
  }
  const double price_s = median(by_rule_s) - median(plain_s);
  state.counters["complete_ms"] = 1e3 * median(complete_s);
  state.counters["by_rule_ms"] = 1e3 * median(by_rule_s);
  state.counters["plain_ms"] = 1e3 * median(plain_s);
  state.counters["price/plain scan"] = price_s / (median(complete_s) - price_s);
}

BENCHMARK(equal_bits_os1)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(ratios, mid360, mid360_config(), false)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(ratios, os1, os1_config(), true)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace swiftlet::sim
