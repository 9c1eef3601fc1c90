// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "sim/world/dice.hpp"
#include "sim/world/scene_builder.hpp"

/// Trees with tapering leaning trunks, branches, and crowns of leaf clusters that are partly permeable to rays.
namespace swiftlet::sim {

enum class Species { kPine, kSpruce, kBroadleaf };
const char* name_of(Species species);

/// Height of a tree of this diameter at breast height, by Michailow's curve h = 1.3 + a exp(-b / d) [m].
double height_by_diameter_m(Species species, double dbh_m);

struct TreeOptions {
  double leaf_area_density_per_m = 0.6;  ///< one-sided leaf area per volume of crown [m^2/m^3]
  double leaf_cluster_m = 0.3;           ///< size of a leaf cluster
  double lean_max_deg = 3.0;
  bool is_far = false;  ///< a trunk of few triangles without branches
};

/// The crown is the space between two bodies of revolution about the tree's axis, filled evenly with leaves of
/// isotropic orientation. A ray meets no leaf along a path s through it with probability exp(-G LAD s), G = 1/2
/// (Beer-Lambert law; Monsi and Saeki 1953, Nilson 1971).
struct Crown {
  Species species = Species::kPine;
  double base_m = 0.0;
  double top_m = 0.0;
  double radius_m = 0.0;  ///< largest radius
  double lean_x = 0.0;    ///< horizontal displacement of the axis per meter of height
  double lean_y = 0.0;

  double outer_radius_m(double z_m) const;
  double inner_radius_m(double z_m) const;  ///< leafless core
  bool contains(const Eigen::Vector3d& point_tree_m) const;
};

/// One tree in meters, with its foot at the origin.
struct Tree {
  Species species = Species::kPine;
  double dbh_m = 0.0;
  double height_m = 0.0;
  Crown crown;
  Mesh trunk, branches, leaves;
};

Tree make_tree(Species species, double dbh_m, const TreeOptions& options, Dice dice);

/// Radius of the trunk's circular cross-section at a height above the foot [m].
double trunk_radius_m(double dbh_m, double height_m, double z_m);

/// Trees of one species, one per diameter; place() scales the tree with the nearest diameter.
class TreeStock {
 public:
  TreeStock(SceneBuilder& scene, Species species, std::vector<double> dbh_m, const TreeOptions& options,
            const Random& random);

  /// Dimensions of a tree with this diameter.
  struct Measures {
    double height_m = 0.0;
    double crown_base_m = 0.0;
    double crown_radius_m = 0.0;  ///< including lean: largest horizontal distance of any part from the foot
  };
  Measures measures(double dbh_m, double height_factor) const;
  /// Adds trunk, branches and leaves as one instance, with an entry in the stem map.
  void place(SceneBuilder& scene, const Eigen::Vector3d& foot_world_m, double dbh_m, double height_factor,
             double yaw_rad) const;
  /// As place(), with instance 0 and without an entry.
  void place_nameless(SceneBuilder& scene, const Eigen::Vector3d& foot_world_m, double dbh_m, double height_factor,
                      double yaw_rad) const;

 private:
  struct Kind {
    double dbh_m = 0.0;
    double height_m = 0.0;
    double crown_base_m = 0.0;
    double crown_radius_m = 0.0;
    double reach_m = 0.0;
    std::uint32_t trunk = 0, branches = 0, leaves = 0;
  };
  const Kind& nearest(double dbh_m) const;
  void place_meshes(SceneBuilder& scene, std::uint16_t instance, const Eigen::Vector3d& foot_world_m, double dbh_m,
                    double height_factor, double yaw_rad) const;
  double horizontal_scale(const Kind& kind, double dbh_m, double vertical_scale) const;

  Species species_;
  std::vector<Kind> kinds_;
};

}  // namespace swiftlet::sim
