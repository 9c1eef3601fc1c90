// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/document.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "swiftlet/sim/scenario/suggest.hpp"

namespace swiftlet::sim {
namespace {

using Kind = Node::Kind;

// --- text ---

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }

/// True for a byte of a UTF-8 sequence after its first.
bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

/// Length of the UTF-8 sequence that starts at `i`; 0 when it is malformed, overlong or a surrogate.
std::size_t utf8_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char lead = byte(i);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || i + length > text.size()) return 0;
  for (std::size_t k = i + 1; k < i + length; ++k) {
    if (!is_continuation(text[k])) return 0;
  }
  const unsigned char next = byte(i + 1);
  const bool bad = (lead == 0xE0 && next < 0xA0) || (lead == 0xED && next > 0x9F) || (lead == 0xF0 && next < 0x90) ||
                   (lead == 0xF4 && next > 0x8F);
  return bad ? 0 : length;
}

bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); i += utf8_length(text, i)) {
    if (utf8_length(text, i) == 0) return false;
  }
  return true;
}

/// Two hexadecimal digits: "ff".
std::string hex(unsigned char byte) {
  constexpr char kDigits[] = "0123456789abcdef";
  return {kDigits[byte >> 4], kDigits[byte & 15]};
}

/// Rejects texts that are not plain before parsing.
void check_text(std::string_view text, const std::shared_ptr<const Source>& source) {
  int line = 1;
  std::size_t line_start = 0;
  bool indentation = true;
  std::size_t tab = std::string::npos;  // first tab in the indentation
  for (std::size_t i = 0; i < text.size();) {
    const Place place{source, line, static_cast<int>(i - line_start) + 1};
    const std::size_t length = utf8_length(text, i);
    const auto byte = static_cast<unsigned char>(text[i]);
    if (length == 0) fail(place, "", "expected UTF-8 text, found the byte 0x" + hex(byte));
    if (byte == '\n') {
      ++line;
      line_start = i + 1;
      indentation = true;
      tab = std::string::npos;
    } else if (byte == '\t' && indentation) {
      tab = std::min(tab, i);
    } else if ((byte < 0x20 && byte != '\t' && byte != '\r') || byte == 0x7F) {
      fail(place, "", "expected text, found the control character 0x" + hex(byte));
    } else if (byte != ' ' && byte != '\r' && byte != '#' && tab != std::string::npos) {
      fail({source, line, static_cast<int>(tab - line_start) + 1}, "", "expected spaces as indentation, found a tab");
    } else if (byte != ' ') {
      indentation = false;
      tab = std::string::npos;
    }
    i += length;
  }
}

// --- tree ---

/// Splits "vehicles[0]" into "vehicles" and "[0]"; false for a plain key.
bool split_selector(std::string_view key, std::string_view& name, std::string_view& selector) {
  const std::size_t open = key.find('[');
  if (open == std::string_view::npos || open == 0 || key.back() != ']' || key.size() < open + 3) return false;
  name = key.substr(0, open);
  selector = key.substr(open);
  return selector.find_first_of("[]", 1) == selector.size() - 1;
}

/// Converts keys such as `vehicles[0]` into changes to elements of `vehicles`, after the plain keys of the same map.
void gather_selectors(Node& map) {
  std::string_view name, selector;
  const auto is_plain = [&](const Entry& entry) { return !split_selector(entry.key, name, selector); };
  const auto middle = std::stable_partition(map.entries.begin(), map.entries.end(), is_plain);
  std::vector<Entry> selected(std::make_move_iterator(middle), std::make_move_iterator(map.entries.end()));
  map.entries.erase(middle, map.entries.end());
  for (Entry& entry : selected) {
    split_selector(entry.key, name, selector);
    Node change;
    change.kind = Kind::kElements;
    change.place = entry.place;
    change.entries.push_back({std::string(selector), entry.place, std::move(entry.value)});
    if (Node* list = map.find(name)) {
      merge(*list, change, std::string(name));
    } else {
      map.entries.push_back({std::string(name), entry.place, std::move(change)});
    }
  }
}

void check_duplicates(const Node& map) {
  std::vector<const Entry*> sorted;
  for (const Entry& entry : map.entries) sorted.push_back(&entry);
  std::stable_sort(sorted.begin(), sorted.end(), [](const Entry* a, const Entry* b) { return a->key < b->key; });
  const Entry* duplicate = nullptr;
  const Entry* first = nullptr;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i]->key != sorted[i - 1]->key) continue;
    const bool earlier = duplicate == nullptr || sorted[i]->place.line < duplicate->place.line;
    if (earlier) {
      duplicate = sorted[i];
      first = sorted[i - 1];
    }
  }
  if (duplicate == nullptr) return;
  fail(duplicate->place, "",
       "expected each key once, found " + quote(duplicate->key) + " again (first in line " +
           std::to_string(first->place.line) + ")");
}

