// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "sim/render/image.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {

/// Sends pictures to the ffmpeg program, which encodes an H.264 file (.mp4), complete when finish() returns.
class VideoWriter {
 public:
  /// Throws std::runtime_error when ffmpeg is not installed.
  VideoWriter(std::filesystem::path path, int width, int height, double frames_per_s);
  /// Without finish(): stops ffmpeg and deletes the file.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Throws std::runtime_error when ffmpeg has ended, std::invalid_argument when the picture has another size.
  void add(const Image& frame);
  void finish();

 private:
  std::filesystem::path path_;
  PartialFile file_;
  int width_ = 0;
  int height_ = 0;
  int pipe_ = -1;
  int child_ = -1;
};

}  // namespace swiftlet::sim
