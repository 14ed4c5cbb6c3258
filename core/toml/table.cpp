#include "core/toml/table.h"

#include <toml++/toml.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace roseau {

struct TomlTable::Document {
  struct Complaint {
    std::int64_t line = 0;
    std::string text;
  };
  toml::table root;
  std::string source_name;
  std::vector<Complaint> complaints;
  // Keys asked for, per table, so that finish() knows the rest and can name what would have been right.
  std::map<const toml::table*, std::set<std::string, std::less<>>> asked;
  std::set<std::string> absent;
};

namespace {

const toml::table* as_table(const void* node) { return static_cast<const toml::table*>(node); }

std::string join(const std::set<std::string, std::less<>>& names) {
  std::string joined;
  for (const auto& name : names) joined += (joined.empty() ? "" : ", ") + name;
  return joined;
}

std::int64_t line_of_node(const toml::node& node) { return static_cast<std::int64_t>(node.source().begin.line); }

}  // namespace

TomlTable::TomlTable(std::shared_ptr<Document> document, const void* node, std::string path)
    : document_(std::move(document)), node_(node), path_(std::move(path)) {}

Result<TomlTable> TomlTable::parse(std::string_view text, std::string source_name) {
  try {
    auto document = std::make_shared<Document>();
    document->root = toml::parse(text, source_name);
    document->source_name = std::move(source_name);
    const void* root = &document->root;
    return TomlTable(std::move(document), root, "");
  } catch (const toml::parse_error& error) {
    const auto& begin = error.source().begin;
    return Error{ErrorCode::invalid_argument, source_name + ":" + std::to_string(begin.line) + ":" +
                                                  std::to_string(begin.column) + ": " + std::string(error.description())};
  }
}

const void* TomlTable::find(std::string_view key) const {
  const auto* table = as_table(node_);
  if (table == nullptr) {
    document_->absent.insert(path_ + std::string(key));
    return nullptr;
  }
  document_->asked[table].emplace(key);
  const auto* node = table->get(key);
  if (node == nullptr) document_->absent.insert(path_ + std::string(key));
  return node;
}

std::int64_t TomlTable::line_of(std::string_view key) const {
  const auto* table = as_table(node_);
  if (table == nullptr) return 0;
  const auto* node = table->get(key);
  return line_of_node(node != nullptr ? *node : *static_cast<const toml::node*>(table));
}

template <class T>
std::optional<T> TomlTable::read(std::string_view key, const char* type_name) {
  const auto* node = static_cast<const toml::node*>(find(key));
  if (node == nullptr) return std::nullopt;
  const auto value = node->value_exact<T>();
  if (value) return *value;
  complain(key, std::string("must be ") + type_name);
  return std::nullopt;
}

std::optional<double> TomlTable::optional_number(std::string_view key) {
  const auto* node = static_cast<const toml::node*>(find(key));
  if (node != nullptr && node->is_integer()) return static_cast<double>(node->as_integer()->get());
  return read<double>(key, "a number");
}

std::optional<std::string> TomlTable::optional_text(std::string_view key) { return read<std::string>(key, "text in quotes"); }

double TomlTable::number(std::string_view key, double fallback) { return optional_number(key).value_or(fallback); }

std::int64_t TomlTable::integer(std::string_view key, std::int64_t fallback) {
  return read<std::int64_t>(key, "a whole number").value_or(fallback);
}

bool TomlTable::boolean(std::string_view key, bool fallback) { return read<bool>(key, "true or false").value_or(fallback); }

std::string TomlTable::text(std::string_view key, std::string fallback) {
  return optional_text(key).value_or(std::move(fallback));
}

std::string TomlTable::required_text(std::string_view key) {
  if (!has(key)) complain(key, "is missing");
  return text(key, "");
}

double TomlTable::required_number(std::string_view key) {
  if (!has(key)) complain(key, "is missing");
  return number(key, 0);
}

std::vector<double> TomlTable::numbers(std::string_view key, std::size_t count) {
  const auto* node = static_cast<const toml::node*>(find(key));
  if (node == nullptr) return {};
  std::vector<double> values;
  if (const auto* array = node->as_array(); array != nullptr) {
    for (const auto& element : *array) {
      if (const auto value = element.value<double>()) values.push_back(*value);
    }
    if (values.size() == array->size() && (count == 0 || values.size() == count)) return values;
  }
  complain(key, count == 0 ? "must be a list of numbers" : "must be a list of " + std::to_string(count) + " numbers");
  return {};
}

std::vector<std::string> TomlTable::texts(std::string_view key) {
  const auto* node = static_cast<const toml::node*>(find(key));
  if (node == nullptr) return {};
  std::vector<std::string> values;
  if (const auto* array = node->as_array(); array != nullptr) {
    for (const auto& element : *array) {
      if (const auto value = element.value<std::string>()) values.push_back(*value);
    }
    if (values.size() == array->size()) return values;
  }
  complain(key, "must be a list of texts in quotes");
  return {};
}

TomlTable TomlTable::table(std::string_view key) {
  const auto* node = static_cast<const toml::node*>(find(key));
  if (node != nullptr && !node->is_table()) complain(key, "must be a table: [" + path_ + std::string(key) + "]");
  const void* inner = node != nullptr ? node->as_table() : nullptr;
  return {document_, inner, path_ + std::string(key) + "."};
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) {
  const auto* node = static_cast<const toml::node*>(find(key));
  if (node == nullptr) return {};
  std::vector<TomlTable> inner;
  const auto* array = node->as_array();
  if (array == nullptr || !std::ranges::all_of(*array, [](const toml::node& element) { return element.is_table(); })) {
    complain(key, "must be a list of tables: [[" + path_ + std::string(key) + "]]");
    return {};
  }
  for (const auto& element : *array) inner.push_back({document_, element.as_table(), path_ + std::string(key) + "."});
  return inner;
}

bool TomlTable::has(std::string_view key) const { return find(key) != nullptr; }

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  if (const auto* table = as_table(node_); table != nullptr) {
    for (const auto& [key, value] : *table) names.emplace_back(key.str());
  }
  return names;
}

void TomlTable::complain(std::string_view key, const std::string& what) {
  document_->complaints.push_back({line_of(key), "'" + path_ + std::string(key) + "' " + what});
}

std::string TomlTable::place(std::string_view key) const { return document_->source_name + ":" + std::to_string(line_of(key)); }

std::vector<std::string> TomlTable::absent() const { return {document_->absent.begin(), document_->absent.end()}; }

Result<void> TomlTable::finish() const {
  auto complaints = document_->complaints;
  for (const auto& [table, asked] : document_->asked) {
    for (const auto& [key, value] : *table) {
      if (asked.contains(key.str())) continue;
      complaints.push_back({static_cast<std::int64_t>(key.source().begin.line),
                            "unknown key '" + std::string(key.str()) + "'; known here: " + join(asked)});
    }
  }
  if (complaints.empty()) return {};
  const auto first = std::ranges::min_element(complaints, {}, &Document::Complaint::line);
  return Error{ErrorCode::invalid_argument, document_->source_name + ":" + std::to_string(first->line) + ": " + first->text};
}

}  // namespace roseau
