// SPDX-License-Identifier: BSD-3-Clause
#include "sim/raycast/ray_scene.hpp"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/raycast/embree_scene.hpp"
#include "sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kMaxTriangles = 2'000'000'000.0;

// Equal (class, instance, material, part) share one surface number.
class SurfaceNumbers {
 public:
  explicit SurfaceNumbers(std::vector<Surface>& surfaces) : surfaces_(surfaces) {}

  std::uint32_t number_of(const Surface& s) {
    const std::uint64_t key = static_cast<std::uint64_t>(s.material) | (static_cast<std::uint64_t>(s.instance) << 32) |
                              (static_cast<std::uint64_t>(s.surface_class) << 48);
    const auto [it, is_new] = numbers_.try_emplace(std::pair(key, static_cast<std::uint64_t>(s.part)), 0);
    if (is_new) {
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
  const auto first = static_cast<std::uint32_t>(out.vertices_m.size());
  const Eigen::Matrix3f linear = T_world_mesh.linear();
  const Eigen::Vector3f translation = T_world_mesh.translation();
  for (const Eigen::Vector3f& v : mesh.vertices_m) out.vertices_m.push_back(linear * v + translation);
  for (const auto& t : mesh.triangles) out.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  out.surface_of_triangle.insert(out.surface_of_triangle.end(), mesh.triangles.size(), surface);
}

// All instances unrolled: one big geometry is quicker to build and to trace than instances of small ones.
TriangleScene flatten(const Scene& scene) {
  std::size_t num_vertices = 0;
  std::size_t num_triangles = 0;
  for (const Instance& instance : scene.instances) {
    num_vertices += scene.meshes.at(instance.mesh).vertices_m.size();
    num_triangles += scene.meshes[instance.mesh].triangles.size();
  }
  if (static_cast<double>(num_triangles) > kMaxTriangles || static_cast<double>(num_vertices) > kMaxTriangles) {
    throw std::invalid_argument("world: expected at most 2e9 triangles, found " + std::to_string(num_triangles));
  }
  TriangleScene out;
  out.vertices_m.reserve(num_vertices + 1);  // Embree reads 16 bytes at the last vertex
  out.triangles.reserve(num_triangles);
  out.surface_of_triangle.reserve(num_triangles);
  SurfaceNumbers numbers(out.surfaces);
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Surface surface = {mesh.material, mesh.surface_class, instance.instance, VehiclePart::kNone};
    append(mesh, instance.T_world_mesh, numbers.number_of(surface), out);
  }
  return out;
}

EmbreeDevice make_device() {
  // Embree takes 4-wide trees where it believes that wider registers slow the clock (Xeons of the Skylake family).
  // 8-wide ones are a fifth faster there all the same; a processor without AVX gets the narrow ones anyway.
  EmbreeDevice device(rtcNewDevice("frequency_level=simd256"));
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

// Embree culls in single precision: a little more, so that only the exact distances decide.
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
  const auto& t = query.world->triangles[args->primID];
  const auto corner = [&](int i) -> Vector3 { return query.world->vertices_m[t[i]].cast<double>(); };
  const Vector3 point = closest_point_on_triangle(query.p, corner(0), corner(1), corner(2));
  const double distance_sq = (point - query.p).squaredNorm();
  // Of equally near triangles the first in the scene wins, whatever the order of the visits.
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
  const std::function<void(const Vector3&, const Vector3&, const Vector3&, int)>* visit;
};

bool visit_box(RTCPointQueryFunctionArguments* args) {
  const auto& query = *static_cast<const BoxQuery*>(args->userPtr);
  const auto& t = query.world->triangles[args->primID];
  const auto& v = query.world->vertices_m;
  Eigen::AlignedBox3f bounds(v[t[0]]);
  bounds.extend(v[t[1]]).extend(v[t[2]]);
  if (query.box.intersects(bounds)) {
    (*query.visit)(v[t[0]].cast<double>(), v[t[1]].cast<double>(), v[t[2]].cast<double>(),
                   static_cast<int>(args->primID));
  }
  return false;
}

RTCPointQuery point_query(const Vector3& p, float radius_m) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0.0F, radius_m};
}

RTCRay ray_between(const Vector3& origin, const Vector3& direction, double from_m, double to_m) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = static_cast<float>(from_m);
  ray.tfar = static_cast<float>(to_m);
  ray.mask = ~0U;
  return ray;
}

}  // namespace

