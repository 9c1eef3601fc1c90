// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace swiftlet::sim {

/// Key of an earlier version and the key that has its role. Both are ends of key paths.
struct RetiredKey {
  std::string_view key;
  std::string_view replacement;
};

/// A renamed or merged key gets a row, so that scenarios of earlier versions are refused with its replacement.
inline constexpr RetiredKey kRetiredKeys[] = {
    {"global.locate", "global.closures"},     {"global.share.search", "global.closures"},
    {"told_existence", "reported_existence"}, {"max_told", "max_sent"},
    {"tell_rays_to", "send_rays_to"},
};

/// `; replaced by "global.closures"` for the path of a retired key, otherwise empty.
inline std::string replacement_hint(std::string_view path) {
  for (const RetiredKey& retired : kRetiredKeys) {
    if (path == retired.key || path.ends_with("." + std::string(retired.key)))
      return "; replaced by \"" + std::string(retired.replacement) + "\"";
  }
  return "";
}

}  // namespace swiftlet::sim
