// SPDX-License-Identifier: BSD-3-Clause
#include "sim/scenario/changes.hpp"

#include <algorithm>

namespace swiftlet::sim {
namespace {

using Kind = Node::Kind;

/// True for a text that is valid without quotes anywhere on a line.
bool is_plain_in_flow(const std::string& text) {
  constexpr std::string_view kSafe = "_./+-% ";
  const auto safe = [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           static_cast<unsigned char>(c) >= 0x80 || kSafe.find(c) != std::string_view::npos;
  };
  const bool looks_like_a_dash = text.starts_with("- ") || text.starts_with("--") || text == "-";
  return !text.empty() && text.front() != ' ' && text.back() != ' ' && text.front() != '%' && !looks_like_a_dash &&
         std::all_of(text.begin(), text.end(), safe);
}

std::string in_quotes(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '\n') {
      quoted += "\\n";
    } else if (c == '\t') {
      quoted += "\\t";
    } else {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += c;
    }
  }
  return quoted + "\"";
}

void add(ConfigChanges& changes, const Node& node, const std::string& path);

void add_entries(ConfigChanges& changes, const Node& node, const std::string& path) {
  const bool elements = node.kind == Kind::kElements;
  const auto add_entry = [&](const Entry& entry) {
    add(changes, entry.value, path + (elements || path.empty() ? "" : ".") + entry.key);
  };
  for (const Entry& entry : node.entries) {
    if (entry.key == "type") add_entry(entry);
  }
  for (const Entry& entry : node.entries) {
    if (entry.key != "type") add_entry(entry);
  }
}

void add(ConfigChanges& changes, const Node& node, const std::string& path) {
  if ((node.is_map() && !node.entries.empty()) || node.kind == Kind::kElements) return add_entries(changes, node, path);
  changes.emplace_back(path, flow_text(node));
  for (const Entry& entry : node.entries) add(changes, entry.value, path + entry.key);  // pending changes of a list
}

std::string flow_entries(const Node& node) {
  std::string text;
  for (const Entry& entry : node.entries) {
    if (entry.value.kind == Kind::kElements) {
      for (const Entry& element : entry.value.entries) {
        text += (text.empty() ? "" : ", ") + in_quotes(entry.key + element.key) + ": " + flow_text(element.value);
      }
    } else {
      text += (text.empty() ? "" : ", ") + (is_plain_in_flow(entry.key) ? entry.key : in_quotes(entry.key)) + ": " +
              flow_text(entry.value);
    }
  }
  return text;
}

}  // namespace

ConfigChanges changes_of(const Node& map) {
  ConfigChanges changes;
  add_entries(changes, map, "");
  return changes;
}

std::string flow_text(const Node& value) {
  switch (value.kind) {
    case Kind::kNull:
      return "";
    case Kind::kScalar:
      return value.quoted || !is_plain_in_flow(value.text) ? in_quotes(value.text) : value.text;
    case Kind::kList: {
      std::string text;
      for (const Node& item : value.items) {
        text += (text.empty() ? "" : ", ") + (item.kind == Kind::kNull ? "~" : flow_text(item));
      }
      return "[" + text + "]";
    }
    case Kind::kMap:
    case Kind::kElements:
      return "{" + flow_entries(value) + "}";
  }
  return "";
}

}  // namespace swiftlet::sim
