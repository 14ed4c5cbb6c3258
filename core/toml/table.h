// TomlTable: reading a TOML file strictly. Every key that is asked for is known; whatever else the file holds is an error
// with its line number, so that a misspelt key never passes for a default.
//
//   auto root = TomlTable::parse(text, "field.toml");
//   auto sonic = root->table("sonic");
//   const auto port = sonic.text("port", "");
//   if (auto checked = root->finish(); !checked) return checked.error();   // wrong types and unknown keys, first line first
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace roseau {

class TomlTable {
 public:
  /// Error: not TOML (with line and column). `source_name` is the file name used in messages.
  static Result<TomlTable> parse(std::string_view text, std::string source_name);

  /// The value, or the fallback when the key is absent or of the wrong type (which finish() then reports).
  double number(std::string_view key, double fallback);  // takes integers too
  std::int64_t integer(std::string_view key, std::int64_t fallback);
  bool boolean(std::string_view key, bool fallback);
  std::string text(std::string_view key, std::string fallback);

  std::optional<double> optional_number(std::string_view key);
  std::optional<std::string> optional_text(std::string_view key);

  /// As above, but finish() reports an absent key as missing.
  std::string required_text(std::string_view key);
  double required_number(std::string_view key);

  /// A number list; with `count` > 0 it must have that many. Empty when absent.
  std::vector<double> numbers(std::string_view key, std::size_t count = 0);
  std::vector<std::string> texts(std::string_view key);

  /// A sub-table; an empty one when absent.
  TomlTable table(std::string_view key);
  /// The tables of [[key]]; none when absent.
  std::vector<TomlTable> tables(std::string_view key);

  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;

  /// Reports a value that is well formed but makes no sense, at the key's own line: "must be positive".
  void complain(std::string_view key, const std::string& what);

  /// "field.toml:12": where this key (or, when absent, its table) stands.
  std::string place(std::string_view key) const;

  /// On the table returned by parse(): every key asked for and not in the file, anywhere, as "table.key".
  std::vector<std::string> absent() const;

  /// On the table returned by parse(): the first complaint or unknown key in the file, by line.
  Result<void> finish() const;

 private:
  struct Document;
  TomlTable(std::shared_ptr<Document> document, const void* node, std::string path);
  template <class T>
  std::optional<T> read(std::string_view key, const char* type_name);
  const void* find(std::string_view key) const;
  std::int64_t line_of(std::string_view key) const;

  std::shared_ptr<Document> document_;
  const void* node_ = nullptr;  // const toml::table*, null for an absent table; untyped to keep toml++ out of this header
  std::string path_;
};

}  // namespace roseau
