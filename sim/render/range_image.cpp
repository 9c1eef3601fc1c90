// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/range_image.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kTwoPi = 2.0 * M_PI;

double azimuth_of(const Eigen::Vector3f& d) { return std::atan2(d.y(), d.x()); }
double elevation_of(const Eigen::Vector3f& d) { return std::asin(std::clamp(static_cast<double>(d.z()), -1.0, 1.0)); }
/// In [0, 2 pi).
double wrap(double angle) { return angle - kTwoPi * std::floor(angle / kTwoPi); }
/// In [-pi, pi).
double wrap_signed(double angle) { return wrap(angle + M_PI) - M_PI; }

float quantile(std::vector<float>& values, double q) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// Mapping from a scan's values to colors.
struct Shading {
  ColorBar bar;
  const std::vector<float>* values = nullptr;
  bool decibel = false;
  Rgb nothing = Rgb::Zero();  // for beams without return

  Rgb color(const Scan& scan, int beam) const {
    if (!scan.hit(beam)) return nothing;
    double value = (*values)[static_cast<std::size_t>(beam)];
    if (decibel) value = 10.0 * std::log10(std::max(value, 1e-9));
    return bar.color(static_cast<float>((value - bar.low) / (bar.high - bar.low)));
  }
};

Shading shading_of(const Scan& scan, ScanQuantity quantity, double max_range_m, const Rgb& nothing) {
  std::vector<float> hits;
  const bool range = quantity == ScanQuantity::kRange;
  Shading shading;
  shading.values = range ? &scan.range_m : &scan.intensity;
  shading.decibel = !range;
  shading.nothing = nothing;
  for (int i = 0; i < scan.size(); ++i) {
    if (scan.hit(i)) hits.push_back((*shading.values)[static_cast<std::size_t>(i)]);
  }
  if (range) {
    if (max_range_m <= 0.0) {
      const double far_m = hits.empty() ? 10.0 : std::max(1.0F, quantile(hits, 0.96));
      const double step = round_down_nicely(far_m / 4.0);
      max_range_m = step * std::ceil(far_m / step);
    }
    shading.bar = {turbo_like, 0.0, max_range_m, "range [m]"};
    return shading;
  }
  double low = -30.0;
  double high = 0.0;
  if (!hits.empty()) {
    low = 10.0 * std::log10(std::max(1e-9F, quantile(hits, 0.02)));
    high = std::max(low + 3.0, 10.0 * std::log10(std::max(1e-9F, quantile(hits, 0.99))));
  }
  // Decibels relative to a white wall at 10 m.
  shading.bar = {[](float s) { return Rgb::Constant(0.12F + 0.88F * std::clamp(s, 0.0F, 1.0F)); }, low, high,
                 "power [dB]"};
  return shading;
}

}  // namespace

BeamLookup::BeamLookup(const BeamTable& beams) : cols_(beams.cols) {
  for (int i = 0; i < beams.size(); ++i) {
    const double elevation = elevation_of(beams.directions_lidar[static_cast<std::size_t>(i)]);
    if (i == 0) elevation_min_rad_ = elevation_max_rad_ = elevation;
    elevation_min_rad_ = std::min(elevation_min_rad_, elevation);
    elevation_max_rad_ = std::max(elevation_max_rad_, elevation);
  }
  organize(beams);
  if (rows_.empty()) scatter(beams);
}

void BeamLookup::organize(const BeamTable& beams) {
  if (beams.rows < 8 || beams.cols < 16) return;
  const auto direction = [&](int row, int col) {
    return beams.directions_lidar[static_cast<std::size_t>(row) * cols_ + col];
  };
  pitch_rad_ = wrap_signed(azimuth_of(direction(0, 1)) - azimuth_of(direction(0, 0)));
  if (pitch_rad_ == 0.0) return;
  std::vector<Row> rows;
  for (int row = 0; row < beams.rows; ++row) {
    // A row has constant elevation and even azimuth steps.
    const double elevation = elevation_of(direction(row, 0));
    const double azimuth = azimuth_of(direction(row, 0));
    for (const int col : {1, cols_ / 3, 2 * cols_ / 3, cols_ - 1}) {
      const double expected = azimuth + pitch_rad_ * col;
      if (std::abs(elevation_of(direction(row, col)) - elevation) > 0.3 * kRadPerDeg ||
          std::abs(wrap_signed(azimuth_of(direction(row, col)) - expected)) > 0.5 * std::abs(pitch_rad_) + 1e-4) {
        return;
      }
    }
    rows.push_back({row, elevation, azimuth});
  }
  rows_ = std::move(rows);
  std::stable_sort(rows_.begin(), rows_.end(),
                   [](const Row& a, const Row& b) { return a.elevation_rad > b.elevation_rad; });
  const double half_row = 0.5 * (elevation_max_rad_ - elevation_min_rad_) / (beams.rows - 1);
  elevation_min_rad_ -= half_row;
  elevation_max_rad_ += half_row;
}

