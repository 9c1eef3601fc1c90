// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/assets.hpp"

#include <map>
#include <sstream>

namespace swiftlet::sim {
namespace {

/// End of the first sentence: a period or colon before a space, outside of brackets.
std::size_t sentence_end(const std::string& text) {
  int depth = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    depth += (text[i] == '[' || text[i] == '(') - (text[i] == ']' || text[i] == ')');
    if (depth == 0 && (text[i] == '.' || text[i] == ':') && text[i + 1] == ' ') return i;
  }
  return text.size();
}

/// First sentence of the comment at the beginning of a text.
std::string head_comment(const std::string& text) {
  std::istringstream lines(text);
  std::string line, comment;
  while (std::getline(lines, line) && line.starts_with('#')) {
    line.erase(0, line.find_first_not_of("# "));
    if (line.empty() && !comment.empty()) break;
    comment += (comment.empty() ? "" : " ") + line;
  }
  comment.resize(sentence_end(comment));
  if (comment.ends_with('.')) comment.pop_back();
  return comment;
}

/// Joins the lines of a YAML text block: the indented ones after its first.
std::string block(std::istringstream& lines) {
  std::string line, text;
  while (std::getline(lines, line) && line.starts_with(' '))
    text += (text.empty() ? "" : " ") + line.substr(line.find_first_not_of(' '));
  text.resize(sentence_end(text));
  if (text.ends_with('.')) text.pop_back();
  return text;
}

/// Short description: the first sentence of `description`, otherwise of the leading comment.
std::string about(const std::string& text) {
  constexpr std::string_view kKey = "\ndescription: ";
  const std::size_t at = text.find(kKey);
  if (at == std::string::npos) return head_comment(text);
  std::istringstream lines(text.substr(at + kKey.size()));
  std::string line;
  std::getline(lines, line);
  return line.starts_with('>') || line.starts_with('|') ? block(lines) : line;
}

}  // namespace

std::vector<Asset> list_assets(const std::string& folder, const ConfigFiles& files) {
  std::vector<std::filesystem::path> folders = files.scenario_roots();
  if (folder.starts_with("scenarios/")) {
    for (std::filesystem::path& root : folders) root /= folder.substr(folder.find('/') + 1);
  } else if (folder != "scenarios") {
    folders = files.asset_roots();
    for (std::filesystem::path& root : folders) root /= folder;
  }
  std::map<std::string, std::string> docs;
  for (const std::filesystem::path& where : folders) {
    for (const std::string& file : files.list(where)) {
      if (!file.ends_with(".yaml") || !files.is_file(where / file)) continue;
      const std::string name = file.substr(0, file.size() - 5);
      // The first folder takes precedence, as in the reader.
      if (!docs.contains(name)) docs[name] = about(files.read(where / file));
    }
  }
  std::vector<Asset> assets;
  for (const auto& [name, doc] : docs) assets.push_back({name, doc});
  return assets;
}

}  // namespace swiftlet::sim
