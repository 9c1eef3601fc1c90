// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "sim/dataset/frame.hpp"
#include "swiftlet/sim/dataset/dataset_config.hpp"
#include "swiftlet/sim/dataset/sequence_recorder.hpp"
#include "swiftlet/sim/recorders/gray_png.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet::sim {

/// Encodes and writes the scans, labels and images of one sequence beside the simulation, on a thread of its own. It
/// goes frame after frame, so that the files do not depend on when it gets to run. Not more than a few frames wait for
/// it.
class FrameWriter {
 public:
  FrameWriter(ContentConfig content, std::filesystem::path directory);
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  /// The next frame. Throws what an earlier one failed with.
  void push(std::shared_ptr<const LabeledScan> scan);
  /// Waits for all of them. Throws what one of them failed with.
  /// @return frames, points, classes, ranges, shape and files
  SequenceStatistics finish();
  /// Processor time of the thread, after finish().
  double processor_s() const { return processor_s_; }

 private:
  void work();
  void write(const LabeledScan& labeled);
  void write_bytes(const std::string& name, const ByteBuffer& bytes);
  void write_images(const LabeledScan& labeled);
  void count(const LabeledScan& labeled);
  void stop();

  const ContentConfig content_;
  const std::filesystem::path directory_;

  // Between the two threads.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<const LabeledScan>> waiting_;
  std::vector<std::shared_ptr<const LabeledScan>> written_;  // given back: who made them lets go of them
  std::exception_ptr failure_;
  bool closed_ = false;

  // Of the thread.
  SequenceStatistics statistics_;
  Frame frame_;
  GrayPng png_;
  std::vector<std::uint16_t> range_image_, intensity_image_;
  std::vector<std::int64_t> classes_;  // of one frame, by label
  double processor_s_ = 0.0;

  std::thread thread_;  // last: it starts when all the rest is there
};

}  // namespace swiftlet::sim
