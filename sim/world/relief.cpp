// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/relief.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

// Second derivative vanishes at both ends: no creases at the lattice.
double fade(double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); }

double lattice_value(const Random& random, int octave, double column, double row) {
  const auto hash = [](double cell) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(cell)); };
  // The octave goes into the high bits, far from any lattice that fits into a world.
  return random.uniform(-1.0, 1.0, hash(column) ^ (static_cast<std::uint32_t>(octave) << 27), hash(row));
}

double noise(const Random& random, int octave, double x, double y) {
  const double column = std::floor(x);
  const double row = std::floor(y);
  const double u = fade(x - column);
  const double v = fade(y - row);
  const double low =
      std::lerp(lattice_value(random, octave, column, row), lattice_value(random, octave, column + 1, row), u);
  const double high =
      std::lerp(lattice_value(random, octave, column, row + 1), lattice_value(random, octave, column + 1, row + 1), u);
  return std::lerp(low, high, v);
}

}  // namespace

void ReliefConfig::visit(ConfigVisitor& v) {
  v.field("amplitude_m", amplitude_m, "[m] highest ground above (and lowest below) z = 0", Range::non_negative());
  v.field("wavelength_m", wavelength_m, "[m] size of the largest hills", Range::positive());
  v.field("octaves", octaves, "[-] levels of ever smaller bumps", Range::between(1, 8));
}

Relief::Relief(const ReliefConfig& config, std::uint64_t seed) : config_(config), random_(seed, "world.relief") {}

double Relief::height_m(double x_m, double y_m) const {
  if (config_.amplitude_m == 0.0) return 0.0;
  double sum = 0.0;
  double weight = 1.0;
  double sum_of_weights = 0.0;
  double frequency_per_m = 1.0 / config_.wavelength_m;
  for (int octave = 0; octave < config_.octaves; ++octave) {
    sum += weight * noise(random_, octave, x_m * frequency_per_m, y_m * frequency_per_m);
    sum_of_weights += weight;
    weight *= 0.5;
    frequency_per_m *= 2.0;
  }
  return config_.amplitude_m * sum / sum_of_weights;
}

Mesh make_ground(const Relief& relief, bool flat, const Eigen::Vector2d& min_world_m,
                 const Eigen::Vector2d& max_world_m, double cell_m) {
  const Eigen::Vector2d size_m = max_world_m - min_world_m;
  const auto cells = [&](double length_m) {
    return flat ? 1 : std::max(1, static_cast<int>(std::ceil(length_m / cell_m)));
  };
  const int columns = cells(size_m.x()) + 1;
  const int rows = cells(size_m.y()) + 1;
  const Eigen::Vector2d cell(size_m.x() / (columns - 1), size_m.y() / (rows - 1));
  std::vector<float> heights_m(static_cast<std::size_t>(columns) * rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      heights_m[static_cast<std::size_t>(row) * columns + column] =
          static_cast<float>(relief.height_m(min_world_m.x() + column * cell.x(), min_world_m.y() + row * cell.y()));
    }
  }
  Mesh mesh;
  add_heightfield(mesh, min_world_m.cast<float>(), cell.cast<float>(), columns, rows, heights_m);
  return mesh;
}

}  // namespace swiftlet::sim
