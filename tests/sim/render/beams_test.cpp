// SPDX-License-Identifier: BSD-3-Clause
// Scans as pictures: beams found a second time by looking at all of them, and strips measured on the canvas.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "noted_canvas.hpp"
#include "render_support.hpp"
#include "sim/render/captions.hpp"
#include "sim/render/range_image.hpp"
#include "sim/render/sight.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kRadians = M_PI / 180.0;

Eigen::Vector3f direction_of(double azimuth, double elevation) {
  return Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation))
      .cast<float>();
}

struct Pattern {
  int rows = 16, cols = 90;
  double low_deg = -10.0, high_deg = 20.0;
  double sweep_deg = 360.0;  // from the first column to behind the last
  double first_deg = 40.0;
  bool clockwise = true;
  bool highest_first = true;
  double stagger_deg = 0.0;  // every second row looks aside by this
};

BeamTable beams_of(const Pattern& p) {
  BeamTable beams;
  beams.rows = p.rows;
  beams.cols = p.cols;
  for (int row = 0; row < p.rows; ++row) {
    const double share = static_cast<double>(row) / (p.rows - 1);
    const double elevation = (p.highest_first ? p.high_deg + share * (p.low_deg - p.high_deg)
                                              : p.low_deg + share * (p.high_deg - p.low_deg)) *
                             kRadians;
    for (int col = 0; col < p.cols; ++col) {
      const double turned = p.sweep_deg * col / p.cols * (p.clockwise ? -1.0 : 1.0);
      beams.directions_lidar.push_back(
          direction_of((p.first_deg + (row % 2 == 0 ? 0.0 : p.stagger_deg) + turned) * kRadians, elevation));
    }
  }
  beams.origins_lidar.assign(beams.directions_lidar.size(), Eigen::Vector3f::Zero());
  beams.column_offset_s.assign(static_cast<std::size_t>(p.cols), 0.0F);
  return beams;
}

double azimuth_of(const BeamTable& beams, int i) {
  const Eigen::Vector3f& d = beams.directions_lidar[static_cast<std::size_t>(i)];
  return std::atan2(d.y(), d.x());
}
double elevation_of(const BeamTable& beams, int i) {
  return std::asin(std::clamp<double>(beams.directions_lidar[static_cast<std::size_t>(i)].z(), -1.0, 1.0));
}

/// The nearest row; of it the beam nearest in azimuth, unless that is more than half a step away.
int by_rows(const BeamTable& beams, const Pattern& p, double azimuth, double elevation) {
  int row = 0;
  for (int r = 0; r < p.rows; ++r) {
    if (std::abs(elevation_of(beams, r * p.cols) - elevation) < std::abs(elevation_of(beams, row * p.cols) - elevation))
      row = r;
  }
  const double step = p.sweep_deg / p.cols * kRadians;
  for (int col = 0; col < p.cols; ++col) {
    const int i = row * p.cols + col;
    if (std::abs(std::remainder(azimuth_of(beams, i) - azimuth, 2.0 * M_PI)) < 0.5 * step) return i;
  }
  return -1;
}

TEST(BeamLookup, FindsTheBeamOfTheNearestRowThatIsNearestInAzimuth) {
  std::vector<Pattern> patterns(6);
  patterns[1].clockwise = false;
  patterns[2].highest_first = false;
  patterns[3].sweep_deg = 120.0;
  patterns[4].sweep_deg = 120.0, patterns[4].clockwise = false, patterns[4].first_deg = 170.0;
  patterns[5].stagger_deg = 7.3;
  for (const Pattern& p : patterns) {
    const BeamTable beams = beams_of(p);
    const BeamLookup lookup(beams);
    ASSERT_TRUE(lookup.organized());
    const double half_row = 0.5 * (p.high_deg - p.low_deg) / (p.rows - 1) * kRadians;
    EXPECT_NEAR(lookup.elevation_min_rad(), p.low_deg * kRadians - half_row, 1e-5);
    EXPECT_NEAR(lookup.elevation_max_rad(), p.high_deg * kRadians + half_row, 1e-5);
    const Random random(1, "test.rows");
    int found = 0;
    for (std::uint32_t i = 0; i < 1500; ++i) {
      const double azimuth = random.uniform(-7.0, 7.0, i, 0);
      const double elevation = random.uniform(lookup.elevation_min_rad(), lookup.elevation_max_rad(), i, 1);
      const int expected = by_rows(beams, p, azimuth, elevation), beam = lookup.beam_at(azimuth, elevation);
      ASSERT_EQ(beam, expected) << azimuth << " " << elevation;
      found += beam >= 0;
    }
    EXPECT_NEAR(found, 1500.0 * p.sweep_deg / 360.0, 120.0);
    EXPECT_EQ(lookup.beam_at(0.7, lookup.elevation_max_rad() + 1e-4), -1);
    EXPECT_EQ(lookup.beam_at(0.7, lookup.elevation_min_rad() - 1e-4), -1);
    EXPECT_GE(lookup.beam_at(p.first_deg * kRadians, lookup.elevation_min_rad() + 1e-4), 0);
  }
}

