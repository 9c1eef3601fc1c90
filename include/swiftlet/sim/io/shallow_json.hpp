// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {

/// Parses JSON of unknown origin. Invalid JSON gives a discarded value, and so does JSON that is nested deeper than any
/// file of Swiftlet, because libraries traverse documents recursively.
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

namespace json_value {

template <class T>
constexpr bool kIsList = false;
template <class T>
constexpr bool kIsList<std::vector<T>> = true;

/// The value as a T; empty when it has another type or does not fit into a T.
template <class T, class Json>
std::optional<T> as(const Json& value) {
  if constexpr (kIsList<T>) {
    if (!value.is_array()) return std::nullopt;
    T list;
    for (const Json& item : value) {
      auto element = as<typename T::value_type>(item);
      if (!element) return std::nullopt;
      list.push_back(std::move(*element));
    }
    return list;
  } else if constexpr (std::is_same_v<T, std::string>) {
    if (value.is_string()) return value.template get<std::string>();
  } else if constexpr (std::floating_point<T>) {
    if (value.is_number()) return value.template get<T>();
  } else if (value.is_number_unsigned()) {
    const auto number = value.template get<std::uint64_t>();
    if (std::in_range<T>(number)) return static_cast<T>(number);
  } else if (value.is_number_integer()) {
    const auto number = value.template get<std::int64_t>();
    if (std::in_range<T>(number)) return static_cast<T>(number);
  }
  return std::nullopt;
}

template <class T>
std::string name_of_type() {
  if constexpr (kIsList<T>) return "a list, each element " + name_of_type<typename T::value_type>();
  if constexpr (std::is_same_v<T, std::string>) return "a text";
  return std::is_floating_point_v<T> ? "a number" : std::is_signed_v<T> ? "a whole number" : "a whole number >= 0";
}

}  // namespace json_value

/// The value of a key, checked for type and range. Throws InputError "KEY: expected ...".
template <class T, class Json>
T json_at(const Json& json, const std::string& key) {
  const auto found = json.find(key);
  if (found == json.end()) throw InputError(key + ": expected " + json_value::name_of_type<T>() + ", found nothing");
  auto value = json_value::as<T>(*found);
  if (!value) throw InputError(key + ": expected " + json_value::name_of_type<T>() + ", found something else");
  return std::move(*value);
}

}  // namespace swiftlet::sim
