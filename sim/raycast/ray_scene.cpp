// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/raycast/ray_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/raycast/embree_internal.hpp"
#include "sim/raycast/embree_scene.hpp"
#include "sim/raycast/exact_hits_internal.hpp"
#include "sim/raycast/waving_foliage.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {
namespace {

// [-] Maximum number of triangles of a scene; larger scenes are refused.
constexpr std::size_t kMaxTriangles = 1'000'000'000;
constexpr std::size_t kUsuallyNear = 1024;      // reserved triangles near a vehicle
constexpr std::size_t kMaxSurfaces = 1U << 24;  // limit of Facet::surface

// Equal (class, instance, material, part) share one surface number.
class SurfaceNumbers {
 public:
  explicit SurfaceNumbers(std::vector<Surface>& surfaces) : surfaces_(surfaces) {}

  std::uint32_t number_of(const Surface& s) {
    const std::uint64_t key = static_cast<std::uint64_t>(s.material) | (static_cast<std::uint64_t>(s.instance) << 32) |
                              (static_cast<std::uint64_t>(s.surface_class) << 48);
    const auto [it, is_new] = numbers_.try_emplace(std::pair(key, static_cast<std::uint64_t>(s.part)), 0);
    if (is_new) {
      if (surfaces_.size() == kMaxSurfaces) throw std::invalid_argument("world: expected at most 2^24 labeled things");
      it->second = static_cast<std::uint32_t>(surfaces_.size());
      surfaces_.push_back(s);
    }
    return it->second;
  }

 private:
  std::vector<Surface>& surfaces_;
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint32_t> numbers_;
};

void append(const Mesh& mesh, const Eigen::Affine3f& T_world_mesh, std::uint32_t surface, TriangleScene& out) {
  const Eigen::Matrix3f linear = T_world_mesh.linear();
  const Eigen::Vector3f translation = T_world_mesh.translation();
  std::vector<Eigen::Vector3f> vertices_mesh_m;
  vertices_mesh_m.reserve(mesh.vertices_mesh_m.size());
  for (const Eigen::Vector3f& v : mesh.vertices_mesh_m) vertices_mesh_m.push_back(linear * v + translation);
  for (const auto& t : mesh.triangles)
    out.corners_m.push_back({vertices_mesh_m[t[0]], vertices_mesh_m[t[1]], vertices_mesh_m[t[2]]});
  Facet facet{};
  facet.surface = surface;
  out.facets.resize(out.size(), facet);
}

// Flattens all instances: one large geometry is faster to build and to trace than instances of small ones.
/// @param first_triangle  output: index of the first triangle of each instance
TriangleScene flatten(const Scene& scene, std::vector<std::uint32_t>& first_triangle) {
  std::size_t num_triangles = 0;
  for (const Instance& instance : scene.instances) num_triangles += scene.meshes.at(instance.mesh).triangles.size();
  if (num_triangles > kMaxTriangles) {
    throw std::invalid_argument("world: expected at most 1e9 triangles, found " + std::to_string(num_triangles));
  }
  TriangleScene out;
  out.corners_m.reserve(num_triangles);
  out.facets.reserve(num_triangles);
  SurfaceNumbers numbers(out.surfaces);
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Surface surface = {mesh.material, mesh.surface_class, instance.instance, VehiclePart::kNone};
    first_triangle.push_back(static_cast<std::uint32_t>(out.size()));
    append(mesh, instance.T_world_mesh, numbers.number_of(surface), out);
  }
  return out;
}

EmbreeDevice make_device() {
  // Embree by default uses 4-wide trees where it assumes that wider registers reduce the clock rate (Xeons of the
  // Skylake family). 8-wide trees are a fifth faster there; on processors without AVX the option has no effect.
  // SWIFTLET_EMBREE overrides this, such as "isa=avx", for tests that results do not depend on it.
  const char* chosen = std::getenv("SWIFTLET_EMBREE");
  EmbreeDevice device(rtcNewDevice(chosen != nullptr ? chosen : "frequency_level=simd256"));
  if (device) return device;
  const RTCError error = rtcGetDeviceError(nullptr);
  throw std::runtime_error("cannot start the ray tracer: " + (error == RTC_ERROR_OUT_OF_MEMORY
                                                                  ? std::string("out of memory")
                                                                  : "error " + std::to_string(error)));
}

// Ericson, Real-Time Collision Detection (2005), sec. 5.1.5: closest point by the Voronoi regions of the triangle.
Vector3 closest_point_on_triangle(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vector3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vector3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double denominator = va + vb + vc;
  if (denominator <= 0) return a;  // degenerate: all three corners coincide
  return a + ab * (vb / denominator) + ac * (vc / denominator);
}

// Embree culls in single precision; the enlarged radius leaves the decision to the exact distances.
float query_radius(double radius_m) { return static_cast<float>(radius_m * (1.0 + 1e-6) + 1e-4); }

