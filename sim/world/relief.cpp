// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/relief.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

// The second derivative vanishes at both ends, which avoids creases at the lattice.
double fade(double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); }

double lattice_value(const Random& random, int octave, double column, double row) {
  const auto hash = [](double cell) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(cell)); };
  // The octave is encoded in the high bits, beyond any lattice index of a world.
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

/// Grid lines of the ground along one axis: the last one lies at first_m + (count - 1) * cell_m.
struct Lines {
  double first_m = 0.0, cell_m = 1.0;
  int count = 2;

  Lines(double from_m, double to_m, double most_cell_m, bool flat) : first_m(from_m) {
    const int cells = flat ? 1 : std::max(1, static_cast<int>(std::ceil((to_m - from_m) / most_cell_m)));
    cell_m = (to_m - from_m) / cells;
    count = cells + 1;
  }
  /// Position in the mesh: in single precision.
  float at(int i) const { return static_cast<float>(first_m) + static_cast<float>(cell_m) * static_cast<float>(i); }
};

/// The lines, extended beyond both ends out to `width_m` with increasing steps.
std::vector<float> widened(const Lines& lines, double width_m, bool flat) {
  // Factor of the edges of triangles from row to row, and [m] their largest edge.
  constexpr double kGrowth = 1.25;
  constexpr double kLargest_m = 8.0;
  std::vector<float> beyond_m;
  double step_m = flat ? width_m : lines.cell_m;
  for (double out_m = 0.0; out_m < width_m; step_m = std::min(step_m * kGrowth, std::max(kLargest_m, lines.cell_m))) {
    out_m = std::min(out_m + step_m, width_m);
    beyond_m.push_back(static_cast<float>(out_m));
  }
  std::vector<float> all;
  all.reserve(2 * beyond_m.size() + static_cast<std::size_t>(lines.count));
  for (auto out = beyond_m.rbegin(); out != beyond_m.rend(); ++out) all.push_back(lines.at(0) - *out);
  for (int i = 0; i < lines.count; ++i) all.push_back(lines.at(i));
  for (const float out : beyond_m) all.push_back(lines.at(lines.count - 1) + out);
  return all;
}

}  // namespace

void ReliefConfig::visit(ConfigVisitor& v) {
  v.field("amplitude_m", amplitude_m, "[m] highest ground above (and lowest below) z = 0", Range::non_negative());
  v.field("wavelength_m", wavelength_m, "[m] size of the largest hills", Range::positive());
  v.field("octaves", octaves, "[-] number of noise octaves, each of half the wavelength and half the height",
          Range::between(1, 8));
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
  const Lines x(min_world_m.x(), max_world_m.x(), cell_m, flat);
  const Lines y(min_world_m.y(), max_world_m.y(), cell_m, flat);
  std::vector<float> heights_m(static_cast<std::size_t>(x.count) * y.count);
  for (int row = 0; row < y.count; ++row) {
    for (int column = 0; column < x.count; ++column) {
      heights_m[static_cast<std::size_t>(row) * x.count + column] =
          static_cast<float>(relief.height_m(min_world_m.x() + column * x.cell_m, min_world_m.y() + row * y.cell_m));
    }
  }
  Mesh mesh;
  add_heightfield(mesh, min_world_m.cast<float>(), Eigen::Vector2d(x.cell_m, y.cell_m).cast<float>(), x.count, y.count,
                  heights_m);
  return mesh;
}

Mesh make_ground_around(const Relief& relief, bool flat, const Eigen::Vector2d& min_world_m,
                        const Eigen::Vector2d& max_world_m, double cell_m, double width_m) {
  const Lines x_inside(min_world_m.x(), max_world_m.x(), cell_m, flat);
  const Lines y_inside(min_world_m.y(), max_world_m.y(), cell_m, flat);
  const std::vector<float> x = widened(x_inside, width_m, flat), y = widened(y_inside, width_m, flat);
  const std::size_t outside_x = (x.size() - x_inside.count) / 2, outside_y = (y.size() - y_inside.count) / 2;
  // On the common edge, use the heights of the rectangle, computed at its lines in double precision.
  const auto exact = [](const Lines& inside, const std::vector<float>& all, std::size_t outside, std::size_t i) {
    const bool is_line = i >= outside && i < outside + static_cast<std::size_t>(inside.count);
    return is_line ? inside.first_m + static_cast<double>(i - outside) * inside.cell_m : static_cast<double>(all[i]);
  };
  const auto within = [](std::size_t i, std::size_t size, std::size_t outside) {
    return i > outside && i + 1 < size - outside;
  };
  Mesh mesh;
  std::vector<std::uint32_t> vertices(x.size() * y.size());
  for (std::size_t row = 0; row < y.size(); ++row) {
    for (std::size_t column = 0; column < x.size(); ++column) {
      if (within(column, x.size(), outside_x) && within(row, y.size(), outside_y)) continue;
      vertices[row * x.size() + column] = static_cast<std::uint32_t>(mesh.vertices_mesh_m.size());
      const double height_m =
          relief.height_m(exact(x_inside, x, outside_x, column), exact(y_inside, y, outside_y, row));
      mesh.vertices_mesh_m.emplace_back(x[column], y[row], static_cast<float>(height_m));
    }
  }
  const auto at = [&](std::size_t column, std::size_t row) { return vertices[row * x.size() + column]; };
  for (std::size_t row = 0; row + 1 < y.size(); ++row) {
    for (std::size_t column = 0; column + 1 < x.size(); ++column) {
      const bool inside = column >= outside_x && column + 1 < x.size() - outside_x && row >= outside_y &&
                          row + 1 < y.size() - outside_y;
      if (inside) continue;
      mesh.triangles.push_back({at(column, row), at(column + 1, row), at(column + 1, row + 1)});
      mesh.triangles.push_back({at(column, row), at(column + 1, row + 1), at(column, row + 1)});
    }
  }
  return mesh;
}

}  // namespace swiftlet::sim
