// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace swiftlet::sim {

/// XXH3, 128 bits, as `xxhsum -H128` prints it.
struct Hash128 {
  std::uint64_t high = 0, low = 0;
  bool operator==(const Hash128&) const = default;
};

Hash128 hash_of(std::string_view bytes);
/// Hash of the file's content. Throws std::runtime_error with path and reason.
Hash128 hash_of_file(const std::filesystem::path& path);
/// 32 hexadecimal digits.
std::string hex(const Hash128& hash);

}  // namespace swiftlet::sim
