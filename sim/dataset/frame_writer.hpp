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
#include "swiftlet/sim/dataset/sequence_info.hpp"
#include "swiftlet/sim/recorders/gray_png.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet::sim {

/// Encodes and writes the scans, labels and images of one sequence in parallel with the simulation, on a thread of its
/// own. Frames are written in order, so that the files do not depend on the thread's timing. The queue is limited to a
/// few frames.
class FrameWriter {
 public:
  FrameWriter(ContentConfig content, std::filesystem::path directory);
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  /// Enqueues the next frame. Throws the failure of an earlier one.
  void push(std::shared_ptr<const LabeledScan> scan);
  /// Waits for all frames. Throws the failure of any.
  /// @return frames, points, classes, ranges, shape and files
  SequenceStatistics finish();
  /// Processor time of the thread; valid after finish().
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

  // Shared by both threads:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<const LabeledScan>> waiting_;
  std::vector<std::shared_ptr<const LabeledScan>> written_;  // returned to the pushing thread, which releases them
  std::exception_ptr failure_;
  bool closed_ = false;

  // Used only by the writing thread:
  SequenceStatistics statistics_;
  Frame frame_;
  GrayPng png_;
  std::vector<std::uint16_t> range_image_, intensity_image_;
  std::vector<std::int64_t> classes_;  // point counts of one frame by label
  double processor_s_ = 0.0;

  std::thread thread_;  // last member: starts when all others are constructed
};

}  // namespace swiftlet::sim