TEST(BeamLookup, TakesForRowsWhatKeepsItsElevationAndTurnsEvenly) {
  const auto organized = [](const Pattern& p, const auto& change) {
    BeamTable beams = beams_of(p);
    change(beams);
    return BeamLookup(beams).organized();
  };
  const auto nothing = [](BeamTable&) {};
  Pattern p;
  p.rows = 8, p.cols = 16;
  EXPECT_TRUE(organized(p, nothing));
  p.rows = 7;
  EXPECT_FALSE(organized(p, nothing));
  p.rows = 8, p.cols = 15;
  EXPECT_FALSE(organized(p, nothing));
  p = {};
  const double pitch = 4.0 * kRadians;
  for (const int col : {1, 30, 60, 89}) {
    for (const int row : {0, 7, 15}) {
      const auto moved = [&](double azimuth, double elevation) {
        return [=](BeamTable& beams) {
          const int i = row * 90 + col;
          beams.directions_lidar[static_cast<std::size_t>(i)] =
              direction_of(azimuth_of(beams, i) + azimuth, elevation_of(beams, i) + elevation);
        };
      };
      EXPECT_TRUE(organized(p, moved(0.0, 0.27 * kRadians))) << row << " " << col;
      EXPECT_FALSE(organized(p, moved(0.0, 0.33 * kRadians)));
      EXPECT_TRUE(organized(p, moved(0.0, -0.27 * kRadians)));
      EXPECT_FALSE(organized(p, moved(0.0, -0.33 * kRadians)));
      if (row == 0 && col == 1) continue;  // it tells how fast the rows turn
      EXPECT_TRUE(organized(p, moved(0.45 * pitch, 0.0)));
      EXPECT_FALSE(organized(p, moved(0.55 * pitch, 0.0)));
      EXPECT_TRUE(organized(p, moved(-0.45 * pitch, 0.0)));
      EXPECT_FALSE(organized(p, moved(-0.55 * pitch, 0.0)));
    }
  }
  EXPECT_FALSE(organized(p, [](BeamTable& beams) { beams.directions_lidar[1] = beams.directions_lidar[0]; }))
      << "rows that do not turn";
}

/// Within a cell's size of the nearest beam, that one; farther from all of them, none.
TEST(BeamLookup, OfAPatternWithoutRowsFindsTheNearestBeamOfAll) {
  for (const std::uint32_t count : {300U, 4000U}) {
    const Random random(count, "test.scattered");
    BeamTable beams;
    beams.rows = 1;
    beams.cols = static_cast<int>(count);
    const double low = -0.12, high = 0.2;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double elevation = i == 0 ? low : i == 1 ? high : random.uniform(low, high, i, 1);
      beams.directions_lidar.push_back(direction_of(random.uniform(-M_PI, M_PI, i, 0), elevation));
    }
    const BeamLookup lookup(beams);
    ASSERT_FALSE(lookup.organized());
    EXPECT_NEAR(lookup.elevation_min_rad(), low, 1e-6);
    EXPECT_NEAR(lookup.elevation_max_rad(), high, 1e-6);
    const double cell = std::max(0.1 * kRadians, 1.3 * std::sqrt(2.0 * M_PI * (high - low) / count));
    int none = 0;
    for (std::uint32_t k = 0; k < 800; ++k) {
      const double azimuth = random.uniform(-8.0, 8.0, k, 2), elevation = random.uniform(low, high, k, 3);
      int best = -1;
      double least = std::numeric_limits<double>::infinity();
      for (int i = 0; i < beams.size(); ++i) {
        const double aside = std::remainder(azimuth_of(beams, i) - azimuth, 2.0 * M_PI) * std::cos(elevation);
        const double off = std::hypot(aside, elevation_of(beams, i) - elevation);
        if (off < least) least = off, best = i;
      }
      const int found = lookup.beam_at(azimuth, elevation);
      if (least < 0.97 * cell) {
        EXPECT_EQ(found, best) << k;
      } else if (least > 1.03 * cell) {
        EXPECT_EQ(found, -1) << k;
        ++none;
      }
    }
    EXPECT_GT(none, 0);
    EXPECT_LT(none, 60);
  }
}