struct NearestQuery {
  const TriangleScene* world;
  Vector3 p;
  double best_sq;
  Vector3 best_point;
  std::uint32_t best_triangle = RTC_INVALID_GEOMETRY_ID;
};

bool visit_nearest(RTCPointQueryFunctionArguments* args) {
  auto& query = *static_cast<NearestQuery*>(args->userPtr);
  const auto& [a, b, c] = query.world->corners_m[args->primID];
  const Vector3 point = closest_point_on_triangle(query.p, a.cast<double>(), b.cast<double>(), c.cast<double>());
  const double distance_sq = (point - query.p).squaredNorm();
  // At equal distance the first triangle in the scene wins, independent of the order of visits.
  if (distance_sq > query.best_sq) return false;
  if (distance_sq == query.best_sq && args->primID > query.best_triangle) return false;
  query.best_sq = distance_sq;
  query.best_point = point;
  query.best_triangle = args->primID;
  args->query->radius = query_radius(std::sqrt(distance_sq));
  return true;
}

struct BoxQuery {
  const TriangleScene* world;
  Eigen::AlignedBox3f box;
  std::vector<std::uint32_t>* found;
};

bool visit_box(RTCPointQueryFunctionArguments* args) {
  const auto& query = *static_cast<const BoxQuery*>(args->userPtr);
  const auto& [a, b, c] = query.world->corners_m[args->primID];
  Eigen::AlignedBox3f bounds(a);
  bounds.extend(b).extend(c);
  if (query.box.intersects(bounds)) query.found->push_back(args->primID);
  return false;
}

RTCPointQuery point_query(const Vector3& p, float radius_m) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0.0F, radius_m};
}

}  // namespace

void ReleaseDevice::operator()(RTCDevice device) const { rtcReleaseDevice(device); }
void ReleaseScene::operator()(RTCScene scene) const { rtcReleaseScene(scene); }

namespace {

void check_tree(std::size_t num_triangles, RTCDevice device) {
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE) {
    throw std::runtime_error("cannot build the ray tracing structure of " + std::to_string(num_triangles) +
                             " triangles (error " + std::to_string(error) + ")");
  }
}

void commit_tree(RTCScene scene, RTCSceneFlags flags, RTCBuildQuality quality, std::size_t num_triangles,
                 RTCDevice device) {
  rtcSetSceneFlags(scene, flags | kFilterInArguments);
  rtcSetSceneBuildQuality(scene, quality);
  rtcCommitScene(scene);
  check_tree(num_triangles, device);
}

void attach_triangles(TriangleScene& triangles, RTCBuildQuality quality, RTCDevice device) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, triangles.enlarged_m.data(), 0,
                             sizeof(triangles.enlarged_m[0][0]), 3 * triangles.size());
  auto* corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
  if (corners != nullptr) std::iota(corners, corners + 3 * triangles.size(), 0U);
  rtcSetGeometryBuildQuality(geometry, quality);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(triangles.scene.get(), geometry);
  rtcReleaseGeometry(geometry);
}

}  // namespace

void TriangleScene::commit(RTCDevice device) {
  scene.reset(rtcNewScene(device));
  if (!corners_m.empty()) {
    prepare_for_exact_hits(*this);
    attach_triangles(*this, RTC_BUILD_QUALITY_MEDIUM, device);
  }
  // Robust: a ray that touches a box of the tree does not miss it.
  commit_tree(scene.get(), RTC_SCENE_FLAG_ROBUST, RTC_BUILD_QUALITY_MEDIUM, size(), device);
}

void TriangleScene::commit_to_move(RTCDevice device) {
  scene.reset(rtcNewScene(device));
  attach_triangles(*this, RTC_BUILD_QUALITY_REFIT, device);
  // Embree rebuilds scenes of medium quality instead of refitting them. Here LOW concerns only the top level of the
  // two-level tree: the geometry's own tree is built by the surface area heuristic, as RTC_BUILD_QUALITY_REFIT
  // requests.
  commit_tree(scene.get(), RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC, RTC_BUILD_QUALITY_LOW, size(), device);
}

void TriangleScene::refit() {
  RTCGeometry geometry = rtcGetGeometry(scene.get(), 0);
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene.get());
}

// Not robust: the margins of the triangles exceed the distance by which a ray may miss a box.
void TriangleScene::commit_for_scattered_rays(RTCDevice device) const {
  EmbreeScene tree(rtcNewScene(device));
  if (!corners_m.empty()) rtcAttachGeometry(tree.get(), rtcGetGeometry(scene.get(), 0));
  commit_tree(tree.get(), RTC_SCENE_FLAG_NONE, RTC_BUILD_QUALITY_MEDIUM, size(), device);
  for_scattered_rays = std::move(tree);
}

