// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The programs of the renderer, GLSL 4.50.
namespace swiftlet::sim::shaders {

// World and vehicles: color and normal; light comes later.
extern const char* const kMeshVertex;
extern const char* const kMeshFragment;
// Only depth, for shadow maps and depth pictures.
extern const char* const kDepthFragment;
// One color, for what is hidden behind something.
extern const char* const kGhostFragment;
// Already projected triangles (lines, rotor discs).
extern const char* const kClipVertex;
extern const char* const kClipFragment;
// Round points of a cloud.
extern const char* const kPointVertex;
extern const char* const kPointFragment;
// Cubes and spheres of overlays, instanced; triangles of overlays.
extern const char* const kSolidVertex;
extern const char* const kSolidFragment;
// A triangle over the whole picture: ambient occlusion, light and sky.
extern const char* const kScreenVertex;
extern const char* const kOcclusionFragment;
extern const char* const kLightFragment;

}  // namespace swiftlet::sim::shaders
