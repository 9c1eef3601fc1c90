// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace swiftlet::sim {

/// MD5 (RFC 1321) in hexadecimal digits; ROS 1 identifies message types by it.
std::string md5(std::string_view text);

}  // namespace swiftlet::sim