/// Builds the tree from the parser's events, within limits.
class Builder final : public YAML::EventHandler {
 public:
  explicit Builder(std::shared_ptr<const Source> source) : source_(std::move(source)) {}

  bool has_document() const { return documents_ > 0; }
  Node take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) fail(at(mark), "", "expected one document, found another one");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Node node = start(mark, Kind::kNull, "");
    // The parser reports the location of the next token; the key's location is more useful.
    if (!open_.empty() && open_.back().key) node.place = open_.back().key->place;
    add(std::move(node), anchor, 1);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Node node = start(mark, Kind::kScalar, tag);
    // The parser converts some escapes ("\N", "\_") into single bytes of Latin-1.
    if (!is_utf8(value)) fail(node.place, "", "expected UTF-8 text, found an escape sequence that is none");
    node.text = value;
    node.quoted = tag == "!";
    add(std::move(node), anchor, 1);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchors_.find(anchor);
    if (known == anchors_.end()) fail(at(mark), "", "expected an alias of a complete value, found one of itself");
    count(at(mark), known->second.size);
    if (depth() + known->second.depth > kMaxDepth) fail_depth(mark);
    Node copy = known->second.node;
    add(std::move(copy), 0, known->second.size, known->second.depth);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(start(mark, Kind::kList, tag), anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(start(mark, Kind::kMap, tag), anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override {
    Open& done = open_.back();
    check_duplicates(done.node);
    if (done.merge_at) lay_under(done.node, *done.merge_at);
    gather_selectors(done.node);
    close();
  }

 private:
  struct Open {
    Node node;
    YAML::anchor_t anchor = 0;
    std::size_t size = 1;
    int depth = 1;                        ///< nesting depth of the value itself
    std::optional<Entry> key;             ///< maps: key whose value is still missing
    bool merges = false;                  ///< maps: `key` is the merge key
    std::optional<std::size_t> merge_at;  ///< maps: index of the merge key's entry
  };
  struct Anchored {
    Node node;
    std::size_t size = 1;
    int depth = 1;
  };

  Place at(const YAML::Mark& mark) const { return {source_, mark.line + 1, mark.column + 1}; }
  int depth() const { return static_cast<int>(open_.size()); }

  void count(const Place& place, std::size_t size) {
    num_nodes_ += size;
    if (num_nodes_ > kMaxNodes) {
      fail(place, "", "expected at most " + std::to_string(kMaxNodes) + " values (aliases counted), found more");
    }
  }
  [[noreturn]] void fail_depth(const YAML::Mark& mark) const {
    fail(at(mark), "", "expected at most " + std::to_string(kMaxDepth) + " levels, found more");
  }

  Node start(const YAML::Mark& mark, Kind kind, const std::string& tag) {
    count(at(mark), 1);
    if (!tag.empty() && tag != "?" && tag != "!")
      fail(at(mark), "", "expected a plain value, found the tag " + quote(tag));
    const bool is_key = !open_.empty() && open_.back().node.is_map() && !open_.back().key;
    if (is_key && kind != Kind::kScalar) {
      const char* found = kind == Kind::kNull   ? "nothing"
                          : kind == Kind::kList ? "a list (or is a bracket left open?)"
                                                : "a map (or is a brace left open?)";
      fail(at(mark), "", std::string("expected a word as key, found ") + found);
    }
    Node node;
    node.kind = kind;
    node.place = at(mark);
    return node;
  }

  void open(Node node, YAML::anchor_t anchor) {
    if (depth() >= kMaxDepth)
      fail(node.place, "", "expected at most " + std::to_string(kMaxDepth) + " levels, found more");
    open_.push_back({std::move(node), anchor, 1, 1, {}, false, {}});
  }
  void close() {
    Open done = std::move(open_.back());
    open_.pop_back();
    add(std::move(done.node), done.anchor, done.size, done.depth);
  }

  void add(Node node, YAML::anchor_t anchor, std::size_t size, int depth = 1) {
    if (anchor != 0) {
      count(node.place, size);  // the copy kept for its aliases needs memory as well
      anchors_[anchor] = {node, size, depth};
    }
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    parent.size += size;
    parent.depth = std::max(parent.depth, depth + 1);
    check_size(parent.node);
    if (parent.node.is_list()) {
      parent.node.items.push_back(std::move(node));
    } else if (!parent.key) {
      if (!node.is_scalar()) fail(node.place, "", "expected a word as key, found " + describe(node));
      parent.merges = node.text == "<<" && !node.quoted;
      parent.key = Entry{std::move(node.text), node.place, {}};
    } else {
      if (parent.merges) parent.merge_at = parent.node.entries.size();
      parent.key->value = std::move(node);
      parent.node.entries.push_back(std::move(*parent.key));
      parent.key.reset();
    }
  }

  /// Applies the merge key of YAML 1.1: its map, or each map of its list, provides the missing keys.
  static void lay_under(Node& map, std::size_t merge_at) {
    Node merged = std::move(map.entries[merge_at].value);
    map.entries.erase(map.entries.begin() + static_cast<std::ptrdiff_t>(merge_at));
    std::vector<Node> sources;
    if (merged.is_list()) {
      sources = std::move(merged.items);
    } else {
      sources.push_back(std::move(merged));
    }
    std::set<std::string> known;
    for (const Entry& entry : map.entries) known.insert(entry.key);
    for (Node& source : sources) {
      if (!source.is_map()) fail(source.place, "<<", "expected a map or a list of maps, found " + describe(source));
      for (Entry& entry : source.entries) {
        if (!known.insert(entry.key).second) continue;
        check_size(map);
        map.entries.push_back(std::move(entry));
      }
    }
  }

  static void check_size(const Node& parent) {
    if (parent.items.size() >= kMaxItems) {
      fail(parent.place, "", "expected a list of at most " + std::to_string(kMaxItems) + " values, found more");
    }
    if (parent.entries.size() >= kMaxKeys) {
      fail(parent.place, "", "expected a map of at most " + std::to_string(kMaxKeys) + " keys, found more");
    }
  }

  std::shared_ptr<const Source> source_;
  int documents_ = 0;
  std::size_t num_nodes_ = 0;
  Node root_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Anchored> anchors_;
};

// --- merging ---

/// Index of the element selected by "[2]" or "[uav1]"; npos when absent.
std::size_t element_index(const Node& list, std::string_view selector) {
  const std::string_view word = selector.substr(1, selector.size() - 2);
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
  if (error == std::errc() && end == word.data() + word.size())
    return index < list.items.size() ? index : std::string::npos;
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const Node* name = list.items[i].find("name");
    if (name != nullptr && name->is_scalar() && name->text == word) return i;
  }
  return std::string::npos;
}

