// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/render/colors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {
namespace {

using Bytes = std::array<std::uint8_t, 3>;

constexpr float kMinContrast = 4.5F;  // luminance ratio of text to its halo (WCAG 2, level AA)

Rgb rgb_of(const Bytes& bytes) { return Rgb(bytes[0], bytes[1], bytes[2]) / 255.0F; }

// Linear interpolation between evenly spaced colors.
Rgb between(std::span<const Bytes> anchors, float s) {
  const float position = std::clamp(s, 0.0F, 1.0F) * static_cast<float>(anchors.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(position), anchors.size() - 2);
  const float f = position - static_cast<float>(i);
  return (1.0F - f) * rgb_of(anchors[i]) + f * rgb_of(anchors[i + 1]);
}

constexpr Bytes kViridis[] = {{68, 1, 84},    {71, 44, 122}, {59, 82, 139},  {44, 113, 142}, {33, 145, 140},
                              {39, 173, 129}, {94, 201, 98}, {170, 220, 50}, {253, 231, 37}};
constexpr Bytes kTurbo[] = {{48, 18, 59},   {67, 88, 203},  {70, 145, 253}, {32, 200, 222},
                            {44, 240, 158}, {128, 255, 86}, {194, 241, 52}, {243, 199, 58},
                            {254, 140, 39}, {235, 80, 14},  {189, 34, 2},   {122, 4, 3}};
constexpr Bytes kVehicles[] = {{230, 57, 53},  {33, 120, 230}, {255, 179, 0},  {171, 71, 205}, {0, 188, 196},
                               {244, 112, 32}, {236, 64, 150}, {140, 200, 30}, {92, 72, 190},  {200, 160, 110}};

}  // namespace

Rgb viridis_like(float s) { return between(kViridis, s); }
Rgb turbo_like(float s) { return between(kTurbo, s); }

Rgb height_color(float s) { return turbo_like(0.14F + 0.72F * std::clamp(s, 0.0F, 1.0F)); }

Rgb vehicle_color(VehicleId vehicle) {
  const auto index = static_cast<std::size_t>(std::max(vehicle, 0));
  if (index < std::size(kVehicles)) return rgb_of(kVehicles[index]);
  // Further colors: hues at multiples of the golden ratio.
  const double hue = 6.0 * std::fmod(0.618033988749895 * static_cast<double>(index), 1.0);
  Rgb color;
  for (int c = 0; c < 3; ++c) {
    const double k = std::fmod(hue + (c == 0 ? 0.0 : c == 1 ? 4.0 : 2.0), 6.0);
    color[c] = static_cast<float>(0.92 - 0.72 * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
  }
  return color;
}

Rgb class_color(std::uint16_t surface_class) {
  switch (static_cast<SurfaceClass>(surface_class)) {
    case SurfaceClass::kGround:
      return rgb_of({186, 164, 128});
    case SurfaceClass::kKerb:
      return rgb_of({170, 120, 190});
    case SurfaceClass::kBuilding:
      return rgb_of({255, 200, 0});
    case SurfaceClass::kWall:
      return rgb_of({240, 140, 40});
    case SurfaceClass::kDoor:
      return rgb_of({250, 90, 140});
    case SurfaceClass::kPillar:
      return rgb_of({110, 160, 245});
    case SurfaceClass::kCeiling:
      return rgb_of({205, 210, 235});
    case SurfaceClass::kVegetation:
      return rgb_of({40, 190, 70});
    case SurfaceClass::kTrunk:
      return rgb_of({125, 65, 25});
    case SurfaceClass::kBranch:
      return rgb_of({190, 105, 55});
    case SurfaceClass::kUndergrowth:
      return rgb_of({150, 235, 80});
    case SurfaceClass::kFallenTrunk:
      return rgb_of({120, 60, 110});
    case SurfaceClass::kRack:
      return rgb_of({40, 85, 220});
    case SurfaceClass::kPallet:
      return rgb_of({245, 210, 165});
    case SurfaceClass::kMarking:
      return rgb_of({255, 255, 90});
    case SurfaceClass::kObject:
      return rgb_of({60, 215, 205});
    case SurfaceClass::kVehicle:
      return rgb_of({255, 40, 40});
    case SurfaceClass::kUnlabeled:
      break;
  }
  return rgb_of({130, 130, 130});
}

Rgb part_color(const VehicleShape& shape, const Mesh& mesh, VehicleId vehicle) {
  const Rgb material =
      mesh.material < shape.materials.size() ? shape.materials[mesh.material].color_rgb : Rgb::Constant(0.3F);
  const Rgb own = vehicle_color(vehicle);
  switch (mesh.part) {
    case VehiclePart::kBody:
      return own;
    case VehiclePart::kArm:
      return 0.75F * own + 0.25F * material;
    case VehiclePart::kMotor:
      return Rgb(0.16F, 0.16F, 0.18F);
    default:
      return material;
  }
}

Rgb to_linear(const Rgb& srgb) {
  return srgb.unaryExpr([](float s) { return s <= 0.04045F ? s / 12.92F : std::pow((s + 0.055F) / 1.055F, 2.4F); });
}

float luminance(const Rgb& srgb) { return Rgb(0.2126F, 0.7152F, 0.0722F).dot(to_linear(srgb)); }

Rgb ink_of(const Rgb& srgb) {
  Rgb ink = srgb;
  while (1.05F < kMinContrast * (luminance(ink) + 0.05F)) ink *= 0.97F;
  return ink;
}

float color_difference(const Rgb& a_srgb, const Rgb& b_srgb) {
  const auto oklab = [](const Rgb& srgb) {
    Eigen::Matrix3f cones, lab;
    cones << 0.4122214708F, 0.5363325363F, 0.0514459929F, 0.2119034982F, 0.6806995451F, 0.1073969566F, 0.0883024619F,
        0.2817188376F, 0.6299787005F;
    lab << 0.2104542553F, 0.7936177850F, -0.0040720468F, 1.9779984951F, -2.4285922050F, 0.4505937099F, 0.0259040371F,
        0.7827717662F, -0.8086757660F;
    return Eigen::Vector3f(lab * (cones * to_linear(srgb)).unaryExpr([](float s) { return std::cbrt(s); }));
  };
  return (oklab(a_srgb) - oklab(b_srgb)).norm();
}

}  // namespace swiftlet::sim
