// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

namespace swiftlet::sim {

/// Parses what somebody else may have written. What is no JSON becomes a discarded value. So does what is nested deeper
/// than any file of ours, because libraries walk a document by calling themselves.
template <class Json, class Input>
Json parse_shallow(Input&& input) {
  constexpr int kMaxDepth = 64;
  bool deep = false;
  const auto watch = [&deep](int depth, typename Json::parse_event_t, Json&) {
    deep = deep || depth > kMaxDepth;
    return !deep;
  };
  Json json = Json::parse(std::forward<Input>(input), watch, false);
  return deep ? Json(Json::value_t::discarded) : json;
}

}  // namespace swiftlet::sim
