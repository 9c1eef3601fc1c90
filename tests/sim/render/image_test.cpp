// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "sim/render/captions.hpp"
#include "sim/render/png.hpp"
#include "sim/render/video.hpp"
#include "swiftlet/sim/render/colors.hpp"
#include "swiftlet/sim/world/scene.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

Image test_picture(int width, int height) {
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<std::uint8_t>(i * 37 + i / 91);
  return image;
}

TEST(Png, HoldsExactlyThePixelsGiven) {
  const TemporaryDirectory folder;
  const Image image = test_picture(33, 21);
  write_png(folder.path() / "a.png", image);
  png_image read{};
  read.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&read, (folder.path() / "a.png").c_str()), 0) << read.message;
  EXPECT_EQ(read.width, 33U);
  EXPECT_EQ(read.height, 21U);
  read.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(read));
  ASSERT_NE(png_image_finish_read(&read, nullptr, pixels.data(), 0, nullptr), 0);
  EXPECT_EQ(pixels, image.rgb);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "a.png.part"));
}

TEST(Png, StoresItsPrintSize) {
  const TemporaryDirectory folder;
  write_png(folder.path() / "plain.png", test_picture(8, 8));
  write_png(folder.path() / "paper.png", test_picture(8, 8), 300.0);
  const auto content = [&](const char* name) {
    std::ifstream stream(folder.path() / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  EXPECT_EQ(content("plain.png").find("pHYs"), std::string::npos);
  const std::string paper = content("paper.png");
  const std::size_t at = paper.find("pHYs");
  ASSERT_NE(at, std::string::npos);
  // Pixels per meter, big-endian, in x and y; then 1: the unit is the meter. 11811 = 300 / 0.0254.
  EXPECT_EQ(paper.substr(at + 4, 9), std::string("\x00\x00\x2e\x23\x00\x00\x2e\x23\x01", 9));
}

TEST(Png, HoldsSixteenBitsOfGray) {
  const TemporaryDirectory folder;
  const std::vector<std::uint16_t> gray = {0, 1, 255, 256, 12345, 65535};
  write_png16(folder.path() / "depth.png", 3, 2, gray);
  // Read row by row with the low-level interface, which gives the file's own big-endian samples.
  std::FILE* file = std::fopen((folder.path() / "depth.png").c_str(), "rb");
  ASSERT_NE(file, nullptr);
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_read_info(png, info);
  EXPECT_EQ(png_get_bit_depth(png, info), 16);
  EXPECT_EQ(png_get_color_type(png, info), PNG_COLOR_TYPE_GRAY);
  std::vector<std::uint16_t> read;
  for (int y = 0; y < 2; ++y) {
    std::uint8_t row[6];
    png_read_row(png, row, nullptr);
    for (int x = 0; x < 3; ++x) read.push_back(static_cast<std::uint16_t>(256 * row[2 * x] + row[2 * x + 1]));
  }
  png_destroy_read_struct(&png, &info, nullptr);
  std::fclose(file);
  EXPECT_EQ(read, gray);
}

TEST(Png, SaysWhereItCannotWrite) {
  try {
    write_png("/nonexistent/folder/a.png", test_picture(4, 4));
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("/nonexistent/folder/a.png"));
    EXPECT_THAT(error.what(), testing::HasSubstr("No such file"));
  }
}

TEST(Video, UsesFfmpegOrRefusesConcisely) {
  const TemporaryDirectory folder;
  const std::filesystem::path path = folder.path() / "run.mp4";
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) {
    EXPECT_THROW(VideoWriter(path, 65, 48, 25.0), std::runtime_error);
    return;
  }
  {
    VideoWriter abandoned(path, 65, 48, 25.0);
    abandoned.add(test_picture(65, 48));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "an abandoned video leaves nothing";
  VideoWriter video(path, 65, 48, 25.0);
  for (int i = 0; i < 10; ++i) video.add(test_picture(65, 48));
  EXPECT_THROW(video.add(test_picture(64, 48)), std::invalid_argument);
  video.finish();
  // Ten frames of the next even size come out again.
  const std::string raw = (folder.path() / "frames.rgb").string();
  ASSERT_EQ(std::system(("ffmpeg -loglevel error -i " + path.string() + " -f rawvideo -pix_fmt rgb24 " + raw).c_str()),
            0);
  EXPECT_EQ(std::filesystem::file_size(raw), 10U * 66 * 48 * 3);
}

// In DejaVu Sans 2.37 all digits are 1303 of 2048 units wide and capitals 1493 high: a running clock does not jitter.
TEST(Text, HasWidthGivenByFont) {
  EXPECT_EQ(text_width_px("", 9.0F), 0.0F);
  for (const char* text : {"0", "1", "8"}) EXPECT_NEAR(text_width_px(text, 149.3F), 130.3F, 0.1F) << text;
  EXPECT_NEAR(text_width_px("10.25", 20.0F), text_width_px("10.", 20.0F) + text_width_px("25", 20.0F), 1e-3F);
  EXPECT_EQ(text_width_px("\xc3\xa9", 20.0F), text_width_px("e", 20.0F)) << "UTF-8 is one letter";
}

TEST(Text, ClipsAtEdges) {
  Image image(200, 60, Rgb::Constant(0.5F));
  draw_text(image, -50.0F, 2.0F, "clipped on all sides of the picture", {.height_px = 40.0F});
  for (const char* text : {"\xc3\xa9", "\xff", "\xe2\x82", "\xf0"}) draw_text(image, 190.0F, 70.0F, text, {});
}

// The values that matplotlib publishes, at every eighth.
TEST(Colors, OfIntensitiesAreThoseOfViridis) {
  const int published[9][3] = {{68, 1, 84},    {71, 44, 122}, {59, 82, 139},  {44, 113, 142}, {33, 145, 140},
                               {39, 173, 129}, {94, 201, 98}, {170, 220, 50}, {253, 231, 37}};
  for (int i = 0; i < 9; ++i) {
    const Rgb found = 255.0F * viridis_like(static_cast<float>(i) / 8.0F);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], published[i][c], 1e-2F) << i;
  }
  EXPECT_EQ(viridis_like(-1.0F), viridis_like(0.0F));
  EXPECT_EQ(viridis_like(2.0F), viridis_like(1.0F));
}