/// "[uav*]" selects all elements whose names begin with uav.
bool is_named_like(const Node& item, std::string_view selector) {
  const std::string_view word = selector.substr(1, selector.size() - 2);
  const Node* name = item.find("name");
  return word == "*" ||
         (name != nullptr && name->is_scalar() && name->text.starts_with(word.substr(0, word.size() - 1)));
}

bool chooses_another_type(const Node& base, const Node& over) {
  const Node* now = base.find("type");
  const Node* then = over.find("type");
  return now != nullptr && then != nullptr && now->text != then->text;
}

/// True if a vehicle of the list has a `count`.
bool has_counts(const Node& list) {
  return std::any_of(list.items.begin(), list.items.end(),
                     [](const Node& item) { return item.find("count") != nullptr; });
}

/// Expands the short form `detector: vofod` to `detector: {type: vofod}`, so that further keys can be merged.
void spell_out_type(Node& node, const Place& place) {
  Node type = node;
  node.kind = Kind::kMap;
  node.text.clear();
  node.place = place;
  node.entries.push_back({"type", type.place, std::move(type)});
}

/// Merges trees; limits the number of copied values, since a change to every element of a list multiplies.
class Merger {
 public:
  void merge(Node& base, const Node& over, const std::string& path) {
    if (over.kind == Kind::kElements) {
      if (base.is_list()) return change_elements(base, over, path);
      if (base.kind != Kind::kElements) {
        fail(over.place, path, "expected a list whose elements can be changed, found " + describe(base));
      }
      pay(over);
      base.entries.insert(base.entries.end(), over.entries.begin(), over.entries.end());
      return;
    }
    if (base.is_scalar() && over.is_map() && over.find("type") == nullptr) spell_out_type(base, over.place);
    if (!base.is_map() || !over.is_map() || chooses_another_type(base, over)) {
      pay(over);
      base = over;
      return;
    }
    for (const Entry& entry : over.entries) {
      if (Node* value = base.find(entry.key)) {
        merge(*value, entry.value, join_path(path, entry.key));
      } else {
        pay(entry.value);
        base.entries.push_back(entry);
      }
    }
  }

