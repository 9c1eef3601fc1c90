// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/scene.hpp"

#include <algorithm>
#include <numeric>

namespace swiftlet::sim {
namespace {

struct ClassName {
  SurfaceClass surface_class;
  const char* name;
};

constexpr ClassName kClassNames[] = {
    {SurfaceClass::kUnlabeled, "unlabeled"},
    {SurfaceClass::kGround, "ground"},
    {SurfaceClass::kKerb, "kerb"},
    {SurfaceClass::kBuilding, "building"},
    {SurfaceClass::kWall, "wall"},
    {SurfaceClass::kDoor, "door"},
    {SurfaceClass::kPillar, "pillar"},
    {SurfaceClass::kCeiling, "ceiling"},
    {SurfaceClass::kVegetation, "vegetation"},
    {SurfaceClass::kTrunk, "trunk"},
    {SurfaceClass::kBranch, "branch"},
    {SurfaceClass::kUndergrowth, "undergrowth"},
    {SurfaceClass::kFallenTrunk, "fallen_trunk"},
    {SurfaceClass::kRack, "rack"},
    {SurfaceClass::kPallet, "pallet"},
    {SurfaceClass::kMarking, "marking"},
    {SurfaceClass::kObject, "object"},
};

}  // namespace

const char* name_of(SurfaceClass surface_class) {
  if (surface_class == SurfaceClass::kVehicle) return "vehicle";
  const auto* found = std::ranges::find(kClassNames, surface_class, &ClassName::surface_class);
  return found == std::end(kClassNames) ? "unlabeled" : found->name;
}

std::span<const char* const> static_class_names() {
  static const std::array names = [] {
    std::array<const char*, std::size(kClassNames)> all{};
    std::ranges::transform(kClassNames, all.begin(), &ClassName::name);
    return all;
  }();
  return names;
}

std::optional<SurfaceClass> surface_class_of(std::string_view name) {
  const auto* found = std::ranges::find(kClassNames, name, &ClassName::name);
  if (found == std::end(kClassNames)) return std::nullopt;
  return found->surface_class;
}

const char* name_of(VehiclePart part) {
  constexpr const char* kNames[] = {"none", "body", "arm", "motor", "rotor", "leg", "sensor", "marker"};
  return kNames[static_cast<std::size_t>(part)];
}

std::vector<std::uint32_t> pieces_of(const Mesh& mesh, std::span<const std::uint32_t> welded) {
  std::vector<std::uint32_t> parent(mesh.vertices_mesh_m.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t vertex) {
    std::uint32_t i = welded.empty() ? vertex : welded[vertex];
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& t : mesh.triangles) {
    for (int k = 1; k < 3; ++k) {
      const std::uint32_t a = root(t[0]), b = root(t[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<std::uint32_t> pieces(parent.size());
  for (std::uint32_t i = 0; i < parent.size(); ++i) pieces[i] = root(i);
  return pieces;
}

std::size_t Scene::num_triangles() const {
  std::size_t count = 0;
  for (const Instance& instance : instances) count += meshes[instance.mesh].triangles.size();
  return count;
}

}  // namespace swiftlet::sim