void BeamLookup::scatter(const BeamTable& beams) {
  const auto n = static_cast<std::size_t>(beams.size());
  if (n == 0) return;
  angles_rad_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    angles_rad_[i] = {wrap(azimuth_of(beams.directions_lidar[i])), elevation_of(beams.directions_lidar[i])};
  }
  // About one beam per cell.
  const double height = elevation_max_rad_ - elevation_min_rad_ + 1e-3;
  cell_rad_ = std::max(0.1 * kRadPerDeg, 1.3 * std::sqrt(kTwoPi * height / static_cast<double>(n)));
  cells_wide_ = std::max(1, static_cast<int>(kTwoPi / cell_rad_));
  cells_high_ = static_cast<int>(height / cell_rad_) + 1;
  const auto cell_of = [&](const Eigen::Vector2d& angle) {
    const int x = std::min(cells_wide_ - 1, static_cast<int>(angle.x() / kTwoPi * cells_wide_));
    const int y = std::min(cells_high_ - 1, static_cast<int>((angle.y() - elevation_min_rad_) / cell_rad_));
    return static_cast<std::size_t>(y) * cells_wide_ + x;
  };
  first_in_cell_.assign(static_cast<std::size_t>(cells_wide_) * cells_high_ + 1, 0);
  for (const auto& angle : angles_rad_) ++first_in_cell_[cell_of(angle) + 1];
  std::partial_sum(first_in_cell_.begin(), first_in_cell_.end(), first_in_cell_.begin());
  std::vector<int> cursor(first_in_cell_.begin(), first_in_cell_.end() - 1);
  beams_in_cells_.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    beams_in_cells_[static_cast<std::size_t>(cursor[cell_of(angles_rad_[i])]++)] = static_cast<int>(i);
}

int BeamLookup::beam_at(double azimuth_rad, double elevation_rad) const {
  if (elevation_rad < elevation_min_rad_ || elevation_rad > elevation_max_rad_) return -1;
  return rows_.empty() ? nearest(azimuth_rad, elevation_rad) : in_rows(azimuth_rad, elevation_rad);
}

int BeamLookup::in_rows(double azimuth_rad, double elevation_rad) const {
  auto row = std::lower_bound(rows_.begin(), rows_.end(), elevation_rad,
                              [](const Row& r, double elevation) { return r.elevation_rad > elevation; });
  if (row == rows_.end() ||
      (row != rows_.begin() && (row - 1)->elevation_rad - elevation_rad < elevation_rad - row->elevation_rad))
    --row;
  const double turned =
      wrap((azimuth_rad - row->azimuth_first_rad) * (pitch_rad_ > 0.0 ? 1.0 : -1.0) + 0.5 * std::abs(pitch_rad_));
  const int col = static_cast<int>(turned / std::abs(pitch_rad_));
  return col < cols_ ? row->row * cols_ + col : -1;
}