 private:
  void change_elements(Node& list, const Node& changes, const std::string& path) {
    for (const Entry& change : changes.entries) {
      if (path == "vehicles" && has_counts(list)) {
        change_later(list, change, path);
      } else {
        change_element(list, change, path);
      }
    }
  }

  void change_element(Node& list, const Entry& change, const std::string& path) {
    if (change.key.ends_with("*]")) {
      bool found = change.key == "[*]";
      for (std::size_t i = 0; i < list.items.size(); ++i) {
        if (!is_named_like(list.items[i], change.key)) continue;
        merge_element(list, i, change.value, path);
        found = true;
      }
      if (!found) fail_selector(list, change, path);
      return;
    }
    const std::size_t index = element_index(list, change.key);
    if (index == std::string::npos) fail_selector(list, change, path);
    merge_element(list, index, change.value, path);
  }

  /// Single vehicles exist only after expand_team(). Until then a change of `count` is applied, and others remain
  /// pending as entries of the list.
  void change_later(Node& list, const Entry& change, const std::string& path) {
    Entry count = change, rest = change;
    std::erase_if(count.value.entries, [](const Entry& entry) { return entry.key != "count"; });
    std::erase_if(rest.value.entries, [](const Entry& entry) { return entry.key == "count"; });
    if (!count.value.entries.empty()) change_element(list, count, path);
    if (rest.value.is_map() && rest.value.entries.empty()) return;
    pay(rest.value);
    list.entries.push_back(std::move(rest));
  }

  void merge_element(Node& list, std::size_t index, const Node& over, const std::string& path) {
    merge(list.items[index], over, path + "[" + std::to_string(index) + "]");
  }

  [[noreturn]] static void fail_selector(const Node& list, const Entry& change, const std::string& path) {
    const std::string word = change.key.substr(1, change.key.size() - 2);
    std::vector<std::string> names;
    for (const Node& item : list.items) {
      if (const Node* name = item.find("name"); name != nullptr && name->is_scalar()) names.push_back(name->text);
    }
    fail(change.place, join_path("", path + change.key),
         list.items.empty() ? "expected an element of the list, which is empty, found " + quote(word)
                            : "expected an index below " + std::to_string(list.items.size()) +
                                  ", the name of an element or *, found " + quote(word) + did_you_mean(word, names));
  }

  void pay(const Node& copied) {
    num_copied_ += num_nodes(copied);
    if (num_copied_ > 2 * kMaxNodes) {
      fail(copied.place, "", "expected at most " + std::to_string(2 * kMaxNodes) + " changed values, found more");
    }
  }

  std::size_t num_copied_ = 0;
};

// --- overrides ---

/// True for UTF-8 without control characters, of at most 1000 bytes.
bool is_plain_line(const std::string& text) {
  return text.size() <= 1000 && is_utf8(text) && std::none_of(text.begin(), text.end(), is_control);
}

/// "vehicles[0].start.yaw_deg" -> "vehicles", "[0]", "start", "yaw_deg"; empty when malformed.
std::vector<std::string> split_path(const std::string& path) {
  if (!is_plain_line(path)) return {};
  std::vector<std::string> parts;
  std::size_t i = 0;
  while (i <= path.size()) {
    const std::size_t end = std::min(path.find_first_of(".[", i), path.size());
    if (end == i) return {};
    parts.push_back(path.substr(i, end - i));
    i = end;
    if (i < path.size() && path[i] == '[') {
      const std::size_t close = path.find(']', i);
      if (close == std::string::npos || close == i + 1) return {};
      parts.push_back(path.substr(i, close + 1 - i));
      i = close + 1;
    }
    if (i == path.size()) return parts;
    if (path[i] != '.') return {};
    ++i;
  }
  return {};
}

/// Overrides have no lines: their location is the option as a whole.
void forget_lines(Node& node, const std::shared_ptr<const Source>& source) {
  node.place = {source, 0, 0};
  for (Node& item : node.items) forget_lines(item, source);
  for (Entry& entry : node.entries) {
    entry.place = node.place;
    forget_lines(entry.value, source);
  }
}

}  // namespace

std::string Place::str() const {
  const std::string name = source ? source->name : "";
  return line > 0 ? name + ":" + std::to_string(line) + ":" + std::to_string(column) : name;
}

