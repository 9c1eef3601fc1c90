// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <string_view>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/sim/io/byte_buffer.hpp"

namespace swiftlet::sim {

enum class RosDialect { kRos1, kRos2 };

/// Serializes one ROS message, field by field. ROS 1: packed. ROS 2: little-endian CDR (OMG RTPS 2.3, 10: four bytes of
/// encapsulation header, then every number aligned to its own size, strings with terminating zero). Any frame, the same
/// for all arguments: the header of a message names it.
class RosEncoder {
 public:
  /// @param start_time  added to every time; for times since 1970
  explicit RosEncoder(RosDialect dialect, TimeNs start_time = 0) : dialect_(dialect), start_time_(start_time) {}
  RosDialect dialect() const { return dialect_; }
  TimeNs recorded(TimeNs t) const { return start_time_ + t; }

  void begin();
  std::span<const std::byte> bytes() const { return buffer_.bytes(); }

  template <class Number>
  void put(Number value) {
    if (dialect_ == RosDialect::kRos2) align(sizeof value);
    buffer_.put(value);
  }
  void put(bool value) { put(static_cast<std::uint8_t>(value)); }
  void text(std::string_view text);
  void time(TimeNs t);
  /// std_msgs/Header; only ROS 1 has the sequence number.
  void header(std::uint32_t sequence, TimeNs t, std::string_view frame);
  void vector3(const Vector3& v);  ///< also a point
  void rotation(const Eigen::Quaterniond& q);
  void pose(const Pose& pose) { put_pose(pose.translation(), Eigen::Quaterniond(pose.linear())); }
  void put_pose(const Vector3& position, const Eigen::Quaterniond& q);
  template <class Derived>
  void row_major(const Eigen::MatrixBase<Derived>& matrix) {  ///< an array of fixed length
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
      for (Eigen::Index j = 0; j < matrix.cols(); ++j) put(static_cast<double>(matrix(i, j)));
    }
  }
  /// Length of the following sequence.
  void count(std::size_t count) { put(static_cast<std::uint32_t>(count)); }
  /// A sequence of bytes; the caller must fill it before the next field.
  std::byte* blob(std::size_t size);

 private:
  void align(std::size_t size);

  RosDialect dialect_;
  TimeNs start_time_;
  ByteBuffer buffer_;
};

}  // namespace swiftlet::sim
