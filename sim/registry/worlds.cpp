// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/world/campus.hpp"
#include "swiftlet/sim/world/cloud.hpp"
#include "swiftlet/sim/world/empty.hpp"
#include "swiftlet/sim/world/field.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "swiftlet/sim/world/forest_thesis.hpp"
#include "swiftlet/sim/world/hall.hpp"
#include "swiftlet/sim/world/mesh_import.hpp"
#include "swiftlet/sim/world/two_rooms_gap.hpp"
#include "swiftlet/sim/world/walls.hpp"
#include "swiftlet/sim/world/warehouse.hpp"

namespace swiftlet::sim {
namespace {

template <class Config, Scene (*make)(const Config&, std::uint64_t)>
Scene make_from(const ModuleConfig& config, std::uint64_t seed) {
  return make(dynamic_cast<const Config&>(config), seed);
}

template <class Config, Scene (*make)(const Config&, std::uint64_t)>
constexpr WorldType row(const char* name, const char* doc) {
  return {{name, doc, make_module_config<Config>}, make_from<Config, make>};
}

// All generators: a new one needs its .hpp, .cpp and test, and one line here.
const WorldType kWorldTypes[] = {
    row<FieldConfig, make_field>("field", "open ground with scattered trees"),
    row<ForestConfig, make_forest>("forest",
                                   "mixed forest on hills: stems, branches, porous crowns, undergrowth, fallen trunks"),
    row<EmptyConfig, make_empty>("empty", "nothing, or a flat ground"),
    row<ForestThesisConfig, make_forest_thesis>("forest_thesis",
                                                "100 cylinder-and-sphere trees [Kamler 2025, sec. 3.4]"),
    row<WarehouseConfig, make_warehouse>(
        "warehouse", "racks, aisles, pallets, pillars, and a door of any width [Pritzl 2024, sec. III-C]"),
    row<TwoRoomsGapConfig, make_two_rooms_gap>("two_rooms_gap", "two rooms joined by a gap [Pritzl 2024, sec. III-A]"),
    row<HallConfig, make_hall>("hall", "an indoor area with a wall as cover [Vrba 2025, sec. V-B]"),
    row<CampusConfig, make_campus>("campus",
                                   "a small building to circle, trees, paths with kerbs, lamp posts [Orsulic 2021]"),
    row<WallsConfig, make_walls>("walls", "straight walls on a flat ground, and a maze"),
    row<MeshImportConfig, make_mesh_import>("mesh", "an OBJ, PLY or STL file"),
    row<CloudConfig, make_cloud>("cloud", "a PCD or PLY point cloud as solid voxels"),
};

}  // namespace

Registry<WorldType>& world_registry() {
  static Registry<WorldType> table("world", kWorldTypes);
  return table;
}

Scene make_world(const Module& config, std::uint64_t seed) { return world_registry().make(config, seed); }

}  // namespace swiftlet::sim