const Node* Node::find(std::string_view key) const {
  for (const Entry& entry : entries) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

Node* Node::find(std::string_view key) { return const_cast<Node*>(std::as_const(*this).find(key)); }

Node parse_document(const std::string& text, Source source_value) {
  const auto source = std::make_shared<const Source>(std::move(source_value));
  const Place whole{source, 0, 0};
  if (text.size() > kMaxFileBytes) {
    fail(whole, "",
         "expected at most " + std::to_string(kMaxFileBytes / 1'000'000) + " MB, found " +
             std::to_string(text.size() / 1'000'000) + " MB");
  }
  check_text(text, source);
  Builder builder(source);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    const Place place = error.mark.is_null() ? whole : Place{source, error.mark.line + 1, error.mark.column + 1};
    fail(place, "", "expected YAML, found a mistake: " + error.msg);
  }
  if (!builder.has_document()) fail(whole, "", "expected a map of keys, found an empty text");
  return builder.take();
}

void merge(Node& base, const Node& over, const std::string& path) { Merger().merge(base, over, path); }

std::size_t num_nodes(const Node& node) {
  std::size_t count = 1;
  for (const Node& item : node.items) count += num_nodes(item);
  for (const Entry& entry : node.entries) count += num_nodes(entry.value);
  return count;
}

Node parse_override(const std::string& path, const std::string& value) {
  const auto source = std::make_shared<const Source>(Source{"--set " + path, std::filesystem::path(".")});
  const Place place{source, 0, 0};
  const std::vector<std::string> parts = split_path(path);
  if (parts.empty() || parts.size() > kMaxDepth) {
    fail({std::make_shared<const Source>(Source{"--set", "."}), 0, 0}, "",
         "expected a path such as vehicles[0].start.yaw_deg, found " + quote(path));
  }
  Node node;
  if (value.find_first_not_of(" \t\r\n") != std::string::npos) node = parse_document(value, *source);
  forget_lines(node, source);
  for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
    Node parent;
    parent.kind = part->front() == '[' ? Kind::kElements : Kind::kMap;
    parent.place = place;
    parent.entries.push_back({*part, place, std::move(node)});
    node = std::move(parent);
  }
  return node;
}

const Place* place_of_key(const Node& changes, const std::string& key) {
  for (const Entry& entry : changes.entries) {
    if (entry.key == key) return &entry.place;
    if (!key.starts_with(entry.key)) continue;
    std::string rest = key.substr(entry.key.size());
    if (rest.front() == '.') rest.erase(0, 1);
    if (const Place* place = place_of_key(entry.value, rest)) return place;
  }
  return nullptr;
}

std::string quote(std::string_view text) {
  constexpr std::size_t kMaxShown = 60;
  std::string shown = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    // Shortens only between characters.
    if (shown.size() > kMaxShown && !is_continuation(text[i])) return shown + "...\"";
    if (byte == '\n') {
      shown += "\\n";
    } else if (byte == '\t') {
      shown += "\\t";
    } else if (is_control(text[i])) {
      shown += "\\x";
      shown += hex(byte);
    } else {
      shown += text[i];
    }
  }
  return shown + "\"";
}

std::string describe(const Node& node) {
  switch (node.kind) {
    case Kind::kNull:
      return "nothing";
    case Kind::kScalar:
      return quote(node.text);
    case Kind::kList:
      return node.items.empty()       ? "an empty list"
             : node.items.size() == 1 ? "a list of 1 value"
                                      : "a list of " + std::to_string(node.items.size()) + " values";
    case Kind::kMap:
      return "a map";
    case Kind::kElements:
      return "changes to elements of a list";
  }
  return "";
}

std::string error_line(const Place& place, const std::string& path, const std::string& message) {
  const std::string where = place.str();
  const bool repeats = path.empty() || where == "--set " + path;
  std::string line = where + ": " + (repeats ? "" : path + ": ") + message;
  // Keys and file names may contain anything, but a message is one line.
  for (char& c : line) c = is_control(c) ? '?' : c;
  return line;
}

void fail(const Place& place, const std::string& path, const std::string& message) {
  throw InputError(error_line(place, path, message));
}

std::string join_path(const std::string& path, std::string_view key) {
  constexpr std::size_t kMaxShown = 60;
  std::size_t length = std::min(key.size(), kMaxShown);
  while (length < key.size() && is_continuation(key[length])) ++length;
  return (path.empty() ? "" : path + ".") + std::string(key.substr(0, length));
}

}  // namespace swiftlet::sim