Scan scan_with(const BeamTable& beams) {
  Scan scan;
  scan.beams = std::make_shared<const BeamTable>(beams);
  scan.range_m.assign(static_cast<std::size_t>(beams.size()), 5.0F);
  scan.intensity.assign(scan.range_m.size(), 0.5F);
  return scan;
}

/// The strips of a scan and what stands below them.
struct Strips {
  NotedCanvas canvas;
  int left_px = 0;

  Strips(const Scan& scan, const Look& look, int width, int height) : canvas(width, height) {
    left_px = draw_range_image(canvas, look, scan, ScanQuantity::kRange, 40.0);
  }
};

TEST(RangeImage, HasAsManyStripsAsMakeItLargest) {
  for (const auto& [high_deg, width, height] :
       {std::tuple(20.0, 800, 450), {20.0, 400, 700}, {5.0, 500, 500}, {40.0, 300, 900}, {2.0, 1400, 300}}) {
    for (const bool captions : {true, false}) {
      Pattern p;
      p.high_deg = high_deg;
      Look look;
      look.text_px = 10.0F;
      look.captions = captions;
      const Strips drawn(scan_with(beams_of(p)), look, width, height);
      const double tall = (p.high_deg - p.low_deg) * kRadians * p.rows / (p.rows - 1);
      // A margin of 3.2 letters at both sides; a line of numbers below each strip, and the caption.
      const double free_width = drawn.left_px - 2.0 * 32.0, free_height = height - (captions ? 30.0 : 10.0);
      double best = 0.0;
      std::size_t strips = 1;
      for (std::size_t n = 1; n <= 4; ++n) {
        const double scale = std::min(free_width * static_cast<double>(n) / (2.0 * M_PI),
                                      (free_height / static_cast<double>(n) - 24.0) / tall);
        if (scale > best * 1.001) best = scale, strips = n;
      }
      ASSERT_EQ(drawn.canvas.pictures.size(), strips) << high_deg << " " << width << "x" << height;
      const Box& first = drawn.canvas.pictures[0];
      EXPECT_NEAR(first.width, 2.0 * M_PI / static_cast<double>(strips) * best, 0.02 * first.width + 1.0);
      EXPECT_NEAR(first.height, tall * best, 0.03 * first.height + 1.0);
      for (std::size_t i = 0; i < strips; ++i) {
        const Box& strip = drawn.canvas.pictures[i];
        EXPECT_EQ(strip.width, first.width);
        EXPECT_EQ(strip.height, first.height);
        EXPECT_EQ(strip.left, first.left);
        if (i > 0) {
          EXPECT_NEAR(strip.top - drawn.canvas.pictures[i - 1].bottom(), 24.0F, 5.0F);
        }
      }
      // In the middle of what is free.
      EXPECT_NEAR(first.left, drawn.left_px - first.right(), 3.0F);
      const float below =
          static_cast<float>(height) - drawn.canvas.pictures.back().bottom() - (captions ? 30.0F : 10.0F) - 14.0F;
      EXPECT_NEAR(first.top - 10.0F, below, 5.0F);
      // Every number is on the canvas, below its strip, and over no other one.
      for (std::size_t i = 0; i < drawn.canvas.texts.size(); ++i) {
        const NotedCanvas::Text& text = drawn.canvas.texts[i];
        if (text.content.find(" deg") == std::string::npos) continue;
        EXPECT_GE(text.box.left, 0.0F);
        EXPECT_LE(text.box.right(), static_cast<float>(drawn.left_px) + 1.0F);
        EXPECT_LE(text.at_px.y(), static_cast<float>(height));
        for (const Box& strip : drawn.canvas.pictures)
          EXPECT_FALSE(text.at_px.y() > strip.top && text.box.top < strip.bottom()) << text.content;
      }
    }
  }
}

