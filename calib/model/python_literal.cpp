#include "calib/model/python_literal.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

namespace roseau::calib {

namespace {

constexpr int kDeepest = 32;  // a file nested deeper is not a camera model, and must not exhaust the stack

class Parser {
 public:
  explicit Parser(std::string_view text) : rest_(text) {}

  Result<PythonDictionary> dictionary() {
    PythonDictionary entries;
    if (!take('{')) return wrong("expected '{'");
    while (!take('}')) {
      Result<std::string> key = string();
      if (!key) return key.error();
      if (!take(':')) return wrong("expected ':' after a key");
      Result<PythonValue> its_value = value(0);
      if (!its_value) return its_value.error();
      const std::string name = *key;
      if (!entries.emplace(std::move(*key), std::move(*its_value)).second) {
        return wrong(fmt::format("key '{}' is there twice", name));
      }
      if (!take(',') && peek() != '}') return wrong("expected ',' or '}'");
    }
    skip_blank();
    if (!rest_.empty()) return wrong("text after the closing '}'");
    return entries;
  }

 private:
  Error wrong(const std::string& what) const { return {ErrorCode::corrupt, fmt::format("line {}: {}", line_, what)}; }

  void advance(std::size_t count) {
    line_ += static_cast<int>(std::ranges::count(rest_.substr(0, count), '\n'));
    rest_.remove_prefix(count);
  }

  void skip_blank() {
    while (!rest_.empty()) {
      if (rest_[0] == '#') {
        advance(std::min(rest_.find('\n'), rest_.size()));
      } else if (std::string_view(" \t\r\n\f").find(rest_[0]) != std::string_view::npos) {
        advance(1);
      } else {
        return;
      }
    }
  }

  char peek() {
    skip_blank();
    return rest_.empty() ? '\0' : rest_[0];
  }

  bool take(char wanted) {
    if (peek() != wanted) return false;
    advance(1);
    return true;
  }

  // Strings and bytes; escapes other than of quotes and backslash are of no matter here and kept as they are.
  Result<std::string> string() {
    const char first = peek();
    if (first == 'b' || first == 'r' || first == 'u') advance(1);
    const char quote = rest_.empty() ? '\0' : rest_[0];
    if (quote != '\'' && quote != '"') return wrong("expected a quoted text");
    std::string text;
    for (std::size_t i = 1; i < rest_.size(); ++i) {
      if (rest_[i] == quote) {
        advance(i + 1);
        return text;
      }
      if (rest_[i] == '\n') break;
      if (rest_[i] == '\\' && i + 1 < rest_.size()) ++i;
      text.push_back(rest_[i]);
    }
    return wrong("a quoted text does not end");
  }

  Result<double> number() {
    double result = 0;
    std::size_t sign = 0;
    if (rest_[0] == '+') sign = 1;  // Python allows it, from_chars does not
    const auto [end, error] = std::from_chars(rest_.data() + sign, rest_.data() + rest_.size(), result);
    if (error != std::errc{}) return wrong("expected a number");
    advance(static_cast<std::size_t>(end - rest_.data()));
    return result;
  }

  // A list or tuple. Numbers are kept; anything else in it makes the whole list one to skip.
  Result<PythonValue> list(char close, int depth) {
    PythonValue result{.line = line_, .value = {}};
    std::optional<std::vector<double>> numbers{std::in_place};
    advance(1);
    while (!take(close)) {
      Result<PythonValue> item = value(depth + 1);
      if (!item) return item.error();
      if (const double* as_number = std::get_if<double>(&item->value); as_number != nullptr && numbers) {
        numbers->push_back(*as_number);
      } else {
        numbers.reset();
      }
      if (!take(',') && peek() != close) return wrong(fmt::format("expected ',' or '{}'", close));
    }
    if (numbers) result.value = std::move(*numbers);
    return result;
  }

  // A dictionary inside the dictionary: skipped.
  Result<PythonValue> inner_dictionary(int depth) {
    const PythonValue result{.line = line_, .value = {}};
    advance(1);
    while (!take('}')) {
      if (const Result<PythonValue> key = value(depth + 1); !key) return key.error();
      if (!take(':')) return wrong("expected ':' after a key");
      if (const Result<PythonValue> inner = value(depth + 1); !inner) return inner.error();
      if (!take(',') && peek() != '}') return wrong("expected ',' or '}'");
    }
    return result;
  }

  Result<PythonValue> value(int depth) {
    if (depth > kDeepest) return wrong("nested too deeply");
    const char first = peek();
    const int line = line_;
    if (first == '[') return list(']', depth);
    if (first == '(') return list(')', depth);
    if (first == '{') return inner_dictionary(depth);
    for (const std::string_view word : {"None", "True", "False"}) {
      if (!rest_.starts_with(word)) continue;
      advance(word.size());
      return PythonValue{.line = line, .value = {}};
    }
    const bool quoted = first == '\'' || first == '"';
    const bool prefixed =
        rest_.size() > 1 && (first == 'b' || first == 'r' || first == 'u') && (rest_[1] == '\'' || rest_[1] == '"');
    if (quoted || prefixed) {
      Result<std::string> text = string();
      if (!text) return text.error();
      return PythonValue{.line = line, .value = std::move(*text)};
    }
    if (first == '\0') return wrong("the text ends too early");
    const Result<double> as_number = number();
    if (!as_number) return as_number.error();
    return PythonValue{.line = line, .value = *as_number};
  }

  std::string_view rest_;
  int line_ = 1;
};

}  // namespace

Result<PythonDictionary> parse_python_dictionary(std::string_view text) { return Parser(text).dictionary(); }

}  // namespace roseau::calib
