// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/render/render_config.hpp"

namespace swiftlet::sim {

/// Takes the pictures of a scenario's `snapshots`: snapshots/CAMERA_0012.300s.png, and for depth cameras also the depth
/// in millimeters as 16-bit gray (CAMERA_0012.300s.mm.png). OpenGL is initialized when the first picture is due.
std::unique_ptr<Recorder> make_snapshot_recorder(std::vector<CameraConfig> cameras);

/// The pictures of `snapshots` as one video per camera: snapshots/CAMERA.mp4 (needs the ffmpeg program).
std::unique_ptr<Recorder> make_video_recorder(std::vector<CameraConfig> cameras, double frames_per_s);

}  // namespace swiftlet::sim
