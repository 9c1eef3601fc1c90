// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace swiftlet::sim {

/// Base64 encoding of any bytes: padded, in one line (RFC 4648, section 4).
std::string base64(std::string_view bytes);

}  // namespace swiftlet::sim
