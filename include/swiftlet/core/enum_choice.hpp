// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <string>
#include <type_traits>

#include "swiftlet/core/config.hpp"

namespace swiftlet {

/// A choice that the program keeps as an enum and that files know by a word. The words come in the order of the enum's
/// values, which count from 0.
template <class Enum>
requires std::is_enum_v<Enum>
void enum_choice(ConfigVisitor& v, const char* key, Enum& value, std::initializer_list<const char*> words,
                 const char* doc) {
  std::string word = words.begin()[static_cast<std::size_t>(value)];
  v.choice(key, word, words, doc);
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (word == words.begin()[i]) value = static_cast<Enum>(i);
  }
}

}  // namespace swiftlet