int BeamLookup::nearest(double azimuth_rad, double elevation_rad) const {
  if (angles_rad_.empty()) return -1;
  const double azimuth = wrap(azimuth_rad);
  const int cx = std::min(cells_wide_ - 1, static_cast<int>(azimuth / kTwoPi * cells_wide_));
  const int cy = static_cast<int>((elevation_rad - elevation_min_rad_) / cell_rad_);
  const double shrink = std::cos(elevation_rad);
  int best = -1;
  double best_sq = cell_rad_ * cell_rad_;
  for (int y = std::max(0, cy - 1); y <= std::min(cells_high_ - 1, cy + 1); ++y) {
    for (int dx = -1; dx <= 1; ++dx) {
      const auto cell = static_cast<std::size_t>(y) * cells_wide_ + (cx + dx + cells_wide_) % cells_wide_;
      for (int k = first_in_cell_[cell]; k < first_in_cell_[cell + 1]; ++k) {
        const int beam = beams_in_cells_[static_cast<std::size_t>(k)];
        const Eigen::Vector2d& angle = angles_rad_[static_cast<std::size_t>(beam)];
        const double da = wrap_signed(angle.x() - azimuth) * shrink;
        const double de = angle.y() - elevation_rad;
        const double distance_sq = da * da + de * de;
        if (distance_sq < best_sq) {
          best_sq = distance_sq;
          best = beam;
        }
      }
    }
  }
  return best;
}

int draw_range_image(Canvas& canvas, const Look& look, const Scan& scan, ScanQuantity quantity, double max_range_m) {
  const BeamLookup lookup(*scan.beams);
  const Shading shading = shading_of(scan, quantity, max_range_m, look.nothing);
  const Sidebar sidebar{{}, shading.bar};
  const int area_width = canvas.width_px() - sidebar_width_px(sidebar, look);
  draw_sidebar(canvas, look, sidebar, area_width);
  const float h = look.text_px;

  // The number of strips that makes the image largest, between a margin on top and the caption.
  const double height_rad = lookup.elevation_max_rad() - lookup.elevation_min_rad();
  const int gap = static_cast<int>(2.4F * h);
  const int free_height = canvas.height_px() - static_cast<int>((look.captions ? 3.0F : 1.0F) * h);
  const int margin = static_cast<int>(3.2F * h);  // half the width of a label
  const int free_width = area_width - 2 * margin;
  int strips = 1;
  double pixels_per_rad = 0.0;
  for (int n = 1; n <= 4; ++n) {
    const double scale =
        std::min(free_width / (kTwoPi / n), (free_height / n - gap) / std::max(height_rad, kRadPerDeg));
    if (scale > pixels_per_rad * 1.001) {
      pixels_per_rad = scale;
      strips = n;
    }
  }
  if (pixels_per_rad <= 0.0) return area_width;  // only the bar fits

  const int strip_width = static_cast<int>(kTwoPi / strips * pixels_per_rad);
  const int strip_height = std::max(1, static_cast<int>(height_rad * pixels_per_rad));
  const int left = (free_width - strip_width) / 2 + margin;
  const int used_height = strips * strip_height + strips * gap;
  for (int strip = 0; strip < strips; ++strip) {
    const int top = (free_height - used_height) / 2 + strip * (strip_height + gap) + static_cast<int>(h);
    const double azimuth_left = -strip * kTwoPi / strips + M_PI / strips;
    Image pixels(strip_width, strip_height, look.page);
    for (int y = 0; y < strip_height; ++y) {
      const double elevation = lookup.elevation_max_rad() - (y + 0.5) / pixels_per_rad;
      for (int x = 0; x < strip_width; ++x) {
        const int beam = lookup.beam_at(azimuth_left - (x + 0.5) / pixels_per_rad, elevation);
        if (beam >= 0) set_pixel(pixels, x, y, shading.color(scan, beam));
      }
    }
    canvas.picture(left, top, pixels);
    // Azimuths below the strip.
    const auto bottom = static_cast<float>(top + strip_height);
    const double left_deg = azimuth_left / kRadPerDeg;
    for (double deg = std::floor(left_deg / 45.0) * 45.0; deg >= left_deg - 360.0 / strips - 1e-6; deg -= 45.0) {
      const auto x = static_cast<float>(left + (left_deg - deg) * kRadPerDeg * pixels_per_rad);
      canvas.rectangle({x, bottom, std::max(1.0F, 0.09F * h), 0.4F * h}, look.ink);
      const double shown = deg < -180.0 + 1e-6 ? deg + 360.0 : deg;
      canvas.text({x, bottom + 1.5F * h}, tick_text(shown, 1.0) + " deg", look.text(0.75F, Align::kCenter));
    }
  }
  return area_width;
}

}  // namespace swiftlet::sim