TEST(Colors, BecomeLinearAsTheStandardSays) {
  // IEC 61966-2-1: a straight piece, then the power of 2.4.
  for (const float s : {0.0F, 0.02F, 0.0404F, 0.0405F, 0.1F, 0.5F, 1.0F}) {
    const double expected = s <= 0.04045F ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(to_linear(Rgb::Constant(s)).x(), expected, 1e-6) << s;
  }
  EXPECT_NEAR(to_linear(Rgb(0.2F, 0.5F, 0.7F)).y(), 0.21404, 1e-4);
}

TEST(Colors, OfHeightsLightenMonotonically) {
  float last = -1.0F;
  for (int i = 0; i <= 100; ++i) {
    const Rgb linear = to_linear(viridis_like(static_cast<float>(i) / 100.0F));
    const float luminance = 0.2126F * linear.x() + 0.7152F * linear.y() + 0.0722F * linear.z();
    EXPECT_GT(luminance, last) << i;
    last = luminance;
  }
}

TEST(Colors, DifferAsOklabSays) {
  EXPECT_NEAR(color_difference(Rgb::Zero(), Rgb::Ones()), 1.0F, 1e-3F);
  EXPECT_EQ(color_difference(vehicle_color(3), vehicle_color(3)), 0.0F);
  // Published with the space: red is (0.628, 0.225, 0.126), blue (0.452, -0.032, -0.312).
  EXPECT_NEAR(color_difference({1, 0, 0}, {0, 0, 1}), std::sqrt(0.176 * 0.176 + 0.257 * 0.257 + 0.438 * 0.438), 2e-3);
}

TEST(Colors, OfVehiclesAndSurfacesAreDistinguishable) {
  std::vector<Rgb> vehicles, surfaces = {class_color(static_cast<std::uint16_t>(SurfaceClass::kVehicle))};
  for (VehicleId v = 0; v < 10; ++v) vehicles.push_back(vehicle_color(v));
  for (const char* name : static_class_names())
    surfaces.push_back(class_color(static_cast<std::uint16_t>(*surface_class_of(name))));
  for (const std::vector<Rgb>& colors : {vehicles, surfaces}) {
    for (std::size_t a = 0; a < colors.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) EXPECT_GE(color_difference(colors[a], colors[b]), 0.1F) << a << " " << b;
    }
  }
  const Rgb late = vehicle_color(1234);
  EXPECT_TRUE(late.minCoeff() >= 0.0F && late.maxCoeff() <= 1.0F);
}

TEST(Captions, RoundToNiceNumbers) {
  EXPECT_DOUBLE_EQ(round_down_nicely(7.3), 5.0);
  EXPECT_DOUBLE_EQ(round_down_nicely(4.99), 2.0);
  EXPECT_DOUBLE_EQ(round_down_nicely(0.1), 0.1);
  EXPECT_DOUBLE_EQ(round_down_nicely(199.0), 100.0);
  EXPECT_EQ(tick_text(2.5, 0.5), "2.5");
  EXPECT_EQ(tick_text(-20.0, 10.0), "-20");
}

TEST(DepthPicture, ColorsNearFarAndMissingDistinctly) {
  DepthImage depth{300, 200, std::vector<float>(300 * 200, 0.0F)};
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 100; ++x) depth.depth_m[y * 300 + x] = x < 50 ? 2.0F : 19.0F;
  }
  const Image image = depth_colors(depth, 20.0, Rgb::Constant(0.5F));
  EXPECT_GT(image.pixel(20, 100)[2], image.pixel(20, 100)[0]);
  EXPECT_GT(image.pixel(80, 100)[0], image.pixel(80, 100)[2]);
  EXPECT_EQ(image.pixel(150, 100)[0], image.pixel(150, 100)[2]);
  EXPECT_DOUBLE_EQ(depth_scale_end_m(depth), 20.0);
}

TEST(Text, FollowsItsAlignment) {
  const float width = text_width_px("left", 20.0F);
  for (const Align align : {Align::kLeft, Align::kCenter, Align::kRight}) {
    Image image(300, 60, Rgb::Constant(0.5F));
    draw_text(image, 150.0F, 40.0F, "left",
              {.height_px = 20.0F, .color = Rgb::Ones(), .align = align, .halo_alpha = 0.0F});
    int left = 300, right = 0;
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 300; ++x) {
        if (image.pixel(x, y)[0] > 200) left = std::min(left, x), right = std::max(right, x);
      }
    }
    const float begin = 150.0F - (align == Align::kLeft ? 0.0F : align == Align::kCenter ? 0.5F * width : width);
    EXPECT_NEAR(left, begin, 3);
    EXPECT_NEAR(right, begin + width, 3);
  }
}

TEST(Image, ClipsRectanglesAtItsEdges) {
  Image image(12, 9, Rgb::Zero());
  for (const auto& [left, top] : {std::pair(-3, -2), {10, 7}, {20, 0}, {0, -9}})
    blend_rectangle(image, left, top, 5, 4, Rgb::Ones(), 1.0F);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 12; ++x) EXPECT_EQ(image.pixel(x, y)[0], (x < 2 && y < 2) || (x >= 10 && y >= 7) ? 255 : 0);
  }
}

}  // namespace
}  // namespace swiftlet::sim