// Azimuth falls to the right; the sensor's x axis is in the middle of the first strip.
TEST(RangeImage, NumbersAndTicksStandAtTheirAzimuths) {
  for (const auto& [width, height] : {std::pair(1300, 260), {800, 450}, {400, 700}}) {
    Look look;
    look.text_px = 10.0F;
    const Strips drawn(scan_with(beams_of({})), look, width, height);
    const std::size_t strips = drawn.canvas.pictures.size();
    const double extent_deg = 360.0 / static_cast<double>(strips);
    std::size_t numbers = 0;
    for (const NotedCanvas::Text& text : drawn.canvas.texts) {
      const std::size_t unit = text.content.find(" deg");
      if (unit == std::string::npos) continue;
      const double deg = std::stod(text.content.substr(0, unit));
      EXPECT_LE(std::abs(deg), 180.0);
      EXPECT_EQ(std::fmod(deg, 45.0), 0.0);
      ++numbers;
      const auto strip = std::find_if(drawn.canvas.pictures.begin(), drawn.canvas.pictures.end(), [&](const Box& s) {
        return text.at_px.y() > s.bottom() && text.at_px.y() < s.bottom() + 24.0F;
      });
      ASSERT_NE(strip, drawn.canvas.pictures.end()) << text.content;
      const double middle_deg = -extent_deg * static_cast<double>(strip - drawn.canvas.pictures.begin());
      const double share = 0.5 + (middle_deg - deg) / extent_deg;
      const double turns = std::round(share * extent_deg / 360.0 - 0.5 * extent_deg / 360.0);
      const double at = share - turns * 360.0 / extent_deg;
      const double x = (text.at_px.x() - strip->left) / strip->width;
      EXPECT_NEAR(std::remainder(x - at, 360.0 / extent_deg), 0.0, 0.02) << text.content;
      EXPECT_NEAR(text.at_px.y() - strip->bottom(), 15.0F, 4.0F);
      EXPECT_NEAR(text.style.height_px, 7.5F, 1.8F);
      // With a tick above it.
      const auto tick =
          std::find_if(drawn.canvas.rectangles.begin(), drawn.canvas.rectangles.end(), [&](const Box& box) {
            return std::abs(box.left - text.at_px.x()) < 0.01F && std::abs(box.top - strip->bottom()) < 0.01F;
          });
      ASSERT_NE(tick, drawn.canvas.rectangles.end());
      EXPECT_NEAR(tick->height, 4.0F, 1.2F);
      EXPECT_NEAR(tick->width, 1.0F, 0.4F);
    }
    EXPECT_EQ(numbers, 8U + strips) << "both ends of a strip count";
  }
}

TEST(RangeImage, EveryPixelShowsTheBeamThatLooksThere) {
  Pattern p;
  p.rows = 8, p.cols = 16, p.sweep_deg = 200.0;
  const BeamTable beams = beams_of(p);
  Scan scan = scan_with(beams);
  for (std::size_t i = 0; i < scan.range_m.size(); ++i)
    scan.range_m[i] = i % 7 == 0 ? 0.0F : 1.0F + 0.06F * static_cast<float>(i);
  Look look;
  look.text_px = 8.0F;
  NotedCanvas noted(640, 420);
  const int left_px = draw_range_image(noted, look, scan, ScanQuantity::kRange, 40.0);
  ASSERT_GE(noted.pictures.size(), 1U);
  const Image image = painted(
      640, 420, look.page, [&](Canvas& canvas) { draw_range_image(canvas, look, scan, ScanQuantity::kRange, 40.0); });
  const BeamLookup lookup(beams);
  const double strips = static_cast<double>(noted.pictures.size());
  int nothing = 0, beside = 0, shown = 0;
  for (std::size_t s = 0; s < noted.pictures.size(); ++s) {
    const Box& box = noted.pictures[s];
    const double px_per_rad = box.height / (lookup.elevation_max_rad() - lookup.elevation_min_rad());
    for (int y = 0; y < static_cast<int>(box.height); ++y) {
      for (int x = 0; x < static_cast<int>(box.width); ++x) {
        // The scale is known to a pixel only, so the edges of beams are left out.
        const auto beam_at = [&](double dx, double dy) {
          const double scale = px_per_rad;
          const double azimuth =
              (M_PI - 2.0 * M_PI * static_cast<double>(s)) / strips - (x + 0.5 + dx) * 2.0 * M_PI / strips / box.width;
          return lookup.beam_at(azimuth, lookup.elevation_max_rad() - (y + 0.5 + dy) / scale);
        };
        const int beam = beam_at(0, 0);
        if (beam != beam_at(1.2, 1.2) || beam != beam_at(-1.2, -1.2) || beam != beam_at(1.2, -1.2) ||
            beam != beam_at(-1.2, 1.2))
          continue;
        const Rgb found = color_at(image, static_cast<int>(box.left) + x, static_cast<int>(box.top) + y);
        const Rgb expected = beam < 0         ? look.page
                             : scan.hit(beam) ? turbo_like(scan.range_m[static_cast<std::size_t>(beam)] / 40.0F)
                                              : look.nothing;
        ASSERT_LT((found - expected).cwiseAbs().maxCoeff(), 0.006F) << s << ": " << x << " " << y;
        (beam < 0 ? beside : scan.hit(beam) ? shown : nothing) += 1;
      }
    }
  }
  EXPECT_GT(shown, 1000);
  EXPECT_GT(nothing, 50);
  EXPECT_GT(beside, 500);
  EXPECT_LT(left_px, 640);
}

