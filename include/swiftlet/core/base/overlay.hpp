// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Geometry that an agent adds to a snapshot (voxels, tracks, cells, paths). Local frame between stages, world in
/// Action. Recorders and renderers select overlays by name; agents make them only when `Observation::wants_overlays` is
/// set.
struct Overlay {
  enum class Kind { kPoints, kLines, kPolyline, kCubes, kSpheres, kTriangles };

  /// Meaning of a color, for the legend of a picture.
  struct Key {
    std::string meaning;
    Eigen::Vector4f color;
    bool dashed = false;  ///< the lines of this color are dashed
  };

  std::string name;  ///< such as "reference", "tracks", "voxels.confident"
  Kind kind = Kind::kPoints;
  std::vector<Eigen::Vector3f> positions;  ///< points, cubes, spheres: centers; lines: pairs; triangles: triples
  std::vector<Eigen::Vector4f> colors;     ///< RGBA 0..1, one per position, or one for all; none: the vehicle's color
  float size_m = 0.1F;  ///< edge of a cube, radius of a sphere, diameter of a point; lines: width in px
  std::vector<Key> legend;
};

}  // namespace swiftlet