void ReleaseDevice::operator()(RTCDevice device) const { rtcReleaseDevice(device); }
void ReleaseScene::operator()(RTCScene scene) const { rtcReleaseScene(scene); }

void TriangleScene::commit(RTCDevice device) {
  scene.reset(rtcNewScene(device));
  // Robust: no ray slips through the edge between two triangles.
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_MEDIUM);
  if (!triangles.empty()) {
    vertices_m.reserve(vertices_m.size() + 1);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_m.data(), 0,
                               sizeof(vertices_m[0]), vertices_m.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                               sizeof(triangles[0]), triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene.get(), geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene.get());
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE) {
    throw std::runtime_error("cannot build the ray tracing structure of " + std::to_string(triangles.size()) +
                             " triangles (error " + std::to_string(error) + ")");
  }
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

StaticScene::StaticScene(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  impl_->device = make_device();
  impl_->world = flatten(scene);
  for (const Eigen::Vector3f& v : impl_->world.vertices_m) {
    if (!v.allFinite()) throw std::invalid_argument("world: a vertex is not a finite number");
    impl_->bounds_m.extend(v.cast<double>());
  }
  impl_->world.commit(impl_->device.get());
}

StaticScene::~StaticScene() = default;

std::size_t StaticScene::num_triangles() const { return impl_->world.triangles.size(); }

const Eigen::AlignedBox3d& StaticScene::bounds_m() const { return impl_->bounds_m; }

RayHit StaticScene::trace(const Vector3& origin_world, const Vector3& direction_world, double range_max_m) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query{};
  query.ray = ray_between(origin_world, direction_world, 0.0, range_max_m);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->world.scene.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};

  const Surface& surface = impl_->world.surfaces[impl_->world.surface_of_triangle[query.hit.primID]];
  const Eigen::Vector3f normal(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
  RayHit hit;
  hit.range_m = query.ray.tfar;
  hit.cos_incidence = std::abs(normal.normalized().dot(direction_world.cast<float>()));
  hit.material = surface.material;
  hit.surface_class = surface.surface_class;
  hit.instance = surface.instance;
  return hit;
}

bool StaticScene::occluded(const Vector3& a_world, const Vector3& b_world) const {
  constexpr double kEndMargin_m = 1e-4;  // the ends may lie on surfaces
  const Vector3 ab = b_world - a_world;
  const double distance_m = ab.norm();
  if (distance_m <= 2 * kEndMargin_m) return false;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = ray_between(a_world, ab / distance_m, kEndMargin_m, distance_m - kEndMargin_m);
  rtcOccluded1(impl_->world.scene.get(), &context, &ray);
  return ray.tfar < 0;
}

std::optional<NearestSurface> StaticScene::nearest(const Vector3& p_world, double max_distance_m) const {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  NearestQuery nearest{&impl_->world, p_world, max_distance_m * max_distance_m, Vector3::Zero()};
  RTCPointQuery query = point_query(p_world, query_radius(max_distance_m));
  rtcPointQuery(impl_->world.scene.get(), &query, &context, visit_nearest, &nearest);
  if (nearest.best_triangle == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Surface& surface = impl_->world.surfaces[impl_->world.surface_of_triangle[nearest.best_triangle]];
  return NearestSurface{std::sqrt(nearest.best_sq), nearest.best_point, surface.surface_class, surface.instance};
}

void StaticScene::triangles_near_box(
    const Eigen::AlignedBox3d& box_world,
    const std::function<void(const Vector3&, const Vector3&, const Vector3&, int)>& visit) const {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  // A hair of slack for the rounding to single precision.
  constexpr float kSlack_m = 1e-4F;
  const Eigen::Vector3f slack = Eigen::Vector3f::Constant(kSlack_m);
  BoxQuery box{&impl_->world,
               Eigen::AlignedBox3f(box_world.min().cast<float>() - slack, box_world.max().cast<float>() + slack),
               &visit};
  RTCPointQuery query = point_query(box_world.center(), query_radius(0.5 * box_world.diagonal().norm()));
  rtcPointQuery(impl_->world.scene.get(), &query, &context, visit_box, &box);
}

}  // namespace swiftlet::sim