/// The ends of the scale, as its bar tells them.
std::pair<double, double> scale_of(const Scan& scan, ScanQuantity quantity, double max_range_m) {
  NotedCanvas canvas(800, 450);
  Look look;
  look.text_px = 10.0F;
  draw_range_image(canvas, look, scan, quantity, max_range_m);
  // Two numbers beside the bar tell where all others lie.
  std::vector<std::pair<double, double>> marks;  // value, y
  for (const NotedCanvas::Text& text : canvas.texts) {
    if (text.content.find_first_not_of("-0123456789.") == std::string::npos)
      marks.push_back({std::stod(text.content), text.at_px.y() - 4.25});
  }
  if (marks.size() < 2) return {0, 0};
  Box bar;
  float top = 1e9F, bottom = 0.0F, left = 0.0F;
  for (std::size_t i = 1; i < canvas.rectangles.size(); ++i) {
    const Box& box = canvas.rectangles[i];
    if (std::abs(box.width - 1.3F * 8.5F) > 0.01F) continue;
    left = box.left;
    top = std::min(top, box.top), bottom = std::max(bottom, box.bottom());
  }
  EXPECT_GT(left, 0.0F);
  const double per_px = (marks.back().first - marks.front().first) / (marks.back().second - marks.front().second);
  return {marks.front().first + per_px * (bottom - marks.front().second),
          marks.front().first + per_px * (top - marks.front().second)};
}

TEST(RangeImage, ScaleOfRangesHoldsNearlyAllOfThemUpToARoundNumber) {
  Pattern p;
  p.rows = 10, p.cols = 100;
  Scan scan = scan_with(beams_of(p));
  for (std::size_t i = 0; i < 1000; ++i) scan.range_m[i] = 0.02F * static_cast<float>(i + 1);  // up to 20 m
  EXPECT_NEAR(scale_of(scan, ScanQuantity::kRange, 33.0).second, 33.0, 0.3) << "as told";
  EXPECT_NEAR(scale_of(scan, ScanQuantity::kRange, 0.0).second, 20.0, 0.3);  // of 19.2 m: steps of 2 m
  for (std::size_t i = 0; i < 1000; ++i) scan.range_m[i] = i < 965 ? 7.0F : 90.0F;
  EXPECT_NEAR(scale_of(scan, ScanQuantity::kRange, 0.0).second, 7.0, 0.2) << "96 of a hundred are near";
  for (std::size_t i = 0; i < 1000; ++i) scan.range_m[i] = i < 955 ? 7.0F : 90.0F;
  EXPECT_NEAR(scale_of(scan, ScanQuantity::kRange, 0.0).second, 100.0, 2.0);
  scan.range_m.assign(1000, 0.0F);
  EXPECT_NEAR(scale_of(scan, ScanQuantity::kRange, 0.0).second, 10.0, 0.3) << "of nothing";
  scan.range_m.assign(1000, 0.2F);
  EXPECT_NEAR(scale_of(scan, ScanQuantity::kRange, 0.0).second, 1.0, 0.05) << "a meter at least";
}

