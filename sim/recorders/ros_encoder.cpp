// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/ros_encoder.hpp"

#include <algorithm>

namespace swiftlet::sim {
namespace {

/// [bytes] Encapsulation header of a CDR message. Numbers are aligned relative to its end.
constexpr std::size_t kEncapsulationBytes = 4;

}  // namespace

void RosEncoder::begin() {
  buffer_.clear();
  if (dialect_ == RosDialect::kRos2) buffer_.put(std::uint32_t{0x00000100});  // bytes 00 01 00 00: CDR, little-endian
}

void RosEncoder::text(std::string_view text) {
  const bool ends_with_zero = dialect_ == RosDialect::kRos2;
  count(text.size() + (ends_with_zero ? 1 : 0));
  buffer_.put_text(text);
  if (ends_with_zero) buffer_.put(std::uint8_t{0});
}

void RosEncoder::time(TimeNs t) {
  t = recorded(t);
  // A time of ROS 1 is unsigned, so earlier times become zero. A time of ROS 2 before zero has negative seconds and
  // non-negative nanoseconds.
  if (dialect_ == RosDialect::kRos1) t = std::max<TimeNs>(t, 0);
  const TimeNs nanoseconds = (t % kNsPerSecond + kNsPerSecond) % kNsPerSecond;
  put(static_cast<std::int32_t>((t - nanoseconds) / kNsPerSecond));
  put(static_cast<std::uint32_t>(nanoseconds));
}

void RosEncoder::header(std::uint32_t sequence, TimeNs t, std::string_view frame) {
  if (dialect_ == RosDialect::kRos1) put(sequence);
  time(t);
  text(frame);
}

void RosEncoder::vector3(const Vector3& v) {
  for (int i = 0; i < 3; ++i) put(v[i]);
}

void RosEncoder::rotation(const Eigen::Quaterniond& q) {
  for (const double value : {q.x(), q.y(), q.z(), q.w()}) put(value);
}

void RosEncoder::put_pose(const Vector3& position, const Eigen::Quaterniond& q) {
  vector3(position);
  rotation(q);
}

std::byte* RosEncoder::blob(std::size_t size) {
  count(size);
  return buffer_.grow(size);
}

void RosEncoder::align(std::size_t size) {
  const std::size_t excess = (buffer_.size() - kEncapsulationBytes) % size;
  if (excess != 0) buffer_.grow(size - excess);
}

}  // namespace swiftlet::sim
