// SPDX-License-Identifier: BSD-3-Clause
#include "sim/replay/page.hpp"

#include <array>
#include <utility>

#include "embedded/sim_replay.hpp"
#include "sim/replay/block.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/sim/io/base64.hpp"

namespace swiftlet::sim {
namespace {

using Script = std::pair<std::string_view, std::string_view>;  // text and its digest

/// In the order of execution.
std::array<Script, 11> scripts() {
  using namespace embedded;
  return {{{names_js, names_js_sha256},
           {data_js, data_js_sha256},
           {draw_js, draw_js_sha256},
           {camera_js, camera_js_sha256},
           {points_js, points_js_sha256},
           {scene_js, scene_js_sha256},
           {plot_js, plot_js_sha256},
           {captions_js, captions_js_sha256},
           {panel_js, panel_js_sha256},
           {input_js, input_js_sha256},
           {app_js, app_js_sha256}}};
}

/// Digest in the format of a content security policy: 'sha256-...'.
std::string source_of(std::string_view hexadecimal) {
  const auto digit = [&](std::size_t i) {
    const char c = hexadecimal[i];
    return c <= '9' ? c - '0' : c - 'a' + 10;
  };
  std::string bytes;
  for (std::size_t i = 0; i < hexadecimal.size(); i += 2)
    bytes.push_back(static_cast<char>(digit(i) * 16 + digit(i + 1)));
  return "'sha256-" + base64(bytes) + "'";
}

void replace(std::string& text, std::string_view mark, std::string_view by) {
  const std::size_t at = text.find(mark);
  ENSURE(at != std::string::npos, mark);
  text.replace(at, mark.size(), by);
}

}  // namespace

std::string page_head(PageUse use) {
  std::string policy = "default-src 'none'; base-uri 'none'; form-action 'none'; img-src blob: data:; style-src " +
                       source_of(embedded::replay_css_sha256) + "; script-src";
  for (const auto& [text, digest] : scripts()) policy += " " + source_of(digest);
  if (use == PageUse::kLive) policy += "; connect-src 'self'";
  std::string page(embedded::replay_html);
  replace(page, "{policy}", policy);
  replace(page, "{style}", embedded::replay_css);
  return page;
}

std::string page_block(std::string_view packed) {
  return "<script type=\"application/octet-stream\" class=\"block\">" + base64(packed) + "</script>\n";
}

std::string page_tail() {
  std::string tail;
  for (const auto& [text, digest] : scripts()) tail += "<script>" + std::string(text) + "</script>\n";
  return tail + "</body></html>\n";
}

}  // namespace swiftlet::sim
