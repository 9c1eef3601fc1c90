// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace swiftlet::sim {

inline std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

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
