// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {

inline std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, at);) words.push_back(word);
  return words;
}

inline std::vector<double> numbers_of(const std::string& line, char at = ' ') {
  std::vector<double> numbers;
  for (const std::string& word : split(line, at)) numbers.push_back(std::stod(word));
  return numbers;
}

}  // namespace swiftlet::sim