TEST(RangeImage, ScaleOfPowersLeavesOutTheWeakestAndTheStrongestFew) {
  Pattern p;
  p.rows = 10, p.cols = 100;
  Scan scan = scan_with(beams_of(p));
  for (std::size_t i = 0; i < 1000; ++i) {
    const double decibel = i < 15 ? -80.0 : i < 30 ? -40.0 : i < 985 ? -20.0 : i < 995 ? -10.0 : 30.0;
    scan.intensity[i] = static_cast<float>(std::pow(10.0, decibel / 10.0));
  }
  const auto [low, high] = scale_of(scan, ScanQuantity::kIntensity, 0.0);
  EXPECT_NEAR(low, -40.0, 0.5) << "two in a hundred are weaker";
  EXPECT_NEAR(high, -10.0, 0.5) << "one in a hundred is stronger";
  scan.intensity.assign(1000, 0.01F);
  const auto [same_low, same_high] = scale_of(scan, ScanQuantity::kIntensity, 0.0);
  EXPECT_NEAR(same_low, -20.0, 0.1);
  EXPECT_NEAR(same_high, -17.0, 0.1) << "three decibels at least";
  scan.range_m.assign(1000, 0.0F);
  const auto [none_low, none_high] = scale_of(scan, ScanQuantity::kIntensity, 0.0);
  EXPECT_NEAR(none_low, -30.0, 3.0);
  EXPECT_NEAR(none_high, 0.0, 0.5);
}

TEST(RangeImage, WithoutRoomThereIsOnlyTheBar) {
  Look look;
  look.text_px = 10.0F;
  NotedCanvas canvas(120, 120);
  const int left_px = draw_range_image(canvas, look, scan_with(beams_of({})), ScanQuantity::kRange, 40.0);
  EXPECT_LT(left_px, 80);
  EXPECT_TRUE(canvas.pictures.empty());
}

// ---- Sight.

/// So many leaves one behind the other, and a wall behind the last one.
BlocksSight leaves_and_wall(int leaves, double wall_behind_m) {
  Scene scene;
  scene.materials.resize(1);
  const auto add = [&](float x, SurfaceClass surface_class) {
    Mesh mesh;
    mesh.surface_class = surface_class;
    add_quad(mesh, {x, -1, -1}, {x, 1, -1}, {x, 1, 1}, {x, -1, 1});
    scene.instances.push_back({static_cast<std::uint32_t>(scene.meshes.size()), Eigen::Affine3f::Identity(), 1});
    scene.meshes.push_back(mesh);
  };
  for (int i = 0; i < leaves; ++i)
    add(1.0F + 0.1F * static_cast<float>(i), i % 2 == 0 ? SurfaceClass::kVegetation : SurfaceClass::kUndergrowth);
  if (wall_behind_m > 0.0)
    add(1.0F + 0.1F * static_cast<float>(leaves - 1) + static_cast<float>(wall_behind_m), SurfaceClass::kWall);
  return sight_in(std::make_shared<const StaticScene>(scene));
}

TEST(Sight, GoesThroughSixtyThreeLeavesAndTakesMoreForAWall) {
  const Eigen::Vector3d a(0, 0, 0), b(20, 0, 0);
  EXPECT_FALSE(leaves_and_wall(63, 0.0)(a, b));
  EXPECT_TRUE(leaves_and_wall(64, 0.0)(a, b));
  // A leaf is a centimeter thick: what stands within it is not seen.
  EXPECT_TRUE(leaves_and_wall(3, 0.02)(a, b));
  EXPECT_FALSE(leaves_and_wall(3, 0.006)(a, b));
  EXPECT_FALSE(leaves_and_wall(1, 0.0)(a, {1.005, 0, 0})) << "it ends within a leaf";
  const BlocksSight wall = leaves_and_wall(1, 0.5);
  EXPECT_FALSE(wall({1.498, 0, 0}, {1.506, 0, 0})) << "as near as a leaf is thick";
  EXPECT_TRUE(wall({1.49, 0, 0}, {1.51, 0, 0}));
}

}  // namespace
}  // namespace swiftlet::sim
