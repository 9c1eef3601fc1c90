// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/frame_writer.hpp"

#include <algorithm>
#include <ctime>
#include <string_view>
#include <utility>

#include "sim/dataset/hash.hpp"
#include "sim/dataset/sequence_recorder.hpp"
#include "swiftlet/sim/io/output_file.hpp"

namespace swiftlet::sim {
namespace {

// [frames] Length of the queue to the writing thread. Larger values use more memory; at 1 the simulation often waits.
constexpr std::size_t kMaxWaiting = 4;

double thread_processor_s() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

FrameWriter::FrameWriter(ContentConfig content, std::filesystem::path directory)
    : content_(std::move(content)), directory_(std::move(directory)), thread_([this] { work(); }) {}

FrameWriter::~FrameWriter() { stop(); }

void FrameWriter::push(std::shared_ptr<const LabeledScan> scan) {
  std::vector<std::shared_ptr<const LabeledScan>> written;  // freed here, after the lock is released
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return waiting_.size() < kMaxWaiting || failure_; });
  if (failure_) std::rethrow_exception(failure_);
  waiting_.push_back(std::move(scan));
  written.swap(written_);
  changed_.notify_all();
}

SequenceStatistics FrameWriter::finish() {
  stop();
  if (failure_) std::rethrow_exception(failure_);
  return std::move(statistics_);
}

void FrameWriter::stop() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

void FrameWriter::work() {
  for (;;) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !waiting_.empty() || closed_; });
    if (waiting_.empty()) break;
    const std::shared_ptr<const LabeledScan>& scan = waiting_.front();  // remains in the queue until it is written
    lock.unlock();
    std::exception_ptr failure;
    try {
      write(*scan);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    written_.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
    failure_ = failure;
    changed_.notify_all();
    if (failure_) break;
  }
  processor_s_ = thread_processor_s();
}

void FrameWriter::write(const LabeledScan& labeled) {
  const int frame = static_cast<int>(statistics_.frames);
  encode_frame(labeled, content_, frame_);
  write_bytes(frame_file("velodyne", frame, "bin"), frame_.velodyne);
  write_bytes(frame_file("labels", frame, "label"), frame_.labels);
  if (content_.point_truth) write_bytes(frame_file("point_truth", frame, "bin"), frame_.point_truth);
  if (content_.images && is_image_shaped(labeled.scan)) write_images(labeled);
  count(labeled);
}

void FrameWriter::write_bytes(const std::string& name, const ByteBuffer& bytes) {
  OutputFile file(directory_ / name, 0);
  file.append(bytes.bytes());
  file.finish();
  const std::string_view text(reinterpret_cast<const char*>(bytes.bytes().data()), bytes.size());
  statistics_.files.push_back({name, bytes.size(), hex(hash_of(text))});
}

void FrameWriter::write_images(const LabeledScan& labeled) {
  const Scan& scan = labeled.scan;
  const int frame = static_cast<int>(statistics_.frames);
  if (frame == 0) statistics_.pixel_shift_by_row = pixel_shift_by_row(*scan.beams);
  encode_images(labeled, content_, range_image_, intensity_image_);
  write_bytes(frame_file("images/range", frame, "png"), png_.encode(scan.cols(), scan.rows(), range_image_));
  write_bytes(frame_file("images/intensity", frame, "png"), png_.encode(scan.cols(), scan.rows(), intensity_image_));
}

void FrameWriter::count(const LabeledScan& labeled) {
  const Scan& scan = labeled.scan;
  statistics_.rows = scan.rows();
  statistics_.columns = scan.cols();
  ++statistics_.frames;
  statistics_.points += frame_.num_points;
  classes_.resize(65536, 0);
  constexpr auto kPerMeter = static_cast<float>(1.0 / SequenceStatistics::kRangeBin_m);
  std::size_t last_label = 0;
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    const std::size_t label = labeled.truth.surface_class[i];
    ++classes_[label];
    last_label = std::max(last_label, label);
    const int bin = std::min(static_cast<int>(scan.range_m[i] * kPerMeter), SequenceStatistics::kRangeBins - 1);
    ++statistics_.points_by_range[static_cast<std::size_t>(bin)];
  }
  for (std::size_t label = 0; label <= last_label; ++label) {
    if (classes_[label] == 0) continue;
    statistics_.points_by_class[static_cast<std::uint16_t>(label)] += classes_[label];
    classes_[label] = 0;
  }
}

}  // namespace swiftlet::sim