std::shared_ptr<const VehicleBody> StaticScene::Impl::body_of(const std::shared_ptr<const VehicleShape>& shape,
                                                              bool with_sensors) const {
  const std::scoped_lock lock(mutex_);
  CachedBody& cached = bodies_[{shape.get(), with_sensors}];
  if (!cached.shape.expired()) {
    if (auto body = cached.body.lock()) return body;
  }
  auto body = std::make_shared<VehicleBody>();
  SurfaceNumbers numbers(body->triangles.surfaces);
  for (const Mesh& mesh : shape->meshes) {
    if (mesh.part == VehiclePart::kSensor && !with_sensors) continue;
    const Surface surface = {mesh.material, SurfaceClass::kVehicle, 0, mesh.part};
    append(mesh, Eigen::Affine3f::Identity(), numbers.number_of(surface), body->triangles);
  }
  body->triangles.commit(device.get());
  cached = {shape, body};
  return body;
}

void StaticScene::Impl::expect_scattered_rays() const {
  const std::scoped_lock lock(mutex_);
  const TriangleScene& seen = foliage ? foliage->firm : world;
  if (!seen.for_scattered_rays) seen.commit_for_scattered_rays(device.get());
}

StaticScene::StaticScene(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  impl_->device = make_device();
  std::vector<std::uint32_t> first_triangle;
  impl_->world = flatten(scene, first_triangle);
  for (const auto& corners_m : impl_->world.corners_m) {
    for (const Eigen::Vector3f& corner : corners_m) {
      if (!corner.allFinite()) throw std::invalid_argument("world: a vertex is not a finite number");
    }
  }
  impl_->bounds_m = scene.bounds_m;
  impl_->world.commit(impl_->device.get());
  auto foliage = make_foliage(scene, impl_->world, first_triangle);
  if (foliage) foliage->firm.commit(impl_->device.get());
  impl_->foliage = std::move(foliage);
}

StaticScene::~StaticScene() = default;

std::size_t StaticScene::num_triangles() const { return impl_->world.size(); }

const Eigen::AlignedBox3d& StaticScene::bounds_m() const { return impl_->bounds_m; }

RayHit StaticScene::trace(const Vector3& origin_world, const Vector3& direction_world, double range_max_m) const {
  ExactQuery query(impl_->world);
  query.set_ray(0, origin_world.cast<float>(), direction_world.cast<float>(), range_max_m);
  query.trace_singly(1);
  if (!query.met(0)) return {};

  const Surface& surface = impl_->world.surfaces[query.surface(0)];
  RayHit hit;
  hit.range_m = query.range_m(0);
  hit.cos_incidence = query.cos_incidence(0);
  hit.material = surface.material;
  hit.surface_class = surface.surface_class;
  hit.instance = surface.instance;
  return hit;
}

bool StaticScene::occluded(const Vector3& a_world, const Vector3& b_world) const {
  const Vector3 ab = b_world - a_world;
  const double distance_m = ab.norm();
  if (distance_m <= 2 * kMinHeight_m) return false;  // ends may lie on surfaces
  ExactQuery query(impl_->world);
  query.set_ray(0, a_world.cast<float>(), (ab / distance_m).cast<float>(), distance_m - kMinHeight_m);
  return query.is_blocked();
}

std::optional<NearestSurface> StaticScene::nearest(const Vector3& p_world, double max_distance_m) const {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  NearestQuery nearest{&impl_->world, p_world, max_distance_m * max_distance_m, Vector3::Zero()};
  RTCPointQuery query = point_query(p_world, query_radius(max_distance_m));
  rtcPointQuery(impl_->world.scene.get(), &query, &context, visit_nearest, &nearest);
  if (nearest.best_triangle == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Surface& surface = impl_->world.surfaces[impl_->world.facets[nearest.best_triangle].surface];
  return NearestSurface{std::sqrt(nearest.best_sq), nearest.best_point, surface.surface_class, surface.instance};
}

void StaticScene::triangles_near_box(
    const Eigen::AlignedBox3d& box_world,
    const std::function<void(const Vector3&, const Vector3&, const Vector3&, int)>& visit) const {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  // Sorted by scene index, since the order of the tree depends on the processor.
  static thread_local std::vector<std::uint32_t> found;
  found.clear();
  found.reserve(kUsuallyNear);
  // Slack for rounding to single precision.
  constexpr float kSlack_m = 1e-4F;
  const Eigen::Vector3f slack = Eigen::Vector3f::Constant(kSlack_m);
  BoxQuery box{&impl_->world,
               Eigen::AlignedBox3f(box_world.min().cast<float>() - slack, box_world.max().cast<float>() + slack),
               &found};
  RTCPointQuery query = point_query(box_world.center(), query_radius(0.5 * box_world.diagonal().norm()));
  rtcPointQuery(impl_->world.scene.get(), &query, &context, visit_box, &box);
  std::sort(found.begin(), found.end());
  const TriangleScene& world = impl_->world;
  for (const std::uint32_t triangle : found) {
    const auto& [a, b, c] = world.corners_m[triangle];
    visit(a.cast<double>(), b.cast<double>(), c.cast<double>(), static_cast<int>(triangle));
  }
}

}  // namespace swiftlet::sim
